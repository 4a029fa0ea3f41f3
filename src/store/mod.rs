//! All SQL and all blobs: shapes, the queue with its leases, cached spectra, results, remembered answers.
//!
//! One file per aggregate. Blobs are written before the row that names them and deleted after it, so that a crash
//! between the two leaves an unnamed blob and never a name without one.

mod blobs;
mod database;
mod error;
mod geometry;
mod idempotency;
mod job;
mod page;
mod preparations;
mod queue;
mod sealed;
mod shapes;
mod spectra;
mod tensors;
mod upgrade;

use std::fs::{self, File, TryLockError};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use sqlx::AnyPool;
use tokio::sync::watch;

use blobs::Blobs;
pub use error::StoreError;
pub use idempotency::Remembered;
pub use job::{Beat, Job, JobKind, Lease, State, problem};
pub use page::Page;
pub use queue::{LEASE, MAX_TRIES};
pub use shapes::{Kind, Shape, Source, SourceFile};
pub use spectra::{SpectrumKey, SpectrumTask};

/// Where everything is kept.
#[derive(Clone, Debug)]
pub struct Config {
    /// Directory of the database (`sketchmatch.db`), the blobs (`blobs/`) and the lock (`lock`); made when missing.
    pub data_dir: PathBuf,
}

/// The one door to what outlives the process. Clones share it; the last one dropped gives the data directory free.
#[derive(Clone)]
pub struct Store {
    pool: AnyPool,
    blobs: Blobs,
    changes: watch::Sender<u64>,
    /// Held, never read: the lock goes when the file is closed.
    _lock: Arc<File>,
}

impl Store {
    /// The store under `config.data_dir`, brought up to the present tables, with the jobs of a process that died back
    /// in the queue: the lock proves that nobody works on them any more.
    ///
    /// # Errors
    /// [`StoreError::Locked`] when another process has it open; otherwise what the disk or the database said.
    pub async fn open(config: &Config) -> Result<Store, StoreError> {
        let blob_dir = config.data_dir.join("blobs");
        fs::create_dir_all(&blob_dir).map_err(|source| directory(&blob_dir, source))?;
        let data_dir = config.data_dir.canonicalize().map_err(|source| directory(&config.data_dir, source))?;
        let lock = lock(&data_dir)?;
        let blobs = Blobs::local(&blob_dir)?;
        let pool = database::connected(&data_dir.join("sketchmatch.db")).await?;
        upgrade::run(&pool, &blobs).await?;
        let store = Store {
            pool,
            blobs,
            changes: watch::Sender::new(0),
            _lock: Arc::new(lock),
        };
        store.reap_all().await?;
        store.sweep_results().await?;
        Ok(store)
    }

    /// Ok when the database answers.
    ///
    /// # Errors
    /// What the database said.
    pub async fn healthy(&self) -> Result<(), StoreError> {
        sqlx::query("SELECT now_ms FROM clock").execute(&self.pool).await?;
        Ok(())
    }

    /// A counter that grows with every change of the queue made by this process: it wakes those who wait for one.
    /// Changes made by other processes are seen by polling only.
    pub fn changes(&self) -> watch::Receiver<u64> {
        self.changes.subscribe()
    }

    fn announce(&self) {
        self.changes.send_modify(|count| *count += 1);
    }
}

/// Runs work that takes more than a moment off the threads that answer requests.
async fn blocking<T: Send + 'static>(
    work: impl FnOnce() -> Result<T, StoreError> + Send + 'static,
) -> Result<T, StoreError> {
    let joined = tokio::task::spawn_blocking(work).await;
    joined.unwrap_or_else(|error| Err(StoreError::damaged("a background task", error)))
}

fn lock(data_dir: &Path) -> Result<File, StoreError> {
    let path = data_dir.join("lock");
    let file = File::create(&path).map_err(|source| directory(&path, source))?;
    match file.try_lock() {
        Ok(()) => Ok(file),
        Err(TryLockError::WouldBlock) => Err(StoreError::Locked { data_dir: data_dir.to_owned() }),
        Err(TryLockError::Error(source)) => Err(directory(&path, source)),
    }
}

fn directory(path: &Path, source: std::io::Error) -> StoreError {
    StoreError::Directory { path: path.to_owned(), source }
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
    use super::testing::fresh;
    use super::*;

    #[tokio::test]
    async fn a_second_process_is_refused_until_the_first_lets_go() {
        let (directory, store) = fresh().await;
        let config = Config { data_dir: directory.path().join("data") };
        let refusal = Store::open(&config).await.err().unwrap();
        assert!(matches!(refusal, StoreError::Locked { .. }), "{refusal}");
        assert!(refusal.to_string().contains("data is in use by another process"), "{refusal}");
        drop(store);
        Store::open(&config).await.unwrap().healthy().await.unwrap();
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
