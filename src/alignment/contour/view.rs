//! A mesh seen from one direction.

use std::borrow::Cow;

use serde::{Deserialize, Serialize};

use super::Contour;
use crate::geometry::doubled_area;
use crate::geometry::frame::Frame;
use crate::raster::silhouette::silhouette;

/// The frame of a parallel projection and the outline seen through it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct View {
    pub frame: Frame,
    pub contour: Contour,
}

impl View {
    /// The view of these vertices through the frame. Where the mesh is `closed` what faces away is not looked at: it is
    /// behind what faces the camera.
    pub fn through(frame: Frame, positions: &[[f64; 3]], triangles: &[[u32; 3]], closed: bool) -> View {
        let flat: Vec<[f64; 2]> = positions.iter().map(|&p| frame.project(p)).collect();
        View { frame, contour: Contour::of(&flat, &facing(&flat, triangles, closed)) }
    }

    /// The view of the mesh from a direction, its longest axis lying flat in the picture as that of a sketch does: what
    /// the pixels do to an outline then happens to both alike.
    pub fn lying_flat(direction: [f64; 3], positions: &[[f64; 3]], triangles: &[[u32; 3]], closed: bool) -> View {
        let frame = Frame::looking_from(direction);
        let flat: Vec<[f64; 2]> = positions.iter().map(|&p| frame.project(p)).collect();
        let axis = silhouette(&flat, &facing(&flat, triangles, closed)).longest_axis();
        View::through(frame.rolled(axis), positions, triangles, closed)
    }

    /// The same shape seen from behind: its outline is the reflection.
    pub fn from_behind(&self) -> View {
        let mut contour = self.contour.reversed();
        contour.curve.iter_mut().for_each(|p| p[0] = -p[0]);
        View { frame: self.frame.from_behind(), contour }
    }
}

/// The triangles that the silhouette is made of.
fn facing<'a>(flat: &[[f64; 2]], triangles: &'a [[u32; 3]], closed: bool) -> Cow<'a, [[u32; 3]]> {
    let front = |t: &&[u32; 3]| doubled_area(t.map(|v| flat[v as usize])) >= 0.0;
    if closed { triangles.iter().filter(front).copied().collect() } else { triangles.into() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::solids::star;

    #[test]
    fn what_faces_away_does_not_change_the_silhouette() {
        let mesh = star(0.3);
        for direction in [[0.0, 0.0, 1.0], [1.0, 0.2, 0.0], [0.3, -1.0, 0.5]] {
            let frame = Frame::looking_from(direction);
            let flat: Vec<[f64; 2]> = mesh.positions().iter().map(|&p| frame.project(p)).collect();
            let whole = silhouette(&flat, mesh.triangles());
            let front = facing(&flat, mesh.triangles(), true);
            assert!(front.len() < 2 * mesh.triangles().len() / 3);
            let half = silhouette(&flat, &front);
            assert_eq!((half.low, half.scale), (whole.low, whole.scale));
            let near = |x: usize, y: usize| (x - 1..=x + 1).any(|x| (y - 1..=y + 1).any(|y| half.inside.get(x, y)));
            for [x, y] in (0..256 * 256).map(|pixel| [pixel % 256, pixel / 256]) {
                // What faces away may round to a pixel beside.
                assert!(if whole.inside.get(x, y) { near(x, y) } else { !half.inside.get(x, y) });
            }
            assert!(whole.area() - half.area() < whole.area() / 200, "{} {}", whole.area(), half.area());
        }
    }
}
