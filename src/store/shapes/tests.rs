use std::sync::Arc;
use std::time::Duration;

use futures::future::join_all;
use serde_json::json;

use super::*;
use crate::mesh::TriangleMesh;
use crate::mesh::formats::{Format, Limits};
use crate::mesh::solids::star;
use crate::mesh::validation::import;
use crate::sketch::YAxis;
use crate::store::testing::{ALL, fresh, on_every_database, open, source};
use crate::store::{NewJob, Places, Source, Submitted};

/// A unit square in two triangles, and a vertex of no triangle, moved by `x`.
fn square(x: f64) -> FileMesh {
    let positions = [[x, 0.0, 0.0], [x + 1.0, 0.0, 0.0], [x + 1.0, 1.0, 0.0], [x, 1.0, 0.0], [9.0, 9.0, 0.1]];
    TriangleMesh::new(positions.to_vec(), vec![[0, 1, 2], [0, 2, 3]]).unwrap().into()
}

fn drawing(y_axis: YAxis) -> Sketch {
    let positions = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.3, 1.0, 0.0]];
    Sketch::new(TriangleMesh::new(positions, vec![[0, 1, 2]]).unwrap(), y_axis).unwrap()
}

async fn blobs(store: &Store, folder: &str) -> usize {
    store.blobs.names(folder).await.unwrap().len()
}

#[tokio::test]
async fn an_upload_is_kept_whole_and_once() {
    let (directory, store) = fresh().await;
    let (shape, new) = store.insert_mesh(square(0.1), source("a"), Some("one"), json!({"a": 1})).await.unwrap();
    assert!(new && shape.id.starts_with("mesh_") && shape.id.len() == 37, "{shape:?}");
    let (again, new) = store.insert_mesh(square(0.1), source("a"), None, json!({"a": 1})).await.unwrap();
    assert_eq!((&again, new), (&shape, false));
    drop(store);
    let store = open(&directory).await;
    assert_eq!(store.shape(ShapeKind::Mesh, &shape.id).await.unwrap().as_ref(), Some(&shape));
    assert_eq!(store.mesh(&shape.id).await.unwrap(), Some(square(0.1)));
    let file = SourceFile { bytes: Bytes::from("a"), media_type: "model/obj".to_owned() };
    assert_eq!(store.file(ShapeKind::Mesh, &shape.id).await.unwrap(), Some(file));
    assert_eq!(store.sketch(&shape.id).await.unwrap(), None);
    assert_eq!(store.shape(ShapeKind::Sketch, &shape.id).await.unwrap(), None);
    assert_eq!(store.file(ShapeKind::Sketch, &shape.id).await.unwrap(), None);
}

#[tokio::test]
async fn every_upload_is_told_of_for_itself() {
    on_every_database(async |_, store| {
        let of_type = |media_type: &str| Source { media_type: media_type.to_owned(), ..source("a") };
        let asked = |parameters: &str| Source { parameters: parameters.to_owned(), ..source("a") };
        let sources = [source("a"), source("b"), of_type("model/off"), asked("target_vertices=60")];
        let mut ids = std::collections::BTreeSet::new();
        for (number, source) in sources.into_iter().enumerate() {
            let (name, body) = (number.to_string(), json!({"number": number}));
            let (shape, new) = store.insert_mesh(square(0.1), source, Some(&name), body.clone()).await.unwrap();
            assert!(new);
            assert_eq!((shape.name.as_deref(), &shape.body), (Some(name.as_str()), &body));
            assert_eq!(store.mesh(&shape.id).await.unwrap(), Some(square(0.1)));
            ids.insert(shape.id);
        }
        assert_eq!((ids.len(), blobs(&store, "shapes").await, blobs(&store, "files").await), (4, 4, 4));
        // What another version of the program reads of the same file is another shape.
        let (other, new) = store.insert_mesh(square(0.2), source("a"), None, json!({})).await.unwrap();
        assert!(new && !ids.contains(&other.id));
    })
    .await;
}

