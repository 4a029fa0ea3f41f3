use super::{Store, StoreError};

/// The blob that says whose blobs they are.
const IDENTITY: &str = "identity";

impl Store {
    /// Ok where the blobs are those of the database, or were nobody's until now: a database knows the blobs it names, and all
    /// others for left behind.
    ///
    /// # Errors
    /// [`StoreError::Foreign`]; what the database or the disk said.
    pub(super) async fn pair(&self) -> Result<(), StoreError> {
        let token: String = sqlx::query_scalar("SELECT token FROM identity").fetch_one(&self.pool).await?;
        // Looked for first: not every server of blobs heeds that a name is taken.
        let mut found = self.blobs.read(IDENTITY).await?;
        if found.is_none() {
            self.blobs.put_once(IDENTITY, token.clone()).await?;
            found = self.blobs.read(IDENTITY).await?;
        }
        if found.is_some_and(|found| found == token.as_bytes()) {
            return Ok(());
        }
        Err(StoreError::Foreign { place: self.blobs.place().to_string() })
    }
}

#[cfg(test)]
mod tests {
    use crate::store::testing::{fresh, open};
    use crate::store::{BlobUrl, Config, Store, StoreError};

    #[tokio::test]
    async fn blobs_of_another_database_are_not_touched() {
        let (directory, store) = fresh().await;
        store.blobs.put("results/job/1", "answer").await.unwrap();
        drop(store);
        let blobs = directory.path().join("data/blobs");
        // What another process is writing at this moment.
        let unfinished = blobs.join("results/job/2#17");
        std::fs::write(&unfinished, "half").unwrap();
        let config = Config { blob_url: Some(BlobUrl::Folder(blobs)), ..Config::local(directory.path().join("other")) };
        for _ in 0..2 {
            let refusal = Store::open(&config).await.err().unwrap();
            assert!(matches!(refusal, StoreError::Unnamed { .. } | StoreError::Foreign { .. }), "{refusal}");
        }
        assert!(directory.path().join("data/blobs/results/job/1").is_file() && unfinished.is_file());
        open(&directory).await;
    }

    #[tokio::test]
    async fn blobs_may_move() {
        let (directory, store) = fresh().await;
        store.blobs.put("spectra/1", "numbers").await.unwrap();
        drop(store);
        let (old, new) = (directory.path().join("data/blobs"), directory.path().join("elsewhere"));
        std::fs::rename(old, &new).unwrap();
        let config = Config { blob_url: Some(BlobUrl::Folder(new)), ..Config::local(directory.path().join("data")) };
        let store = Store::open(&config).await.unwrap();
        assert_eq!(store.blobs.read("spectra/1").await.unwrap().unwrap(), "numbers");
    }
}
