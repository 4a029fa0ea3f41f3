use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// Why an iteration ended. Neither is an error.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum Stopped {
    Converged,
    MaxIterations,
}

/// What an iterative solver did.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct Report {
    /// Iterations carried out; 0 for a direct solution.
    pub iterations: usize,
    /// The objective at the start and after every iteration; of a direct solution at the start and at its end.
    pub history: Vec<f64>,
    pub stopped: Stopped,
}

impl Report {
    /// The objective at the solution that was returned.
    pub fn objective(&self) -> f64 {
        self.history.last().copied().unwrap_or(f64::NAN)
    }

    /// That of this solver and of the `next`, which went on from its solution: what is told of the start of the second is left out.
    pub fn followed_by(self, next: Report) -> Report {
        let history = self.history.into_iter().chain(next.history.into_iter().skip(1));
        Report { iterations: self.iterations + next.iterations, history: history.collect(), stopped: next.stopped }
    }
}