#[tokio::test]
async fn an_upload_that_is_known_takes_the_name_that_comes_with_it() {
    on_every_database(async |_, store| {
        let named = async |name| store.insert_mesh(square(0.1), source("a"), name, json!({})).await.unwrap().0.name;
        assert_eq!(named(Some("one")).await.as_deref(), Some("one"));
        assert_eq!(named(Some("two")).await.as_deref(), Some("two"));
        assert_eq!(named(None).await.as_deref(), Some("two"));
    })
    .await;
}

#[tokio::test]
async fn a_geometry_that_is_not_the_one_of_its_name_is_damaged_until_it_is_uploaded_again() {
    on_every_database(async |_, store| {
        let mesh = async || store.insert_mesh(square(0.1), source("a"), Some("square"), json!({})).await.unwrap().0;
        let sketch = async || store.insert_sketch(drawing(YAxis::Up), source("a"), None, json!({})).await.unwrap().0;
        let (of_mesh, of_sketch) = (mesh().await, sketch().await);
        let others =
            [(&of_mesh, geometry::of_mesh(&square(0.2))), (&of_sketch, geometry::of_sketch(&drawing(YAxis::Down)))];
        for (shape, other) in others {
            store.blobs.put(&shape.geometry_blob, other.unwrap().bytes).await.unwrap();
        }
        let error = store.mesh(&of_mesh.id).await.unwrap_err();
        let remedy =
            format!("mesh {} (square) is damaged on the server's disk: upload the same file again", of_mesh.id);
        assert!(error.remedy().unwrap().starts_with(&remedy), "{error}");
        assert!(store.sketch(&of_sketch.id).await.unwrap_err().remedy().is_some());
        assert_eq!((mesh().await, sketch().await), (of_mesh.clone(), of_sketch.clone()));
        assert_eq!(store.mesh(&of_mesh.id).await.unwrap(), Some(square(0.1)));
        assert_eq!(store.sketch(&of_sketch.id).await.unwrap(), Some(drawing(YAxis::Up)));
    })
    .await;
}

#[tokio::test]
async fn a_shape_without_its_blobs_is_damaged() {
    on_every_database(async |_, store| {
        let (shape, _) = store.insert_mesh(square(0.1), source("a"), None, json!({})).await.unwrap();
        store.blobs.delete(&shape.geometry_blob).await.unwrap();
        store.blobs.delete(&shape.file.as_ref().unwrap().0).await.unwrap();
        assert!(matches!(store.mesh(&shape.id).await, Err(StoreError::DamagedShape { .. })));
        assert!(matches!(store.file(ShapeKind::Mesh, &shape.id).await, Err(StoreError::DamagedShape { .. })));
    })
    .await;
}

#[tokio::test]
async fn a_sketch_keeps_its_axis() {
    on_every_database(async |_, store| {
        for y_axis in [YAxis::Up, YAxis::Down] {
            let (shape, new) = store.insert_sketch(drawing(y_axis), source("a"), None, json!({})).await.unwrap();
            assert!(new && shape.id.starts_with("sketch_"), "{shape:?}");
            assert_eq!(store.sketch(&shape.id).await.unwrap(), Some(drawing(y_axis)));
            assert_eq!(store.mesh(&shape.id).await.unwrap(), None);
        }
    })
    .await;
}

#[tokio::test]
async fn pages_go_from_the_newest_to_the_oldest() {
    on_every_database(async |_, store| {
        for x in 0..5 {
            store.insert_mesh(square(f64::from(x)), source("a"), None, json!({})).await.unwrap();
        }
        store.insert_sketch(drawing(YAxis::Up), source("a"), None, json!({})).await.unwrap();
        let whole = store.shapes(ShapeKind::Mesh, &Page { after: None, limit: 100 }).await.unwrap();
        assert_eq!(whole.len(), 5);
        assert!(whole.is_sorted_by_key(|shape| std::cmp::Reverse((shape.created_ms, shape.id.clone()))));
        let mut paged = Vec::new();
        let mut after = None;
        loop {
            let page = store.shapes(ShapeKind::Mesh, &Page { after, limit: 2 }).await.unwrap();
            after = page.last().map(Shape::cursor);
            paged.extend(page);
            if after.is_none() {
                break;
            }
        }
        assert_eq!(paged, whole);
    })
    .await;
}

