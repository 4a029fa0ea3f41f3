//! All SQL and all blobs: shapes, the queue with its leases, cached spectra, results, remembered answers.
//!
//! One file per aggregate. Blobs are written before the row that names them and deleted after it, so that a crash
//! between the two leaves an unnamed blob and never a name without one.

mod blobs;
mod caches;
mod changes;
mod claims;
mod database;
mod directory;
mod error;
mod geometry;
mod health;
mod idempotency;
mod identity;
mod job;
mod keys;
mod measures;
mod notices;
mod page;
mod place;
mod preparations;
mod previews;
mod queue;
mod retention;
mod sealed;
mod secrets;
mod shapes;
mod spectra;
mod sweep;
mod tenancy;
mod tensors;
mod upgrade;
mod uploads;
mod usage;
mod webhooks;
mod weights;

use std::sync::Arc;
use std::time::Duration;

use sqlx::AnyPool;
use tokio_util::task::AbortOnDropHandle;
use uuid::Uuid;

use crate::access::Tenant;
use blobs::Blobs;
use changes::Changes;
pub use changes::{JobChanges, QueueChanges};
pub use claims::Claim;
use database::{Engine, Listener};
use directory::Directory;
pub use error::{Lack, StoreError};
pub use idempotency::{MEMORY, Remembered, Turn};
pub use job::{Heartbeat, Job, Lease, NewJob, Places, Priority, Room, State, Submitted, problem};
pub use keys::{KeyRow, Keys};
pub use measures::describe;
pub use page::Page;
pub use place::{BlobUrl, Config, DatabaseUrl};
pub use queue::{LEASE, MAX_TRIES};
pub use retention::{Gone, Retention};
pub use shapes::{Deletion, Shape, ShapeKind, SourceFile};
pub use spectra::SpectrumKey;
pub use uploads::{Source, Unkept};
pub use usage::Usage;
pub use webhooks::{MAX_CALLS, Webhook};

/// The one door to what outlives the process. Clones share it; the last one dropped gives the data directory free.
///
/// Shapes, jobs and remembered answers are those of one tenant, see [`of`](Self::of). Whoever works on jobs and measures them
/// has to do with those of all.
#[derive(Clone)]
pub struct Store {
    pool: AnyPool,
    engine: Engine,
    blobs: Blobs,
    changes: Arc<Changes>,
    turns: Arc<idempotency::Turns>,
    /// Where the database is a file, that of this process.
    directory: Option<Arc<Directory>>,
    /// Where it is shared, what hears of the changes of other nodes.
    _notices: Option<Arc<AbortOnDropHandle<()>>>,
    tenant: Tenant,
    /// Whether spectra and preparations are the same for all tenants.
    shared_caches: bool,
}

/// The character that PostgreSQL takes into no text.
pub const NUL: char = '\0';

/// Whether something can be called so.
pub fn is_text(name: &str) -> bool {
    !name.contains(NUL)
}

impl Store {
    /// The store at the places of `config`, brought up to the present tables.
    ///
    /// # Errors
    /// [`StoreError::Locked`] when another process has the data directory open, [`StoreError::Unnamed`] and
    /// [`StoreError::Foreign`] where there are blobs that the database does not know, [`StoreError::Elsewhere`] where its own are
    /// not there; otherwise what the disk or the database said.
    pub async fn open(config: &Config) -> Result<Store, StoreError> {
        match &config.database_url {
            None => Store::open_alone(config).await,
            Some(url) => Store::join(config, url).await,
        }
    }

    /// The store of a process that has it to itself, with the jobs of the one before that died back in the queue: the lock
    /// proves that nobody works on them any more.
    async fn open_alone(config: &Config) -> Result<Store, StoreError> {
        let path = config.data_dir.clone();
        let directory = Arc::new(blocking(move || Directory::open(&path)).await?);
        let blobs = Blobs::open(config.blobs()).await?;
        if directory.database_is_empty()? && blobs.any().await? {
            return Err(StoreError::Unnamed { data_dir: directory.path().to_owned() });
        }
        // No connection that knows the tables before this is to be used after it.
        let pool = database::of_file(&directory.database(), 1).await?;
        let upgraded = upgrade::run(&pool, &blobs, &directory).await;
        pool.close().await;
        upgraded?;
        let pool = database::of_file(&directory.database(), database::SQLITE_CONNECTIONS).await?;
        let (changes, turns, directory) = (Arc::default(), Arc::default(), Some(directory));
        let (tenant, shared_caches) = (Tenant::default(), false);
        let (engine, _notices) = (Engine::Sqlite, None);
        let store = Store { pool, engine, blobs, changes, turns, directory, _notices, tenant, shared_caches };
        store.pair().await?;
        store.blobs.remove_unfinished().await?;
        store.forget_claims().await?;
        store.reap_all().await?;
        store.sweep(Duration::ZERO).await?;
        Ok(store)
    }

    /// The store that this process shares with other nodes. What theirs are doing is theirs.
    async fn join(config: &Config, url: &DatabaseUrl) -> Result<Store, StoreError> {
        let node = format!("sketchmatch/{}", Uuid::now_v7().simple());
        let blobs = Blobs::open(config.blobs()).await?;
        // In this order: of nodes that start together the one that has made the tables writes the first blob.
        let blobs_before = blobs.any().await?;
        let pool = database::of_server(url, &node).await?;
        if blobs_before && Engine::Postgres.version(&pool).await? == 0 {
            return Err(StoreError::Foreign { place: blobs.place().to_string() });
        }
        pool.close().await;
        let pool = database::up_to_date_server(url, &node).await?;
        let (changes, turns): (Arc<Changes>, _) = (Arc::default(), Arc::default());
        let listener = Listener::at(url, &node).await?;
        let notices = tokio::spawn(notices::follow(listener, url.clone(), node, changes.clone()));
        let (engine, directory, _notices) = (Engine::Postgres, None, Some(Arc::new(AbortOnDropHandle::new(notices))));
        let (tenant, shared_caches) = (Tenant::default(), false);
        let store = Store { pool, engine, blobs, changes, turns, directory, _notices, tenant, shared_caches };
        store.pair().await?;
        Ok(store)
    }

    /// Whether other nodes may be at work on it.
    pub fn is_shared(&self) -> bool {
        self.engine.is_shared()
    }

    /// Ends the use of the store in peace: afterwards a data directory's database file alone is whole, and clones of this
    /// store fail.
    ///
    /// # Errors
    /// What the database said.
    pub async fn close(&self) -> Result<(), StoreError> {
        self.engine.close(&self.pool).await
    }
}

fn milliseconds(duration: Duration) -> i64 {
    i64::try_from(duration.as_millis()).unwrap_or(i64::MAX)
}

/// Runs work that takes more than a moment off the threads that answer requests.
async fn blocking<T: Send + 'static>(
    work: impl FnOnce() -> Result<T, StoreError> + Send + 'static,
) -> Result<T, StoreError> {
    let joined = tokio::task::spawn_blocking(work).await;
    joined.unwrap_or_else(|error| Err(StoreError::damaged("a background task", error)))
}

#[cfg(test)]
pub(crate) mod testing;

#[cfg(test)]
mod earlier_versions;

#[cfg(test)]
mod tests;
