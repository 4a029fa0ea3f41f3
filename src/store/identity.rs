use super::{Store, StoreError};

/// The blob that says whose blobs they are.
const IDENTITY: &str = "identity";

impl Store {
    /// Ok where the blobs are those of the database, or were nobody's until now and the database had none: a database knows the
    /// blobs it names, and all others for left behind.
    ///
    /// # Errors
    /// [`StoreError::Foreign`], [`StoreError::Elsewhere`]; what the database or the disk said.
    pub(super) async fn pair(&self) -> Result<(), StoreError> {
        let identity = "SELECT token, paired FROM identity";
        let (token, paired): (String, i64) = sqlx::query_as(identity).fetch_one(&self.pool).await?;
        if paired == 0 {
            self.pair_first(&token).await?;
        }
        let place = || self.blobs.place().to_string();
        match self.blobs.read(IDENTITY).await? {
            Some(found) if found == token.as_bytes() => Ok(()),
            Some(_) => Err(StoreError::Foreign { place: place() }),
            None => Err(StoreError::Elsewhere { place: place() }),
        }
    }

    /// Gives the token to blobs that are nobody's, where no other node has done so meanwhile.
    async fn pair_first(&self, token: &str) -> Result<(), StoreError> {
        let mut alone = self.engine.alone(&self.pool).await?;
        let paired: i64 = sqlx::query_scalar("SELECT paired FROM identity").fetch_one(&mut *alone).await?;
        // Looked for first: not every server of blobs heeds that a name is taken.
        if paired == 0 && self.blobs.read(IDENTITY).await?.is_none_or(|found| found == token.as_bytes()) {
            self.blobs.put_once(IDENTITY, token.to_owned()).await?;
            sqlx::query("UPDATE identity SET paired = 1").execute(&mut *alone).await?;
        }
        Ok(alone.commit().await?)
    }
}

#[cfg(test)]
mod tests {
    use crate::store::testing::{fresh, on_every_database, open};
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
    async fn an_empty_place_is_not_taken_for_that_of_a_database_with_blobs() {
        on_every_database(async |place, store| {
            drop(store);
            let empty = place.path().join("empty");
            let config = Config { blob_url: Some(BlobUrl::Folder(empty.clone())), ..place.config() };
            for _ in 0..2 {
                let refusal = Store::open(&config).await.err().unwrap();
                assert!(matches!(refusal, StoreError::Elsewhere { .. }), "{refusal}");
                assert!(refusal.to_string().contains("--blob-url"), "{refusal}");
            }
            assert!(!empty.join("identity").exists());
            open(&place).await;
        })
        .await;
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
