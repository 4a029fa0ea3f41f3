//! Why no alignment is found.

use crate::numerics::Cancelled;
use crate::numerics::cholesky::FactorisationError;

/// Why no alignment was found.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum AlignmentError {
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    #[error("the sketch cannot be laid on the mesh: {0}")]
    Factorisation(#[from] FactorisationError),
}
