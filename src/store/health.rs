use uuid::Uuid;

use super::{Store, StoreError, blocking};

/// The folder of the blobs that are written to see whether they can be.
const CHECKS: &str = "ready";

impl Store {
    /// Ok when a row and a blob can be written, read and deleted.
    ///
    /// # Errors
    /// What the disk or the database said.
    pub async fn healthy(&self) -> Result<(), StoreError> {
        let directory = self.directory.clone();
        blocking(move || directory.database_present()).await?;
        let token = Uuid::now_v7().to_string();
        sqlx::query("INSERT INTO checks (token) VALUES ($1)").bind(&token).execute(&self.pool).await?;
        let read = sqlx::query_scalar::<_, String>("SELECT token FROM checks WHERE token = $1");
        let read = read.bind(&token).fetch_optional(&self.pool).await?;
        sqlx::query("DELETE FROM checks WHERE token = $1").bind(&token).execute(&self.pool).await?;
        let blob = format!("{CHECKS}/{token}");
        self.blobs.put(&blob, token.clone()).await?;
        let found = self.blobs.read(&blob).await?;
        self.blobs.delete(&blob).await?;
        match (read, found) {
            (Some(_), Some(_)) => Ok(()),
            _ => Err(StoreError::damaged("the data directory", "what was written is not there")),
        }
    }

    /// Bytes that can still be written to the disk of the data directory.
    ///
    /// # Errors
    /// What the disk said.
    pub async fn free_bytes(&self) -> Result<u64, StoreError> {
        let directory = self.directory.clone();
        blocking(move || directory.free_bytes()).await
    }

    /// Deletes what checks of a process that died left behind.
    pub(super) async fn forget_checks(&self) -> Result<(), StoreError> {
        sqlx::query("DELETE FROM checks").execute(&self.pool).await?;
        for name in self.blobs.names(CHECKS).await? {
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
        let (directory, store) = fresh().await;
        store.healthy().await.unwrap();
        assert!(!directory.path().join("data/blobs").join(CHECKS).exists());
        let left: i64 = sqlx::query_scalar("SELECT count(*) FROM checks").fetch_one(&store.pool).await.unwrap();
        assert_eq!(left, 0);
        assert!(store.free_bytes().await.unwrap() > 0);
    }

    #[tokio::test]
    async fn a_store_without_its_blobs_or_its_database_is_not_healthy_until_they_are_back() {
        let (directory, store) = fresh().await;
        let data = directory.path().join("data");
        for part in [data.join("blobs"), data.join("sketchmatch.db"), data.clone()] {
            let elsewhere: PathBuf = directory.path().join("elsewhere");
            fs::rename(&part, &elsewhere).unwrap();
            assert!(matches!(store.healthy().await, Err(StoreError::Away { .. })), "{}", part.display());
            assert!(!part.exists());
            fs::rename(&elsewhere, &part).unwrap();
            store.healthy().await.unwrap();
        }
    }

    #[tokio::test]
    async fn a_database_that_was_written_over_is_not_healthy() {
        let (directory, store) = fresh().await;
        let path = directory.path().join("data/sketchmatch.db");
        let whole = fs::read(&path).unwrap();
        for bytes in [vec![0; whole.len()], Vec::new(), b"SELECT 1".repeat(100)] {
            fs::write(&path, bytes).unwrap();
            assert!(matches!(store.healthy().await, Err(StoreError::Damaged { .. })));
        }
    }
}
