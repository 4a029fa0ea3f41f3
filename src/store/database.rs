use std::path::Path;

use sqlx::any::{AnyConnectOptions, AnyPoolOptions, install_default_drivers};
use sqlx::migrate::{Migration, MigrationType, Migrator};
use sqlx::sqlite::SqliteConnectOptions;
use sqlx::{AnyPool, ConnectOptions, Executor, SqlSafeStr};

use super::StoreError;

/// Readers beside the one writer that SQLite admits.
pub(super) const CONNECTIONS: u32 = 8;

/// `synchronous = FULL`: an acknowledged job survives a power cut.
const PRAGMAS: &str = "PRAGMA journal_mode = WAL; PRAGMA synchronous = FULL; PRAGMA busy_timeout = 30000; \
                       PRAGMA foreign_keys = ON";

/// A pool of connections to the SQLite file at `path`, which has to be there. They are opened at the start and stay open, so
/// that none lacks a descriptor or finds another file when it is needed.
pub(super) async fn connected(path: &Path, connections: u32) -> Result<AnyPool, StoreError> {
    install_default_drivers();
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

/// The last migration the tables have seen; 0 where there are none.
pub(super) async fn version(pool: &AnyPool) -> Result<i64, StoreError> {
    let tables = "SELECT count(*) FROM sqlite_master WHERE name = '_sqlx_migrations'";
    if sqlx::query_scalar::<_, i64>(tables).fetch_one(pool).await? == 0 {
        return Ok(0);
    }
    Ok(sqlx::query_scalar("SELECT COALESCE(max(version), 0) FROM _sqlx_migrations").fetch_one(pool).await?)
}

/// Ok where the tables are those of this program.
///
/// # Errors
/// [`StoreError::OtherVersion`]; what the database said.
pub(super) async fn up_to_date(pool: &AnyPool) -> Result<(), StoreError> {
    let (found, ours) = (version(pool).await?, migrator().iter().map(|migration| migration.version).max());
    if Some(found) == ours { Ok(()) } else { Err(StoreError::OtherVersion) }
}

/// Brings the tables up to the present. The caller holds the lock that this needs.
pub(super) async fn migrate(pool: &AnyPool) -> Result<(), StoreError> {
    Ok(migrator().run(pool).await?)
}

/// Writes all that is in the log of writes into the database itself and closes it, so that its file alone is whole.
pub(super) async fn close(pool: &AnyPool) -> Result<(), StoreError> {
    sqlx::query("PRAGMA wal_checkpoint(TRUNCATE)").execute(pool).await?;
    pool.close().await;
    Ok(())
}

/// Every migration in its order; a new one is a new file and a new line, an old one is never edited.
fn migrator() -> Migrator {
    let files = [
        (1, "store", include_str!("../../migrations/sqlite/0001_store.sql")),
        (2, "jobs by key", include_str!("../../migrations/sqlite/0002_jobs_by_key.sql")),
        (3, "uploads", include_str!("../../migrations/sqlite/0003_uploads.sql")),
        (4, "jobs by shape", include_str!("../../migrations/sqlite/0004_jobs_by_shape.sql")),
        (5, "names of jobs", include_str!("../../migrations/sqlite/0005_names_of_jobs.sql")),
        (6, "answers by key", include_str!("../../migrations/sqlite/0006_answers_by_key.sql")),
        (7, "sizes of shapes", include_str!("../../migrations/sqlite/0007_sizes_of_shapes.sql")),
        (8, "keys", include_str!("../../migrations/sqlite/0008_keys.sql")),
        (9, "tenants", include_str!("../../migrations/sqlite/0009_tenants.sql")),
        (11, "previews", include_str!("../../migrations/sqlite/0011_previews.sql")),
    ];
    let migration = |(version, name, sql): (i64, &'static str, &'static str)| {
        Migration::new(version, name.into(), MigrationType::Simple, sql.into_sql_str(), false)
    };
    Migrator::with_migrations(files.into_iter().map(migration).collect())
}

#[cfg(test)]
pub(super) mod testing {
    use super::*;

    /// A pool on the SQLite file at `path` with the tables as the migration `version` left them.
    pub async fn of_version(path: &Path, version: i64) -> AnyPool {
        let pool = connected(path, 1).await.unwrap();
        let migrations =
            migrator().migrations.iter().filter(|migration| migration.version <= version).cloned().collect();
        Migrator::with_migrations(migrations).run(&pool).await.unwrap();
        pool
    }
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    #[test]
    fn every_migration_there_is_is_carried_out() {
        let files = fs::read_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/migrations/sqlite")).unwrap().count();
        assert_eq!(migrator().migrations.len(), files);
    }
}
