//! Vectors of the plane and of space: what is added, turned and measured before there is a mesh.

mod areas;
pub mod axes;
pub mod frame;
mod segments;
mod triangles;
mod vectors;

pub use areas::{doubled_area, doubled_area_of_sides, triangle_area};
pub use segments::distance_to_segment;
pub use triangles::nearest_on_triangle;
pub use vectors::{cross, dot, length, subtract, unit};
