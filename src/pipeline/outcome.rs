//! What a match answers.

use std::collections::BTreeMap;

use faer::MatRef;
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::settings::Settings;
use crate::numerics::{Report, Stopped};
use crate::regions::pairing::Pair;

/// The result of a match: the functional map, the points, and how both were found.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct MatchResult {
    /// Id of the match; none outside the service.
    #[serde(rename = "match", default, skip_serializing_if = "Option::is_none")]
    pub id: Option<String>,
    pub sketch: String,
    pub mesh: String,
    /// Every setting as used; sent again, it gives the same answer.
    pub request: Settings,
    pub c: Matrix,
    /// One for every vertex of the sketch, in its order.
    pub correspondences: Vec<Correspondence>,
    /// Mean of the points' confidence, weighted by area.
    pub confidence: f64,
    /// Other plausible answers: none without the alignment of views.
    #[schema(value_type = Vec<Object>)]
    pub alternatives: Vec<serde_json::Value>,
    pub solver: Solver,
    pub intermediate: Intermediate,
    /// Milliseconds by stage, and in `total`.
    pub timings_ms: BTreeMap<String, f64>,
    pub warnings: Vec<String>,
}

/// A dense matrix by rows.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct Matrix {
    pub rows: usize,
    pub columns: usize,
    pub values: Vec<Vec<f64>>,
}

impl From<MatRef<'_, f64>> for Matrix {
    fn from(matrix: MatRef<'_, f64>) -> Matrix {
        let values = (0..matrix.nrows()).map(|i| matrix.row(i).iter().copied().collect()).collect();
        Matrix { rows: matrix.nrows(), columns: matrix.ncols(), values }
    }
}

/// Where a vertex of the sketch lies on the mesh.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct Correspondence {
    pub sketch_vertex: u32,
    /// In the coordinates the sketch was uploaded in.
    #[schema(value_type = Vec<f64>, min_items = 2, max_items = 2)]
    pub point: [f64; 2],
    /// Counted from 0 in the user's file.
    pub mesh_vertex: u32,
    /// In `[0, 1]`: how well the map agrees with its own way back. Not calibrated.
    pub confidence: f64,
}

/// How C was found.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct Solver {
    pub regulariser: String,
    /// 0 where the solution is direct.
    pub iterations: usize,
    /// ‖C A − B‖²_F + γ ρ(C) at the C that was found, before any refinement.
    pub objective: f64,
    pub stopped: Stopped,
    /// The objective at the start C⁰ and after every iteration.
    pub history: Vec<f64>,
}

impl Solver {
    pub(super) fn new(regulariser: &str, report: Report) -> Solver {
        Solver {
            regulariser: regulariser.to_owned(),
            iterations: report.iterations,
            objective: report.objective(),
            stopped: report.stopped,
            history: report.history,
        }
    }
}

/// What the stages handed on, for those who want to look inside.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct Intermediate {
    /// The first k eigenvalues of the sketch, scaled to area 1.
    pub sketch_eigenvalues: Vec<f64>,
    /// The first l eigenvalues of the mesh, scaled to area 1, before the spectral scale.
    pub mesh_eigenvalues: Vec<f64>,
    /// The factor on the mesh's eigenvalues that descriptors were made with.
    pub spectral_scale: f64,
    pub regions: PairedRegions,
    /// C⁰, the least-squares solution every solver starts from.
    pub initial_c: Matrix,
    /// W.
    pub weights: Matrix,
}

/// The regions of both shapes and which correspond.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct PairedRegions {
    /// A label per vertex of the sketch; −1 is in no region.
    pub sketch: Vec<i32>,
    /// A label per vertex of the user's mesh file; −1 is in no region.
    pub mesh: Vec<i32>,
    pub pairs: Vec<Pair>,
    /// Sum of the pairs' costs; 0 where they were given.
    pub cost: f64,
}
