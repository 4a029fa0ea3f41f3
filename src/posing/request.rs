//! What a pose is asked to be, as the user sends it. Points are in the coordinates the sketch was uploaded in.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// Handles of a request, and weights that all of them together make: a cage has one for every corner.
pub const MAX_HANDLES: usize = 64;
pub const MAX_WEIGHTS: usize = 64;
/// Corners of a cage.
pub const CORNERS: std::ops::RangeInclusive<usize> = 3..=64;
/// Frames of a request, and places of vertices in all of them together: some 100 MiB of JSON.
pub const MAX_FRAMES: usize = 240;
pub const MAX_PLACES: usize = 2_000_000;

/// A pose as the user asks for it: a match, and either `handles` with `frames`, or `sketch`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct PoseRequest {
    /// Id of a match that succeeded: its mesh is posed.
    #[serde(rename = "match")]
    pub matching: String,
    /// What its sketch is moved by.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(min_items = 1, max_items = 64)]
    pub handles: Option<Vec<HandleRequest>>,
    /// The poses: each a map for every handle, in their order.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(min_items = 1, max_items = 240)]
    pub frames: Option<Vec<Vec<MapRequest>>>,
    /// Id of the sketch of the match: the mesh takes the pose it is drawn in. For the pose of another drawing name its match
    /// with the mesh.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sketch: Option<String>,
}

/// Something on the sketch by which it is moved.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(tag = "type", rename_all = "snake_case", deny_unknown_fields)]
pub enum HandleRequest {
    /// A point and what is around it.
    Point {
        #[schema(value_type = Vec<f64>, min_items = 2, max_items = 2)]
        at: [f64; 2],
    },
    /// A bone of a skeleton: the line between two points and what is around it.
    Bone {
        #[schema(value_type = Vec<f64>, min_items = 2, max_items = 2)]
        from: [f64; 2],
        #[schema(value_type = Vec<f64>, min_items = 2, max_items = 2)]
        to: [f64; 2],
    },
    /// A closed polygon that does not cross itself, around the sketch or a part of it.
    Cage {
        #[schema(value_type = Vec<Vec<f64>>, min_items = 3, max_items = 64)]
        points: Vec<[f64; 2]>,
    },
}

/// Where a handle goes in a frame.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(tag = "type", rename_all = "snake_case", deny_unknown_fields)]
pub enum MapRequest {
    /// Nowhere.
    Stay {},
    Translation {
        #[schema(value_type = Vec<f64>, min_items = 2, max_items = 2)]
        by: [f64; 2],
    },
    /// A turn, and after it a translation.
    Rotation {
        /// Counter-clockwise as the sketch is seen.
        degrees: f64,
        /// What it turns about; by default the point, where the bone begins, or the mean of the cage's corners.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        #[schema(value_type = Option<Vec<f64>>, min_items = 2, max_items = 2)]
        about: Option<[f64; 2]>,
        #[serde(default)]
        #[schema(value_type = Vec<f64>, min_items = 2, max_items = 2, required = false)]
        by: [f64; 2],
    },
    /// (x, y) goes to (a x + b y + c, d x + e y + f).
    Affine {
        /// `[[a, b, c], [d, e, f]]`, of positive determinant a e − b d.
        #[schema(value_type = Vec<Vec<f64>>, min_items = 2, max_items = 2)]
        matrix: [[f64; 3]; 2],
    },
    /// New places of a cage's corners, in their order.
    Corners {
        #[schema(value_type = Vec<Vec<f64>>, min_items = 3, max_items = 64)]
        points: Vec<[f64; 2]>,
    },
}
