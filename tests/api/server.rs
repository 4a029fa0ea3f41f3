//! A server on a free port over a data directory of its own.

use std::path::Path;
use std::time::SystemTime;

use metrics_exporter_prometheus::PrometheusBuilder;
use reqwest::header::{AUTHORIZATION, HeaderValue};
use reqwest::{Client, RequestBuilder, Response};
use serde_json::{Value, json};
use sketchmatch::access::{Key, Scopes};
use sketchmatch::http::admission::Admission;
use sketchmatch::http::{self, App};
use sketchmatch::store::{self, Room, Store};
use sketchmatch::worker;
use tempfile::TempDir;
use tokio::net::{TcpListener, TcpStream};
use tokio_util::sync::{CancellationToken, DropGuard};

use crate::client::client;
use crate::drawings;

/// A running server; it stops when dropped.
pub struct Server {
    client: Client,
    address: String,
    store: Store,
    _stop: DropGuard,
    data: TempDir,
}

impl Server {
    /// A server with one worker.
    pub async fn working() -> Server {
        Server::start(http::Config::default(), true).await
    }

    /// The same with other limits.
    pub async fn working_within(config: http::Config) -> Server {
        Server::start(config, true).await
    }

    /// A server that queues and never works.
    pub async fn idle(config: http::Config) -> Server {
        Server::start(config, false).await
    }

    /// A server with one worker that lets in who has a key in its database.
    pub async fn for_keyholders() -> Server {
        let config = http::Config { admission: Admission::Keyholders(None), ..http::Config::default() };
        Server::start(config, true).await
    }

    async fn start(config: http::Config, works: bool) -> Server {
        let data = tempfile::tempdir().unwrap();
        let store = Store::open(&store::Config::local(data.path())).await.unwrap();
        let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
        let address = format!("http://{}", listener.local_addr().unwrap());
        let shutdown = CancellationToken::new();
        if works {
            let config = worker::Config { workers: 1, ..worker::Config::default() };
            tokio::spawn(worker::run(store.clone(), config, shutdown.clone()));
        }
        let measures = PrometheusBuilder::new().build_recorder().handle();
        let app = App::new(store.clone(), config, measures, shutdown.clone());
        tokio::spawn(http::serve(listener, app));
        Server { client: client(), address, store, _stop: shutdown.drop_guard(), data }
    }

    /// Lets every request that names no key come with this one.
    pub fn send(&mut self, key: &str) {
        let header = (AUTHORIZATION, HeaderValue::try_from(format!("Bearer {key}")).unwrap());
        self.client = Client::builder().default_headers([header].into_iter().collect()).build().unwrap();
    }

    /// A request with this key or none.
    pub fn request_with(&self, key: Option<&str>, method: &str, path: &str) -> RequestBuilder {
        let request = client().request(method.parse().unwrap(), format!("{}{path}", self.address));
        match key {
            Some(key) => request.bearer_auth(key),
            None => request,
        }
    }

    /// A new key in its database, and the id of the key.
    pub async fn key(&self, tenant: &str, scopes: &str, expires: Option<SystemTime>) -> (String, String) {
        let (key, tenant, scopes) =
            (Key::random().unwrap(), tenant.parse().unwrap(), scopes.parse::<Scopes>().unwrap());
        let id = self.store.keys().add(&key, (&tenant, &scopes), None, expires).await.unwrap();
        (key.reveal().to_owned(), id)
    }

    /// Lets a key open nothing any more.
    pub async fn revoke(&self, id: &str) {
        assert!(self.store.keys().revoke(id).await.unwrap());
    }

    /// Takes up the match whose turn it is, as a worker does, and leaves it at that.
    pub async fn take_up_a_match(&self) {
        let room = Room { memory: u64::MAX, alone: true };
        self.store.claim(&["match"], room).await.unwrap().expect("a match waits");
    }

