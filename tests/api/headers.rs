//! What every answer carries, and keys that keep requests from being carried out twice.

use std::fs;

use futures::future::join_all;
use serde_json::json;
use sketchmatch::http::Config;

use crate::drawings::ellipsoid;
use crate::server::{Server, header, id, json_of, problem_of};

#[tokio::test(flavor = "multi_thread")]
async fn a_key_makes_one_match_of_many_requests() {
    let server = Server::idle(Config::default()).await;
    let asked =
        async |besides| server.request_match(besides).await.header("idempotency-key", "one").send().await.unwrap();
    let first = asked(json!({})).await;
    let location = header(&first, "location").to_owned();
    let again = asked(json!({})).await;
    assert_eq!((again.status().as_u16(), header(&again, "location")), (202, location.as_str()));
    assert_eq!(id(&json_of(first, 202).await), id(&json_of(again, 202).await));
    let other = problem_of(asked(json!({"preset": "thesis"})).await, 422).await;
    assert_eq!(other["errors"][0]["place"], "header idempotency-key");
    // Whose turn it is, is part of what is asked.
    let request = json!({"mesh": server.mesh().await, "sketch": server.sketch().await});
    let later = server.post("/v1/matches?priority=batch").header("idempotency-key", "one").json(&request);
    problem_of(later.send().await.unwrap(), 422).await;
    let same = server.post("/v1/matches?priority=interactive").header("idempotency-key", "one").json(&request);
    json_of(same.send().await.unwrap(), 202).await;
    assert_eq!(server.read("/v1/matches").await["items"].as_array().unwrap().len(), 1);
}

#[tokio::test(flavor = "multi_thread")]
async fn a_key_makes_one_match_of_requests_at_the_same_moment() {
    let server = Server::working().await;
    // Short enough to be finished before the last of the requests is looked at.
    let request = server.request_match(json!({"preset": "thesis"})).await.header("idempotency-key", "one");
    let requests = (0..24).map(|_| request.try_clone().unwrap().send());
    let mut ids = Vec::new();
    for answer in join_all(requests).await {
        ids.push(id(&json_of(answer.unwrap(), 202).await));
    }
    ids.dedup();
    assert_eq!(ids.len(), 1, "{ids:?}");
    assert_eq!(server.read("/v1/matches").await["items"].as_array().unwrap().len(), 1);
}

#[tokio::test(flavor = "multi_thread")]
async fn a_key_repeats_the_answer_to_an_upload() {
    let server = Server::idle(Config::default()).await;
    let upload = |segments| {
        server.post("/v1/meshes?format=obj").header("idempotency-key", "one").body(ellipsoid(segments, 6)).send()
    };
    let first = json_of(upload(8).await.unwrap(), 201).await;
    assert_eq!(json_of(upload(8).await.unwrap(), 201).await, first);
    problem_of(upload(9).await.unwrap(), 422).await;
}

#[tokio::test(flavor = "multi_thread")]
async fn uploads_under_one_key_at_the_same_moment_get_the_answer_of_the_first() {
    let server = Server::idle(Config::default()).await;
    let upload = || server.post("/v1/meshes?format=obj").header("idempotency-key", "one").body(ellipsoid(8, 6)).send();
    let mut answers = Vec::new();
    for answer in join_all((0..50).map(|_| upload())).await {
        answers.push(json_of(answer.unwrap(), 201).await);
    }
    answers.dedup();
    assert_eq!(answers.len(), 1, "{answers:?}");
    // Without a key one of them is told that it is new.
    let upload = || server.post("/v1/meshes?format=obj").body(ellipsoid(9, 6)).send();
    let answers = join_all((0..50).map(|_| upload())).await;
    let new = answers.into_iter().filter(|answer| answer.as_ref().unwrap().status() == 201).count();
    assert_eq!(new, 1);
}

