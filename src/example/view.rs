//! The orthographic views a creature is drawn from.

use crate::geometry::dot;
use crate::mesh::TriangleMesh;

/// Side of the square a drawing fits into, in drawing units.
pub const FRAME: f64 = 600.0;
/// Width left free around the figure.
const MARGIN: f64 = 10.0;
const UP: [f64; 3] = [0.0, 1.0, 0.0];

/// Where the viewer stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum View {
    /// On the creature's left: its head is on the left of the drawing.
    Side,
    /// Before the creature: its left hand is on the right of the drawing.
    Front,
}

/// A view of one mesh: the similarity that takes it into the drawing's frame.
#[derive(Clone, Copy, Debug)]
pub(super) struct Projection {
    right: [f64; 3],
    towards: [f64; 3],
    scale: f64,
    offset: [f64; 2],
}

impl Projection {
    /// The view that centres the mesh in the frame.
    pub(super) fn around(mesh: &TriangleMesh, view: View) -> Self {
        let (right, towards) = match view {
            View::Side => ([0.0, 0.0, -1.0], [1.0, 0.0, 0.0]),
            View::Front => ([1.0, 0.0, 0.0], [0.0, 0.0, 1.0]),
        };
        let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for &p in mesh.positions() {
            for (i, x) in [dot(p, right), dot(p, UP)].into_iter().enumerate() {
                (low[i], high[i]) = (low[i].min(x), high[i].max(x));
            }
        }
        let size = (high[0] - low[0]).max(high[1] - low[1]);
        let scale = (FRAME - 2.0 * MARGIN) / size;
        Self { right, towards, scale, offset: std::array::from_fn(|i| 0.5 * (FRAME - scale * (low[i] + high[i]))) }
    }

    /// The place of a point in the drawing, and how near it is to the viewer in units of the mesh.
    pub(super) fn projected(&self, p: [f64; 3]) -> ([f64; 2], f64) {
        let x = self.offset[0] + self.scale * dot(p, self.right);
        let y = self.offset[1] + self.scale * dot(p, UP);
        ([x, y], dot(p, self.towards))
    }

    /// The point in space at a place in the drawing: the inverse of [`Projection::projected`].
    pub(super) fn lifted(&self, [x, y]: [f64; 2], nearness: f64) -> [f64; 3] {
        let (x, y) = ((x - self.offset[0]) / self.scale, (y - self.offset[1]) / self.scale);
        std::array::from_fn(|i| x * self.right[i] + y * UP[i] + nearness * self.towards[i])
    }
}
