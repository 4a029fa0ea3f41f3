//! What jobs work with.

use tokio::runtime::Handle;

use super::preparations::CachedPreparations;
use super::spectra::CachedSpectra;
use crate::access::Tenant;
use crate::store::Store;

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

    /// The same bench with what this tenant has.
    pub fn of(&self, tenant: &Tenant) -> Bench {
        let store = self.store.of(tenant);
        let (spectra, preparations) = (self.spectra.of(store.clone()), self.preparations.of(store.clone()));
        Bench { store, spectra, preparations, runtime: self.runtime.clone() }
    }
}
