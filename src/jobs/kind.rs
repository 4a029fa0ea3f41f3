//! What a kind of job is.

use bytes::Bytes;
use serde::Serialize;
use serde::de::DeserializeOwned;

use super::waiting::Writing;
use super::{Bench, Failure, Progress};
use crate::store::{Lease, NewJob};

/// A kind of job; a value of it is what one job is to do, which is stored as JSON until its turn comes.
pub trait Task: Serialize + DeserializeOwned {
    /// The name it is stored and measured under.
    const NAME: &'static str;
    /// One in so many of the places in the queue are the most that jobs of this kind take.
    const ONE_PLACE_IN: usize = 1;
    /// Threads that jobs of this kind leave to others, where there are more than these.
    const THREADS_LEFT: usize = 0;
    /// What comes of it, stored as JSON.
    type Outcome: Serialize;

    /// The mesh and the sketch it needs: neither can be deleted until it has ended.
    fn shapes(&self) -> [Option<&str>; 2];

    /// Bytes of memory it takes, about, for each vertex of the larger of its shapes.
    fn bytes_per_vertex(&self) -> usize;

    /// Bytes of memory it takes, about, however large its shapes are.
    fn bytes_besides(&self) -> usize {
        0
    }

    /// Carries out the job of this id, on a thread outside the runtime. Whatever takes time asks `progress` whether to go
    /// on.
    ///
    /// # Errors
    /// [`Failure`].
    fn run(self, id: &str, bench: &Bench, progress: &Progress) -> Result<Self::Outcome, Failure>;

    /// The job as it is put into the queue, `payload` being this value in JSON.
    fn job<'a>(&'a self, payload: &'a str) -> NewJob<'a> {
        let [mesh, sketch] = self.shapes();
        let (bytes_per_vertex, bytes_besides) = (self.bytes_per_vertex(), self.bytes_besides());
        NewJob { mesh, sketch, bytes_per_vertex, bytes_besides, ..NewJob::of(Self::NAME, payload) }
    }
}

/// The result's bytes.
pub type Outcome = Result<Bytes, Failure>;

/// A kind of job, whatever its type.
pub struct Kind {
    /// As [`Task::NAME`].
    pub name: &'static str,
    one_place_in: usize,
    threads_left: usize,
    run: fn(&Lease, &Bench, &Progress) -> Outcome,
}

impl Kind {
    pub(super) const fn of<T: Task>() -> Kind {
        Kind { name: T::NAME, one_place_in: T::ONE_PLACE_IN, threads_left: T::THREADS_LEFT, run: run::<T> }
    }

    /// How many jobs of this kind may wait in a queue of so many places.
    pub fn places(&self, queue: usize) -> usize {
        queue.div_ceil(self.one_place_in)
    }

    /// How many of these threads jobs of this kind may take.
    pub fn threads(&self, all: usize) -> usize {
        all.saturating_sub(self.threads_left).max(1)
    }

    /// Carries out a job of this kind.
    ///
    /// # Errors
    /// [`Failure`].
    pub fn run(&self, lease: &Lease, bench: &Bench, progress: &Progress) -> Outcome {
        (self.run)(lease, bench, progress)
    }
}

fn run<T: Task>(lease: &Lease, bench: &Bench, progress: &Progress) -> Outcome {
    let task: T = serde_json::from_str(&lease.payload).map_err(|error| Failure::internal(error, false))?;
    let outcome = task.run(&lease.job.id, &bench.of(&lease.job), progress)?;
    let mut writing = Writing::new(|| progress.going());
    match serde_json::to_writer(&mut writing, &outcome) {
        Ok(()) => Ok(writing.bytes.into()),
        // Nothing else keeps bytes from being written to memory.
        Err(error) if error.is_io() => Err(Failure::Stopped),
        Err(error) => Err(Failure::internal(error, false)),
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use crate::jobs::KINDS;

    #[test]
    fn every_kind_has_a_name_of_its_own_a_place_and_a_thread() {
        assert_eq!(KINDS.iter().map(|kind| kind.name).collect::<BTreeSet<_>>().len(), KINDS.len());
        for kind in &KINDS {
            assert!(kind.places(1) == 1 && kind.threads(1) == 1 && kind.threads(8) > 1, "{}", kind.name);
        }
    }
}
