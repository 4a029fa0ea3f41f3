use std::fmt::Display;
use std::time::Duration;

use serde_json::{Value, json};

use crate::numerics::Cancelled;
use crate::numerics::block_lanczos::EigenError;
use crate::numerics::cholesky::FactorisationError;
use crate::pipeline::{Fault, MatchError};
use crate::spectral::SpectralError;
use crate::store::{StoreError, problem};

/// Why a job has no result.
#[derive(Debug)]
pub enum Failure {
    /// It was told to stop.
    Stopped,
    /// The process lacked what it takes, which is no fault of the job.
    Lacking,
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

    /// It took longer than a job may.
    pub fn overdue(longest: Duration) -> Failure {
        Failure::refused(format_args!("it took longer than the {} s a job may take here", longest.as_secs_f64()), &[])
    }

    /// The fault is ours: `cause` is for the log.
    pub fn internal(cause: impl Display, retry: bool) -> Failure {
        tracing::error!(%cause, "a job failed");
        let problem = problem(500, "Internal Server Error", "the computation failed; the log of the server says why");
        Failure::Problem { problem, retry }
    }

    /// No spectrum: refused where the shape is to blame, else our fault; `told` says it in full.
    fn spectral(cause: SpectralError, told: impl Display) -> Failure {
        match cause {
            SpectralError::TooMany { .. }
            | SpectralError::NoMass
            | SpectralError::Eigen(EigenError::Factorisation(FactorisationError::NotPositiveDefinite)) => {
                Failure::refused(told, &[])
            }
            SpectralError::Eigen(EigenError::NotConverged) => {
                // With thin triangles rounding alone is above what is asked of a residual; with others we want to know.
                tracing::warn!("{told}");
                Failure::refused(format_args!("{told}, as happens where triangles are very thin"), &[])
            }
            SpectralError::Eigen(_) => Failure::internal(told, false),
        }
    }
}

impl From<Cancelled> for Failure {
    fn from(_: Cancelled) -> Failure {
        Failure::Stopped
    }
}

impl From<StoreError> for Failure {
    fn from(error: StoreError) -> Failure {
        if error.lack().is_some() {
            tracing::warn!(%error, "a job cannot be carried out now");
            return Failure::Lacking;
        }
        let Some(remedy) = error.remedy() else { return Failure::internal(error, true) };
        tracing::error!(%error, "a job failed");
        Failure::Problem { problem: problem(500, "Internal Server Error", remedy), retry: false }
    }
}

impl From<SpectralError> for Failure {
    fn from(error: SpectralError) -> Failure {
        match error {
            SpectralError::Eigen(EigenError::Cancelled(_)) => Failure::Stopped,
            error => Failure::spectral(error, error),
        }
    }
}

impl From<MatchError> for Failure {
    fn from(error: MatchError) -> Failure {
        match error {
            MatchError::Cancelled(_) => Failure::Stopped,
            MatchError::Faults(ref faults) => Failure::refused(&error, faults),
            MatchError::Spectrum { error: cause, .. } => Failure::spectral(cause, error),
            MatchError::Alignment(_) | MatchError::Map(_) | MatchError::Refinement(_) => {
                Failure::internal(error, false)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::correspondence::icp::IcpError;
    use crate::functional_map::MapError;
    use crate::numerics::DecompositionError;

    /// The status of the problem a job is left with; nothing where it was stopped.
    fn status(failure: impl Into<Failure>) -> Option<u64> {
        match failure.into() {
            Failure::Stopped | Failure::Lacking => None,
            Failure::Problem { problem, .. } => problem["status"].as_u64(),
        }
    }

    fn of_factor(error: FactorisationError) -> SpectralError {
        SpectralError::Eigen(EigenError::Factorisation(error))
    }

    #[test]
    fn what_the_shapes_rule_out_is_refused() {
        for error in [
            SpectralError::TooMany { k: 7, most: 6 },
            SpectralError::NoMass,
            SpectralError::Eigen(EigenError::NotConverged),
            of_factor(FactorisationError::NotPositiveDefinite),
        ] {
            assert_eq!(status(error), Some(422), "{error}");
            assert_eq!(status(MatchError::Spectrum { shape: "mesh", error }), Some(422), "{error}");
        }
        let fault = Fault { pointer: "/basis/k".to_owned(), detail: "too many".to_owned() };
        assert_eq!(status(MatchError::Faults(vec![fault])), Some(422));
    }

    #[test]
    fn what_we_could_not_do_is_our_fault() {
        for error in [of_factor(FactorisationError::Singular), of_factor(FactorisationError::OutOfMemory)] {
            assert_eq!(status(error), Some(500), "{error}");
            assert_eq!(status(MatchError::Spectrum { shape: "mesh", error }), Some(500), "{error}");
        }
        let decomposition = DecompositionError::Eigenvalues { size: 3 };
        for error in [
            MapError::Shape { matrix: "C", found: (1, 2), wanted: (2, 1) },
            MapError::NotFinite { matrix: "C", row: 0, column: 0 },
            MapError::Decomposition(decomposition),
        ] {
            assert_eq!(status(MatchError::Map(error)), Some(500), "{error}");
        }
        assert_eq!(status(MatchError::Refinement(IcpError::Decomposition(decomposition))), Some(500));
    }

    #[test]
    fn who_is_told_to_stop_leaves_no_problem() {
        assert_eq!(status(SpectralError::Eigen(EigenError::Cancelled(Cancelled))), None);
        assert_eq!(status(MatchError::Cancelled(Cancelled)), None);
    }
}
