use std::sync::Arc;

use tokio::runtime::Handle;

use super::once::once;
use crate::alignment::prepared::PreparedMesh;
use crate::mesh::TriangleMesh;
use crate::numerics::{Cancelled, Watch};
use crate::pipeline;
use crate::store::Store;

/// Prepared meshes out of the store, made and kept where they are not there yet; each by one job of all nodes.
pub struct CachedPreparations {
    store: Store,
    runtime: Handle,
}

impl CachedPreparations {
    /// To be used from threads outside the runtime, which is the calling one.
    pub fn new(store: Store) -> CachedPreparations {
        CachedPreparations { store, runtime: Handle::current() }
    }

    /// The same, out of this store, which is another tenant's.
    pub fn of(&self, store: Store) -> CachedPreparations {
        CachedPreparations { store, runtime: self.runtime.clone() }
    }
}

impl pipeline::Preparations for CachedPreparations {
    fn prepared(&self, mesh: &TriangleMesh, watch: &dyn Watch) -> Result<Arc<PreparedMesh>, Cancelled> {
        let hash = mesh.content_hash();
        // A cache that fails costs time, not the answer.
        let cached = || {
            let found = self.runtime.block_on(self.store.preparation(&hash));
            found.inspect_err(|error| tracing::warn!(%error, "no prepared mesh can be read")).ok().flatten()
        };
        let compute = || {
            let prepared = PreparedMesh::new(mesh, watch)?;
            if let Err(error) = self.runtime.block_on(self.store.put_preparation(&hash, &prepared)) {
                tracing::warn!(%error, "a prepared mesh cannot be kept");
            }
            Ok(prepared)
        };
        let name = self.store.preparation_name(&hash);
        once((&self.store, &self.runtime), &name, watch, cached, compute).map(Arc::new)
    }
}
