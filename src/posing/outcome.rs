//! What a pose answers.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::request::PoseRequest;
use crate::deformation::strain::Strain;
use crate::pipeline::outcome::ViewReport;

/// The result of a pose: where every vertex of the user's file is in each frame.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct PoseResult {
    /// Id of the pose; none outside the service.
    #[serde(rename = "pose", default, skip_serializing_if = "Option::is_none")]
    pub id: Option<String>,
    /// The version of the program that posed.
    pub version: String,
    /// Id of the match.
    #[serde(rename = "match")]
    pub matching: String,
    pub sketch: String,
    pub mesh: String,
    pub request: PoseRequest,
    /// The plane of the drawing: `up` is up in it. Nothing moves toward the camera or away.
    pub view: ViewReport,
    /// How much each handle moves each vertex of the sketch; none where the pose is that of the drawing.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub weights: Option<HandleWeights>,
    pub frames: Vec<PosedFrame>,
    /// Milliseconds by stage, and in `total`.
    pub timings_ms: BTreeMap<String, f64>,
}

/// Bounded biharmonic weights.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct HandleWeights {
    /// A row for every vertex of the sketch: a weight for every handle, of a cage one for every corner; they sum to 1.
    pub values: Vec<Vec<f64>>,
    /// Weights larger, or smaller, than at all neighbours, away from the handles.
    pub local_extrema: usize,
}

/// One pose.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct PosedFrame {
    /// One for every vertex of the user's mesh file, in its order; null where the file has no number.
    #[schema(value_type = Vec<Vec<Option<f64>>>)]
    pub positions: Vec<[Option<f64>; 3]>,
    /// The vertices of the sketch, in the coordinates it was uploaded in.
    #[schema(value_type = Vec<Vec<f64>>)]
    pub drawing: Vec<[f64; 2]>,
    /// What became of the mesh.
    pub strain: Strain,
    /// What became of the sketch; it has no volume.
    pub drawing_strain: Strain,
}
