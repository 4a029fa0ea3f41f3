//! Stores for tests.

use std::path::Path;
use std::time::Duration;

use bytes::Bytes;
use tempfile::TempDir;

use super::database::testing::Schema;
use super::{BlobUrl, Config, Room, Source, Store};

/// A node that has nothing to do yet.
pub(crate) const ALL: Room = Room { memory: u64::MAX, alone: true };

/// A directory and, for a database that is shared, a schema of its own, gone when it is dropped.
pub(crate) struct Place {
    directory: TempDir,
    schema: Option<Schema>,
}

impl Place {
    pub fn path(&self) -> &Path {
        self.directory.path()
    }

    /// The store in this place, by this process or, where it is shared, by another node.
    pub async fn open(&self) -> Store {
        Store::open(&self.config()).await.unwrap()
    }

    pub fn config(&self) -> Config {
        let data_dir = self.path().join("data");
        match &self.schema {
            None => Config::local(data_dir),
            Some(schema) => {
                let blob_url = Some(BlobUrl::Folder(data_dir.join("blobs")));
                Config { data_dir, database_url: Some(schema.url().parse().unwrap()), blob_url }
            }
        }
    }
}

/// A place whose store is by PostgreSQL, where one answers.
pub(crate) async fn shared_place() -> Option<Place> {
    Some(Place { directory: tempfile::tempdir().unwrap(), schema: Some(Schema::fresh().await?) })
}

/// A store in a place of its own, by SQLite.
pub(crate) async fn fresh() -> (Place, Store) {
    let place = Place { directory: tempfile::tempdir().unwrap(), schema: None };
    let store = place.open().await;
    (place, store)
}

/// A store in a place of its own, by PostgreSQL where one answers.
pub(crate) async fn fresh_shared() -> Option<(Place, Store)> {
    let place = shared_place().await?;
    let store = place.open().await;
    Some((place, store))
}

/// An upload of these bytes.
pub(crate) fn source(bytes: &'static str) -> Source {
    Source { bytes: Bytes::from(bytes), media_type: "model/obj".to_owned(), parameters: String::new(), file_name: None }
}

/// Carries out a test with SQLite, and with PostgreSQL where one answers.
pub(crate) async fn on_every_database(test: impl AsyncFn(Place, Store)) {
    let (place, store) = fresh().await;
    test(place, store).await;
    if let Some((place, store)) = fresh_shared().await {
        test(place, store).await;
    }
}

pub(crate) async fn open(place: &Place) -> Store {
    place.open().await
}

/// Lets jobs that rest be taken again at once, for as long as it is asked.
pub(crate) async fn make_rests_short(store: &Store) {
    loop {
        sqlx::query("UPDATE jobs SET due_ms = 0 WHERE due_ms > 0").execute(&store.pool).await.unwrap();
        store.changes.tell_of_queue();
        tokio::time::sleep(Duration::from_millis(20)).await;
    }
}

/// Lets calls that tell of the ends of jobs be made at once.
pub(crate) async fn make_webhooks_due(store: &Store) {
    sqlx::query("UPDATE webhooks SET due_ms = 0").execute(&store.pool).await.unwrap();
}

/// A file as failing disks leave it: emptied, cut short, with a page of zeros, with a bit turned over.
pub(crate) fn damaged(whole: &[u8]) -> [Vec<u8>; 4] {
    let (mut zeroed, mut turned) = (whole.to_vec(), whole.to_vec());
    let middle = whole.len() / 2;
    zeroed[middle..].iter_mut().take(4096).for_each(|byte| *byte = 0);
    turned[middle] ^= 1;
    [Vec::new(), whole[..middle].to_vec(), zeroed, turned]
}
