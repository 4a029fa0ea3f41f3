//! What jobs work with.

use std::future::Future;

use tokio::runtime::Handle;

use super::preparations::CachedPreparations;
use super::shapes::Shapes;
use super::spectra::CachedSpectra;
use super::waiting::awaited;
use super::{Failure, Progress};
use crate::store::{Job, Store, StoreError};

/// The store, and what is kept there for all jobs.
pub struct Bench {
    pub store: Store,
    pub spectra: CachedSpectra,
    pub preparations: CachedPreparations,
    runtime: Handle,
}

impl Bench {
    /// A bench whose computations wait for the store by the calling runtime.
    pub fn new(store: Store) -> Bench {
        let (spectra, preparations) = (CachedSpectra::new(store.clone()), CachedPreparations::new(store.clone()));
        Bench { store, spectra, preparations, runtime: Handle::current() }
    }

    /// The same bench for one job, with what its tenant has.
    pub fn of(&self, job: &Job) -> Bench {
        let (store, shapes) = (self.store.of(&job.tenant), Shapes::from(job));
        let spectra = self.spectra.of(store.clone(), shapes.clone());
        let preparations = self.preparations.of(store.clone(), shapes);
        Bench { store, spectra, preparations, runtime: self.runtime.clone() }
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
