//! A sketch and a mesh to lay it on, and what is known of both.

pub mod eyes;
pub mod landmarks;
pub mod upright;

use eyes::Eyes;
use upright::Upright;

use crate::alignment::prepared::{FlatShape, PreparedMesh};
use crate::numerics::Watch;

/// What every step of an alignment looks at.
#[derive(Clone, Copy)]
pub struct Scene<'a> {
    pub shape: &'a FlatShape,
    pub mesh: &'a PreparedMesh,
    /// Which way is up on both, where that is known of both.
    pub upright: Option<Upright>,
    /// Drawn eyes, where it is known where eyes are.
    pub eyes: Option<Eyes<'a>>,
    pub watch: &'a dyn Watch,
}

impl<'a> Scene<'a> {
    pub fn new(
        shape: &'a FlatShape,
        mesh: &'a PreparedMesh,
        upright: Option<Upright>,
        watch: &'a dyn Watch,
    ) -> Scene<'a> {
        Scene { shape, mesh, upright, eyes: Eyes::of(shape, mesh, upright), watch }
    }

    /// The scene of a drawing that leans by an angle, counter-clockwise; none where up is not known.
    pub fn leaning(&self, degrees: f64) -> Option<Scene<'a>> {
        let upright = self.upright?;
        let ((sin, cos), [x, y]) = (degrees.to_radians().sin_cos(), upright.sketch);
        let upright = Upright { sketch: [cos * x - sin * y, sin * x + cos * y], ..upright };
        Some(Scene { upright: Some(upright), ..*self })
    }
}
