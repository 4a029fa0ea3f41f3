//! Where resources are.

use crate::store::Kind;

/// Where matches are listed.
pub const MATCHES: &str = "/v1/matches";

/// Where poses are listed.
pub const POSES: &str = "/v1/poses";

/// Where the shapes of a kind are listed.
pub const fn of_shapes(kind: Kind) -> &'static str {
    match kind {
        Kind::Mesh => "/v1/meshes",
        Kind::Sketch => "/v1/sketches",
    }
}

/// The address of a shape.
pub fn of_shape(kind: Kind, id: &str) -> String {
    format!("{}/{id}", of_shapes(kind))
}
