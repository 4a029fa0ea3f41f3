//! Why no alignment is found.

use crate::numerics::cholesky::FactorisationError;
use crate::numerics::{Cancelled, DecompositionError};

/// Why no alignment was found.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum AlignmentError {
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    #[error("the sketch cannot be laid on the mesh: {0}")]
    Factorisation(#[from] FactorisationError),
    #[error("what the landmarks miss cannot be spread over the sketch: {0}")]
    Decomposition(#[from] DecompositionError),
}
