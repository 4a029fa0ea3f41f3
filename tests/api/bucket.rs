//! Blobs in a bucket: of a small S3 server within the test, which refuses and breaks off as it is told.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard};
use std::time::Duration;

use axum::Router;
use axum::body::{Body, Bytes};
use axum::extract::{Query, State};
use axum::http::{HeaderMap, Method, StatusCode, Uri, header};
use axum::response::{IntoResponse, Response};
use reqwest::Client;
use serde_json::{Value, json};
use tokio::net::TcpListener;
use tokio::time::timeout;

use crate::client::client;
use crate::drawings;
use crate::program::{Program, end};
use crate::server::{header, id, json_of, problem_of};

/// What is waited for is there long before, also on a busy machine; it only keeps a fault from being waited for for ever.
const LONGEST: Duration = Duration::from_secs(120);

/// How the server behaves.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Mood {
    Well,
    /// Takes nobody's word.
    Refusing,
    /// Breaks off in the middle of what it sends.
    Torn,
}

struct Objects {
    mood: Mood,
    kept: BTreeMap<String, Bytes>,
    /// What was written only if it was not there, and what was written over.
    once: Vec<String>,
    over: Vec<String>,
}

#[derive(Clone)]
struct Bucket(Arc<Mutex<Objects>>);

impl Bucket {
    /// An S3 server with one bucket, and its address.
    async fn open() -> (Bucket, String) {
        let objects = Objects { mood: Mood::Well, kept: BTreeMap::new(), once: Vec::new(), over: Vec::new() };
        let bucket = Bucket(Arc::new(Mutex::new(objects)));
        let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
        let address = format!("http://{}", listener.local_addr().unwrap());
        let routes = Router::new().fallback(answer).with_state(bucket.clone());
        tokio::spawn(async move { axum::serve(listener, routes).await.unwrap() });
        (bucket, address)
    }

    fn objects(&self) -> MutexGuard<'_, Objects> {
        self.0.lock().unwrap()
    }

    fn be(&self, mood: Mood) {
        self.objects().mood = mood;
    }

    /// The names within a folder.
    fn names(&self, folder: &str) -> Vec<String> {
        self.objects().kept.keys().filter(|name| name.starts_with(folder)).cloned().collect()
    }
}

async fn answer(
    State(bucket): State<Bucket>,
    method: Method,
    uri: Uri,
    Query(query): Query<BTreeMap<String, String>>,
    headers: HeaderMap,
    body: Bytes,
) -> Response {
    let mut objects = bucket.objects();
    if objects.mood == Mood::Refusing {
        let told = "<Error><Code>AccessDenied</Code><Message>as told</Message></Error>";
        return (StatusCode::FORBIDDEN, told).into_response();
    }
    let name = uri.path().trim_start_matches("/sketches").trim_start_matches('/').to_owned();
    match method {
        Method::GET if query.contains_key("list-type") => listed(&objects, &query).into_response(),
        Method::GET => match objects.kept.get(&name) {
            None => (StatusCode::NOT_FOUND, "<Error><Code>NoSuchKey</Code></Error>").into_response(),
            Some(whole) => {
                let sent = if objects.mood == Mood::Torn { whole.slice(..whole.len() / 2) } else { whole.clone() };
                Response::builder()
                    .header(header::CONTENT_LENGTH, whole.len())
                    .header(header::ETAG, "\"one\"")
                    .header(header::LAST_MODIFIED, "Thu, 01 Jan 2026 00:00:00 GMT")
                    .body(Body::from_stream(futures::stream::iter([Ok::<_, std::io::Error>(sent)])))
                    .unwrap()
            }
        },
        Method::PUT => {
            if headers.contains_key(header::IF_NONE_MATCH) {
                if objects.kept.contains_key(&name) {
                    let told = "<Error><Code>PreconditionFailed</Code></Error>";
                    return (StatusCode::PRECONDITION_FAILED, told).into_response();
                }
                objects.once.push(name.clone());
            } else {
                objects.over.push(name.clone());
            }
            objects.kept.insert(name, body);
            ([(header::ETAG, "\"one\"")], "").into_response()
        }
        Method::DELETE => {
            objects.kept.remove(&name);
            StatusCode::NO_CONTENT.into_response()
        }
        // Many are deleted together.
        Method::POST => {
            let told = String::from_utf8_lossy(&body);
            let names = told.split("<Key>").skip(1).map(|part| part.split("</Key>").next().unwrap_or_default());
            let deleted = names.map(|name| {
                objects.kept.remove(name);
                format!("<Deleted><Key>{name}</Key></Deleted>")
            });
            format!("<DeleteResult>{}</DeleteResult>", deleted.collect::<String>()).into_response()
        }
        _ => StatusCode::METHOD_NOT_ALLOWED.into_response(),
    }
}

fn listed(objects: &Objects, query: &BTreeMap<String, String>) -> String {
    let prefix = query.get("prefix").map(String::as_str).unwrap_or_default();
    let names = objects.kept.iter().filter(|(name, _)| name.starts_with(prefix));
    let contents = names.map(|(name, bytes)| {
        format!(
            "<Contents><Key>{name}</Key><LastModified>2026-01-01T00:00:00.000Z</LastModified><ETag>\"one\"</ETag><Size>{}</Size></Contents>",
            bytes.len()
        )
    });
    format!("<ListBucketResult><IsTruncated>false</IsTruncated>{}</ListBucketResult>", contents.collect::<String>())
}

