//! A valid triangle mesh.

pub mod geodesics;

/// A triangle mesh that can only be built valid.
///
/// Guaranteed: coordinates finite; indices in range; every triangle has three distinct vertices and positive area; no
/// triangle occurs twice; every edge has one or two triangles, wound consistently; the triangles around a vertex form
/// one fan (edges and vertices are manifold). Allowed: boundary, several components, vertices of no triangle.
///
/// Vertices are those of the user's file in its order, so that an index here is an id in every answer. Flat shapes
/// (sketches) are meshes with z = 0.
#[derive(Clone, Debug, PartialEq)]
pub struct TriangleMesh {
    positions: Vec<[f64; 3]>,
    triangles: Vec<[u32; 3]>,
}

/// Stand-in until the validation of meshes is merged.
pub mod refusal {
    #[derive(Clone, Debug, PartialEq, thiserror::Error)]
    #[error("{0}")]
    pub struct Refusal(pub String);
}

impl TriangleMesh {
    /// Stand-in until the validation of meshes is merged.
    pub fn new(positions: Vec<[f64; 3]>, triangles: Vec<[u32; 3]>) -> Result<Self, refusal::Refusal> {
        Ok(Self { positions, triangles })
    }

    pub fn positions(&self) -> &[[f64; 3]] {
        &self.positions
    }

    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    /// Sum of the triangles' areas, in squared units of the file.
    pub fn area(&self) -> f64 {
        self.triangles.iter().map(|&t| triangle_area(t.map(|v| self.positions[v as usize]))).sum()
    }
}

/// Half the length of the cross product of two edges.
pub fn triangle_area([a, b, c]: [[f64; 3]; 3]) -> f64 {
    let (u, v) = (subtract(b, a), subtract(c, a));
    0.5 * length(cross(u, v))
}

pub(crate) fn subtract(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

pub(crate) fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(crate) fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

pub(crate) fn length(a: [f64; 3]) -> f64 {
    dot(a, a).sqrt()
}
