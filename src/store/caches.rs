//! What is cached, and for which shapes: it is freed with the last of them.

use std::fmt::Display;

use bytes::Bytes;

use super::{Store, StoreError, blocking};

impl Store {
    /// What is cached as that blob; nothing where there is none or it is damaged, so that it is computed and written anew.
    ///
    /// # Errors
    /// What the disk said.
    pub(super) async fn cached<T: Send + 'static, E: Display + Send + 'static>(
        &self,
        name: String,
        decode: impl FnOnce(&[u8]) -> Result<T, E> + Send + 'static,
    ) -> Result<Option<T>, StoreError> {
        let Some(bytes) = self.blobs.read_cached(&name).await? else { return Ok(None) };
        let decoded = blocking(move || Ok(decode(&bytes))).await?;
        Ok(decoded.inspect_err(|error| tracing::warn!(%error, name, "what is cached cannot be read")).ok())
    }

    /// Caches a blob that was made for this shape, as long as there is the shape. What is cached for no shape stays.
    ///
    /// # Errors
    /// What the database or the disk said.
    pub(super) async fn put_cached(
        &self,
        blob: &str,
        bytes: impl Into<Bytes>,
        shape: Option<&str>,
    ) -> Result<(), StoreError> {
        let Some(shape) = shape else { return self.blobs.put(blob, bytes).await };
        let sql = "INSERT INTO caches (blob, shape) SELECT $1, $2 FROM shapes WHERE id = $2 \
                   ON CONFLICT (blob, shape) DO NOTHING";
        sqlx::query(sql).bind(blob).bind(shape).execute(&self.pool).await?;
        self.blobs.put(blob, bytes).await?;
        // The shape may have been deleted before, or since.
        if !self.is_cached(blob).await? {
            self.blobs.delete(blob).await?;
        }
        Ok(())
    }

    /// Deletes what was cached for a shape that is gone, but for what was also made for others. A computation that would have
    /// found it does it again.
    ///
    /// # Errors
    /// What the database or the disk said.
    pub(super) async fn free_caches(&self, shape: &str) -> Result<(), StoreError> {
        let sql = "SELECT blob FROM caches WHERE shape = $1";
        let blobs: Vec<String> = sqlx::query_scalar(sql).bind(shape).fetch_all(&self.pool).await?;
        for blob in blobs {
            // Before the row, for as long as that is there the sweep finds what could not be deleted.
            let sql = "SELECT count(*) FROM caches WHERE blob = $1 AND shape <> $2";
            let others: i64 = sqlx::query_scalar(sql).bind(&blob).bind(shape).fetch_one(&self.pool).await?;
            if others == 0 {
                self.blobs.delete(&blob).await?;
            }
            let sql = "DELETE FROM caches WHERE blob = $1 AND shape = $2";
            sqlx::query(sql).bind(&blob).bind(shape).execute(&self.pool).await?;
            // And after it, for until then a computation that goes on may have cached it anew.
            if !self.is_cached(&blob).await? {
                self.blobs.delete(&blob).await?;
            }
        }
        Ok(())
    }

    /// Frees the caches of shapes that are gone, where their deletion was broken off.
    ///
    /// # Errors
    /// What the database or the disk said.
    pub(super) async fn free_caches_left(&self) -> Result<(), StoreError> {
        let sql = "SELECT DISTINCT shape FROM caches WHERE shape NOT IN (SELECT id FROM shapes)";
        let gone: Vec<String> = sqlx::query_scalar(sql).fetch_all(&self.pool).await?;
        for shape in gone {
            self.free_caches(&shape).await?;
        }
        Ok(())
    }

    /// Whether there is a shape that the blob was made for.
    async fn is_cached(&self, blob: &str) -> Result<bool, StoreError> {
        let sql = "SELECT count(*) FROM caches WHERE blob = $1";
        Ok(sqlx::query_scalar::<_, i64>(sql).bind(blob).fetch_one(&self.pool).await? > 0)
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use serde_json::json;

    use super::*;
    use crate::mesh::TriangleMesh;
    use crate::store::ShapeKind;
    use crate::store::testing::{Place, on_every_database, source};

    async fn mesh(store: &Store, file: &'static str) -> String {
        let mesh = TriangleMesh::new(vec![[0.0; 3], [1.0, 0.0, 0.0], [0.3, 1.0, 0.0]], vec![[0, 1, 2]]).unwrap();
        store.insert_mesh(mesh.into(), source(file), None, json!({})).await.unwrap().0.id
    }

    #[tokio::test]
    async fn what_is_cached_goes_with_the_last_shape_it_was_made_for() {
        on_every_database(freed).await;
    }

    async fn freed(_: Place, store: Store) {
        let (one, other) = (mesh(&store, "a").await, mesh(&store, "b").await);
        for shape in [&one, &other, &one] {
            store.put_cached("spectra/both", "b", Some(shape)).await.unwrap();
        }
        store.put_cached("spectra/one", "o", Some(&one)).await.unwrap();
        store.put_cached("spectra/none", "n", None).await.unwrap();
        let kept = async || {
            let mut names = store.blobs.names("spectra").await.unwrap();
            names.sort();
            names
        };
        store.delete_shape(ShapeKind::Mesh, &one).await.unwrap();
        assert_eq!(kept().await, ["spectra/both", "spectra/none"]);
        // A job that was cancelled and goes on for a moment leaves nothing behind.
        store.put_cached("spectra/late", "l", Some(&one)).await.unwrap();
        assert_eq!(kept().await, ["spectra/both", "spectra/none"]);
        // Of two shapes that are gone the caches of one were not freed, for its deletion was broken off.
        sqlx::query("DELETE FROM shapes").execute(&store.pool).await.unwrap();
        assert_eq!(kept().await, ["spectra/both", "spectra/none"]);
        store.sweep(Duration::ZERO).await.unwrap();
        assert_eq!(kept().await, ["spectra/none"]);
    }
}