/// The program with its blobs in the bucket at this address.
fn serving(data: &std::path::Path, address: &str) -> Program {
    let variables = [
        ("AWS_ENDPOINT_URL", address),
        ("AWS_ALLOW_HTTP", "true"),
        ("AWS_REGION", "us-east-1"),
        ("AWS_ACCESS_KEY_ID", "test"),
        ("AWS_SECRET_ACCESS_KEY", "test"),
    ];
    Program::in_environment(data, &["--workers", "1", "--blob-url", "s3://sketches"], &variables)
}

/// The request for a match of two shapes that are there from now on.
async fn uploaded(program: &Program, client: &Client) -> Value {
    let mesh = client.post(program.url("/v1/meshes?format=obj")).body(drawings::ellipsoid(40, 30));
    let sketch = client.post(program.url("/v1/sketches")).json(&drawings::ellipse());
    let mesh = id(&json_of(mesh.send().await.unwrap(), 201).await);
    json!({"mesh": mesh, "sketch": id(&json_of(sketch.send().await.unwrap(), 201).await)})
}

async fn asked(program: &Program, client: &Client, request: &Value) -> String {
    let answer = client.post(program.url("/v1/matches")).json(request).send().await.unwrap();
    json_of(answer, 202).await["links"]["self"].as_str().unwrap().to_owned()
}

#[tokio::test(flavor = "multi_thread")]
async fn a_bucket_that_refuses_is_waited_for_and_what_it_tears_is_no_answer() {
    let (bucket, address) = Bucket::open().await;
    let (data, client) = (tempfile::tempdir().unwrap(), client());
    let program = serving(data.path(), &address);
    let request = uploaded(&program, &client).await;
    let path = asked(&program, &client, &request).await;
    assert_eq!(end(&program, &client, &path).await["status"], "succeeded");
    let result = async |path: &str| client.get(program.url(&format!("{path}/result"))).send().await.unwrap();
    let whole = json_of(result(&path).await, 200).await;
    {
        // A result is written where there is none, whoever else writes.
        let objects = bucket.objects();
        assert!(objects.once.iter().any(|name| name.starts_with("results/")), "{:?}", objects.once);
        assert!(!objects.over.iter().any(|name| name.starts_with("results/")), "{:?}", objects.over);
    }

    bucket.be(Mood::Torn);
    problem_of(result(&path).await, 503).await;
    bucket.be(Mood::Well);
    assert_eq!(json_of(result(&path).await, 200).await, whole);

    bucket.be(Mood::Refusing);
    let ready = problem_of(client.get(program.url("/readyz")).send().await.unwrap(), 503).await;
    assert!(ready["detail"].as_str().unwrap().contains("the place of the blobs"), "{ready}");
    let refused = client.post(program.url("/v1/meshes?format=obj")).body(drawings::ellipsoid(12, 8));
    let refused = refused.send().await.unwrap();
    assert_ne!(header(&refused, "retry-after"), "");
    problem_of(refused, 503).await;
    let waits = asked(&program, &client, &request).await;
    // Until it was tried, in vain.
    let measures = async || client.get(program.url("/metrics")).send().await.unwrap().text().await.unwrap();
    let never = "sketchmatch_jobs_total{kind=\"match\",outcome=\"postponed\"} 0";
    timeout(LONGEST, async { while measures().await.contains(never) {} }).await.expect("a job that is tried");
    bucket.be(Mood::Well);
    // A check that takes longer than its time on a busy machine says no.
    let status = async || client.get(program.url("/readyz")).send().await.unwrap().status();
    timeout(LONGEST, async { while status().await != 200 {} }).await.expect("a server that is ready again");
    let ended = end(&program, &client, &waits).await;
    assert_eq!(ended["status"], "succeeded", "{ended}");
    let again = json_of(result(&waits).await, 200).await;
    assert_eq!(again["correspondences"], whole["correspondences"]);
    assert_eq!(bucket.names("results/").len(), 2);
}

#[tokio::test(flavor = "multi_thread")]
async fn what_is_damaged_in_a_bucket_is_made_anew_or_said_to_be_lost() {
    let (bucket, address) = Bucket::open().await;
    let (data, client) = (tempfile::tempdir().unwrap(), client());
    let program = serving(data.path(), &address);
    let request = uploaded(&program, &client).await;
    let mut answers = Vec::new();
    for _ in 0..2 {
        let path = asked(&program, &client, &request).await;
        assert_eq!(end(&program, &client, &path).await["status"], "succeeded");
        let result = client.get(program.url(&format!("{path}/result"))).send().await.unwrap();
        answers.push(json_of(result, 200).await["correspondences"].clone());
        // Spectra, preparations and results lose their second half.
        for (name, bytes) in &mut bucket.objects().kept {
            if ["spectra/", "preparations/", "results/"].iter().any(|folder| name.starts_with(folder)) {
                *bytes = bytes.slice(..bytes.len() / 2);
            }
        }
        let lost = client.get(program.url(&format!("{path}/result"))).send().await.unwrap();
        assert!(problem_of(lost, 500).await["detail"].as_str().unwrap().contains("is lost"));
    }
    assert_eq!(answers[0], answers[1]);
}
