use std::path::Path;

use sqlx::any::{AnyConnectOptions, AnyPoolOptions};
use sqlx::sqlite::SqliteConnectOptions;
use sqlx::{AnyPool, ConnectOptions, Executor};

use crate::store::StoreError;

/// `synchronous = FULL`: an acknowledged job survives a power cut.
const PRAGMAS: &str = "PRAGMA journal_mode = WAL; PRAGMA synchronous = FULL; PRAGMA busy_timeout = 30000; \
                       PRAGMA foreign_keys = ON";

/// A pool of connections to the file at `path`. They are opened at the start and stay open, so that none lacks a descriptor
/// or finds another file when it is needed.
pub(super) async fn connected(path: &Path, connections: u32) -> Result<AnyPool, StoreError> {
    let url = SqliteConnectOptions::new().filename(path).to_url_lossy();
    let pool = AnyPoolOptions::new()
        .min_connections(connections)
        .max_connections(connections)
        .idle_timeout(None)
        .max_lifetime(None)
        .after_connect(|connection, _| Box::pin(async move { connection.execute(PRAGMAS).await.map(drop) }))
        .connect_with(AnyConnectOptions::from_url(&url)?)
        .await?;
    Ok(pool)
}

/// Writes all that is in the log of writes into the database itself.
pub(super) async fn empty_log(pool: &AnyPool) -> Result<(), StoreError> {
    sqlx::query("PRAGMA wal_checkpoint(TRUNCATE)").execute(pool).await?;
    Ok(())
}
