use super::{Store, StoreError, blocking};
use crate::alignment::prepared::{PREPARATION_VERSION, PreparedMesh};

impl Store {
    /// The mesh of that content made ready for the alignment, where it is cached. A damaged blob is deleted, so that it
    /// can be written anew.
    ///
    /// # Errors
    /// What the disk said.
    pub async fn preparation(&self, mesh: &blake3::Hash) -> Result<Option<PreparedMesh>, StoreError> {
        let name = blob(mesh);
        let Some(bytes) = self.blobs.read(&name).await? else { return Ok(None) };
        match blocking(move || Ok(postcard::from_bytes::<PreparedMesh>(&bytes))).await? {
            Ok(prepared) => Ok(Some(prepared)),
            Err(error) => {
                tracing::warn!(%error, name, "a damaged preparation is deleted");
                self.blobs.delete(&name).await?;
                Ok(None)
            }
        }
    }

    /// Caches what was made of the mesh of that content.
    ///
    /// # Errors
    /// What the disk said.
    pub async fn put_preparation(&self, mesh: &blake3::Hash, prepared: &PreparedMesh) -> Result<(), StoreError> {
        let bytes = postcard::to_stdvec(prepared).map_err(|error| StoreError::damaged("the preparation", error))?;
        Ok(self.blobs.put(&blob(mesh), bytes).await?)
    }
}

fn blob(mesh: &blake3::Hash) -> String {
    format!("preparations/{}/{PREPARATION_VERSION}", mesh.to_hex())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::TriangleMesh;
    use crate::numerics::Unwatched;
    use crate::store::testing::{fresh, open};

    fn tetrahedron() -> TriangleMesh {
        let positions = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        TriangleMesh::new(positions, vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]).unwrap()
    }

    #[tokio::test]
    async fn a_preparation_survives_bit_for_bit_and_a_damaged_one_is_forgotten() {
        let (directory, store) = fresh().await;
        let mesh = tetrahedron();
        let (hash, prepared) = (mesh.content_hash(), PreparedMesh::new(&mesh, &Unwatched).unwrap());
        assert_eq!(store.preparation(&hash).await.unwrap(), None);
        store.put_preparation(&hash, &prepared).await.unwrap();
        drop(store);
        let store = open(&directory).await;
        assert_eq!(store.preparation(&hash).await.unwrap(), Some(prepared));
        store.blobs.delete(&blob(&hash)).await.unwrap();
        store.blobs.put(&blob(&hash), b"no".to_vec()).await.unwrap();
        assert_eq!(store.preparation(&hash).await.unwrap(), None);
        assert_eq!(store.blobs.read(&blob(&hash)).await.unwrap(), None);
    }
}
