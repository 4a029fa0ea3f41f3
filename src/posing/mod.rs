//! The application of a match (chapter 5): the drawing is moved by handles and the mesh takes its deformation, or the mesh
//! takes the pose it is drawn in.

mod basis;
mod maps;
mod of_file;
pub mod outcome;
pub mod request;
mod run;
mod seen;

use std::sync::Arc;

use crate::deformation::biharmonic_weights::{self, Weights};
use crate::deformation::handles::Held;
use crate::numerics::bounded_quadratic::QuadraticError;
use crate::numerics::cholesky::FactorisationError;
use crate::numerics::{Cancelled, Watch};
use crate::picture::Unfit;
use crate::pipeline::{Computing, Fault};

pub use basis::{Basis, basis};
pub use maps::faults;
pub use run::run;

/// Where the weights of handles come from: computed, or out of a cache.
pub trait WeightSource: Sync {
    /// Those of a drawing that is held so.
    ///
    /// # Errors
    /// [`QuadraticError`].
    fn weights(&self, held: &Held, watch: &dyn Watch) -> Result<Arc<Weights>, QuadraticError>;
}

impl WeightSource for Computing {
    fn weights(&self, held: &Held, watch: &dyn Watch) -> Result<Arc<Weights>, QuadraticError> {
        biharmonic_weights::weights(held, watch).map(Arc::new)
    }
}

/// Why a mesh is not posed.
#[derive(Debug, thiserror::Error)]
pub enum PoseError {
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    /// It cannot be posed as asked.
    #[error("the mesh cannot be posed as asked")]
    Faults(Vec<Fault>),
    #[error(transparent)]
    Unfit(#[from] Unfit),
    #[error("the deformation cannot be computed: {0}")]
    Factorisation(#[from] FactorisationError),
}

impl From<QuadraticError> for PoseError {
    fn from(error: QuadraticError) -> PoseError {
        match error {
            QuadraticError::Cancelled(cancelled) => PoseError::Cancelled(cancelled),
            QuadraticError::Factorisation(error) => PoseError::Factorisation(error),
        }
    }
}