#[tokio::test]
async fn a_cursor_of_somebody_else_is_refused() {
    on_every_database(async |_, store| {
        for after in ["", "nonsense", "x.mesh_0"] {
            let page = Page { after: Some(after.to_owned()), limit: 1 };
            assert!(matches!(store.shapes(ShapeKind::Mesh, &page).await, Err(StoreError::Cursor)), "{after}");
        }
    })
    .await;
}

#[tokio::test]
async fn a_shape_is_renamed() {
    on_every_database(async |_, store| {
        let (shape, _) = store.insert_mesh(square(0.1), source("a"), Some("one"), json!({})).await.unwrap();
        for name in [Some("two"), None] {
            let renamed = store.rename(ShapeKind::Mesh, &shape.id, name).await.unwrap().unwrap();
            assert_eq!(renamed.name.as_deref(), name);
            assert_eq!(store.shape(ShapeKind::Mesh, &shape.id).await.unwrap(), Some(renamed));
        }
        assert_eq!(store.rename(ShapeKind::Sketch, &shape.id, Some("three")).await.unwrap(), None);
    })
    .await;
}

#[tokio::test]
async fn a_shape_is_deleted_with_what_no_other_shares() {
    on_every_database(async |_, store| {
        let insert = async |bytes| store.insert_mesh(square(0.1), source(bytes), None, json!({})).await.unwrap().0.id;
        let (first, second) = (insert("a").await, insert("b").await);
        let delete = async |id: &str| store.delete_shape(ShapeKind::Mesh, id).await.unwrap();
        assert_eq!(store.delete_shape(ShapeKind::Sketch, &first).await.unwrap(), Deletion::Missing);
        assert_eq!(delete(&first).await, Deletion::Done);
        assert_eq!(delete(&first).await, Deletion::Missing);
        assert_eq!((blobs(&store, "shapes").await, blobs(&store, "files").await), (1, 1));
        assert_eq!(store.mesh(&second).await.unwrap(), Some(square(0.1)));
        assert_eq!(delete(&second).await, Deletion::Done);
        assert_eq!((blobs(&store, "shapes").await, blobs(&store, "files").await), (0, 0));
        assert_eq!(insert("a").await, first);
    })
    .await;
}

#[tokio::test]
async fn a_shape_stays_while_an_unfinished_job_needs_it() {
    on_every_database(async |_, store| {
        let mesh = store.insert_mesh(square(0.1), source("a"), None, json!({})).await.unwrap().0.id;
        let sketch = store.insert_sketch(drawing(YAxis::Up), source("a"), None, json!({})).await.unwrap().0.id;
        let job = NewJob { mesh: Some(&mesh), sketch: Some(&sketch), ..NewJob::of("match", "{}") };
        let places = Places { queue: 9, of_kind: 9 };
        let Submitted::Taken(taken) = store.submit(&job, places).await.unwrap() else { panic!("there is place") };
        for _ in ["queued", "running"] {
            assert_eq!(store.delete_shape(ShapeKind::Mesh, &mesh).await.unwrap(), Deletion::Needed);
            assert_eq!(store.delete_shape(ShapeKind::Sketch, &sketch).await.unwrap(), Deletion::Needed);
            store.claim(&["match"], ALL).await.unwrap();
        }
        store.cancel(&taken.id).await.unwrap();
        assert_eq!(store.delete_shape(ShapeKind::Sketch, &sketch).await.unwrap(), Deletion::Done);
        assert_eq!(store.submit(&job, places).await.unwrap(), Submitted::Gone);
    })
    .await;
}

#[tokio::test]
async fn an_upload_whose_sender_is_gone_is_kept_whole() {
    let (_directory, store) = fresh().await;
    let users = Arc::strong_count(&store.turns);
    // The only one who may write.
    let hold = store.engine.alone(&store.pool).await.unwrap();
    let mut insert = Box::pin(store.insert_mesh(square(0.1), source("a"), None, json!({})));
    while Arc::strong_count(&store.turns) == users {
        assert!(futures::poll!(&mut insert).is_pending());
        tokio::task::yield_now().await;
    }
    drop((insert, hold));
    while Arc::strong_count(&store.turns) > users {
        tokio::task::yield_now().await;
    }
    let shapes = store.shapes(ShapeKind::Mesh, &Page { after: None, limit: 100 }).await.unwrap();
    assert_eq!(store.mesh(&shapes[0].id).await.unwrap(), Some(square(0.1)));
}

