//! Many nodes on one database: what one is asked for another computes and a third answers, and those that die are not missed.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};

use reqwest::Client;
use rustix::process::{Pid, Signal, kill_process};
use serde_json::{Value, json};
use tempfile::TempDir;

use crate::client::client;
use crate::drawings;
use crate::program::{Program, end};
use crate::schema::Schema;
use crate::server::{id, json_of};

/// What all nodes have in common; each has a data directory of its own, with nothing in it.
struct Shared {
    schema: Schema,
    directory: TempDir,
}

impl Shared {
    async fn fresh() -> Option<Shared> {
        Some(Shared { schema: Schema::fresh().await?, directory: tempfile::tempdir().unwrap() })
    }

    fn blobs(&self) -> PathBuf {
        self.directory.path().join("blobs")
    }

    fn options(&self) -> [String; 4] {
        let blobs = format!("file://{}", self.blobs().display());
        ["--database-url".to_owned(), self.schema.url(), "--blob-url".to_owned(), blobs]
    }

    /// A node that computes nothing.
    fn serve(&self, name: &str) -> Program {
        let options = self.options();
        let options = ["--workers", "0"].into_iter().chain(options.iter().map(String::as_str));
        Program::with(&self.directory.path().join(name), &options.collect::<Vec<_>>())
    }

    fn work(&self) -> Worker {
        let mut command = Command::new(env!("CARGO_BIN_EXE_sketchmatch"));
        let command = command.args(["work", "--workers", "1", "--data-dir"]).arg(self.directory.path().join("none"));
        Worker(command.args(self.options()).stderr(Stdio::null()).spawn().unwrap())
    }
}

/// A node that only computes; killed when it is dropped.
struct Worker(Child);

impl Drop for Worker {
    fn drop(&mut self) {
        // Both fail where it has ended, which is what is wanted.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

async fn uploaded(client: &Client, server: &Program) -> Value {
    let mesh = client.post(server.url("/v1/meshes?format=obj")).body(drawings::ellipsoid(40, 30));
    let sketch = client.post(server.url("/v1/sketches")).json(&drawings::ellipse());
    let mesh = id(&json_of(mesh.send().await.unwrap(), 201).await);
    json!({"mesh": mesh, "sketch": id(&json_of(sketch.send().await.unwrap(), 201).await)})
}

fn files(folder: &Path) -> usize {
    let entries = fs::read_dir(folder).map(|entries| entries.map(|entry| entry.unwrap().path()).collect::<Vec<_>>());
    entries.unwrap_or_default().iter().map(|path| if path.is_dir() { files(path) } else { 1 }).sum()
}

#[tokio::test(flavor = "multi_thread")]
async fn what_is_asked_of_one_node_another_computes_and_a_third_answers() {
    let Some(shared) = Shared::fresh().await else { return };
    let (one, two, client) = (shared.serve("one"), shared.serve("two"), client());
    let request = uploaded(&client, &one).await;
    let mut workers: Vec<Worker> = (0..2).map(|_| shared.work()).collect();
    let mut paths = Vec::new();
    for server in [&one, &two].into_iter().cycle().take(12) {
        let answer = client.post(server.url("/v1/matches")).json(&request).send().await.unwrap();
        paths.push(json_of(answer, 202).await["links"]["self"].as_str().unwrap().to_owned());
    }
    workers[0].0.kill().unwrap();
    workers.push(shared.work());
    let mut answers = Vec::new();
    for path in &paths {
        // Events come from the node that has not computed it.
        assert_eq!(end(&two, &client, path).await["status"], "succeeded");
        let result = client.get(one.url(&format!("{path}/result"))).send().await.unwrap();
        answers.push(json_of(result, 200).await["correspondences"].clone());
        assert_eq!(files(&shared.blobs().join("results").join(path.rsplit('/').next().unwrap())), 1, "{path}");
    }
    assert!(answers.windows(2).all(|pair| pair[0] == pair[1]), "the same question has the same answer on every node");
    // Both shapes at one length, and one preparation.
    let caches = shared.blobs();
    assert_eq!((files(&caches.join("spectra")), files(&caches.join("preparations"))), (2, 1));
    let sweep = Command::new(env!("CARGO_BIN_EXE_sketchmatch")).arg("sweep").args(shared.options()).output().unwrap();
    assert!(sweep.status.success(), "{}", String::from_utf8_lossy(&sweep.stderr));
    assert_eq!(String::from_utf8_lossy(&sweep.stdout), "0 blobs that nothing names were set aside\n");
}

#[tokio::test(flavor = "multi_thread")]
async fn a_node_that_is_told_to_stop_gives_its_jobs_back() {
    let Some(shared) = Shared::fresh().await else { return };
    let client = client();
    let idle = shared.serve("idle");
    let request = uploaded(&client, &idle).await;
    let mut worker = shared.work();
    let answer = client.post(idle.url("/v1/matches")).json(&request).send().await.unwrap();
    let path = json_of(answer, 202).await["links"]["self"].as_str().unwrap().to_owned();
    let mut events = client.get(idle.url(&format!("{path}/events"))).send().await.unwrap();
    let mut told = String::new();
    while !told.contains("running") {
        told.push_str(&String::from_utf8_lossy(&events.chunk().await.unwrap().unwrap()));
    }
    kill_process(Pid::from_child(&worker.0), Signal::TERM).unwrap();
    assert!(worker.0.wait().unwrap().success());
    let _another = shared.work();
    assert_eq!(end(&idle, &client, &path).await["status"], "succeeded");
}
