use std::sync::Arc;

use tokio::runtime::Handle;

use super::once::{Cache, once};
use super::shapes::Shapes;
use super::waiting::awaited;
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
            let found = awaited(&self.runtime, self.store.preparation(&hash), || watch.proceed(0.0))?;
            let found = found.inspect_err(|error| tracing::warn!(%error, "no prepared mesh can be read"));
            Ok(found.ok().flatten().map(Arc::new))
        };
        let compute = || {
            let prepared = Arc::new(PreparedMesh::new(mesh, watch)?);
            let (store, made) = (self.store.clone(), prepared.clone());
            let shape = self.shapes.of(mesh).map(str::to_owned);
            // Carried through where nobody waits for it any more.
            let kept = self.runtime.spawn(async move {
                if let Err(error) = store.put_preparation(&hash, made, shape.as_deref()).await {
                    tracing::warn!(%error, "a prepared mesh cannot be kept");
                }
            });
            awaited(&self.runtime, kept, || watch.proceed(0.5)).map(|_| prepared)
        };
        let name = self.store.preparation_name(&hash);
        once((&self.store, &self.runtime), (Cache::Preparations, &name), watch, cached, compute)
    }
}
