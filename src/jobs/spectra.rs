use std::sync::Arc;

use tokio::runtime::Handle;

use super::single_flight::SingleFlight;
use crate::mesh::TriangleMesh;
use crate::numerics::Watch;
use crate::numerics::block_lanczos::EigenError;
use crate::pipeline;
use crate::spectral::{self, Boundary, SpectralError, Spectrum};
use crate::store::{SpectrumKey, Store};

/// Spectra out of the store, computed and kept where they are not there yet; each by one job at a time.
pub struct CachedSpectra {
    store: Store,
    runtime: Handle,
    /// By the folder of the caches they are kept in, and what they are of.
    flights: Arc<SingleFlight<(String, SpectrumKey)>>,
}

impl CachedSpectra {
    /// To be used from threads outside the runtime, which is the calling one.
    pub fn new(store: Store) -> CachedSpectra {
        CachedSpectra { store, runtime: Handle::current(), flights: Arc::new(SingleFlight::new()) }
    }

    /// The same, out of this store, which is another tenant's.
    pub fn of(&self, store: Store) -> CachedSpectra {
        CachedSpectra { store, runtime: self.runtime.clone(), flights: self.flights.clone() }
    }

    /// A cache that fails costs time, not the answer.
    fn cached(&self, key: &SpectrumKey, k: usize) -> Option<Spectrum> {
        let found = self.runtime.block_on(self.store.spectrum(key, k));
        found.inspect_err(|error| tracing::warn!(%error, "no spectrum can be read")).ok().flatten()
    }

    fn keep(&self, key: &SpectrumKey, spectrum: &Spectrum) {
        if let Err(error) = self.runtime.block_on(self.store.put_spectrum(key, spectrum)) {
            tracing::warn!(%error, "a spectrum cannot be kept");
        }
    }
}

impl pipeline::Spectra for CachedSpectra {
    fn spectrum(
        &self,
        mesh: &TriangleMesh,
        k: usize,
        boundary: Boundary,
        watch: &dyn Watch,
    ) -> Result<Arc<Spectrum>, SpectralError> {
        let key = SpectrumKey { shape_hash: mesh.content_hash(), boundary };
        let _flight = self.flights.board((self.store.caches(), key), watch).map_err(EigenError::from)?;
        if let Some(spectrum) = self.cached(&key, k) {
            return Ok(Arc::new(spectrum));
        }
        let spectrum = spectral::spectrum(mesh, k, boundary, watch)?;
        self.keep(&key, &spectrum);
        Ok(Arc::new(spectrum))
    }
}
