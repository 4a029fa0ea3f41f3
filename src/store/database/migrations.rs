use sqlx::SqlSafeStr;
use sqlx::migrate::{Migration, MigrationType, Migrator};

use super::Engine;

type File = (i64, &'static str, &'static str);

/// Every migration in its order; a new one is a new file and a new line, an old one is never edited. One number makes the
/// same of the tables of both engines.
const SQLITE: [File; 17] = [
    (1, "store", include_str!("../../../migrations/sqlite/0001_store.sql")),
    (2, "jobs by key", include_str!("../../../migrations/sqlite/0002_jobs_by_key.sql")),
    (3, "uploads", include_str!("../../../migrations/sqlite/0003_uploads.sql")),
    (4, "jobs by shape", include_str!("../../../migrations/sqlite/0004_jobs_by_shape.sql")),
    (5, "names of jobs", include_str!("../../../migrations/sqlite/0005_names_of_jobs.sql")),
    (6, "answers by key", include_str!("../../../migrations/sqlite/0006_answers_by_key.sql")),
    (7, "sizes of shapes", include_str!("../../../migrations/sqlite/0007_sizes_of_shapes.sql")),
    (8, "keys", include_str!("../../../migrations/sqlite/0008_keys.sql")),
    (9, "tenants", include_str!("../../../migrations/sqlite/0009_tenants.sql")),
    (10, "nodes", include_str!("../../../migrations/sqlite/0010_nodes.sql")),
    (11, "previews", include_str!("../../../migrations/sqlite/0011_previews.sql")),
    (12, "admission", include_str!("../../../migrations/sqlite/0012_admission.sql")),
    (13, "turns", include_str!("../../../migrations/sqlite/0013_turns.sql")),
    (14, "webhooks", include_str!("../../../migrations/sqlite/0014_webhooks.sql")),
    (15, "traces", include_str!("../../../migrations/sqlite/0015_traces.sql")),
    (16, "matched vertices", include_str!("../../../migrations/sqlite/0016_matched_vertices.sql")),
    (17, "pairs", include_str!("../../../migrations/sqlite/0017_pairs.sql")),
];

/// PostgreSQL came with the seventh.
const POSTGRES: [File; 11] = [
    (7, "store", include_str!("../../../migrations/postgres/0007_store.sql")),
    (8, "keys", include_str!("../../../migrations/postgres/0008_keys.sql")),
    (9, "tenants", include_str!("../../../migrations/postgres/0009_tenants.sql")),
    (10, "nodes", include_str!("../../../migrations/postgres/0010_nodes.sql")),
    (11, "previews", include_str!("../../../migrations/postgres/0011_previews.sql")),
    (12, "admission", include_str!("../../../migrations/postgres/0012_admission.sql")),
    (13, "turns", include_str!("../../../migrations/postgres/0013_turns.sql")),
    (14, "webhooks", include_str!("../../../migrations/postgres/0014_webhooks.sql")),
    (15, "traces", include_str!("../../../migrations/postgres/0015_traces.sql")),
    (16, "matched vertices", include_str!("../../../migrations/postgres/0016_matched_vertices.sql")),
    (17, "pairs", include_str!("../../../migrations/postgres/0017_pairs.sql")),
];

pub(super) fn of(engine: Engine) -> Migrator {
    let files: &[File] = match engine {
        Engine::Sqlite => &SQLITE,
        Engine::Postgres => &POSTGRES,
    };
    let migration = |&(version, name, sql): &File| {
        Migration::new(version, name.into(), MigrationType::Simple, sql.into_sql_str(), false)
    };
    Migrator::with_migrations(files.iter().map(migration).collect())
}

#[cfg(test)]
mod tests {
    use std::fs;
    use std::path::Path;

    use super::*;

    #[test]
    fn every_migration_there_is_is_carried_out() {
        let folders = Path::new(env!("CARGO_MANIFEST_DIR")).join("migrations");
        for (engine, folder) in [(Engine::Sqlite, "sqlite"), (Engine::Postgres, "postgres")] {
            let files = fs::read_dir(folders.join(folder)).unwrap().count();
            assert_eq!(of(engine).migrations.len(), files, "{folder}");
        }
    }

    #[test]
    fn both_engines_have_had_the_same_since_there_are_two() {
        let numbers =
            |files: &[File]| files.iter().map(|file| file.0).filter(|&number| number >= 7).collect::<Vec<_>>();
        assert_eq!(numbers(&SQLITE), numbers(&POSTGRES));
    }
}
