use std::sync::Arc;

use super::{Store, StoreError, blocking};
use crate::alignment::prepared::{PREPARATION_VERSION, PreparedMesh};
use crate::numerics::instruction_set;

impl Store {
    /// The mesh of that content made ready for the alignment, where it is cached; nothing where it is damaged, so that
    /// it is made and written anew.
    ///
    /// # Errors
    /// What the disk said.
    pub async fn preparation(&self, mesh: &blake3::Hash) -> Result<Option<PreparedMesh>, StoreError> {
        self.cached(self.preparation_name(mesh), |bytes: &[u8]| postcard::from_bytes(bytes)).await
    }

    /// Caches what was made of the mesh of that content, for as long as there is the shape it was made for.
    ///
    /// # Errors
    /// What the disk or the database said.
    pub async fn put_preparation(
        &self,
        mesh: &blake3::Hash,
        prepared: impl Into<Arc<PreparedMesh>>,
        shape: Option<&str>,
    ) -> Result<(), StoreError> {
        let prepared = prepared.into();
        let encoded =
            move || postcard::to_stdvec(&*prepared).map_err(|error| StoreError::damaged("the preparation", error));
        self.put_cached(&self.preparation_name(mesh), blocking(encoded).await?, shape).await
    }

    /// What making the mesh of that content ready is claimed by.
    pub fn preparation_name(&self, mesh: &blake3::Hash) -> String {
        self.cached_as(&blob(mesh))
    }
}

fn blob(mesh: &blake3::Hash) -> String {
    format!("preparations/{}/{PREPARATION_VERSION}-{}", mesh.to_hex(), instruction_set())
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;
    use crate::mesh::TriangleMesh;
    use crate::numerics::Unwatched;
    use crate::store::testing::{damaged, fresh, open};

    fn tetrahedron() -> TriangleMesh {
        let positions = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        TriangleMesh::new(positions, vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]).unwrap()
    }

    #[tokio::test]
    async fn a_preparation_survives_bit_for_bit_and_a_damaged_one_is_written_anew() {
        let (directory, store) = fresh().await;
        let mesh = tetrahedron();
        let (hash, prepared) = (mesh.content_hash(), PreparedMesh::new(&mesh, &Unwatched).unwrap());
        assert_eq!(store.preparation(&hash).await.unwrap(), None);
        store.put_preparation(&hash, prepared.clone(), None).await.unwrap();
        drop(store);
        let store = open(&directory).await;
        assert_eq!(store.preparation(&hash).await.unwrap().as_ref(), Some(&prepared));
        let file = directory.path().join("data/blobs").join(blob(&hash));
        let whole = fs::read(&file).unwrap();
        for damaged in damaged(&whole) {
            fs::write(&file, damaged).unwrap();
            assert_eq!(store.preparation(&hash).await.unwrap(), None);
            store.put_preparation(&hash, prepared.clone(), None).await.unwrap();
            assert_eq!(fs::read(&file).unwrap(), whole);
        }
        store.blobs.put(&blob(&hash), b"no".to_vec()).await.unwrap();
        assert_eq!(store.preparation(&hash).await.unwrap(), None);
    }
}
