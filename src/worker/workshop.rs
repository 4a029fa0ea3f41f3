use std::time::Duration;

use rayon::ThreadPool;
use tokio_util::sync::CancellationToken;

use crate::jobs::{Bench, Outcome, Progress};
use crate::store::{Lease, Store};

/// How often progress is reported and the lease extended, a fraction of it.
const BEAT: Duration = Duration::from_millis(500);

/// What every attempt is carried out with.
pub(super) struct Workshop {
    pub bench: Bench,
    /// Cancelled when running jobs are to be given back.
    pub stop: CancellationToken,
    pub longest_job: Duration,
    /// How often progress is reported and the lease extended.
    pub beat: Duration,
    pub pool: ThreadPool,
    pub body: Box<Body>,
}

/// What a job does, on a thread of the pool.
type Body = dyn Fn(&Lease, &Bench, &Progress) -> Outcome + Send + Sync;

impl Workshop {
    /// A workshop whose computations wait for the store by the calling runtime.
    pub fn new(store: Store, pool: ThreadPool, longest_job: Duration, body: Box<Body>) -> Workshop {
        let (bench, stop) = (Bench::new(store), CancellationToken::new());
        Workshop { bench, stop, longest_job, beat: BEAT, pool, body }
    }

    pub fn store(&self) -> &Store {
        &self.bench.store
    }
}
