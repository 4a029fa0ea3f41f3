use std::sync::Arc;

use tokio::runtime::Handle;

use super::once::{Cache, once};
use super::shapes::Shapes;
use super::waiting::awaited;
use crate::mesh::TriangleMesh;
use crate::numerics::{Cancelled, Watch};
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
    fn cached(&self, key: &SpectrumKey, k: usize, watch: &dyn Watch) -> Result<Option<Spectrum>, Cancelled> {
        let found = awaited(&self.runtime, self.store.spectrum(key, k), || watch.proceed(0.0))?;
        Ok(found.inspect_err(|error| tracing::warn!(%error, "no spectrum can be read")).ok().flatten())
    }

    /// Keeps a spectrum, which is carried through where nobody waits for it any more.
    fn keep(
        &self,
        key: SpectrumKey,
        spectrum: Arc<Spectrum>,
        shape: Option<String>,
        watch: &dyn Watch,
    ) -> Result<(), Cancelled> {
        let store = self.store.clone();
        let kept = self.runtime.spawn(async move {
            if let Err(error) = store.put_spectrum(&key, spectrum, shape.as_deref()).await {
                tracing::warn!(%error, "a spectrum cannot be kept");
            }
        });
        awaited(&self.runtime, kept, || watch.proceed(1.0)).map(|_| ())
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
        let cached = || Ok(self.cached(&key, k, watch)?.map(Arc::new));
        let compute = || {
            let spectrum = Arc::new(spectral::spectrum(mesh, k, boundary, watch)?);
            self.keep(key, spectrum.clone(), self.shapes.of(mesh).map(str::to_owned), watch)?;
            Ok(spectrum)
        };
        let name = self.store.spectrum_name(&key, k);
        once((&self.store, &self.runtime), (Cache::Spectra, &name), watch, cached, compute)
    }
}
