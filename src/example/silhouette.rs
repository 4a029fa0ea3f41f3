//! The silhouette of a mesh: what a drawing of it shows.

use i_overlay::core::fill_rule::FillRule;
use i_overlay::float::simplify::SimplifyShape;
use serde::Serialize;

use super::view::{Projection, View};
use crate::geometry::{distance_to_segment, doubled_area};
use crate::mesh::TriangleMesh;

/// How far the outline may be from the projected triangles, in drawing units.
const TOLERANCE: f64 = 0.2;
/// Share of the figure's area below which a hole is an accident of the triangles.
const SMALLEST_HOLE: f64 = 1e-4;

/// A filled outline with holes in a frame of 600 × 600 units, y up.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Silhouette {
    /// Corners, counter-clockwise, the first not repeated.
    pub outline: Vec<[f64; 2]>,
    /// Corners of every hole, clockwise.
    pub holes: Vec<Vec<[f64; 2]>>,
}

impl Silhouette {
    /// The silhouette of a closed, connected mesh from a view; `None` where no triangle faces the viewer.
    pub fn of(mesh: &TriangleMesh, view: View) -> Option<Self> {
        let frame = Projection::around(mesh, view);
        // The triangles that face the viewer cover whatever those on the far side cover.
        let facing: Vec<Vec<[f64; 2]>> = mesh
            .triangles()
            .iter()
            .map(|t| t.map(|v| frame.projected(mesh.positions()[v as usize]).0))
            .filter(|&t| doubled_area(t) > 0.0)
            .map(|t| t.to_vec())
            .collect();
        let figures = facing.simplify_shape(FillRule::NonZero);
        let mut contours = figures.into_iter().max_by(|a, b| area(&a[0]).total_cmp(&area(&b[0])))?.into_iter();
        let outline = simplified(&contours.next()?);
        let smallest = SMALLEST_HOLE * area(&outline);
        let holes = contours.filter(|hole| -area(hole) > smallest).map(|hole| simplified(&hole)).collect();
        Some(Self { outline, holes })
    }

    /// Area inside the outline and outside the holes, in squared drawing units.
    pub fn area(&self) -> f64 {
        area(&self.outline) + self.holes.iter().map(|hole| area(hole)).sum::<f64>()
    }

    /// Whether a point is in the figure.
    pub fn contains(&self, [x, y]: [f64; 2]) -> bool {
        self.crossings(y).iter().filter(|&&crossing| crossing < x).count() % 2 == 1
    }

    /// The abscissas at which the figure begins and ends by turns along the line of the given ordinate, ascending.
    pub fn crossings(&self, y: f64) -> Vec<f64> {
        let mut crossings: Vec<f64> = std::iter::once(&self.outline)
            .chain(&self.holes)
            .flat_map(|contour| contour.iter().zip(contour.iter().cycle().skip(1)))
            .filter(|(a, b)| (a[1] <= y) != (b[1] <= y))
            .map(|(a, b)| a[0] + (y - a[1]) / (b[1] - a[1]) * (b[0] - a[0]))
            .collect();
        crossings.sort_by(f64::total_cmp);
        crossings
    }
}

/// Signed area of a contour, positive where it is counter-clockwise.
fn area(contour: &[[f64; 2]]) -> f64 {
    let next = contour.iter().cycle().skip(1);
    contour.iter().zip(next).map(|(a, b)| 0.5 * (a[0] * b[1] - a[1] * b[0])).sum()
}

/// A closed contour without the corners that stay within the tolerance [DP73], rounded to thousandths.
fn simplified(contour: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let first = contour.first().copied().unwrap_or_default();
    let distance = |p: &[f64; 2]| (p[0] - first[0]).hypot(p[1] - first[1]);
    let farthest = (0..contour.len()).max_by(|&i, &j| distance(&contour[i]).total_cmp(&distance(&contour[j])));
    let closed: Vec<[f64; 2]> = contour.iter().copied().chain([first]).collect();
    let mut kept = vec![false; closed.len()];
    let mut spans = Vec::from([(0, farthest.unwrap_or(0)), (farthest.unwrap_or(0), contour.len())]);
    while let Some((from, to)) = spans.pop() {
        (kept[from], kept[to]) = (true, true);
        let off = |i: usize| distance_to_segment(closed[i], [closed[from], closed[to]]);
        let worst = (from + 1..to).max_by(|&i, &j| off(i).total_cmp(&off(j)));
        if let Some(worst) = worst.filter(|&i| off(i) > TOLERANCE) {
            spans.extend([(from, worst), (worst, to)]);
        }
    }
    let corners = contour.iter().zip(kept).filter(|&(_, kept)| kept);
    corners.map(|(p, _)| p.map(|x| (x * 1e3).round() / 1e3)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ring_has_a_hole() {
        // A square of side 3 without the unit square in its middle, in the plane z = 0.
        let corners = [[0.0, 0.0], [3.0, 0.0], [3.0, 3.0], [0.0, 3.0], [1.0, 1.0], [2.0, 1.0], [2.0, 2.0], [1.0, 2.0]];
        let sides = (0..4).flat_map(|i| [[i, (i + 1) % 4, 4 + (i + 1) % 4], [i, 4 + (i + 1) % 4, 4 + i]]);
        let mesh = TriangleMesh::new(corners.map(|[x, y]| [x, y, 0.0]).to_vec(), sides.collect()).unwrap();
        let ring = Silhouette::of(&mesh, View::Front).unwrap();
        assert_eq!((ring.outline.len(), ring.holes.len()), (4, 1));
        assert!((ring.area() - 580.0 * 580.0 * 8.0 / 9.0).abs() < 1.0);
        assert!(ring.contains([50.0, 300.0]) && !ring.contains([300.0, 300.0]) && !ring.contains([5.0, 300.0]));
        for (found, expected) in ring.crossings(300.0).iter().zip([10.0, 203.333, 396.667, 590.0]) {
            assert!((found - expected).abs() < 1e-2);
        }
        assert!(Silhouette::of(&mesh, View::Side).is_none());
    }

    #[test]
    fn corners_within_the_tolerance_go() {
        let bent = [[0.0, 0.0], [50.0, 0.1], [100.0, 0.0], [100.0, 100.0], [50.0, 101.0], [0.0, 100.0]];
        assert_eq!(simplified(&bent), [bent[0], bent[2], bent[3], bent[4], bent[5]]);
    }
}
