use std::fs;
use std::path::Path;

use super::testing::{ALL, fresh, fresh_shared, shared_place};
use super::*;

#[tokio::test]
async fn a_second_process_is_refused_until_the_first_lets_go() {
    let (directory, store) = fresh().await;
    let config = Config::local(directory.path().join("data"));
    let refusal = Store::open(&config).await.err().unwrap();
    assert!(matches!(refusal, StoreError::Locked { .. }), "{refusal}");
    assert!(refusal.to_string().contains("data is in use by another process"), "{refusal}");
    std::fs::remove_file(config.data_dir.join("lock")).unwrap();
    let refusal = Store::open(&config).await.err().unwrap();
    assert!(matches!(refusal, StoreError::Locked { .. }), "{refusal}");
    drop(store);
    Store::open(&config).await.unwrap().database_healthy().await.unwrap();
}

#[tokio::test]
async fn blobs_without_their_database_are_refused_and_left_alone() {
    let (directory, store) = fresh().await;
    let config = Config::local(directory.path().join("data"));
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
    let pool = database::of_file(path, 1).await.unwrap();
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
    let blob_url = Some(BlobUrl::Folder(directory.path().join("data/blobs")));
    let copied = Store::open(&Config { blob_url, ..Config::local(copy) }).await.unwrap();
    assert_eq!(copied.queued("match").await.unwrap(), 1);
}

#[tokio::test]
async fn a_data_directory_that_cannot_be_made_is_named() {
    let file = tempfile::NamedTempFile::new().unwrap();
    let refusal = Store::open(&Config::local(file.path().join("data"))).await.err().unwrap();
    assert!(refusal.to_string().contains(&file.path().display().to_string()), "{refusal}");
}

#[tokio::test]
async fn the_directory_may_have_odd_characters() {
    let directory = tempfile::tempdir().unwrap();
    let config = Config::local(directory.path().join("a b?c#d&e=ü"));
    let store = Store::open(&config).await.unwrap();
    store.database_healthy().await.unwrap();
    assert!(config.data_dir.join("sketchmatch.db").is_file());
}

#[tokio::test(flavor = "multi_thread", worker_threads = 4)]
async fn nodes_that_start_together_make_the_tables_once() {
    let Some(place) = shared_place().await else { return };
    let config = place.config();
    let starting: Vec<_> = (0..5)
        .map(|_| {
            let config = config.clone();
            tokio::spawn(async move { Store::open(&config).await })
        })
        .collect();
    for started in starting {
        let store = started.await.unwrap().unwrap();
        store.database_healthy().await.unwrap();
        store.blobs_healthy().await.unwrap();
    }
}

#[tokio::test]
async fn a_shared_database_of_the_version_before_is_brought_up_to_date() {
    let Some(place) = shared_place().await else { return };
    let config = place.config();
    let pool = database::of_server(config.database_url.as_ref().unwrap(), "before").await.unwrap();
    database::testing::migrate_to(Engine::Postgres, &pool, 7).await;
    let sql = "INSERT INTO shapes (id, kind, body, created_ms, geometry) VALUES ('mesh_1', 'mesh', '{}', 1, 'mesh_2')";
    sqlx::query(sql).execute(&pool).await.unwrap();
    pool.close().await;
    let store = Store::open(&config).await.unwrap();
    assert!(store.shape(ShapeKind::Mesh, "mesh_1").await.unwrap().is_some());
    let blob = "SELECT geometry_blob FROM shapes";
    let blob: String = sqlx::query_scalar(blob).fetch_one(&store.pool).await.unwrap();
    assert_eq!(blob, "shapes/mesh_2.safetensors");
}

#[tokio::test]
async fn a_node_that_joins_leaves_the_jobs_of_others_alone() {
    let Some((place, store)) = fresh_shared().await else { return };
    store.submit(&NewJob::of("match", "1"), Places { queue: 1, of_kind: 1 }).await.unwrap();
    let lease = store.claim(&["match"], ALL).await.unwrap().unwrap();
    let other = place.open().await;
    assert_eq!(other.reap().await.unwrap(), 0);
    assert_eq!(store.heartbeat(&lease, "map", 0.5).await.unwrap(), Heartbeat::Held);
}

#[tokio::test]
async fn blobs_that_no_database_names_are_not_given_to_a_new_one() {
    let Some(place) = shared_place().await else { return };
    let config = place.config();
    let results = config.data_dir.join("blobs/results/job");
    fs::create_dir_all(&results).unwrap();
    fs::write(results.join("1"), "answer").unwrap();
    let refusal = Store::open(&config).await.err().unwrap();
    assert!(matches!(refusal, StoreError::Foreign { .. }), "{refusal}");
    assert_eq!(fs::read_to_string(results.join("1")).unwrap(), "answer");
}
