//! The built server, as its clients see it.

use std::net::TcpListener;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};
use std::{env, thread};

use reqwest::Client;
use serde_json::{Value, json};

use crate::shapes;
use crate::table::{Sample, Table};

/// Who polls, and how often each asks.
const CLIENTS: usize = 50;
const QUESTIONS: usize = 40;
/// Between two questions of a client.
const PAUSE: Duration = Duration::from_millis(100);
const RUNS: usize = 5;

/// A server on a free port over an empty directory; it ends when dropped.
struct Server {
    process: Child,
    address: String,
    client: Client,
    _data: tempfile::TempDir,
}

impl Drop for Server {
    fn drop(&mut self) {
        // It may have ended by itself.
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

impl Server {
    async fn start() -> Server {
        let free = TcpListener::bind("127.0.0.1:0").and_then(|listener| listener.local_addr()).expect("a free port");
        let data = tempfile::tempdir().expect("a directory can be made");
        let mut command = Command::new(env!("CARGO_BIN_EXE_sketchmatch"));
        command.args(["--log", "error", "serve", "--listen", &free.to_string(), "--data-dir"]).arg(data.path());
        let process = command.stdout(Stdio::null()).spawn().expect("the server starts");
        let server = Server { process, address: format!("http://{free}"), client: Client::new(), _data: data };
        for _ in 0..100 {
            if server.client.get(format!("{}/v1/meshes", server.address)).send().await.is_ok() {
                return server;
            }
            tokio::time::sleep(Duration::from_millis(50)).await;
        }
        panic!("the server does not answer");
    }

    async fn post(&self, path: &str, body: impl Into<reqwest::Body>, wait: bool) -> Value {
        let request = self.client.post(format!("{}{path}", self.address)).header("content-type", "application/json");
        let request = if wait { request.header("prefer", "wait=60") } else { request };
        let answer = request.body(body).send().await.expect("the server answers");
        let (status, text) = (answer.status(), answer.text().await.unwrap_or_default());
        assert!(status.is_success(), "{path}: {status} {text}");
        serde_json::from_str(&text).expect("an answer is JSON")
    }

    async fn get(&self, path: &str) {
        let answer = self.client.get(format!("{}{path}", self.address)).send().await.expect("the server answers");
        assert!(answer.status().is_success());
        answer.bytes().await.expect("an answer ends");
    }
}

/// Rows over HTTP; warm matches are counted for `seconds`.
pub fn rows(table: &Table, seconds: f64) {
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().expect("a runtime");
    runtime.block_on(measured(table, seconds));
}

async fn measured(table: &Table, seconds: f64) {
    let server = Server::start().await;
    let upload = shapes::obj(&shapes::body(shapes::LARGE));
    let mesh = server.post("/v1/meshes?format=obj", upload, false).await["id"].clone();
    // Sketches of other sizes are other sketches: each is new once.
    let sketch = shapes::drawn();
    let outline = |vertices: usize| {
        let mut request: Value = serde_json::from_str(&shapes::drawing()).expect("a drawing is JSON");
        request["target_vertices"] = json!(vertices);
        request.to_string()
    };
    let target = sketch.mesh().positions().len();
    let mut walls = Vec::new();
    let mut request = String::new();
    for run in 0..=RUNS {
        let sketch = server.post("/v1/sketches", outline(target + 2 * run), false).await["id"].clone();
        request = json!({"mesh": mesh, "sketch": sketch, "preset": "thesis"}).to_string();
        let begun = Instant::now();
        let answer = server.post("/v1/matches", request.clone(), true).await;
        let path = answer["links"]["result"].as_str().expect("a match has a result").to_owned();
        server.get(&path).await;
        walls.push(begun.elapsed().as_secs_f64() * 1e3);
    }
    // The first has also computed the spectrum of the mesh.
    let walls = Sample::new(walls.split_off(1));
    table.figure("server: POST to result, thesis, 50K, sketch new (wall)", walls.median(), "ms", Some(150.0));

    let cores = thread::available_parallelism().map_or(1, usize::from);
    let (begun, mut done) = (Instant::now(), 0);
    while begun.elapsed().as_secs_f64() < seconds {
        futures::future::join_all((0..2 * cores).map(|_| server.post("/v1/matches", request.clone(), true))).await;
        done += 2 * cores;
    }
    let rate = done as f64 / begun.elapsed().as_secs_f64() / cores as f64;
    table.figure("server: warm matches, thesis, 50K (a second and core)", rate, "", None);

    polled(table, &server, &request).await;
}

/// What 50 clients wait for the status of a match while the pool is saturated.
async fn polled(table: &Table, server: &Server, request: &str) {
    let mut path = String::new();
    for _ in 0..400 {
        let queued = server.post("/v1/matches", request.to_owned(), false).await;
        path = queued["links"]["self"].as_str().expect("a match has a place").to_owned();
    }
    let one = async |client: usize| {
        tokio::time::sleep(PAUSE.mul_f64(client as f64 / CLIENTS as f64)).await;
        let mut waits = Vec::new();
        for _ in 0..QUESTIONS {
            let begun = Instant::now();
            server.get(&path).await;
            waits.push(begun.elapsed().as_secs_f64() * 1e3);
            tokio::time::sleep(PAUSE).await;
        }
        waits
    };
    let waits = futures::future::join_all((0..CLIENTS).map(one)).await.concat();
    let waits = Sample::new(waits);
    table.figure("server: GET status, pool saturated, 50 clients, p50 (wall)", waits.median(), "ms", None);
    table.figure("server: GET status, pool saturated, 50 clients, p99 (wall)", waits.quantile(0.99), "ms", Some(5.0));
}
