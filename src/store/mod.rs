//! All SQL and all blobs: shapes, the queue with its leases, cached spectra, results, remembered answers.
//!
//! One file per aggregate. Blobs are written before the row that names them and deleted after it, so that a crash
//! between the two leaves an unnamed blob and never a name without one.

mod blobs;
mod changes;
mod database;
mod directory;
mod error;
mod geometry;
mod health;
mod idempotency;
mod job;
mod keys;
mod page;
mod preparations;
mod previews;
mod queue;
mod sealed;
mod secrets;
mod shapes;
mod spectra;
mod sweep;
mod tenancy;
mod tensors;
mod upgrade;

use std::path::PathBuf;
use std::sync::Arc;

use sqlx::AnyPool;
use tokio::sync::RwLock;

use crate::access::Tenant;
use blobs::Blobs;
use changes::Changes;
pub use changes::{JobChanges, QueueChanges};
use directory::Directory;
pub use error::{Lack, StoreError};
pub use idempotency::{MEMORY, Remembered, Turn};
pub use job::{Heartbeat, Job, Lease, NewJob, Places, State, Submitted, problem};
pub use keys::{KeyRow, Keys};
pub use page::Page;
pub use queue::{LEASE, MAX_TRIES};
pub use shapes::{Deletion, Kind, Shape, Source, SourceFile, Unkept};
pub use spectra::SpectrumKey;

/// Where everything is kept.
#[derive(Clone, Debug)]
pub struct Config {
    /// Directory of the database (`sketchmatch.db`), the blobs (`blobs/`) and the lock (`lock`); made when missing.
    pub data_dir: PathBuf,
}

/// The one door to what outlives the process. Clones share it; the last one dropped gives the data directory free.
///
/// Shapes, jobs and remembered answers are those of one tenant, see [`of`](Self::of). Whoever works on jobs and measures them
/// has to do with those of all.
#[derive(Clone)]
pub struct Store {
    pool: AnyPool,
    blobs: Blobs,
    changes: Arc<Changes>,
    turns: Arc<idempotency::Turns>,
    /// Read by those who write a blob and then the row that names it, written by those who delete what no row names.
    naming: Arc<RwLock<()>>,
    directory: Arc<Directory>,
    tenant: Tenant,
    /// Whether spectra and preparations are the same for all tenants.
    shared_caches: bool,
}

impl Store {
    /// The store under `config.data_dir`, brought up to the present tables, with the jobs of a process that died back
    /// in the queue: the lock proves that nobody works on them any more.
    ///
    /// # Errors
    /// [`StoreError::Locked`] when another process has it open, [`StoreError::Unnamed`] where there are blobs that no
    /// database names; otherwise what the disk or the database said.
    pub async fn open(config: &Config) -> Result<Store, StoreError> {
        let path = config.data_dir.clone();
        let directory = Arc::new(blocking(move || Directory::open(&path)).await?);
        let blobs = Blobs::local(directory.clone())?;
        // No connection that knows the tables before this is to be used after it.
        let pool = database::connected(&directory.database(), 1).await?;
        let upgraded = upgrade::run(&pool, &blobs, &directory).await;
        pool.close().await;
        upgraded?;
        let pool = database::connected(&directory.database(), database::CONNECTIONS).await?;
        let (changes, turns, naming) = (Arc::default(), Arc::default(), Arc::default());
        let (tenant, shared_caches) = (Tenant::default(), false);
        let store = Store { pool, blobs, changes, turns, naming, directory, tenant, shared_caches };
        store.reap_all().await?;
        store.sweep().await?;
        Ok(store)
    }

    /// Ends the use of the data directory in peace: afterwards the database's file alone is whole, and clones of this
    /// store fail.
    ///
    /// # Errors
    /// What the database said.
    pub async fn close(&self) -> Result<(), StoreError> {
        database::close(&self.pool).await
    }
}

/// Runs work that takes more than a moment off the threads that answer requests.
async fn blocking<T: Send + 'static>(
    work: impl FnOnce() -> Result<T, StoreError> + Send + 'static,
) -> Result<T, StoreError> {
    let joined = tokio::task::spawn_blocking(work).await;
    joined.unwrap_or_else(|error| Err(StoreError::damaged("a background task", error)))
}

#[cfg(test)]
pub(crate) mod testing {
    use tempfile::TempDir;

    use super::{Config, Store};

    /// A directory of its own, gone when it is dropped, and the store in it.
    pub(crate) async fn fresh() -> (TempDir, Store) {
        let directory = tempfile::tempdir().unwrap();
        let store = open(&directory).await;
        (directory, store)
    }

    pub(crate) async fn open(directory: &TempDir) -> Store {
        Store::open(&Config { data_dir: directory.path().join("data") }).await.unwrap()
    }

