//! A valid triangle mesh.

pub mod connectivity;
mod disjoint_sets;
mod edges;
pub mod formats;
pub mod geodesics;
mod polygon;
pub mod refusal;
mod soundness;
pub mod validation;
mod winding;

use edges::Edges;
use refusal::{Faults, Place, Refusal};

/// A triangle mesh that can only be built valid.
///
/// Guaranteed: at least one triangle; coordinates finite and at most 1e50; indices in range; every triangle has three
/// distinct vertices and an area that is positive beside its edges and the mesh; no triangle occurs twice; every edge
/// has one or two triangles, wound consistently; the triangles around a vertex form one fan (edges and vertices are
/// manifold). Allowed: boundary, several components, vertices of no triangle.
///
/// Vertices are those of the user's file in its order, so that an index here is an id in every answer. Flat shapes
/// (sketches) are meshes with z = 0.
#[derive(Clone, Debug, PartialEq)]
pub struct TriangleMesh {
    positions: Vec<[f64; 3]>,
    triangles: Vec<[u32; 3]>,
}

impl TriangleMesh {
    /// The mesh of these vertices and triangles, n × 3 coordinates and m × 3 indices, in O(m log m). Refused with every
    /// reason where something the type guarantees does not hold; places are vertices and triangles.
    pub fn new(positions: Vec<[f64; 3]>, triangles: Vec<[u32; 3]>) -> Result<TriangleMesh, Refusal> {
        let mut faults = Faults::default();
        if triangles.is_empty() {
            faults.push(Place::file(), "there are no triangles");
        }
        soundness::coordinates(&positions, &mut faults);
        for (t, triangle) in triangles.iter().enumerate() {
            soundness::corners(&triangle.map(i64::from), positions.len(), &Place::face(t), &mut faults);
        }
        faults.into_result()?;

        let mut faults = Faults::default();
        soundness::areas(&positions, &triangles, &mut faults);
        for (t, first) in soundness::firsts(&triangles).into_iter().enumerate().filter(|(t, first)| t != first) {
            faults.push(Place::face(t), format!("it has the same vertices as triangle {first}"));
        }
        let edges = Edges::of(&triangles);
        soundness::crowded_edges(&edges, &mut faults);
        soundness::winding(&triangles, &edges, &mut faults);
        soundness::fans(positions.len(), &triangles, &edges, &mut faults);
        faults.into_result()?;
        Ok(TriangleMesh { positions, triangles })
    }

    /// n × 3, in units of the file.
    pub fn positions(&self) -> &[[f64; 3]] {
        &self.positions
    }

    /// m × 3, every row the vertices of a triangle in its winding.
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    /// Sum of the triangles' areas, in squared units of the file.
    pub fn area(&self) -> f64 {
        self.triangles.iter().map(|&t| triangle_area(t.map(|v| self.positions[v as usize]))).sum()
    }

    /// Hash of the canonical bytes, all little-endian: the numbers of vertices and of triangles as u64, the coordinates
    /// as f64, the triangles as u32.
    pub fn content_hash(&self) -> blake3::Hash {
        let mut hasher = blake3::Hasher::new();
        hasher.update(&(self.positions.len() as u64).to_le_bytes());
        hasher.update(&(self.triangles.len() as u64).to_le_bytes());
        for position in &self.positions {
            hasher.update(position.map(f64::to_le_bytes).as_flattened());
        }
        for triangle in &self.triangles {
            hasher.update(triangle.map(u32::to_le_bytes).as_flattened());
        }
        hasher.finalize()
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
