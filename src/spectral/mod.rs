//! The Laplacian of a mesh and its eigenpairs.

use faer::Mat;
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// What an eigenfunction does at the boundary of the mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum Boundary {
    /// Free: no flow across it.
    Neumann,
    /// Fixed at zero.
    Dirichlet,
}

/// The first k eigenpairs of S φ = λ A φ on a connected mesh of n vertices, S the cotangent stiffness and A the lumped
/// mass, in ascending order of λ.
#[derive(Clone, Debug)]
pub struct Spectrum {
    /// k values in units of 1/length², ascending; the first is 0 under Neumann conditions.
    pub eigenvalues: Vec<f64>,
    /// n × k, Φᵀ A Φ = I; under Dirichlet conditions the rows of boundary vertices are zero. The sign of a column makes
    /// its entry of largest magnitude positive (the first of equals).
    pub eigenfunctions: Mat<f64>,
    /// Diagonal of A: n areas that sum to the mesh's.
    pub mass: Vec<f64>,
}

impl Spectrum {
    /// Number of eigenpairs, k.
    pub fn len(&self) -> usize {
        self.eigenvalues.len()
    }

    pub fn is_empty(&self) -> bool {
        self.eigenvalues.is_empty()
    }

    /// Number of vertices, n.
    pub fn vertices(&self) -> usize {
        self.mass.len()
    }
}