    /// Lets jobs that rest be taken again at once, for as long as it is asked.
    pub(crate) async fn make_rests_short(store: &Store) {
        loop {
            sqlx::query("UPDATE jobs SET due_ms = 0 WHERE due_ms > 0").execute(&store.pool).await.unwrap();
            store.changes.tell_of_queue();
            tokio::time::sleep(std::time::Duration::from_millis(20)).await;
        }
    }

    /// A file as failing disks leave it: emptied, cut short, with a page of zeros, with a bit turned over.
    pub(crate) fn damaged(whole: &[u8]) -> [Vec<u8>; 4] {
        let (mut zeroed, mut turned) = (whole.to_vec(), whole.to_vec());
        let middle = whole.len() / 2;
        zeroed[middle..].iter_mut().take(4096).for_each(|byte| *byte = 0);
        turned[middle] ^= 1;
        [Vec::new(), whole[..middle].to_vec(), zeroed, turned]
    }
}

#[cfg(test)]
mod earlier_versions;

#[cfg(test)]
mod tests {
    use std::fs;
    use std::path::Path;

    use super::testing::fresh;
    use super::*;

    #[tokio::test]
    async fn a_second_process_is_refused_until_the_first_lets_go() {
        let (directory, store) = fresh().await;
        let config = Config { data_dir: directory.path().join("data") };
        let refusal = Store::open(&config).await.err().unwrap();
        assert!(matches!(refusal, StoreError::Locked { .. }), "{refusal}");
        assert!(refusal.to_string().contains("data is in use by another process"), "{refusal}");
        std::fs::remove_file(config.data_dir.join("lock")).unwrap();
        let refusal = Store::open(&config).await.err().unwrap();
        assert!(matches!(refusal, StoreError::Locked { .. }), "{refusal}");
        drop(store);
        Store::open(&config).await.unwrap().healthy().await.unwrap();
    }

    #[tokio::test]
    async fn blobs_without_their_database_are_refused_and_left_alone() {
        let (directory, store) = fresh().await;
        let config = Config { data_dir: directory.path().join("data") };
        store.blobs.put("results/job/1", "answer").await.unwrap();
        store.close().await.unwrap();
        drop(store);
        let database = config.data_dir.join("sketchmatch.db");
        let elsewhere = directory.path().join("elsewhere.db");
        fs::rename(&database, &elsewhere).unwrap();
        for empty in [None, Some("")] {
            if let Some(bytes) = empty {
                fs::write(&database, bytes).unwrap();
            }
            let refusal = Store::open(&config).await.err().unwrap();
            assert!(matches!(refusal, StoreError::Unnamed { .. }), "{refusal}");
            assert!(fs::metadata(&database).map_or(true, |metadata| metadata.len() == 0));
        }
        database_without_tables(&database).await;
        let refusal = Store::open(&config).await.err().unwrap();
        assert!(matches!(refusal, StoreError::Unnamed { .. }), "{refusal}");
        fs::rename(&elsewhere, &database).unwrap();
        // No row names it: it is kept all the same.
        Store::open(&config).await.unwrap();
        assert!(config.data_dir.join("blobs/aside/results/job/1").is_file());
    }

    async fn database_without_tables(path: &Path) {
        let pool = database::connected(path, 1).await.unwrap();
        sqlx::query("PRAGMA user_version = 1").execute(&pool).await.unwrap();
        pool.close().await;
    }

    #[tokio::test]
    async fn after_a_close_the_database_alone_is_whole() {
        let (directory, store) = fresh().await;
        let places = Places { queue: 1, of_kind: 1 };
        store.submit(&NewJob::of("match", "1"), places).await.unwrap();
        store.close().await.unwrap();
        drop(store);
        let copy = directory.path().join("copy");
        fs::create_dir(&copy).unwrap();
        fs::copy(directory.path().join("data/sketchmatch.db"), copy.join("sketchmatch.db")).unwrap();
        let copied = Store::open(&Config { data_dir: copy }).await.unwrap();
        assert_eq!(copied.queued("match").await.unwrap(), 1);
    }

    #[tokio::test]
    async fn a_data_directory_that_cannot_be_made_is_named() {
        let file = tempfile::NamedTempFile::new().unwrap();
        let refusal = Store::open(&Config { data_dir: file.path().join("data") }).await.err().unwrap();
        assert!(refusal.to_string().contains(&file.path().display().to_string()), "{refusal}");
    }

    #[tokio::test]
    async fn the_directory_may_have_odd_characters() {
        let directory = tempfile::tempdir().unwrap();
        let config = Config { data_dir: directory.path().join("a b?c#d&e=ü") };
        let store = Store::open(&config).await.unwrap();
        store.healthy().await.unwrap();
        assert!(config.data_dir.join("sketchmatch.db").is_file());
    }
}
