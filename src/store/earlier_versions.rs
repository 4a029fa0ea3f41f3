//! Data directories as versions before this one left them, opened by this one.

use std::fs;
use std::path::Path;

use bytes::Bytes;
use serde_json::json;
use sqlx::AnyPool;
use tempfile::TempDir;

use super::blobs::Blobs;
use super::testing::{ALL, source};
use super::{BlobUrl, Config, Remembered, ShapeKind, State, Store, StoreError, database, geometry};
use crate::mesh::TriangleMesh;
use crate::sketch::{Sketch, YAxis};

/// The last migration of the version that named shapes by their geometry and kept no files.
const BY_GEOMETRY: i64 = 2;

async fn open(directory: &TempDir) -> Store {
    Store::open(&Config::local(directory.path().join("data"))).await.unwrap()
}

fn triangle() -> TriangleMesh {
    TriangleMesh::new(vec![[0.0; 3], [1.0, 0.0, 0.0], [0.3, 1.0, 0.0]], vec![[0, 1, 2]]).unwrap()
}

fn write(data: &Path, blob: &str, bytes: &[u8]) {
    let path = data.join("blobs").join(blob);
    fs::create_dir_all(path.parent().unwrap()).unwrap();
    fs::write(path, bytes).unwrap();
}

async fn insert_shape(pool: &AnyPool, id: &str, kind: &str, name: Option<&str>, body: &str) {
    let sql = "INSERT INTO shapes (id, kind, name, body, created_ms) VALUES ($1, $2, $3, $4, 1700000000000)";
    sqlx::query(sql).bind(id).bind(kind).bind(name).bind(body).execute(pool).await.unwrap();
}

async fn insert_job(pool: &AnyPool, id: &str, payload: &str, state: &str, result: Option<&str>) {
    let sql = "INSERT INTO jobs (id, kind, payload, priority, state, attempt, tries, result, created_ms) \
               VALUES ($1, 'match', $2, 1, $3, 1, 1, $4, 1700000000000)";
    sqlx::query(sql).bind(id).bind(payload).bind(state).bind(result).execute(pool).await.unwrap();
}

/// A directory with a mesh, a sketch, a match that is done, one whose result is cut short and one that waits, and caches;
/// the ids of the two shapes.
async fn directory_by_geometry() -> (TempDir, String, String) {
    let directory = tempfile::tempdir().unwrap();
    let data = directory.path().join("data");
    fs::create_dir(&data).unwrap();
    let (mesh, sketch) = (geometry::of_mesh(&triangle().into()), geometry::of_sketch(&drawing()));
    let (mesh, sketch) = (mesh.unwrap(), sketch.unwrap());
    write(&data, &format!("shapes/{}.safetensors", mesh.name), &mesh.bytes);
    write(&data, &format!("shapes/{}.safetensors", sketch.name), &sketch.bytes);
    write(&data, "results/done/1", br#"{"c": 1}"#);
    write(&data, "results/cut/1", br#"{"c":"#);
    write(&data, "spectra/hash/cotangent-mixed-neumann-1/20.safetensors", b"numbers");
    write(&data, "preparations/hash/1", b"views");
    let database = data.join("sketchmatch.db");
    fs::write(&database, "").unwrap();
    let pool = database::testing::file_of_version(&database, BY_GEOMETRY).await;
    insert_shape(&pool, &mesh.name, "mesh", Some("old"), r#"{"vertices": 3, "triangles": 1}"#).await;
    insert_shape(&pool, &sketch.name, "sketch", None, r#"{"vertices": 3}"#).await;
    let payload = json!({"mesh": mesh.name, "sketch": sketch.name}).to_string();
    insert_job(&pool, "done", &payload, "succeeded", Some("results/done/1")).await;
    insert_job(&pool, "cut", &payload, "succeeded", Some("results/cut/1")).await;
    insert_job(&pool, "waits", &payload, "queued", None).await;
    pool.close().await;
    (directory, mesh.name, sketch.name)
}

fn drawing() -> Sketch {
    Sketch::new(triangle(), YAxis::Down).unwrap()
}

#[tokio::test]
async fn an_upgrade_that_was_cut_off_goes_on() {
    let (directory, mesh, _) = directory_by_geometry().await;
    let blobs = BlobUrl::Folder(directory.path().join("data/blobs"));
    Blobs::open(blobs).await.unwrap().seal("results/done/1", |_| true).await.unwrap();
    let store = open(&directory).await;
    assert_eq!(store.result("done").await.unwrap(), Some(Bytes::from_static(br#"{"c": 1}"#)));
    assert_eq!(store.mesh(&mesh).await.unwrap(), Some(triangle().into()));
}

#[tokio::test]
async fn answers_under_a_key_are_remembered_still() {
    let (directory, ..) = directory_by_geometry().await;
    let pool = database::testing::file_of_version(&directory.path().join("data/sketchmatch.db"), BY_GEOMETRY).await;
    let sql =
        "INSERT INTO answers (key, route, fingerprint, status, body, expires_ms) VALUES ('k', $1, 'f', $2, $3, $4)";
    for (route, status, expires_ms) in [("POST /b", 202, i64::MAX), ("POST /a", 201, i64::MAX - 1)] {
        let query = sqlx::query(sql).bind(route).bind(status).bind(b"{}".as_slice()).bind(expires_ms);
        query.execute(&pool).await.unwrap();
    }
    pool.close().await;
    let same = Remembered::Same { status: 201, location: None, body: b"{}".to_vec() };
    assert_eq!(open(&directory).await.remembered("k", "POST /a f").await.unwrap(), same);
}

#[tokio::test]
async fn shapes_named_by_their_geometry_keep_their_names_and_their_matches() {
    let (directory, mesh, sketch) = directory_by_geometry().await;
    let store = open(&directory).await;
    let shape = store.shape(ShapeKind::Mesh, &mesh).await.unwrap().unwrap();
    assert_eq!((shape.name.as_deref(), &shape.body), (Some("old"), &json!({"vertices": 3, "triangles": 1})));
    assert_eq!((shape.vertices, shape.triangles), (3, 1));
    // What was told of the sketch says nothing of its triangles.
    let told = store.shape(ShapeKind::Sketch, &sketch).await.unwrap().unwrap();
    assert_eq!((told.vertices, told.triangles), (3, 0));
    assert_eq!(store.mesh(&mesh).await.unwrap(), Some(triangle().into()));
    assert_eq!(store.sketch(&sketch).await.unwrap(), Some(drawing()));
    assert_eq!(store.file(ShapeKind::Mesh, &mesh).await.unwrap(), None);
    assert_eq!(store.result("done").await.unwrap(), Some(Bytes::from_static(br#"{"c": 1}"#)));
    assert!(matches!(store.result("cut").await, Err(StoreError::LostResult { .. })));
    for cache in ["spectra", "preparations"] {
        assert_eq!(store.blobs.names(cache).await.unwrap(), Vec::<String>::new());
    }
    let waiting = store.claim(&["match"], ALL).await.unwrap().unwrap();
    assert_eq!(
        (waiting.job.id.as_str(), waiting.job.kind.as_str(), waiting.job.state),
        ("waits", "match", State::Running)
    );
    // The same geometry comes again: another shape, with its file, beside the old one.
    let (again, new) = store.insert_mesh(triangle().into(), source("v"), None, json!({})).await.unwrap();
    assert!(new && again.id != mesh, "{again:?}");
    assert_eq!(store.shape(ShapeKind::Mesh, &mesh).await.unwrap(), Some(shape));
    assert!(store.file(ShapeKind::Mesh, &again.id).await.unwrap().is_some());
}
