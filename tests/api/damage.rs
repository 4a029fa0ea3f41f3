//! Files of the data directory that a failing disk has changed: no answer is made of them.

use std::fs;
use std::path::{Path, PathBuf};

use serde_json::{Value, json};
use sketchmatch::http::Config;

use crate::drawings;
use crate::server::{Server, header, json_of, problem_of};

/// What becomes of a file.
const DAMAGES: [fn(&mut Vec<u8>); 3] = [
    |bytes| bytes.clear(),
    |bytes| bytes.truncate(bytes.len() / 2),
    |bytes| {
        let middle = bytes.len() / 2;
        bytes[middle..].iter_mut().take(4096).for_each(|byte| *byte = 0);
    },
];

/// Every file under a folder of blobs.
fn files(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    entries.flat_map(|path| if path.is_dir() { files(&path) } else { vec![path] }).collect()
}

/// Damages every file of a folder of blobs; there has to be one.
fn damage(server: &Server, folder: &str, how: fn(&mut Vec<u8>)) {
    let files = files(&server.data().join("blobs").join(folder));
    assert!(!files.is_empty(), "{folder}");
    for file in files {
        let mut bytes = fs::read(&file).unwrap();
        how(&mut bytes);
        fs::write(&file, bytes).unwrap();
    }
}

/// What a match answers, its name and times aside.
async fn answer(server: &Server) -> Value {
    let path = server.finished_match().await;
    let mut result = server.read(&format!("{path}/result")).await;
    result.as_object_mut().unwrap().retain(|field, _| field != "match" && field != "timings_ms");
    result
}

#[tokio::test(flavor = "multi_thread")]
async fn damaged_caches_change_no_answer() {
    let server = Server::working().await;
    let whole = answer(&server).await;
    for how in DAMAGES {
        damage(&server, "spectra", how);
        damage(&server, "preparations", how);
        assert_eq!(answer(&server).await, whole);
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn a_damaged_result_is_lost_and_said_to_be() {
    let server = Server::working().await;
    let path = server.finished_match().await;
    for how in DAMAGES {
        damage(&server, "results", how);
        for form in ["result", "picture", "mesh.glb"] {
            let answer = server.get(&format!("{path}/{form}")).send().await.unwrap();
            assert_eq!(header(&answer, "cache-control"), "", "{form}");
            let problem = problem_of(answer, 500).await;
            assert!(problem["detail"].as_str().unwrap().contains("is lost"), "{problem}");
        }
    }
    assert_eq!(server.request("DELETE", &path).send().await.unwrap().status(), 204);
}

#[tokio::test(flavor = "multi_thread")]
async fn a_damaged_shape_is_mended_by_its_upload() {
    let server = Server::working().await;
    let (mesh, sketch) = (server.mesh().await, server.sketch().await);
    let geometry = format!("/v1/meshes/{mesh}/mesh");
    let whole = server.read(&geometry).await;
    for how in DAMAGES {
        damage(&server, "shapes", how);
        let problem = problem_of(server.get(&geometry).send().await.unwrap(), 500).await;
        let detail = problem["detail"].as_str().unwrap();
        assert!(detail.contains(&mesh) && detail.contains("upload the same file again"), "{problem}");
        let asked = server.post("/v1/matches").json(&json!({"mesh": mesh, "sketch": sketch}));
        let failed = json_of(asked.header("prefer", "wait=60").send().await.unwrap(), 200).await;
        assert_eq!(failed["status"], "failed");
        assert!(failed["error"]["detail"].as_str().unwrap().contains("upload the same file again"), "{failed}");
        let again = server.post("/v1/meshes?format=obj").body(drawings::ellipsoid(16, 12)).send().await.unwrap();
        assert_eq!(json_of(again, 200).await["id"], json!(mesh));
        assert_eq!(server.sketch().await, sketch);
        assert_eq!(server.read(&geometry).await, whole);
    }
    server.finished_match().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_shape_is_told_of_while_it_is_damaged() {
    let server = Server::idle(Config::default()).await;
    let path = format!("/v1/meshes/{}", server.mesh().await);
    let told = server.read(&path).await;
    damage(&server, "shapes", DAMAGES[0]);
    assert_eq!(server.read(&path).await, told);
}
