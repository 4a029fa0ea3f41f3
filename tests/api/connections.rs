//! Clients that are slow, silent, gone or rude, on bare sockets.

use std::time::Duration;

use futures::future::join_all;
use serde_json::{Value, json};
use sketchmatch::http::Config;
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;

use crate::drawings::ellipsoid;
use crate::server::{Server, header, json_of, problem_of};

/// Short enough to wait for, long enough for a busy machine to answer in.
const SOON: Duration = Duration::from_millis(500);

/// What the server says on a connection until it closes it.
async fn said(connection: &mut TcpStream) -> String {
    let mut answer = Vec::new();
    // A reset ends an answer too; what has come by then counts.
    let _ = connection.read_to_end(&mut answer).await;
    String::from_utf8_lossy(&answer).into_owned()
}

/// The status of the first answer in `said`, and its body where that is JSON.
fn read(said: &str) -> (&str, Value) {
    let (head, body) = said.split_once("\r\n\r\n").unwrap_or((said, ""));
    (head.split(' ').nth(1).unwrap_or_default(), serde_json::from_str(body).unwrap_or_default())
}

/// The answer to the bytes of one request.
async fn answered(server: &Server, request: impl AsRef<[u8]>) -> String {
    let mut connection = server.connect().await;
    connection.write_all(request.as_ref()).await.unwrap();
    said(&mut connection).await
}

#[tokio::test(flavor = "multi_thread")]
async fn uploads_that_stand_still_block_nobody() {
    let server = Server::idle(Config::default()).await;
    let mut slow = Vec::new();
    for announced in
        ["transfer-encoding: chunked\r\n\r\n8\r\nv 0 0 0\n\r\n", "content-length: 134217728\r\n\r\nv 0 0 0\n"]
    {
        for _ in 0..4 {
            let mut connection = server.connect().await;
            let request = format!("POST /v1/meshes?format=obj HTTP/1.1\r\nhost: localhost\r\n{announced}");
            connection.write_all(request.as_bytes()).await.unwrap();
            slow.push(connection);
        }
    }
    let upload = || async {
        let mesh = ellipsoid(60, 40).into_bytes();
        let pieces = mesh.chunks(4096).map(|piece| Ok::<_, std::io::Error>(piece.to_vec())).collect::<Vec<_>>();
        let body = reqwest::Body::wrap_stream(futures::stream::iter(pieces));
        server.post("/v1/meshes?format=obj").body(body).send().await.unwrap().status().as_u16()
    };
    let statuses = join_all((0..12).map(|_| upload())).await;
    assert!(statuses.iter().all(|status| [200, 201].contains(status)), "{statuses:?}");
    problem_of(server.post("/v1/matches").json(&json!({})).send().await.unwrap(), 422).await;
    drop(slow);
}

#[tokio::test(flavor = "multi_thread")]
async fn who_is_silent_is_not_waited_for() {
    let server = Server::idle(Config { idle_timeout: SOON, ..Config::default() }).await;
    assert_eq!(answered(&server, "").await, "");
    assert_eq!(answered(&server, "GET /healthz HTTP/1.1\r\nhost: loc").await, "");
    let body = "POST /v1/meshes HTTP/1.1\r\nhost: localhost\r\ncontent-length: 9\r\n\r\nv 0";
    let answer = answered(&server, body).await;
    let (status, problem) = read(&answer);
    assert_eq!((status, &problem["status"]), ("408", &json!(408)), "{answer}");
}

#[tokio::test(flavor = "multi_thread")]
async fn a_request_ends_at_its_deadline() {
    let config = Config { request_deadline: SOON, idle_timeout: 100 * SOON, ..Config::default() };
    let server = Server::idle(config).await;
    let body = "POST /v1/meshes HTTP/1.1\r\nhost: localhost\r\ncontent-length: 9\r\n\r\nv 0";
    let answer = answered(&server, body).await;
    let (status, problem) = read(&answer);
    assert_eq!((status, &problem["status"]), ("503", &json!(503)), "{answer}");
}

#[tokio::test(flavor = "multi_thread")]
async fn connections_without_a_request_make_room() {
    let server = Server::idle(Config { max_connections: 2, ..Config::default() }).await;
    let (mut fresh, mut used) = (server.connect().await, server.connect().await);
    used.write_all(b"GET /healthz HTTP/1.1\r\nhost: localhost\r\n\r\n").await.unwrap();
    used.readable().await.unwrap();
    assert_eq!(server.read("/healthz").await, json!({"status": "ok"}));
    assert_eq!(said(&mut fresh).await, "");
    assert!(said(&mut used).await.starts_with("HTTP/1.1 200"));
}

#[tokio::test(flavor = "multi_thread")]
async fn who_does_not_read_keeps_nobody_out() {
    let config = Config { max_connections: 1, idle_timeout: SOON, ..Config::default() };
    let server = Server::idle(config).await;
    let mut deaf = server.connect().await;
    // Some twenty megabytes, more than the buffers of the system hold.
    let page = "GET /docs/swagger-ui-bundle.js HTTP/1.1\r\nhost: localhost\r\n\r\n";
    deaf.write_all(page.repeat(20).as_bytes()).await.unwrap();
    assert_eq!(server.read("/healthz").await, json!({"status": "ok"}));
}

