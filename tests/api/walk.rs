//! The whole way of a match, from the files to the correspondences.

use futures::future::join_all;
use serde_json::{Value, json};
use sketchmatch::http::Config;

use crate::server::{Server, header, id, json_of, problem_of};

#[tokio::test(flavor = "multi_thread")]
async fn a_match_is_asked_for_followed_read_and_deleted() {
    let server = Server::working().await;
    let asked = server.request_match(json!({})).await.send().await.unwrap();
    assert_eq!(header(&asked, "retry-after"), "1");
    let path = header(&asked, "location").to_owned();
    let document = json_of(asked, 202).await;
    assert_eq!(path, format!("/v1/matches/{}", id(&document)));
    assert_eq!(document["links"]["self"], path);

    let events = server.get(&format!("{path}/events")).send().await.unwrap();
    assert_eq!(header(&events, "content-type"), "text/event-stream");
    let events = events.text().await.unwrap();
    let last = events.lines().filter_map(|line| line.strip_prefix("data: ")).next_back().unwrap();
    assert_eq!(serde_json::from_str::<Value>(last).unwrap()["status"], "succeeded", "{events}");

    let done = server.read(&path).await;
    assert_eq!(done["status"], "succeeded");
    assert_eq!(done["progress"], json!({"stage": "finished", "fraction": 1.0}));
    assert!(done["started_at"].is_string() && done["finished_at"].is_string());
    // In a list a match is told of without its request.
    let mut listed = done.clone();
    listed.as_object_mut().unwrap().remove("request");
    assert_eq!(server.read("/v1/matches").await["items"][0], listed);

    let result = server.read(&format!("{path}/result")).await;
    assert_eq!(result["match"], done["id"]);
    assert_eq!(result["version"], env!("CARGO_PKG_VERSION"));
    let sketch = server.read(&format!("/v1/sketches/{}/mesh", result["sketch"].as_str().unwrap())).await;
    let points = result["correspondences"].as_array().unwrap();
    assert_eq!(points.len(), sketch["vertices"].as_array().unwrap().len());
    assert!(
        points
            .iter()
            .enumerate()
            .all(|(i, point)| point["sketch_vertex"] == i && point["point"] == sketch["vertices"][i])
    );

    assert_eq!(server.request("DELETE", &path).send().await.unwrap().status(), 204);
    problem_of(server.get(&path).send().await.unwrap(), 404).await;
    problem_of(server.get(&format!("{path}/result")).send().await.unwrap(), 404).await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_result_comes_as_json_table_or_array() {
    let server = Server::working().await;
    let path = format!("{}/result", server.finished_match().await);
    let json = server.read(&path).await;
    let form = async |accept: &str| server.get(&path).header("accept", accept).send().await.unwrap();

    let table = form("text/csv").await;
    assert_eq!(header(&table, "content-type"), "text/csv");
    let table = table.text().await.unwrap();
    assert_eq!(table.lines().next(), Some("sketch_vertex,x,y,mesh_vertex,confidence"));
    assert_eq!(table.lines().count(), 1 + json["correspondences"].as_array().unwrap().len());

    let array = form("application/x-npy").await.bytes().await.unwrap();
    let last = f64::from_le_bytes(*array.last_chunk().unwrap());
    let row = json["c"]["values"].as_array().unwrap().last().unwrap();
    assert_eq!(row.as_array().unwrap().last().unwrap().as_f64(), Some(last));
    problem_of(form("image/png").await, 406).await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_result_known_to_the_client_is_not_sent_again() {
    let server = Server::working().await;
    let path = format!("{}/result", server.finished_match().await);
    let first = server.get(&path).send().await.unwrap();
    let tag = header(&first, "etag").to_owned();
    assert!(tag.starts_with('"'), "{tag}");
    let again = server.get(&path).header("if-none-match", &tag).send().await.unwrap();
    assert_eq!((again.status().as_u16(), header(&again, "etag")), (304, tag.as_str()));
    let table = server.get(&path).header("if-none-match", &tag).header("accept", "text/csv").send().await.unwrap();
    assert_eq!(table.status(), 200);
    let zipped = server.get(&path).header("accept-encoding", "gzip").send().await.unwrap();
    assert_eq!(header(&zipped, "content-encoding"), "gzip");
    assert_ne!(header(&zipped, "etag"), tag);
    let again = server.get(&path).header("if-none-match", header(&zipped, "etag")).send().await.unwrap();
    assert_eq!(again.status(), 304);
}

#[tokio::test(flavor = "multi_thread")]
async fn cancelling_leaves_what_is_finished() {
    let server = Server::working().await;
    let path = server.finished_match().await;
    let cancel = async |path: &str| server.post(&format!("{path}/cancel")).send().await.unwrap();
    assert_eq!(json_of(cancel(&path).await, 200).await["status"], "succeeded");
    server.read(&format!("{path}/result")).await;
    problem_of(cancel("/v1/matches/none").await, 404).await;

    let idle = Server::idle(Config::default()).await;
    let asked = idle.request_match(json!({})).await.send().await.unwrap();
    let path = format!("{}/cancel", header(&asked, "location"));
    for _ in 0..2 {
        assert_eq!(json_of(idle.post(&path).send().await.unwrap(), 200).await["status"], "cancelled");
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn a_match_that_waits_has_no_result_and_can_be_cancelled() {
    let server = Server::idle(Config::default()).await;
    let asked = server.request_match(json!({})).await.header("prefer", "wait=0").send().await.unwrap();
    assert_eq!(header(&asked, "preference-applied"), "wait=0");
    let path = header(&asked, "location").to_owned();
    assert_eq!(json_of(asked, 202).await["status"], "queued");
    let result = server.get(&format!("{path}/result")).send().await.unwrap();
    assert_eq!(header(&result, "retry-after"), "1");
    problem_of(result, 409).await;

    let cancelled = json_of(server.request("DELETE", &path).send().await.unwrap(), 200).await;
    assert_eq!(cancelled["status"], "cancelled");
    let events = server.get(&format!("{path}/events")).send().await.unwrap().text().await.unwrap();
    let revision = events.lines().find_map(|line| line.strip_prefix("id: ")).unwrap().to_owned();
    let seen = server.get(&format!("{path}/events")).header("last-event-id", &revision).send().await.unwrap();
    assert_eq!(seen.status(), 204);
    let garbled = server.get(&format!("{path}/events")).header("last-event-id", "x").send().await.unwrap();
    problem_of(garbled, 400).await;
    problem_of(server.get(&format!("{path}/result")).send().await.unwrap(), 409).await;
    assert_eq!(server.request("DELETE", &path).send().await.unwrap().status(), 204);
}

#[tokio::test(flavor = "multi_thread")]
async fn who_waited_in_vain_is_told_how_far_the_match_is() {
    let server = Server::idle(Config::default()).await;
    let request = server.request_match(json!({})).await.header("idempotency-key", "a").header("prefer", "wait=0");
    let again = request.try_clone().unwrap();
    assert_eq!(json_of(request.send().await.unwrap(), 202).await["status"], "queued");
    server.take_up_a_match().await;
    let asked = again.send().await.unwrap();
    assert_eq!(header(&asked, "retry-after"), "1");
    assert_eq!(json_of(asked, 202).await["status"], "running");
}

#[tokio::test(flavor = "multi_thread")]
async fn a_running_match_can_be_cancelled() {
    let server = Server::working().await;
    let long = json!({"regulariser": {"type": "nuclear", "max_iterations": 20_000}, "basis": {"k": 60}});
    let asked = server.request_match(long).await.send().await.unwrap();
    let path = header(&asked, "location").to_owned();
    let mut events = server.get(&format!("{path}/events")).send().await.unwrap();
    let mut seen = String::new();
    while !seen.contains("\"running\"") {
        seen += std::str::from_utf8(&events.chunk().await.unwrap().expect("the match runs")).unwrap();
    }
    json_of(server.request("DELETE", &path).send().await.unwrap(), 200).await;
    let rest = events.text().await.unwrap();
    assert!(rest.contains("\"cancelled\""), "{rest}");
    server.finished_match().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_full_queue_says_when_to_come_again() {
    let server = Server::idle(Config { max_queue: 1, ..Config::default() }).await;
    let asked = server.request_match(json!({})).await.send().await.unwrap();
    json_of(asked, 202).await;
    let refused = server.request_match(json!({})).await.send().await.unwrap();
    assert_eq!(header(&refused, "retry-after"), "10");
    problem_of(refused, 503).await;
}

#[tokio::test(flavor = "multi_thread")]
async fn of_many_requests_at_once_no_more_are_taken_than_may_wait() {
    let server = Server::idle(Config { max_queue: 5, ..Config::default() }).await;
    let request = server.request_match(json!({})).await;
    let answers = join_all((0..60).map(|_| request.try_clone().unwrap().send())).await;
    let taken = answers.iter().filter(|answer| answer.as_ref().unwrap().status() == 202).count();
    assert_eq!(taken, 5);
    let places =
        server.read("/v1/matches").await["items"].as_array().unwrap().iter().rev().map(place).collect::<Vec<_>>();
    assert_eq!(places, [1, 2, 3, 4, 5]);
}

fn place(document: &Value) -> i64 {
    document["place_in_queue"].as_i64().unwrap_or_else(|| panic!("{document}"))
}

#[tokio::test(flavor = "multi_thread")]
async fn spectra_leave_places_to_matches() {
    let server = Server::idle(Config { max_queue: 4, ..Config::default() }).await;
    let path = format!("/v1/meshes/{}/spectrum", server.mesh().await);
    let mut statuses = Vec::new();
    for k in 1..=4 {
        statuses.push(server.get(&format!("{path}?k={k}")).send().await.unwrap().status().as_u16());
    }
    assert_eq!(statuses, [202, 202, 503, 503]);
    for status in [202, 202, 503] {
        assert_eq!(server.request_match(json!({})).await.send().await.unwrap().status(), status);
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn matches_are_listed_in_pages() {
    let server = Server::idle(Config::default()).await;
    let mut ids = Vec::new();
    for _ in 0..3 {
        ids.push(id(&json_of(server.request_match(json!({})).await.send().await.unwrap(), 202).await));
    }
    let first = server.get("/v1/matches?limit=2").send().await.unwrap();
    let link = header(&first, "link").to_owned();
    let first = json_of(first, 200).await;
    let next = first["next"].as_str().unwrap();
    assert_eq!(link, format!("<{next}>; rel=\"next\""));
    let second = server.read(next).await;
    assert_eq!(second["next"], Value::Null);
    let pages = [&first, &second].into_iter().flat_map(|page| page["items"].as_array().unwrap());
    let mut listed: Vec<String> = pages.map(id).collect();
    listed.sort();
    ids.sort();
    assert_eq!(listed, ids);
}

#[tokio::test(flavor = "multi_thread")]
async fn a_match_says_what_it_is_of() {
    let server = Server::idle(Config::default()).await;
    let (mesh, sketch) = (server.mesh().await, server.sketch().await);
    let request = json!({"mesh": mesh, "sketch": sketch, "preset": "thesis"});
    let asked = json_of(server.post("/v1/matches?name=a%20cat").json(&request).send().await.unwrap(), 202).await;
    assert_eq!((&asked["name"], &asked["mesh"], &asked["sketch"]), (&json!("a cat"), &json!(mesh), &json!(sketch)));
    assert_eq!((&asked["request"]["preset"], &asked["request"]["basis"]["k"]), (&json!("thesis"), &json!(20)));
    assert_eq!(server.read(asked["links"]["self"].as_str().unwrap()).await, asked);
    let listed = &server.read("/v1/matches").await["items"][0];
    assert_eq!((&listed["name"], listed.get("request")), (&json!("a cat"), None));
    let endless = server.post(&format!("/v1/matches?name={}", "n".repeat(201))).json(&request).send().await.unwrap();
    assert_eq!(problem_of(endless, 422).await["errors"][0]["place"], "query parameter name");
}

#[tokio::test(flavor = "multi_thread")]
async fn a_sketch_may_be_drawn_in_the_request() {
    let server = Server::idle(Config::default()).await;
    let request =
        |drawing: Value, mesh: &str| server.post("/v1/matches").json(&json!({"mesh": mesh, "sketch": drawing}));
    let drawing = crate::drawings::ellipse();
    let refused = problem_of(request(drawing.clone(), "mesh_0").send().await.unwrap(), 422).await;
    assert_eq!(refused["errors"][0]["pointer"], "/mesh");
    let mesh = server.mesh().await;
    for (drawing, pointer) in [
        (json!({"outline": [[0, 0], [1, 0]]}), "/sketch/outline"),
        (json!({"outline": [[0, 0], [1, "0"], [0, 1]]}), "/sketch/outline/1/1"),
        (json!({}), "/sketch/outline"),
    ] {
        let refused = problem_of(request(drawing, &mesh).send().await.unwrap(), 422).await;
        assert_eq!(refused["errors"][0]["pointer"], pointer);
    }
    assert_eq!(server.read("/v1/sketches").await["items"], json!([]), "a refused request leaves nothing");
    let full = Server::idle(Config { max_queue: 0, ..Config::default() }).await;
    let unheard = json!({"mesh": full.mesh().await, "sketch": drawing});
    problem_of(full.post("/v1/matches").json(&unheard).send().await.unwrap(), 503).await;
    assert_eq!(full.read("/v1/sketches").await["items"], json!([]), "what the queue refuses leaves nothing");
    let asked = json_of(request(drawing, &mesh).send().await.unwrap(), 202).await;
    let sketch = server.read(&format!("/v1/sketches/{}", asked["sketch"].as_str().unwrap())).await;
    assert_eq!(asked["request"]["sketch"], sketch["id"]);
}
