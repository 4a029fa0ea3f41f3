use std::sync::Arc;

use tokio::runtime::Handle;

use super::once::once;
use super::shapes::Shapes;
use crate::alignment::prepared::PreparedMesh;
use crate::mesh::TriangleMesh;
use crate::numerics::{Cancelled, Watch};
use crate::pipeline;
use crate::store::Store;

/// Prepared meshes out of the store, made and kept where they are not there yet; each by one job of all nodes.
pub struct CachedPreparations {
    store: Store,
    runtime: Handle,
    /// Those of the job it is for.
    shapes: Shapes,
}

impl CachedPreparations {
    /// To be used from threads outside the runtime, which is the calling one.
    pub fn new(store: Store) -> CachedPreparations {
        CachedPreparations { store, runtime: Handle::current(), shapes: Shapes::default() }
    }

    /// The same for a job of these shapes, out of the store of its tenant.
    pub fn of(&self, store: Store, shapes: Shapes) -> CachedPreparations {
        CachedPreparations { store, runtime: self.runtime.clone(), shapes }
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
            if let Err(error) =
                self.runtime.block_on(self.store.put_preparation(&hash, &prepared, self.shapes.of(mesh)))
            {
                tracing::warn!(%error, "a prepared mesh cannot be kept");
            }
            Ok(prepared)
        };
        let name = self.store.preparation_name(&hash);
        once((&self.store, &self.runtime), &name, watch, cached, compute).map(Arc::new)
    }
}
