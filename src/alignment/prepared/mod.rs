//! What either shape brings along before the other is known.

pub mod directions;
mod flat_shape;
pub mod limbs;
mod mesh;
pub mod sampled_distances;
pub mod standing;
pub mod symmetry;

pub use flat_shape::FlatShape;
pub use mesh::{PREPARATION_VERSION, PreparedMesh};