#[tokio::test(flavor = "multi_thread")]
async fn who_has_said_all_still_gets_the_answer() {
    let server = Server::idle(Config::default()).await;
    let mesh = ellipsoid(8, 6);
    let request = format!(
        "POST /v1/meshes?format=obj HTTP/1.1\r\nhost: localhost\r\ncontent-length: {}\r\n\r\n{mesh}",
        mesh.len()
    );
    let mut connection = server.connect().await;
    connection.write_all(request.as_bytes()).await.unwrap();
    connection.shutdown().await.unwrap();
    let answer = said(&mut connection).await;
    let (status, document) = read(&answer);
    assert_eq!((status, &document["triangles"].is_u64()), ("201", &true), "{answer}");
}

#[tokio::test(flavor = "multi_thread")]
async fn who_sends_too_much_learns_of_it() {
    let server = Server::idle(Config { max_upload_bytes: 10_000, ..Config::default() }).await;
    let much = vec![b'#'; 8 << 20];
    let chunked = [format!("{:x}\r\n", much.len()).as_bytes(), &much, b"\r\n0\r\n\r\n"].concat();
    let plain = (format!("content-length: {}", much.len()), much);
    for (framing, body) in [plain, ("transfer-encoding: chunked".to_owned(), chunked)] {
        let mut connection = server.connect().await;
        let head = format!("POST /v1/meshes?format=obj HTTP/1.1\r\nhost: localhost\r\n{framing}\r\n\r\n");
        connection.write_all(head.as_bytes()).await.unwrap();
        // As most clients do, all is sent before anything is read.
        connection.write_all(&body).await.unwrap();
        let answer = said(&mut connection).await;
        let (status, problem) = read(&answer);
        assert_eq!((status, &problem["status"]), ("413", &json!(413)), "{framing}: {answer}");
        assert!(answer.contains("\r\nconnection: close\r\n"), "{framing}: {answer}");
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn a_refusal_before_the_end_of_a_body_costs_no_later_request() {
    let server = Server::idle(Config { max_upload_bytes: 10_000, ..Config::default() }).await;
    for _ in 0..50 {
        let upload = server.post("/v1/meshes?format=obj").body(vec![b'#'; 300_000]);
        problem_of(upload.send().await.unwrap(), 413).await;
        assert_eq!(server.read("/healthz").await, json!({"status": "ok"}));
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn a_request_names_its_host() {
    let server = Server::idle(Config { allowed_hosts: vec!["shapes.example".to_owned()], ..Config::default() }).await;
    for (version, hosts, expected) in [
        ("1.1", "", "400"),
        ("1.1", "host: localhost\r\nhost: localhost\r\n", "400"),
        ("1.1", "host: rebound.example\r\n", "421"),
        ("1.1", "host: shapes.example\r\n", "200"),
        ("1.1", "host: localhost:1\r\n", "200"),
        ("1.0", "", "200"),
    ] {
        let request = format!("GET /healthz HTTP/{version}\r\n{hosts}connection: close\r\n\r\n");
        let answer = answered(&server, request).await;
        let (status, body) = read(&answer);
        assert_eq!(status, expected, "{hosts}: {answer}");
        assert!(expected == "200" || body["errors"][0]["place"] == "header host", "{hosts}: {answer}");
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn options_are_known_of_paths_there_are() {
    let server = Server::idle(Config { cors_origins: vec!["*".parse().unwrap()], ..Config::default() }).await;
    let asked = async |path: &str| {
        let request = server.request("OPTIONS", path).header("origin", "https://a.example");
        request.header("access-control-request-method", "POST").send().await.unwrap()
    };
    assert_eq!(header(&asked("/v1/meshes").await, "access-control-allow-methods"), "*");
    problem_of(asked("/v1/nothing").await, 404).await;
}

#[tokio::test(flavor = "multi_thread")]
async fn what_was_carried_out_is_answered_in_any_coding() {
    let server = Server::idle(Config::default()).await;
    for coding in ["identity;q=0", "*;q=0", "br, *;q=0"] {
        let asked = server.request_match(json!({})).await.header("accept-encoding", coding).send().await.unwrap();
        let path = header(&asked, "location").to_owned();
        json_of(asked, 202).await;
        let ended = server.request("DELETE", &path).header("accept-encoding", coding).send().await.unwrap();
        assert_eq!(json_of(ended, 200).await["status"], "cancelled", "{coding}");
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn an_event_that_has_not_been_yet_is_not_waited_for() {
    let server = Server::idle(Config::default()).await;
    let asked = server.request_match(json!({})).await.send().await.unwrap();
    let path = header(&asked, "location").to_owned();
    let mut events = server.get(&format!("{path}/events")).header("last-event-id", "1000000").send().await.unwrap();
    let first = events.chunk().await.unwrap().unwrap();
    assert!(String::from_utf8_lossy(&first).contains(r#""status":"queued""#), "{first:?}");
}