    /// Cancels a job of this tenant, by no request.
    pub async fn cancel_for(&self, tenant: &str, id: &str) {
        self.store.of(&tenant.parse().unwrap()).cancel(id).await.unwrap().expect("the job is there");
    }

    /// Where it answers.
    pub fn address(&self) -> &str {
        &self.address
    }

    /// Where it keeps everything.
    pub fn data(&self) -> &Path {
        self.data.path()
    }

    /// A bare connection to the server.
    pub async fn connect(&self) -> TcpStream {
        TcpStream::connect(self.address.trim_start_matches("http://")).await.unwrap()
    }

    pub fn request(&self, method: &str, path: &str) -> RequestBuilder {
        self.client.request(method.parse().unwrap(), format!("{}{path}", self.address))
    }

    pub fn get(&self, path: &str) -> RequestBuilder {
        self.request("GET", path)
    }

    pub fn post(&self, path: &str) -> RequestBuilder {
        self.request("POST", path)
    }

    /// The answer to a GET as JSON; it has to be 200.
    pub async fn read(&self, path: &str) -> Value {
        json_of(self.get(path).send().await.unwrap(), 200).await
    }

    /// The id of the ellipsoid, uploaded.
    pub async fn mesh(&self) -> String {
        let upload = self.post("/v1/meshes?format=obj").body(drawings::ellipsoid(16, 12)).send().await.unwrap();
        id(&upload.json().await.unwrap())
    }

    /// The id of the ellipse, uploaded.
    pub async fn sketch(&self) -> String {
        let upload = self.post("/v1/sketches").json(&drawings::ellipse()).send().await.unwrap();
        id(&upload.json().await.unwrap())
    }

    /// A match of the ellipse and the ellipsoid with whatever `besides` asks.
    pub async fn request_match(&self, besides: Value) -> RequestBuilder {
        let (mesh, sketch) = (self.mesh().await, self.sketch().await);
        let mut request = json!({"mesh": mesh, "sketch": sketch});
        request.as_object_mut().unwrap().extend(besides.as_object().unwrap().clone());
        self.post("/v1/matches").json(&request)
    }

    /// The path of a match without an alignment that has succeeded: it takes a moment.
    pub async fn intrinsic_match(&self, besides: Value) -> String {
        let mut request = json!({"preset": "thesis", "basis": {"k": 12}, "regions": {"method": "auto", "count": 4}});
        request.as_object_mut().unwrap().extend(besides.as_object().unwrap().clone());
        let request = self.request_match(request).await.header("prefer", "wait=60");
        let body = json_of(request.send().await.unwrap(), 200).await;
        assert_eq!(body["status"], "succeeded", "{body}");
        body["links"]["self"].as_str().unwrap().to_owned()
    }

    /// The path of a match that has succeeded.
    pub async fn finished_match(&self) -> String {
        let request = self.request_match(json!({})).await.header("prefer", "wait=60");
        let body = json_of(request.send().await.unwrap(), 200).await;
        assert_eq!(body["status"], "succeeded", "{body}");
        body["links"]["self"].as_str().unwrap().to_owned()
    }
}

/// The body of an answer that has to have this status.
pub async fn json_of(response: Response, status: u16) -> Value {
    let found = response.status();
    let text = response.text().await.unwrap();
    assert_eq!(found, status, "{text}");
    serde_json::from_str(&text).unwrap()
}

/// The problem an answer has to be.
pub async fn problem_of(response: Response, status: u16) -> Value {
    assert_eq!(response.headers()["content-type"], "application/problem+json");
    let problem = json_of(response, status).await;
    assert_eq!(problem["status"], status);
    assert!(problem["type"].is_string() && problem["title"].is_string() && problem["detail"].is_string(), "{problem}");
    problem
}

pub fn header<'a>(response: &'a Response, name: &str) -> &'a str {
    response.headers().get(name).map(|value| value.to_str().unwrap()).unwrap_or_default()
}

pub fn id(document: &Value) -> String {
    document["id"].as_str().unwrap_or_else(|| panic!("{document}")).to_owned()
}
