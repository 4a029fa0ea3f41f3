//! What is computed once and kept: spectra, prepared meshes, weights of handles.

use std::future::Future;
use std::sync::Arc;

use tokio::runtime::Handle;

use super::once::{Cache, once};
use super::shapes::Shapes;
use super::waiting::awaited;
use crate::alignment::prepared::PreparedMesh;
use crate::deformation::biharmonic_weights::{Weights, weights};
use crate::deformation::handles::Held;
use crate::mesh::TriangleMesh;
use crate::numerics::bounded_quadratic::QuadraticError;
use crate::numerics::{Cancelled, Watch};
use crate::pipeline;
use crate::posing;
use crate::spectral::{self, Boundary, SpectralError, Spectrum};
use crate::store::{SpectrumKey, Store, StoreError};

/// Values out of the store, computed and kept where they are not there yet; each by one job of all nodes.
pub struct Caches {
    store: Store,
    runtime: Handle,
    /// Those of the job it is for.
    shapes: Shapes,
    /// Whether spectra of other instruction sets will do where there is none of its own.
    of_any: bool,
}

impl Caches {
    /// To be used from threads outside the runtime, which is the calling one.
    pub fn new(store: Store) -> Caches {
        Caches { store, runtime: Handle::current(), shapes: Shapes::default(), of_any: false }
    }

    /// The same for who looks at a match of these shapes: with the spectra of the node that its job ran on, if there are none of
    /// this one.
    pub fn of_match(store: Store, mesh: &str, sketch: &str) -> Caches {
        Caches { shapes: Shapes::of_match(mesh, sketch), of_any: true, ..Caches::new(store) }
    }

    /// The same for a job of these shapes, out of the store of its tenant.
    pub fn of(&self, store: Store, shapes: Shapes) -> Caches {
        Caches { store, runtime: self.runtime.clone(), shapes, of_any: self.of_any }
    }

    /// The spectrum that is kept.
    async fn kept_spectrum(&self, key: &SpectrumKey, k: usize) -> Result<Option<Spectrum>, StoreError> {
        if self.of_any { self.store.spectrum_of_any(key, k).await } else { self.store.spectrum(key, k).await }
    }

    /// What is kept by that name, or what `compute` makes, kept then. A cache that fails costs time, not the answer.
    fn get<T, E, Found, Put>(
        &self,
        (cache, name): (Cache, &str),
        watch: &dyn Watch,
        read: impl Fn() -> Found,
        compute: impl FnOnce() -> Result<T, E>,
        keep: impl FnOnce(Store, Arc<T>) -> Put,
    ) -> Result<Arc<T>, E>
    where
        E: From<Cancelled>,
        Found: Future<Output = Result<Option<T>, StoreError>>,
        Put: Future<Output = Result<(), StoreError>> + Send + 'static,
    {
        let cached = || {
            let found = awaited(&self.runtime, read(), || watch.proceed(0.0))?;
            let found = found.inspect_err(|error| tracing::warn!(%error, name, "what is cached cannot be read"));
            Ok(found.ok().flatten().map(Arc::new))
        };
        let made = || {
            let made = Arc::new(compute()?);
            let (keeping, name) = (keep(self.store.clone(), made.clone()), name.to_owned());
            // Carried through where nobody waits for it any more.
            let kept = self.runtime.spawn(async move {
                if let Err(error) = keeping.await {
                    tracing::warn!(%error, name, "what was computed cannot be kept");
                }
            });
            awaited(&self.runtime, kept, || watch.proceed(1.0)).map(|_| made).map_err(E::from)
        };
        once((&self.store, &self.runtime), (cache, name), watch, cached, made)
    }

    /// The shape that a mesh is of, for as long as which is kept what is made of it.
    fn shape_of(&self, mesh: &TriangleMesh) -> Option<String> {
        self.shapes.of(mesh).map(str::to_owned)
    }
}

impl pipeline::Spectra for Caches {
    fn spectrum(
        &self,
        mesh: &TriangleMesh,
        k: usize,
        boundary: Boundary,
        watch: &dyn Watch,
    ) -> Result<Arc<Spectrum>, SpectralError> {
        let key = SpectrumKey { shape_hash: mesh.content_hash(), boundary };
        let (name, shape) = (self.store.spectrum_name(&key, k), self.shape_of(mesh));
        self.get(
            (Cache::Spectra, &name),
            watch,
            || self.kept_spectrum(&key, k),
            || spectral::spectrum(mesh, k, boundary, watch),
            |store, made| async move { store.put_spectrum(&key, made, shape.as_deref()).await },
        )
    }
}

