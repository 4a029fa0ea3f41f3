//! The method in order: a request and two shapes in, correspondences and the functional map out.
//!
//! Both shapes are scaled to area 1 here; what comes back is in the units and the numbering of the user's files.

mod aligned;
mod bases;
mod computing;
mod constraints;
mod figure;
mod inside;
mod landmarks;
mod map;
pub mod outcome;
mod regions;
pub mod request;
mod run;
pub mod settings;
mod stages;
#[cfg(test)]
mod tests;

use std::sync::Arc;

use crate::alignment::AlignmentError;
use crate::alignment::prepared::PreparedMesh;
use crate::correspondence::icp::IcpError;
use crate::functional_map::MapError;
use crate::mesh::TriangleMesh;
use crate::numerics::block_lanczos::EigenError;
use crate::numerics::{Cancelled, Watch};
use crate::spectral::{Boundary, SpectralError, Spectrum};
use outcome::MatchResult;

pub use bases::Bases;
pub use computing::Computing;
pub use constraints::kept;
pub use figure::faults_on_shapes;
pub use inside::{Inside, functions};
pub use regions::segmented;
pub use run::run;
pub use settings::{Settings, check};
pub use stages::{Stage, TOTAL};

/// What a match needs of the world outside.
pub struct Surroundings<'a> {
    pub spectra: &'a dyn Spectra,
    pub preparations: &'a dyn Preparations,
    pub watcher: &'a dyn Watcher,
    /// Milliseconds since some moment; for `timings_ms` alone.
    pub clock: &'a dyn Fn() -> f64,
    /// Who wants the answer at first sight, before poses of the mesh are looked for.
    pub preview: Option<&'a dyn Fn(MatchResult)>,
}

/// Where spectra come from: computed, or out of a cache.
pub trait Spectra: Sync {
    /// The first k eigenpairs of a connected mesh whose every vertex has a triangle, or more than k.
    ///
    /// # Errors
    /// As [`crate::spectral::spectrum`].
    fn spectrum(
        &self,
        mesh: &TriangleMesh,
        k: usize,
        boundary: Boundary,
        watch: &dyn Watch,
    ) -> Result<Arc<Spectrum>, SpectralError>;
}

/// Where meshes made ready for the alignment come from: made, or out of a cache.
pub trait Preparations: Sync {
    /// A connected mesh whose every vertex has a triangle, made ready.
    ///
    /// # Errors
    /// [`Cancelled`] by the watcher.
    fn prepared(&self, mesh: &TriangleMesh, watch: &dyn Watch) -> Result<Arc<PreparedMesh>, Cancelled>;
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

impl Fault {
    fn new(pointer: impl Into<String>, detail: impl Into<String>) -> Fault {
        Fault { pointer: pointer.into(), detail: detail.into() }
    }
}

/// Why a match has no result.
#[derive(Debug, thiserror::Error)]
pub enum MatchError {
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    /// The shapes cannot be matched as asked.
    #[error("the match cannot be carried out as asked: {}", listed(.0))]
    Faults(Vec<Fault>),
    #[error("the eigenfunctions of the {shape} cannot be computed: {error}")]
    Spectrum { shape: &'static str, error: SpectralError },
    #[error(transparent)]
    Alignment(AlignmentError),
    #[error(transparent)]
    Map(MapError),
    #[error(transparent)]
    Refinement(IcpError),
}

fn listed(faults: &[Fault]) -> String {
    let faults: Vec<String> = faults.iter().map(|fault| format!("{}: {}", fault.pointer, fault.detail)).collect();
    faults.join("; ")
}

impl MatchError {
    /// The spectrum of a shape failed, its length given at `pointer`.
    fn of_spectrum(shape: &'static str, pointer: &str, error: SpectralError) -> MatchError {
        match error {
            SpectralError::TooMany { k, most } => {
                let detail = format!("{k} eigenfunctions of the {shape} were asked for, it has {most} free vertices");
                MatchError::Faults(vec![Fault::new(pointer, detail)])
            }
            SpectralError::Eigen(EigenError::Cancelled(cancelled)) => MatchError::Cancelled(cancelled),
            error => MatchError::Spectrum { shape, error },
        }
    }
}

impl From<AlignmentError> for MatchError {
    fn from(error: AlignmentError) -> MatchError {
        match error {
            AlignmentError::Cancelled(cancelled) => MatchError::Cancelled(cancelled),
            error => MatchError::Alignment(error),
        }
    }
}

impl From<MapError> for MatchError {
    fn from(error: MapError) -> MatchError {
        match error {
            MapError::Cancelled(cancelled) => MatchError::Cancelled(cancelled),
            error => MatchError::Map(error),
        }
    }
}

impl From<IcpError> for MatchError {
    fn from(error: IcpError) -> MatchError {
        match error {
            IcpError::Cancelled(cancelled) => MatchError::Cancelled(cancelled),
            error => MatchError::Refinement(error),
        }
    }
}
