//! What jobs work with.

use std::future::Future;

use tokio::runtime::Handle;

use super::caches::Caches;
use super::shapes::Shapes;
use super::waiting::awaited;
use super::{Failure, Progress};
use crate::store::{Job, Store, StoreError};

/// The store, and what is kept there for all jobs.
pub struct Bench {
    pub store: Store,
    pub caches: Caches,
    runtime: Handle,
}

impl Bench {
    /// A bench whose computations wait for the store by the calling runtime.
    pub fn new(store: Store) -> Bench {
        Bench { caches: Caches::new(store.clone()), store, runtime: Handle::current() }
    }

    /// The same bench for one job, with what its tenant has.
    pub fn of(&self, job: &Job) -> Bench {
        let (store, shapes) = (self.store.of(&job.tenant), Shapes::from(job));
        Bench { caches: self.caches.of(store.clone(), shapes), store, runtime: self.runtime.clone() }
    }

    /// What the store answers, waited for as long as the job is to go on.
    ///
    /// # Errors
    /// [`Failure`] of the store, or where the job is told to stop.
    pub fn answer<T>(
        &self,
        asked: impl Future<Output = Result<T, StoreError>>,
        progress: &Progress,
    ) -> Result<T, Failure> {
        Ok(awaited(&self.runtime, asked, || progress.going())??)
    }
}
