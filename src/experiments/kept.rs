//! Spectra and prepared meshes, computed once for all requests of an experiment.

use std::collections::HashMap;
use std::hash::Hash;
use std::sync::{Arc, Mutex, PoisonError};

use crate::alignment::prepared::PreparedMesh;
use crate::mesh::TriangleMesh;
use crate::numerics::{Cancelled, Watch};
use crate::pipeline::{Computing, Preparations, Spectra};
use crate::spectral::{Boundary, SpectralError, Spectrum, rung};

/// Keeps in memory whatever was computed.
#[derive(Default)]
pub struct Kept {
    spectra: Once<(blake3::Hash, usize, Boundary), Spectrum>,
    preparations: Once<blake3::Hash, PreparedMesh>,
}

/// Values by what they are made of. Who asks for one that is being made waits for it.
struct Once<K, V>(Mutex<HashMap<K, Place<V>>>);

type Place<V> = Arc<Mutex<Option<Arc<V>>>>;

impl<K, V> Default for Once<K, V> {
    fn default() -> Once<K, V> {
        Once(Mutex::default())
    }
}

impl<K: Hash + Eq, V> Once<K, V> {
    fn get<E>(&self, key: K, make: impl FnOnce() -> Result<Arc<V>, E>) -> Result<Arc<V>, E> {
        let place = self.0.lock().unwrap_or_else(PoisonError::into_inner).entry(key).or_default().clone();
        let mut place = place.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(value) = &*place {
            return Ok(value.clone());
        }
        let value = make()?;
        *place = Some(value.clone());
        Ok(value)
    }
}

impl Spectra for Kept {
    fn spectrum(
        &self,
        mesh: &TriangleMesh,
        k: usize,
        boundary: Boundary,
        watch: &dyn Watch,
    ) -> Result<Arc<Spectrum>, SpectralError> {
        let key = (mesh.content_hash(), rung(k), boundary);
        let found = self.spectra.get(key, || Computing.spectrum(mesh, k, boundary, watch))?;
        // A mesh of few vertices has fewer pairs than were asked for together with others.
        if found.len() < k { Computing.spectrum(mesh, k, boundary, watch) } else { Ok(found) }
    }
}

impl Preparations for Kept {
    fn prepared(&self, mesh: &TriangleMesh, watch: &dyn Watch) -> Result<Arc<PreparedMesh>, Cancelled> {
        self.preparations.get(mesh.content_hash(), || Computing.prepared(mesh, watch))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::solids::sheet;
    use crate::numerics::Unwatched;

    #[test]
    fn what_was_computed_is_not_computed_again() {
        let (kept, mesh) = (Kept::default(), sheet(8, 8));
        let of = |k: usize, boundary| kept.spectrum(&mesh, k, boundary, &Unwatched).unwrap();
        let first = of(5, Boundary::Neumann);
        assert!(Arc::ptr_eq(&first, &of(7, Boundary::Neumann)));
        assert!(!Arc::ptr_eq(&first, &of(5, Boundary::Dirichlet)));
    }

    #[test]
    fn what_failed_is_tried_again() {
        let once = Once::<u8, u8>::default();
        assert_eq!(once.get(1, || Err("broken")), Err("broken"));
        assert_eq!(once.get(1, || Ok::<_, &str>(Arc::new(7))).map(|value| *value), Ok(7));
        assert_eq!(once.get(1, || Err("not asked")).map(|value| *value), Ok(7));
    }
}
