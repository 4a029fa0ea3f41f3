//! The two databases that tables may be in, and where they differ: everything else is one SQL text for both.

mod migrations;
mod postgres;
mod sqlite;

use std::path::Path;

use sqlx::any::install_default_drivers;
use sqlx::{Any, AnyPool, Transaction};

use super::{DatabaseUrl, StoreError};
pub(super) use postgres::Listener;

/// What keeps the tables.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Engine {
    /// A file, for one process.
    Sqlite,
    /// A server, for many nodes.
    Postgres,
}

/// A pool on the SQLite file at `path`, which has to be there, its tables as they are.
pub(super) async fn of_file(path: &Path, connections: u32) -> Result<AnyPool, StoreError> {
    install_default_drivers();
    sqlite::connected(path, connections).await
}

/// Readers beside the one writer that SQLite admits.
pub(super) const SQLITE_CONNECTIONS: u32 = 8;

/// A pool on the PostgreSQL database at `url`, its tables as they are, for a node of this name.
pub(super) async fn of_server(url: &DatabaseUrl, node: &str) -> Result<AnyPool, StoreError> {
    install_default_drivers();
    postgres::connected(&url.called(node)).await
}

/// A pool on the PostgreSQL database at `url` for a node of this name, its tables brought up to the present.
///
/// # Errors
/// As of [`Engine::migrate`].
pub(super) async fn up_to_date_server(url: &DatabaseUrl, node: &str) -> Result<AnyPool, StoreError> {
    let pool = of_server(url, node).await?;
    Engine::Postgres.migrate(&pool).await?;
    // No connection that knows the tables before this is to be used after it.
    pool.close().await;
    of_server(url, node).await
}

impl Engine {
    /// Brings the tables up to the present. On SQLite the caller holds the lock that this needs; on PostgreSQL one node after
    /// the other gets to it, and the others find nothing to do.
    ///
    /// # Errors
    /// What the database said; tables of a later version of this program among it.
    pub async fn migrate(self, pool: &AnyPool) -> Result<(), StoreError> {
        Ok(migrations::of(self).run(pool).await?)
    }

    /// Ok where the tables are those of this program.
    ///
    /// # Errors
    /// [`StoreError::OtherVersion`]; what the database said.
    pub async fn up_to_date(self, pool: &AnyPool) -> Result<(), StoreError> {
        let (found, ours) =
            (self.version(pool).await?, migrations::of(self).iter().map(|migration| migration.version).max());
        if Some(found) == ours { Ok(()) } else { Err(StoreError::OtherVersion) }
    }

    /// The last migration the tables have seen; 0 where there are none.
    ///
    /// # Errors
    /// What the database said.
    pub async fn version(self, pool: &AnyPool) -> Result<i64, StoreError> {
        let tables = match self {
            Engine::Sqlite => "SELECT count(*) FROM sqlite_master WHERE name = '_sqlx_migrations'",
            Engine::Postgres => "SELECT count(to_regclass('_sqlx_migrations'))",
        };
        if sqlx::query_scalar::<_, i64>(tables).fetch_one(pool).await? == 0 {
            return Ok(0);
        }
        Ok(sqlx::query_scalar("SELECT COALESCE(max(version), 0) FROM _sqlx_migrations").fetch_one(pool).await?)
    }

    /// A transaction that no other of these runs beside: what is read in it is still so when it is committed, as long as
    /// whoever changes it begins like this too.
    ///
    /// # Errors
    /// What the database said.
    pub async fn alone(self, pool: &AnyPool) -> Result<Transaction<'static, Any>, StoreError> {
        match self {
            Engine::Sqlite => Ok(pool.begin_with("BEGIN IMMEDIATE").await?),
            Engine::Postgres => {
                let mut transaction = pool.begin().await?;
                sqlx::query(postgres::TAKE_TURN).execute(&mut *transaction).await?;
                Ok(transaction)
            }
        }
    }

    /// What makes the rows of `table` that are being read nobody else's until they are changed, those that others have being
    /// passed over; SQLite has one writer at a time.
    pub fn for_update_of(self, table: &str) -> String {
        match self {
            Engine::Sqlite => String::new(),
            Engine::Postgres => format!("FOR UPDATE OF {table} SKIP LOCKED"),
        }
    }

    /// Whether other nodes may be at work on the same tables.
    pub const fn is_shared(self) -> bool {
        matches!(self, Engine::Postgres)
    }

    /// Ends the use of the database in peace; SQLite's file alone is whole afterwards.
    ///
    /// # Errors
    /// What the database said.
    pub async fn close(self, pool: &AnyPool) -> Result<(), StoreError> {
        if self == Engine::Sqlite {
            sqlite::empty_log(pool).await?;
        }
        pool.close().await;
        Ok(())
    }
}

#[cfg(test)]
pub(super) mod testing;
