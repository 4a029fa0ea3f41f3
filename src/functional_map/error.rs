use crate::numerics::{Cancelled, DecompositionError};

/// Why there is no functional map.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum MapError {
    #[error("{matrix} has {} rows and {} columns where {} and {} belong", found.0, found.1, wanted.0, wanted.1)]
    Shape { matrix: &'static str, found: (usize, usize), wanted: (usize, usize) },
    #[error("{matrix} is not finite in row {row}, column {column}")]
    NotFinite { matrix: &'static str, row: usize, column: usize },
    #[error(transparent)]
    Decomposition(#[from] DecompositionError),
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}
