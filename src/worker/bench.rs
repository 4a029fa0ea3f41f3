use std::time::Duration;

use bytes::Bytes;
use rayon::ThreadPool;
use tokio::runtime::Handle;
use tokio_util::sync::CancellationToken;

use super::failure::Failure;
use super::preparations::CachedPreparations;
use super::progress::Progress;
use super::spectra::CachedSpectra;
use crate::store::{Lease, Store};

/// How often progress is reported and the lease extended, a fraction of it.
const BEAT: Duration = Duration::from_millis(500);

/// What every attempt works with.
pub(super) struct Bench {
    pub store: Store,
    pub spectra: CachedSpectra,
    pub preparations: CachedPreparations,
    pub runtime: Handle,
    /// Cancelled when running jobs are to be given back.
    pub stop: CancellationToken,
    pub longest_job: Duration,
    /// How often progress is reported and the lease extended.
    pub beat: Duration,
    pub pool: ThreadPool,
    pub body: Box<Body>,
}

/// What a job does, on a thread of the pool.
type Body = dyn Fn(&Bench, &Lease, &Progress) -> Outcome + Send + Sync;

/// The result's bytes.
pub(super) type Outcome = Result<Bytes, Failure>;

impl Bench {
    /// A bench whose computations wait for the store by the calling runtime.
    pub fn new(store: Store, pool: ThreadPool, longest_job: Duration, body: Box<Body>) -> Bench {
        let spectra = CachedSpectra::new(store.clone());
        let preparations = CachedPreparations::new(store.clone());
        let (runtime, stop) = (Handle::current(), CancellationToken::new());
        Bench { store, spectra, preparations, runtime, stop, longest_job, beat: BEAT, pool, body }
    }
}
