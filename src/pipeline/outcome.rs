//! What a match answers.

use std::collections::BTreeMap;

use faer::{Mat, MatRef};
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::settings::Settings;
use crate::numerics::{Report, Stopped};
use crate::regions::pairing::RegionPair;

/// The result of a match: the functional map, the points, and how both were found.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct MatchResult {
    /// Id of the match; none outside the service.
    #[serde(rename = "match", default, skip_serializing_if = "Option::is_none")]
    pub id: Option<String>,
    /// The version of the program that matched; nothing in results of versions before it said so.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub version: Option<String>,
    /// Whether this is the answer at first sight, which another follows.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub preview: bool,
    pub sketch: String,
    pub mesh: String,
    /// Every setting as used; sent again, it gives the same answer.
    pub request: Settings,
    pub c: Matrix,
    /// One for every vertex of the sketch, in its order.
    pub correspondences: Vec<Correspondence>,
    /// Mean of the points' confidence, weighted by area.
    pub confidence: f64,
    /// The confidence in a word, where it is calibrated: for aligned points.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rating: Option<Rating>,
    /// How the sketch was laid on the mesh; none where the request asks for no alignment.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub alignment: Option<AlignmentReport>,
    /// Other plausible answers: none without the alignment of views.
    pub alternatives: Vec<Alternative>,
    pub solver: Solver,
    pub intermediate: Intermediate,
    /// Milliseconds by stage, and in `total`.
    pub timings_ms: BTreeMap<String, f64>,
    pub warnings: Vec<String>,
}

impl MatchResult {
    /// The vertex of the user's mesh for every vertex of the sketch: of the answer, or of an alternative; nothing where
    /// there is no such one.
    pub fn answers(&self, alternative: Option<usize>) -> Option<Vec<u32>> {
        match alternative {
            Some(number) => Some(self.alternatives.get(number)?.mesh_vertices.clone()),
            None => Some(self.correspondences.iter().map(|correspondence| correspondence.mesh_vertex).collect()),
        }
    }
}

/// How far a match is to be trusted, by the measured errors of matches of the same confidence: in units of √area, of √(area / 2)
/// where one side is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum Rating {
    /// From 0.88: a mean error of 0.05 on average; of 35 matches none was off by more than 0.15.
    High,
    /// From 0.75: a mean error of 0.07 on average; of 80 matches 8 were off by more than 0.15, none by more than 0.3.
    Medium,
    /// Below: a mean error of 0.14 on average; of 51 matches 14 were off by more than 0.15 and 5 by more than 0.3, whose
    /// views may be wrong.
    Low,
}

impl Rating {
    const HIGH: f64 = 0.88;
    const MEDIUM: f64 = 0.75;

    /// The word for the confidence of a match.
    pub fn of(confidence: f64) -> Rating {
        match confidence {
            c if c >= Rating::HIGH => Rating::High,
            c if c >= Rating::MEDIUM => Rating::Medium,
            _ => Rating::Low,
        }
    }
}

/// A dense matrix by rows.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct Matrix {
    pub rows: usize,
    pub columns: usize,
    pub values: Vec<Vec<f64>>,
}

impl Matrix {
    /// The matrix to reckon with; 0 where a row is short.
    pub fn to_mat(&self) -> Mat<f64> {
        let entry = |i: usize, j: usize| self.values.get(i).and_then(|row| row.get(j)).copied().unwrap_or(0.0);
        Mat::from_fn(self.rows, self.columns, entry)
    }
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
    /// The vertices, of which `mesh_vertex` is one, of the triangle on which the point lies between them, as `mesh_vertex`
    /// counts; nothing in results of versions before it was told.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(value_type = Option<Vec<u32>>, min_items = 3, max_items = 3)]
    pub triangle: Option<[u32; 3]>,
    /// The weights of the triangle's vertices at the point, which sum to 1.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(value_type = Option<Vec<f64>>, min_items = 3, max_items = 3)]
    pub barycentric: Option<[f64; 3]>,
    /// In `[0, 1]`. Of aligned points the chance to be within a tenth of the square root of the mesh's area of the
    /// truth, of half of that area in the drawings from the side among those it was estimated from; of points read from C how well
    /// the map agrees with its own way back, which is not calibrated.
    pub confidence: f64,
}

