//! The method in order: a request and two shapes in, correspondences and the functional map out.

pub mod request;

use crate::numerics::Cancelled;

/// The stages of a match in their order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize, utoipa::ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum Stage {
    Spectrum,
    Descriptors,
    Regions,
    Map,
    Points,
}

/// Whoever waits for a match: told of every stage, asked at every iteration whether to go on.
pub trait Watcher: Sync {
    /// `fraction` of the whole match is done, in `[0, 1]`, and `stage` is under way.
    ///
    /// # Errors
    /// [`Cancelled`] when nobody waits any more.
    fn proceed(&self, stage: Stage, fraction: f64) -> Result<(), Cancelled>;
}

/// One thing wrong with a request, and where.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize, utoipa::ToSchema)]
pub struct Fault {
    /// JSON pointer into the request, RFC 6901.
    pub pointer: String,
    pub detail: String,
}
