//! Databases for tests.

mod schema;

use std::path::Path;

use sqlx::AnyPool;
use sqlx::migrate::Migrator;

use super::{Engine, migrations, of_file};
pub use schema::Schema;

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
