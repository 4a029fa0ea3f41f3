use std::time::Duration;

use uuid::Uuid;

use super::{Store, StoreError, blocking, directory, milliseconds};

/// The folder of the blobs that are written to see whether they can be.
const CHECKS: &str = "ready";

impl Store {
    /// Ok when a row can be written, read and deleted.
    ///
    /// # Errors
    /// What the disk or the database said.
    pub async fn database_healthy(&self) -> Result<(), StoreError> {
        if let Some(directory) = self.directory.clone() {
            blocking(move || directory.database_present()).await?;
        }
        let token = Uuid::now_v7().to_string();
        let insert = "INSERT INTO checks (token, created_ms) SELECT $1, now_ms FROM clock";
        sqlx::query(insert).bind(&token).execute(&self.pool).await?;
        let read = sqlx::query_scalar::<_, String>("SELECT token FROM checks WHERE token = $1");
        let read = read.bind(&token).fetch_optional(&self.pool).await?;
        sqlx::query("DELETE FROM checks WHERE token = $1").bind(&token).execute(&self.pool).await?;
        read.map(drop).ok_or_else(|| StoreError::damaged("the database", "a row that was written is not there"))
    }

    /// Ok when a blob can be written, read and deleted.
    ///
    /// # Errors
    /// What the disk or the server of the blobs said.
    pub async fn blobs_healthy(&self) -> Result<(), StoreError> {
        let token = Uuid::now_v7().to_string();
        let blob = format!("{CHECKS}/{token}");
        self.blobs.put(&blob, token).await?;
        let found = self.blobs.read(&blob).await?;
        self.blobs.delete(&blob).await?;
        found
            .map(drop)
            .ok_or_else(|| StoreError::damaged("the place of the blobs", "a blob that was written is not there"))
    }

    /// Bytes that can still be written to the fullest disk of those that are this machine's own; nothing where none is.
    ///
    /// # Errors
    /// What the disk said.
    pub async fn free_bytes(&self) -> Result<Option<u64>, StoreError> {
        let of_blobs = self.blobs.free_bytes().await?;
        let Some(directory) = self.directory.clone() else { return Ok(of_blobs) };
        let of_database = blocking(move || directory::free_bytes(directory.path())).await?;
        Ok(Some(of_blobs.map_or(of_database, |bytes| bytes.min(of_database))))
    }

    /// Deletes what checks of processes that died so long ago left behind.
    pub(super) async fn forget_checks(&self, age: Duration) -> Result<(), StoreError> {
        let sql = "DELETE FROM checks WHERE created_ms <= (SELECT now_ms FROM clock) - $1";
        sqlx::query(sql).bind(milliseconds(age)).execute(&self.pool).await?;
        for name in self.blobs.names_older_than(CHECKS, age).await? {
            self.blobs.delete(&name).await?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use std::fs;
    use std::path::PathBuf;

    use super::*;
    use crate::store::testing::fresh;

    #[tokio::test]
    async fn a_store_that_writes_and_reads_is_healthy_and_leaves_nothing_behind() {
        let (_directory, store) = fresh().await;
        store.database_healthy().await.unwrap();
        store.blobs_healthy().await.unwrap();
        assert_eq!(store.blobs.names(CHECKS).await.unwrap(), Vec::<String>::new());
        let left: i64 = sqlx::query_scalar("SELECT count(*) FROM checks").fetch_one(&store.pool).await.unwrap();
        assert_eq!(left, 0);
        assert!(store.free_bytes().await.unwrap().is_some_and(|bytes| bytes > 0));
    }

    #[tokio::test]
    async fn a_store_without_its_blobs_or_its_database_is_not_healthy_until_they_are_back() {
        let (directory, store) = fresh().await;
        let data = directory.path().join("data");
        for part in [data.join("blobs"), data.join("sketchmatch.db"), data.clone()] {
            let elsewhere: PathBuf = directory.path().join("elsewhere");
            fs::rename(&part, &elsewhere).unwrap();
            let checked = [store.database_healthy().await, store.blobs_healthy().await];
            let away = checked.map(|health| matches!(health, Err(StoreError::Away { .. })));
            let (database, blobs) = (!part.ends_with("blobs"), !part.ends_with("sketchmatch.db"));
            assert_eq!(away, [database, blobs], "{}", part.display());
            assert!(!part.exists());
            fs::rename(&elsewhere, &part).unwrap();
            store.database_healthy().await.unwrap();
            store.blobs_healthy().await.unwrap();
        }
    }

    #[tokio::test]
    async fn a_database_that_was_written_over_is_not_healthy() {
        let (directory, store) = fresh().await;
        let path = directory.path().join("data/sketchmatch.db");
        let whole = fs::read(&path).unwrap();
        for bytes in [vec![0; whole.len()], Vec::new(), b"SELECT 1".repeat(100)] {
            fs::write(&path, bytes).unwrap();
            assert!(matches!(store.database_healthy().await, Err(StoreError::Damaged { .. })));
        }
    }
}
