use std::fmt::Display;

use serde_json::{Value, json};

use crate::numerics::block_lanczos::EigenError;
use crate::pipeline::{Fault, MatchError};
use crate::spectral::SpectralError;
use crate::store::{StoreError, problem};

/// Why a job has no result.
#[derive(Debug)]
pub(super) enum Failure {
    /// It was told to stop.
    Stopped,
    /// It cannot succeed, or with `retry` may do so another time.
    Problem { problem: Value, retry: bool },
}

impl Failure {
    /// What was asked for cannot be done; `faults` tell the places.
    pub fn refused(detail: impl Display, faults: &[Fault]) -> Failure {
        let mut problem = problem(422, "Unprocessable Entity", detail);
        if !faults.is_empty() {
            problem["errors"] = json!(faults);
        }
        Failure::Problem { problem, retry: false }
    }

    /// The fault is ours: `cause` is for the log.
    pub fn internal(cause: impl Display, retry: bool) -> Failure {
        tracing::error!(%cause, "a job failed");
        let problem = problem(500, "Internal Server Error", "the computation failed; the log of the server says why");
        Failure::Problem { problem, retry }
    }
}

impl From<StoreError> for Failure {
    fn from(error: StoreError) -> Failure {
        Failure::internal(error, true)
    }
}

impl From<SpectralError> for Failure {
    fn from(error: SpectralError) -> Failure {
        match error {
            SpectralError::Eigen(EigenError::Cancelled(_)) => Failure::Stopped,
            error => Failure::refused(error, &[]),
        }
    }
}

impl From<MatchError> for Failure {
    fn from(error: MatchError) -> Failure {
        match error {
            MatchError::Cancelled(_) => Failure::Stopped,
            MatchError::Faults(ref faults) => Failure::refused(&error, faults),
            error => Failure::refused(error, &[]),
        }
    }
}
