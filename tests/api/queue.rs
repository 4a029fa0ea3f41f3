//! What is asked for with a job beside its request: whose turn it is, and whom to tell.

use reqwest::Response;
use serde_json::{Value, json};
use sketchmatch::http::Config;

use crate::server::{Server, json_of, problem_of};

async fn asked(server: &Server, query: &str) -> Response {
    let request = json!({"mesh": server.mesh().await, "sketch": server.sketch().await});
    server.post(&format!("/v1/matches{query}")).json(&request).send().await.unwrap()
}

#[tokio::test(flavor = "multi_thread")]
async fn batch_jobs_stand_behind_those_that_somebody_waits_for() {
    let server = Server::idle(Config::default()).await;
    let place = |document: &Value| (document["priority"].clone(), document["place_in_queue"].clone());
    let batch = json_of(asked(&server, "?priority=batch").await, 202).await;
    let awaited = json_of(asked(&server, "").await, 202).await;
    assert_eq!((place(&batch), place(&awaited)), ((json!("batch"), json!(1)), (json!("interactive"), json!(1))));
    let batch = server.read(batch["links"]["self"].as_str().unwrap()).await;
    assert_eq!(place(&batch), (json!("batch"), json!(2)));
    let problem = problem_of(asked(&server, "?priority=now").await, 422).await;
    assert!(problem["errors"][0]["place"].as_str().unwrap().contains("priority"), "{problem}");

    let request = json!({"mesh": server.mesh().await, "sketch": server.sketch().await});
    let sweep = json!({"request": request, "pointer": "/basis/k", "values": [8, 9]});
    let sweep = json_of(server.post("/v1/sweeps").json(&sweep).send().await.unwrap(), 202).await;
    let last = json_of(asked(&server, "").await, 202).await;
    assert_eq!(place(&last), (json!("interactive"), json!(2)));
    for document in sweep["matches"].as_array().unwrap() {
        assert_eq!(document["priority"], "batch");
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn only_hosts_that_the_server_may_call_are_told_of_an_end() {
    let nobody = Server::idle(Config::default()).await;
    let problem = problem_of(asked(&nobody, "?webhook=https://hooks.example/").await, 422).await;
    assert!(problem["errors"][0]["detail"].as_str().unwrap().contains("calls nobody"), "{problem}");

    let hosts = vec!["hooks.example".parse().unwrap()].into();
    let server = Server::idle(Config { webhook_hosts: hosts, ..Config::default() }).await;
    for address in ["https://hooks.example/a", "https%3A%2F%2Fhooks.example%2Fa%3Fb%3Dc"] {
        json_of(asked(&server, &format!("?webhook={address}")).await, 202).await;
    }
    for address in
        ["http://hooks.example/", "https://evil.example/", "https://127.0.0.1/", "https://[::ffff:7f00:1]/", ""]
    {
        let problem = problem_of(asked(&server, &format!("?webhook={address}")).await, 422).await;
        assert_eq!(problem["errors"][0]["place"], "query parameter webhook", "{problem}");
    }
    let listed = server.read("/v1/matches").await;
    assert_eq!(listed["items"].as_array().unwrap().len(), 2, "{listed}");

    // Another address is another request.
    let request = json!({"mesh": server.mesh().await, "sketch": server.sketch().await});
    for (address, status) in [("a", 202), ("a", 202), ("b", 422)] {
        let call = server.post(&format!("/v1/matches?webhook=https://hooks.example/{address}")).json(&request);
        assert_eq!(call.header("idempotency-key", "one").send().await.unwrap().status(), status);
    }
}
