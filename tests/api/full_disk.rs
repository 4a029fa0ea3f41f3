//! A disk that is full: what needs space is refused as long as there is none, and goes on by itself when there is.

use std::fs;
use std::io::{Write, stderr};
use std::path::Path;
use std::process::Command;

use serde_json::json;

use crate::client::client;
use crate::drawings;
use crate::program::{Program, end};
use crate::server::{id, json_of, problem_of};

/// A disk of its own in memory, for as long as it lives.
struct Disk(tempfile::TempDir);

impl Disk {
    /// A disk of this many bytes, where this process may make one; else nothing, and a line that says so.
    fn of(bytes: u64) -> Option<Disk> {
        let folder = tempfile::tempdir().unwrap();
        let options = format!("size={bytes}");
        let made = Command::new("mount").args(["-t", "tmpfs", "-o", &options, "tmpfs"]).arg(folder.path()).output();
        if made.is_ok_and(|made| made.status.success()) {
            return Some(Disk(folder));
        }
        // Not by the macro, whose lines are kept from who runs the tests.
        stderr().write_all(b"a full disk: skipped, for no disk can be mounted here\n").unwrap();
        None
    }

    fn path(&self) -> &Path {
        self.0.path()
    }
}

impl Drop for Disk {
    fn drop(&mut self) {
        // Lazily: a process that is just ending may be on it. Where it fails, the folder cannot be removed, which is told then.
        let _ = Command::new("umount").arg("-l").arg(self.path()).status();
    }
}

/// More than a server wants to be free.
const SIZE: u64 = 160 << 20;

#[tokio::test(flavor = "multi_thread")]
async fn a_full_disk_is_told_of_and_outlived() {
    let Some(disk) = Disk::of(SIZE) else { return };
    let client = client();
    let program = Program::start(&disk.path().join("data"), 1);
    let mesh = async |rings| {
        let upload = client.post(program.url("/v1/meshes?format=obj")).body(drawings::ellipsoid(40, rings));
        upload.send().await.unwrap()
    };
    let sketch = client.post(program.url("/v1/sketches")).json(&drawings::ellipse()).send().await.unwrap();
    let request = json!({"mesh": id(&json_of(mesh(30).await, 201).await), "sketch": id(&json_of(sketch, 201).await)});
    let ready = async || client.get(program.url("/readyz")).send().await.unwrap();
    assert_eq!(ready().await.status(), 200);

    let ballast = disk.path().join("ballast");
    let filled = fs::write(&ballast, vec![1; SIZE as usize]);
    assert!(filled.is_err(), "the disk is full");
    problem_of(ready().await, 507).await;
    problem_of(mesh(31).await, 507).await;
    // What can be answered without space is.
    assert_eq!(client.get(program.url("/v1/meshes")).send().await.unwrap().status(), 200);
    assert_eq!(client.get(program.url("/healthz")).send().await.unwrap().status(), 200);

    fs::remove_file(&ballast).unwrap();
    assert_eq!(ready().await.status(), 200);
    json_of(mesh(31).await, 201).await;
    let path = json_of(client.post(program.url("/v1/matches")).json(&request).send().await.unwrap(), 202).await;
    let ended = end(&program, &client, path["links"]["self"].as_str().unwrap()).await;
    assert_eq!(ended["status"], "succeeded", "{ended}");
}
