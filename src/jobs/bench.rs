//! What jobs work with.

use tokio::runtime::Handle;

use super::preparations::CachedPreparations;
use super::shapes::Shapes;
use super::spectra::CachedSpectra;
use crate::store::{Job, Store};

/// The store, and what is kept there for all jobs.
pub struct Bench {
    pub store: Store,
    pub spectra: CachedSpectra,
    pub preparations: CachedPreparations,
    /// What computations wait for the store by.
    pub runtime: Handle,
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
}