/// How a sketch was laid on a mesh.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct AlignmentReport {
    pub view: ViewReport,
    /// The part of the mesh that is matched.
    pub part: SeenPart,
    pub by: MatchedBy,
    /// What the outlines cost per sample, from 0 (alike) to 0.4.
    pub contour_cost: f64,
    /// How far geodesic distances of the sketch are bent, in units of the square root of the mesh's area.
    pub distortion: f64,
    /// Both, and what else counts against the view: the less the better, to compare with the alternatives.
    pub score: f64,
    /// The aligned vertex of the user's mesh for every vertex of the sketch, whatever `conversion` answers with.
    pub mesh_vertices: Vec<u32>,
}

/// A direction to look from, in the axes of the user's mesh.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct ViewReport {
    /// Of length 1.
    #[schema(value_type = Vec<f64>, min_items = 3, max_items = 3)]
    pub toward_camera: [f64; 3],
    /// Of length 1, at right angles to it. The sketch may be turned in the picture.
    #[schema(value_type = Vec<f64>, min_items = 3, max_items = 3)]
    pub up: [f64; 3],
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum SeenPart {
    Whole,
    Side,
}

/// What the aligned points were found by.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum MatchedBy {
    /// A view of the mesh as it is.
    View,
    /// A view of the mesh with its limbs swung.
    Pose,
    /// Geodesic distances to landmarks and to sure points.
    Distances,
}

/// Another plausible answer.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct Alternative {
    pub kind: AlternativeKind,
    pub view: ViewReport,
    /// As the alignment's score.
    pub score: f64,
    /// A vertex of the user's mesh for every vertex of the sketch.
    pub mesh_vertices: Vec<u32>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum AlternativeKind {
    /// The same drawing seen from behind: the other side of the body.
    Mirrored,
    /// Another direction to look from.
    View,
}

/// How C was found.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct Solver {
    pub regulariser: String,
    /// Of all turns where C is found in turns with something else; 0 where the solution is direct.
    pub iterations: usize,
    /// ‖C A − B‖²_F + γ ρ(C) at the C that was found, before any refinement; by `part_indicator` with what area and boundary of the
    /// part cost.
    pub objective: f64,
    pub stopped: Stopped,
    /// The objective at the start C⁰ and after every iteration, of a direct solution at its end. By `permuted_l1` and
    /// `part_indicator` of all turns in C, one after the other, each at the order or the part of that turn; what is gained by a new
    /// order or part is in the next value. Where the request pairs fewer regions than can be paired, the first turn of
    /// `permuted_l1` counts its pairs alone.
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
    /// C⁰, the least-squares solution every solver starts from: of turns the first, with the pairs that were begun with or with
    /// nearly the whole mesh.
    pub initial_c: Matrix,
    /// W: with `joint_diagonalisation` that of C in the coupled bases, as the objective is; C and C⁰ are of the eigenfunctions.
    pub weights: Matrix,
    /// By the regulariser `part_indicator`: for every vertex of the user's mesh file how much it belongs to the part that the
    /// sketch shows, from 0 to 1; 0 off the component that is matched.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub part: Option<Vec<f64>>,
}

/// The regions of both shapes and which correspond.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct PairedRegions {
    /// A label per vertex of the sketch; −1 is in no region.
    pub sketch: Vec<i32>,
    /// A label per vertex of the user's mesh file; −1 is in no region.
    pub mesh: Vec<i32>,
    pub pairs: Vec<RegionPair>,
    /// Sum of the pairs' costs; 0 where they were given.
    pub cost: f64,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rating_changes_at_the_documented_confidences() {
        let ratings = [1.0, 0.88, 0.879, 0.75, 0.749, 0.0].map(Rating::of);
        let [high, medium, low] = [Rating::High, Rating::Medium, Rating::Low];
        assert_eq!(ratings, [high, high, medium, medium, low, low]);
    }
}
