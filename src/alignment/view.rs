//! A mesh seen from one direction.

use serde::{Deserialize, Serialize};

use super::contour::Contour;
use super::frame::Frame;
use super::silhouette::silhouette;

/// The frame of a parallel projection and the outline seen through it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct View {
    pub frame: Frame,
    pub contour: Contour,
}

impl View {
    /// The view of these vertices through the frame.
    pub fn through(frame: Frame, positions: &[[f64; 3]], triangles: &[[u32; 3]]) -> View {
        let flat: Vec<[f64; 2]> = positions.iter().map(|&p| frame.project(p)).collect();
        View { frame, contour: Contour::of(&flat, triangles) }
    }

    /// The view of the mesh from a direction, its longest axis lying flat in the picture as that of a sketch does: what
    /// the pixels do to an outline then happens to both alike.
    pub fn lying_flat(direction: [f64; 3], positions: &[[f64; 3]], triangles: &[[u32; 3]]) -> View {
        let frame = Frame::looking_from(direction);
        let flat: Vec<[f64; 2]> = positions.iter().map(|&p| frame.project(p)).collect();
        View::through(frame.rolled(silhouette(&flat, triangles).longest_axis()), positions, triangles)
    }

    /// The same shape seen from behind: its outline is the reflection.
    pub fn from_behind(&self) -> View {
        let mut contour = self.contour.reversed();
        contour.curve.iter_mut().for_each(|p| p[0] = -p[0]);
        View { frame: self.frame.from_behind(), contour }
    }
}