#[tokio::test(flavor = "multi_thread")]
async fn of_two_requests_under_one_key_at_the_same_moment_one_is_carried_out() {
    let server = Server::idle(Config::default()).await;
    for round in 0..8 {
        let key = format!("key {round}").replace(' ', "-");
        let one = server.request_match(json!({})).await.header("idempotency-key", &key);
        let other = server.request_match(json!({"preset": "thesis"})).await.header("idempotency-key", &key);
        let answers = join_all([one.send(), other.send()]).await;
        let mut statuses: Vec<u16> = answers.iter().map(|answer| answer.as_ref().unwrap().status().as_u16()).collect();
        statuses.sort_unstable();
        assert_eq!(statuses, [202, 422]);
        assert_eq!(server.read("/v1/matches").await["items"].as_array().unwrap().len(), round + 1);
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn a_key_is_forgotten_with_what_it_made() {
    let server = Server::idle(Config::default()).await;
    let asked = async || server.request_match(json!({})).await.header("idempotency-key", "one").send().await.unwrap();
    let first = header(&asked().await, "location").to_owned();
    let end = async |path: &str| server.request("DELETE", path).send().await.unwrap().status().as_u16();
    assert_eq!((end(&first).await, end(&first).await), (200, 204));
    let again = header(&asked().await, "location").to_owned();
    assert_ne!(again, first);
    assert_eq!(server.read(&again).await["status"], "queued");

    let upload = || server.post("/v1/meshes?format=obj").header("idempotency-key", "two").body(ellipsoid(8, 6)).send();
    let path = format!("/v1/meshes/{}", id(&json_of(upload().await.unwrap(), 201).await));
    assert_eq!(end(&path).await, 204);
    json_of(upload().await.unwrap(), 201).await;
    server.read(&path).await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_key_is_of_one_request_whatever_its_route() {
    let server = Server::idle(Config::default()).await;
    let upload = |path: &str| server.post(path).header("idempotency-key", "one").body(ellipsoid(8, 6)).send();
    json_of(upload("/v1/meshes?format=obj").await.unwrap(), 201).await;
    problem_of(upload("/v1/sketches").await.unwrap(), 422).await;
}

#[tokio::test(flavor = "multi_thread")]
async fn an_answer_carries_the_identifiers_of_its_request() {
    let server = Server::idle(Config::default()).await;
    let trace = "00-4bf92f3577b34da6a3ce929d0e0e4736-00f067aa0ba902b7-01";
    let request = server.get("/healthz").header("x-request-id", "abc").header("traceparent", trace);
    let answer = request.send().await.unwrap();
    assert_eq!((header(&answer, "x-request-id"), header(&answer, "traceparent")), ("abc", trace));
    let answer = server.get("/nothing").send().await.unwrap();
    assert_eq!(header(&answer, "x-request-id").len(), 36);
}

#[tokio::test(flavor = "multi_thread")]
async fn other_sites_may_call_as_configured() {
    let server =
        Server::idle(Config { cors_origins: vec!["https://a.example".parse().unwrap()], ..Config::default() }).await;
    let from = async |origin: &str| server.get("/healthz").header("origin", origin).send().await.unwrap();
    assert_eq!(header(&from("https://a.example").await, "access-control-allow-origin"), "https://a.example");
    assert_eq!(header(&from("https://b.example").await, "access-control-allow-origin"), "");
}

#[tokio::test(flavor = "multi_thread")]
async fn the_service_tells_its_state() {
    let server = Server::idle(Config::default()).await;
    assert_eq!(server.read("/healthz").await, json!({"status": "ok"}));
    assert_eq!(server.read("/readyz").await, json!({"status": "ok"}));
    assert_eq!(server.get("/metrics").send().await.unwrap().status(), 200);
    let blobs = server.data().join("blobs");
    fs::rename(&blobs, server.data().join("elsewhere")).unwrap();
    problem_of(server.get("/readyz").send().await.unwrap(), 503).await;
    let refused = server.post("/v1/meshes?format=obj").body(ellipsoid(8, 6)).send().await.unwrap();
    assert_eq!(header(&refused, "retry-after"), "5");
    problem_of(refused, 503).await;
    fs::rename(server.data().join("elsewhere"), &blobs).unwrap();
    assert_eq!(server.read("/readyz").await, json!({"status": "ok"}));
    let page = server.get("/docs/").send().await.unwrap();
    assert!(page.text().await.unwrap().contains("swagger"));
    let regularisers = server.read("/v1/regularisers").await;
    for regulariser in regularisers.as_array().unwrap() {
        let path = format!("/v1/regularisers/{}", regulariser["type"].as_str().unwrap());
        assert_eq!(server.read(&path).await, *regulariser);
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn browsers_are_told_to_take_answers_for_what_they_are() {
    let server = Server::idle(Config::default()).await;
    let mesh = server.mesh().await;
    let picture = format!("/v1/meshes/{mesh}/picture?format=svg&width=100");
    for path in ["/v1/regularisers", "/nothing", "/healthz", &picture] {
        let answer = server.get(path).send().await.unwrap();
        assert_eq!(header(&answer, "x-content-type-options"), "nosniff", "{path}");
        assert_eq!(header(&answer, "referrer-policy"), "no-referrer", "{path}");
        assert!(header(&answer, "content-security-policy").starts_with("default-src 'none'"), "{path}");
    }
    let docs = server.get("/docs/").send().await.unwrap();
    assert!(header(&docs, "content-security-policy").starts_with("default-src 'self'"));
}
