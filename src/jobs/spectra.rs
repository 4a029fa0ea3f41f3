use std::sync::Arc;

use tokio::runtime::Handle;

use super::once::once;
use super::shapes::Shapes;
use crate::mesh::TriangleMesh;
use crate::numerics::Watch;
use crate::pipeline;
use crate::spectral::{self, Boundary, SpectralError, Spectrum};
use crate::store::{SpectrumKey, Store};

/// Spectra out of the store, computed and kept where they are not there yet; each by one job of all nodes.
pub struct CachedSpectra {
    store: Store,
    runtime: Handle,
    /// Those of the job it is for.
    shapes: Shapes,
}

impl CachedSpectra {
    /// To be used from threads outside the runtime, which is the calling one.
    pub fn new(store: Store) -> CachedSpectra {
        CachedSpectra { store, runtime: Handle::current(), shapes: Shapes::default() }
    }

    /// The same for a job of these shapes, out of the store of its tenant.
    pub fn of(&self, store: Store, shapes: Shapes) -> CachedSpectra {
        CachedSpectra { store, runtime: self.runtime.clone(), shapes }
    }

    /// A cache that fails costs time, not the answer.
    fn cached(&self, key: &SpectrumKey, k: usize) -> Option<Spectrum> {
        let found = self.runtime.block_on(self.store.spectrum(key, k));
        found.inspect_err(|error| tracing::warn!(%error, "no spectrum can be read")).ok().flatten()
    }

    fn keep(&self, key: &SpectrumKey, spectrum: &Spectrum, shape: Option<&str>) {
        if let Err(error) = self.runtime.block_on(self.store.put_spectrum(key, spectrum, shape)) {
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
        let compute = || {
            let spectrum = spectral::spectrum(mesh, k, boundary, watch)?;
            self.keep(&key, &spectrum, self.shapes.of(mesh));
            Ok(spectrum)
        };
        once((&self.store, &self.runtime), &self.store.spectrum_name(&key, k), watch, || self.cached(&key, k), compute)
            .map(Arc::new)
    }
}
