//! The program itself: killed in the middle of its work, stopped in peace, started where it should not.

use std::fs;
use std::os::unix::fs::MetadataExt;
use std::process::Command;

use reqwest::Client;
use rustix::process::{Pid, Signal, kill_process};
use serde_json::json;

use crate::client::client;
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
    let client = client();
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
    assert!(measures.contains("sketchmatch_http_requests_total"), "{measures}");
}

#[tokio::test(flavor = "multi_thread")]
async fn a_server_whose_terminal_is_gone_goes_on() {
    let data = tempfile::tempdir().unwrap();
    let client = client();
    let mut program = Program::start(data.path(), 1);
    let pid = Pid::from_child(&program.child);
    kill_process(pid, Signal::HUP).unwrap();
    let path = queued(&program, &client, 1).await.remove(0);
    assert_eq!(end(&program, &client, &path).await["status"], "succeeded");
    kill_process(pid, Signal::TERM).unwrap();
    assert!(program.child.wait().unwrap().success());
}

#[tokio::test(flavor = "multi_thread")]
async fn a_terminated_server_ends_in_peace_and_loses_nothing() {
    let data = tempfile::tempdir().unwrap();
    let client = client();
    let mut program = Program::start(data.path(), 2);
    let paths = queued(&program, &client, 6).await;
    let pid = Pid::from_child(&program.child);
    kill_process(pid, Signal::TERM).unwrap();
    assert!(program.child.wait().unwrap().success());
    drop(program);
    // The database and the blobs alone are whole.
    for besides in ["sketchmatch.db-wal", "sketchmatch.db-shm", "lock"] {
        fs::remove_file(data.path().join(besides)).unwrap_or_default();
    }

    let program = Program::start(data.path(), 2);
    for path in &paths {
        assert_eq!(end(&program, &client, path).await["status"], "succeeded");
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn what_is_kept_is_readable_by_the_server_alone() {
    let data = tempfile::tempdir().unwrap();
    let client = client();
    let program = Program::start(&data.path().join("made"), 1);
    let paths = queued(&program, &client, 1).await;
    end(&program, &client, &paths[0]).await;
    let mut folders = vec![data.path().join("made")];
    let mut files = 0;
    while let Some(folder) = folders.pop() {
        assert_eq!(fs::metadata(&folder).unwrap().mode() & 0o777, 0o700, "{}", folder.display());
        for entry in fs::read_dir(folder).unwrap() {
            let entry = entry.unwrap();
            if entry.file_type().unwrap().is_dir() {
                folders.push(entry.path());
            } else {
                assert_eq!(entry.metadata().unwrap().mode() & 0o777, 0o600, "{}", entry.path().display());
                files += 1;
            }
        }
    }
    assert!(files > 6, "{files}");
    let measures = client.get(program.url("/metrics")).send().await.unwrap().text().await.unwrap();
    for line in [
        "sketchmatch_jobs_total{kind=\"match\",outcome=\"succeeded\"} 1",
        "sketchmatch_jobs_total{kind=\"match\",outcome=\"failed\"} 0",
        "sketchmatch_jobs_queued{kind=\"spectrum\"} 0",
        "# HELP sketchmatch_disk_free_bytes Bytes that are free on the disk of the data directory; not a number where nothing is kept on one.",
        concat!("sketchmatch_build_info{version=\"", env!("CARGO_PKG_VERSION"), "\"} 1"),
    ] {
        assert!(measures.lines().any(|found| found == line), "{line}: {measures}");
    }
    let samples = measures.lines().filter(|line| !line.starts_with('#') && !line.is_empty());
    assert!(samples.clone().all(|line| line.starts_with("sketchmatch_")), "{measures}");
    assert!(samples.clone().any(|line| line.starts_with("sketchmatch_process_open_fds ")), "{measures}");
}

#[test]
fn a_second_server_is_refused_the_data_directory() {
    let data = tempfile::tempdir().unwrap();
    let _program = Program::start(data.path(), 2);
    fs::remove_file(data.path().join("lock")).unwrap();
    let second = Command::new(env!("CARGO_BIN_EXE_sketchmatch"))
        .args(["serve", "--listen", "127.0.0.1:0", "--data-dir"])
        .arg(data.path())
        .output()
        .unwrap();
    assert!(!second.status.success());
    assert!(String::from_utf8_lossy(&second.stderr).contains("in use by another process"));
}
