//! What an alignment answers.

use crate::geometry::frame::Frame;

/// What the answer was found by.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Way {
    /// A view of the mesh as it is.
    View,
    /// A view of the mesh with its limbs swung.
    Pose,
    /// Geodesic distances to the points that are sure.
    Distances,
}

/// A sketch laid on a mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct Alignment {
    /// A vertex of the mesh for every one of the m vertices of the sketch.
    pub map: Vec<u32>,
    /// For every vertex its place between the vertices of the mesh, on a triangle that the one in `map` is of; nothing where
    /// the answer is not what is seen where the vertex lies.
    pub places: Vec<Option<Place>>,
    /// For every vertex the chance that its answer is less than 0.1 from the truth, in the units that errors have.
    pub confidence: Vec<f64>,
    pub frame: Frame,
    pub way: Way,
    /// Whether the body is seen from its side.
    pub sideways: bool,
    /// What the outlines cost per sample, in [0, 0.4].
    pub contour: f64,
    /// Mean distortion of geodesic distances.
    pub distortion: f64,
    /// Costs of the view as they are compared; the less the better.
    pub score: f64,
    pub alternatives: Vec<Alternative>,
    /// The places of the landmarks whose distances from most others are not those in the sketch, ascending.
    pub at_odds: Vec<usize>,
}

/// A place on a mesh: the vertices of a triangle, and their weights, which sum to 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    pub triangle: [u32; 3],
    pub weights: [f64; 3],
}

impl Place {
    /// That of a vertex, as a corner of a triangle it is of.
    pub fn corner(vertex: u32, triangle: [u32; 3]) -> Place {
        Place { triangle, weights: triangle.map(|corner| f64::from(u8::from(corner == vertex))) }
    }
}

/// Another plausible answer.
#[derive(Clone, Debug, PartialEq)]
pub struct Alternative {
    /// Whether it is the answer's twin on the other side of the body; another view otherwise.
    pub mirrored: bool,
    pub frame: Frame,
    pub score: f64,
    pub map: Vec<u32>,
}
