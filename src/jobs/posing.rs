//! A matched mesh, posed.

use std::time::Instant;

use serde::{Deserialize, Serialize};

use super::{Bench, Failure, Progress, Task, memory};
use crate::pipeline::outcome::MatchResult;
use crate::posing::outcome::PoseResult;
use crate::posing::request::PoseRequest;
use crate::posing::{self, PoseError};

/// Which pose, and the shapes of the match it is of, by their ids.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Posing {
    pub request: PoseRequest,
    pub mesh: String,
    pub sketch: String,
}

impl Task for Posing {
    const NAME: &'static str = "pose";
    /// Matches are not to find the queue full of poses.
    const ONE_PLACE_IN: usize = 2;
    type Outcome = PoseResult;

    fn shapes(&self) -> [Option<&str>; 2] {
        [Some(&self.mesh), Some(&self.sketch)]
    }

    fn bytes_per_vertex(&self) -> usize {
        memory::of_pose()
    }

    fn run(self, id: &str, bench: &Bench, progress: &Progress) -> Result<PoseResult, Failure> {
        let Posing { request, mesh, sketch } = self;
        let missing = |noun: &str, id: &str| Failure::refused(format_args!("there is no {noun} {id}"), &[]);
        let flat = bench.answer(bench.store.sketch(&sketch), progress)?.ok_or_else(|| missing("sketch", &sketch))?;
        let solid = bench.answer(bench.store.mesh(&mesh), progress)?.ok_or_else(|| missing("mesh", &mesh))?;
        // The match may have been deleted since.
        let result = bench.answer(bench.store.result(&request.matching), progress)?;
        let result = result.ok_or_else(|| missing("result of match", &request.matching))?;
        let matched: MatchResult = serde_json::from_slice(&result).map_err(|error| Failure::internal(error, false))?;
        let begun = Instant::now();
        let clock = || begun.elapsed().as_secs_f64() * 1e3;
        let result = posing::run(&flat, &solid, &matched, &request, &bench.caches, &progress.stage("posing"), &clock)?;
        Ok(PoseResult { id: Some(id.to_owned()), ..result })
    }
}

impl From<PoseError> for Failure {
    fn from(error: PoseError) -> Failure {
        match error {
            PoseError::Cancelled(_) => Failure::Stopped,
            PoseError::Faults(ref faults) => Failure::refused(&error, faults),
            PoseError::Unfit(_) | PoseError::Factorisation(_) => Failure::internal(error, false),
        }
    }
}