#[tokio::test(flavor = "multi_thread", worker_threads = 4)]
async fn whoever_deletes_a_shape_while_others_upload_it_leaves_no_row_without_its_blobs() {
    on_every_database(async |_, store| {
        let id = store.insert_mesh(square(0.1), source("a"), None, json!({})).await.unwrap().0.id;
        for _ in 0..5 {
            let uploads = (0..4).map(|_| store.insert_mesh(square(0.1), source("a"), None, json!({})));
            let deletions = (0..2).map(|_| store.delete_shape(ShapeKind::Mesh, &id));
            let (uploads, deletions) = tokio::join!(join_all(uploads), join_all(deletions));
            uploads.into_iter().for_each(|upload| drop(upload.unwrap()));
            for deletion in deletions {
                deletion.unwrap();
            }
            if store.shape(ShapeKind::Mesh, &id).await.unwrap().is_some() {
                assert_eq!(store.mesh(&id).await.unwrap(), Some(square(0.1)));
                assert!(store.file(ShapeKind::Mesh, &id).await.unwrap().is_some());
            }
        }
        // What was written for rows that were not to be is found by the sweep.
        store.sweep(Duration::ZERO).await.unwrap();
        let left = usize::from(store.shape(ShapeKind::Mesh, &id).await.unwrap().is_some());
        assert_eq!((blobs(&store, "shapes").await, blobs(&store, "files").await), (left, left));
    })
    .await;
}

#[tokio::test]
async fn a_shape_that_comes_with_a_job_is_kept_where_the_job_is_taken() {
    on_every_database(async |_, store| {
        let drawn = async || store.unkept(drawing(YAxis::Up), source("a"), json!({})).await.unwrap();
        let id = drawn().await.id().to_owned();
        let job = NewJob { sketch: Some(&id), ..NewJob::of("match", "{}") };
        let full = Places { queue: 0, of_kind: 0 };
        assert_eq!(store.submit_with(drawn().await, &job, full).await.unwrap(), Submitted::Full);
        assert_eq!(store.shape(ShapeKind::Sketch, &id).await.unwrap(), None);
        for folder in ["shapes", "files"] {
            assert_eq!(store.blobs.names(folder).await.unwrap(), Vec::<String>::new());
        }
        let places = Places { queue: 1, of_kind: 1 };
        assert!(matches!(store.submit_with(drawn().await, &job, places).await.unwrap(), Submitted::Taken(_)));
        assert_eq!(store.sketch(&id).await.unwrap(), Some(drawing(YAxis::Up)));
        // What was uploaded before stays where the queue refuses.
        assert_eq!(store.submit_with(drawn().await, &job, full).await.unwrap(), Submitted::Full);
        assert!(store.shape(ShapeKind::Sketch, &id).await.unwrap().is_some());
    })
    .await;
}

#[tokio::test]
async fn memory_is_weighed_by_the_vertices_that_are_computed_on() {
    let whole = star(0.0);
    let mut file = String::new();
    for [x, y, z] in whole.positions() {
        file += &format!("v {x} {y} {z}\n");
    }
    for [a, b, c] in whole.triangles().iter().map(|triangle| triangle.map(|v| v + 1)) {
        file += &format!("f {a} {b} {c}\n");
    }
    let limits = Limits { triangles: whole.triangles().len() / 2, ..Limits::default() };
    let mesh = import(file.as_bytes(), Format::Obj, &limits).unwrap().mesh;
    let left = mesh.sound().positions().len();
    on_every_database(async |_, store| {
        let (shape, _) = store.insert_mesh(mesh.clone(), source("a"), None, json!({})).await.unwrap();
        assert_eq!((shape.vertices, shape.matched), (whole.positions().len(), left));
        assert!(left < shape.vertices * 2 / 3, "{left}");
        let job = NewJob { mesh: Some(&shape.id), bytes_per_vertex: 10, ..NewJob::of("match", "{}") };
        store.submit(&job, Places { queue: 1, of_kind: 1 }).await.unwrap();
        assert_eq!(store.claim(&["match"], ALL).await.unwrap().unwrap().memory, 10 * left as u64);
    })
    .await;
}
