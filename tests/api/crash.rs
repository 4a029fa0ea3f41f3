//! The program itself: killed in the middle of its work, stopped in peace, started where it should not.

use std::fs;
use std::process::Command;

use reqwest::Client;
use rustix::process::{Pid, Signal, kill_process};
use serde_json::json;

use crate::drawings;
use crate::program::{Program, end};
use crate::server::{id, json_of};

/// The paths of `count` matches queued at the program.
async fn queued(program: &Program, client: &Client, count: usize) -> Vec<String> {
    let mesh =
        client.post(program.url("/v1/meshes?format=obj")).body(drawings::ellipsoid(40, 30)).send().await.unwrap();
    let sketch = client.post(program.url("/v1/sketches")).json(&drawings::ellipse()).send().await.unwrap();
    let request = json!({"mesh": id(&json_of(mesh, 201).await), "sketch": id(&json_of(sketch, 201).await)});
    let mut paths = Vec::new();
    for _ in 0..count {
        let answer = client.post(program.url("/v1/matches")).json(&request).send().await.unwrap();
        paths.push(json_of(answer, 202).await["links"]["self"].as_str().unwrap().to_owned());
    }
    paths
}

#[tokio::test(flavor = "multi_thread")]
async fn every_match_of_a_killed_server_ends_with_one_result() {
    let data = tempfile::tempdir().unwrap();
    let client = Client::new();
    let mut program = Program::start(data.path(), 2);
    let paths = queued(&program, &client, 12).await;
    assert_eq!(end(&program, &client, &paths[0]).await["status"], "succeeded");
    program.child.kill().unwrap();
    program.child.wait().unwrap();
    drop(program);

    let program = Program::start(data.path(), 2);
    for path in &paths {
        let document = end(&program, &client, path).await;
        assert_eq!(document["status"], "succeeded", "{document}");
        json_of(client.get(program.url(&format!("{path}/result"))).send().await.unwrap(), 200).await;
        let blobs = data.path().join("blobs/results").join(id(&document));
        assert_eq!(fs::read_dir(blobs).unwrap().count(), 1, "{path}");
    }
    let measures = client.get(program.url("/metrics")).send().await.unwrap().text().await.unwrap();
    assert!(measures.contains("http_requests_total"), "{measures}");
}

#[tokio::test(flavor = "multi_thread")]
async fn a_terminated_server_ends_in_peace_and_loses_nothing() {
    let data = tempfile::tempdir().unwrap();
    let client = Client::new();
    let mut program = Program::start(data.path(), 2);
    let paths = queued(&program, &client, 6).await;
    let pid = Pid::from_child(&program.child);
    kill_process(pid, Signal::TERM).unwrap();
    assert!(program.child.wait().unwrap().success());
    drop(program);

    let program = Program::start(data.path(), 2);
    for path in &paths {
        assert_eq!(end(&program, &client, path).await["status"], "succeeded");
    }
}

#[test]
fn a_second_server_is_refused_the_data_directory() {
    let data = tempfile::tempdir().unwrap();
    let _program = Program::start(data.path(), 2);
    let second = Command::new(env!("CARGO_BIN_EXE_sketchmatch"))
        .args(["serve", "--listen", "127.0.0.1:0", "--data-dir"])
        .arg(data.path())
        .output()
        .unwrap();
    assert!(!second.status.success());
    assert!(String::from_utf8_lossy(&second.stderr).contains("in use by another process"));
}
