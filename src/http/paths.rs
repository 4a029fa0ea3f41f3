//! Where resources are.

use crate::store::ShapeKind;

/// Where matches are listed.
pub const MATCHES: &str = "/v1/matches";

/// Where poses are listed.
pub const POSES: &str = "/v1/poses";

/// Where the shapes of a kind are listed.
pub const fn of_shapes(kind: ShapeKind) -> &'static str {
    match kind {
        ShapeKind::Mesh => "/v1/meshes",
        ShapeKind::Sketch => "/v1/sketches",
    }
}

/// The address of a shape.
pub fn of_shape(kind: ShapeKind, id: &str) -> String {
    format!("{}/{id}", of_shapes(kind))
}
