//! Databases for tests.

use std::env;
use std::io::{Write, stderr};
use std::path::Path;
use std::thread;

use sqlx::migrate::Migrator;
use sqlx::postgres::PgConnectOptions;
use sqlx::{AnyPool, AssertSqlSafe, ConnectOptions, Connection, Executor, PgConnection};
use tokio::runtime::Builder;
use uuid::Uuid;

use super::{Engine, migrations, of_file};
use crate::store::DatabaseUrl;

/// A pool on the SQLite file at `path` with the tables as the migration `version` left them.
pub async fn file_of_version(path: &Path, version: i64) -> AnyPool {
    let pool = of_file(path, 1).await.unwrap();
    migrate_to(Engine::Sqlite, &pool, version).await;
    pool
}

/// Brings the tables to where the migration `version` left them.
pub async fn migrate_to(engine: Engine, pool: &AnyPool, version: i64) {
    let all = migrations::of(engine).migrations;
    let migrations = all.iter().filter(|migration| migration.version <= version).cloned().collect();
    Migrator::with_migrations(migrations).run(pool).await.unwrap();
}

/// The database that tests make their schemas in.
const VARIABLE: &str = "SKETCHMATCH_TEST_DATABASE_URL";

/// Where one is looked for unless the variable names it.
const LOCAL: &str = "postgres://127.0.0.1:5432/test";

/// A schema for one test, dropped with all that is in it.
pub struct Schema {
    server: String,
    name: String,
}

impl Schema {
    /// A schema where a PostgreSQL answers; nothing, and a line on standard error, where none does. One that was named has
    /// to answer.
    pub async fn fresh() -> Option<Schema> {
        let named = env::var(VARIABLE).ok();
        let server = named.clone().unwrap_or_else(|| LOCAL.to_owned());
        let name = format!("test_{}", Uuid::now_v7().simple());
        match execute(&server, format!("CREATE SCHEMA {name}")).await {
            Ok(()) => Some(Schema { server, name }),
            Err(error) => {
                assert!(named.is_none(), "{VARIABLE}: {error}");
                let test = thread::current().name().unwrap_or("a test").to_owned();
                // Not by the macro, whose lines are kept from who runs the tests.
                writeln!(stderr(), "{test}: skipped on PostgreSQL, for none answers at {LOCAL}: {error}").unwrap();
                None
            }
        }
    }

    pub fn url(&self) -> DatabaseUrl {
        let separator = if self.server.contains('?') { '&' } else { '?' };
        format!("{}{separator}options[search_path]={}", self.server, self.name).parse().unwrap()
    }
}

impl Drop for Schema {
    fn drop(&mut self) {
        let (server, sql) = (self.server.clone(), format!("DROP SCHEMA {} CASCADE", self.name));
        // A runtime of its own, for the test's waits for this.
        let dropping = move || {
            let runtime = Builder::new_current_thread().enable_all().build();
            runtime.map(|runtime| runtime.block_on(execute(&server, sql)))
        };
        if !matches!(thread::spawn(dropping).join(), Ok(Ok(Ok(())))) {
            writeln!(stderr(), "the schema {} is left behind", self.name).unwrap();
        }
    }
}

async fn execute(server: &str, sql: String) -> Result<(), sqlx::Error> {
    let options: PgConnectOptions = server.parse()?;
    let mut connection: PgConnection = options.connect().await?;
    connection.execute(AssertSqlSafe(sql)).await?;
    connection.close().await
}