impl pipeline::Preparations for Caches {
    fn prepared(&self, mesh: &TriangleMesh, watch: &dyn Watch) -> Result<Arc<PreparedMesh>, Cancelled> {
        let hash = mesh.content_hash();
        let (name, shape) = (self.store.preparation_name(&hash), self.shape_of(mesh));
        self.get(
            (Cache::Preparations, &name),
            watch,
            || self.store.preparation(&hash),
            || PreparedMesh::new(mesh, watch),
            |store, made| async move { store.put_preparation(&hash, made, shape.as_deref()).await },
        )
    }
}

impl posing::WeightSource for Caches {
    fn weights(&self, held: &Held, watch: &dyn Watch) -> Result<Arc<Weights>, QuadraticError> {
        let hash = held.content_hash();
        let (name, shape) = (self.store.weights_name(&hash), self.shape_of(&held.mesh));
        self.get(
            (Cache::Weights, &name),
            watch,
            || self.store.weights(&hash),
            || weights(held, watch),
            |store, made| async move { store.put_weights(&hash, made, shape.as_deref()).await },
        )
    }
}

#[cfg(test)]
mod tests {
    use std::thread;

    use faer::Mat;
    use serde_json::json;

    use super::*;
    use crate::deformation::handles::Handle;
    use crate::mesh::solids::sheet;
    use crate::numerics::Unwatched;
    use crate::pipeline::Spectra;
    use crate::posing::WeightSource;
    use crate::sketch::{Sketch, YAxis};
    use crate::store::testing::fresh;
    use crate::store::{ShapeKind, Source};

    #[tokio::test(flavor = "multi_thread")]
    async fn what_a_match_is_looked_at_by_goes_with_its_shapes() {
        let (_directory, store) = fresh().await;
        let flat = sheet(6, 3);
        let source = Source {
            bytes: "s".into(),
            media_type: "image/svg+xml".to_owned(),
            parameters: String::new(),
            file_name: None,
        };
        let sketch = Sketch::new(flat.clone(), YAxis::Up).unwrap();
        let sketch = store.insert_sketch(sketch, source, None, json!({})).await.unwrap().0.id;
        let caches = Caches::of_match(store.clone(), "mesh_none", &sketch);
        let asked = || caches.spectrum(&flat, 5, Boundary::Neumann, &Unwatched).unwrap();
        let found = thread::scope(|scope| scope.spawn(asked).join()).unwrap();
        let key = SpectrumKey { shape_hash: flat.content_hash(), boundary: Boundary::Neumann };
        assert_eq!(store.spectrum(&key, 5).await.unwrap().as_ref(), Some(&*found));
        store.delete_shape(ShapeKind::Sketch, &sketch).await.unwrap();
        assert_eq!(store.spectrum(&key, 5).await.unwrap(), None);
    }

    #[tokio::test(flavor = "multi_thread")]
    async fn weights_are_kept_by_what_is_held() {
        let (_directory, store) = fresh().await;
        let caches = Caches::new(store.clone());
        let mesh = sheet(6, 3);
        let held = |x: f64| Held::new(&mesh, &[Handle::Point([0.0, 0.0]), Handle::Point([x, 0.3])]).unwrap();
        let (one, other) = (held(1.0), held(0.7));
        let asked = |held: &Held| thread::scope(|scope| scope.spawn(|| caches.weights(held, &Unwatched)).join());
        let found = asked(&one).unwrap().unwrap();
        assert_eq!(*found, weights(&one, &Unwatched).unwrap());
        assert_eq!(store.weights(&one.content_hash()).await.unwrap().as_ref(), Some(&*found));
        // Others than are computed, so that it is seen which are answered.
        let kept = Weights { values: Mat::full(28, 2, 0.5), extrema: 7 };
        assert_ne!(one.content_hash(), other.content_hash());
        store.put_weights(&other.content_hash(), kept.clone(), None).await.unwrap();
        assert_eq!(*asked(&other).unwrap().unwrap(), kept);
    }
}
