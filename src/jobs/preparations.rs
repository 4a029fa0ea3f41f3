use std::sync::Arc;

use tokio::runtime::Handle;

use super::single_flight::SingleFlight;
use crate::alignment::prepared::PreparedMesh;
use crate::mesh::TriangleMesh;
use crate::numerics::{Cancelled, Watch};
use crate::pipeline;
use crate::store::Store;

/// Prepared meshes out of the store, made and kept where they are not there yet; each by one job at a time.
pub struct CachedPreparations {
    store: Store,
    runtime: Handle,
    /// By the folder of the caches they are kept in, and the mesh they are of.
    flights: Arc<SingleFlight<(String, blake3::Hash)>>,
}

impl CachedPreparations {
    /// To be used from threads outside the runtime, which is the calling one.
    pub fn new(store: Store) -> CachedPreparations {
        CachedPreparations { store, runtime: Handle::current(), flights: Arc::new(SingleFlight::new()) }
    }

    /// The same, out of this store, which is another tenant's.
    pub fn of(&self, store: Store) -> CachedPreparations {
        CachedPreparations { store, runtime: self.runtime.clone(), flights: self.flights.clone() }
    }
}

impl pipeline::Preparations for CachedPreparations {
    fn prepared(&self, mesh: &TriangleMesh, watch: &dyn Watch) -> Result<Arc<PreparedMesh>, Cancelled> {
        let hash = mesh.content_hash();
        let _flight = self.flights.board((self.store.caches(), hash), watch)?;
        // A cache that fails costs time, not the answer.
        let cached = self.runtime.block_on(self.store.preparation(&hash));
        if let Ok(Some(prepared)) = cached.inspect_err(|error| tracing::warn!(%error, "no prepared mesh can be read")) {
            return Ok(Arc::new(prepared));
        }
        let prepared = PreparedMesh::new(mesh, watch)?;
        if let Err(error) = self.runtime.block_on(self.store.put_preparation(&hash, &prepared)) {
            tracing::warn!(%error, "a prepared mesh cannot be kept");
        }
        Ok(Arc::new(prepared))
    }
}
