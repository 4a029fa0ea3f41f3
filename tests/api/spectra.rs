//! Spectra: queued at first, then answered in every form.

use safetensors::SafeTensors;
use serde_json::{Value, json};
use sketchmatch::http::Config;

use crate::server::{Server, header, json_of, problem_of};

/// The spectrum once it is there.
async fn spectrum(server: &Server, path: &str) -> Value {
    loop {
        let answer = server.get(path).send().await.unwrap();
        if answer.status() == 200 {
            return answer.json().await.unwrap();
        }
        assert_eq!(header(&answer, "retry-after"), "1");
        assert!(path.starts_with(header(&answer, "location")), "{}", header(&answer, "location"));
        json_of(answer, 202).await;
        tokio::task::yield_now().await;
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn a_spectrum_is_worked_out_once_and_then_answered() {
    let server = Server::working().await;
    let path = format!("/v1/meshes/{}/spectrum?k=10&boundary=neumann", server.mesh().await);
    let long = spectrum(&server, &path).await;
    let eigenvalues = long["eigenvalues"].as_array().unwrap();
    assert_eq!((eigenvalues.len(), &long["k"], &long["boundary"]), (10, &json!(10), &json!("neumann")));
    assert!(eigenvalues[0].as_f64().unwrap().abs() < 1e-6);
    let short = server.read(&path.replace("k=10", "k=4")).await;
    assert_eq!(short["eigenvalues"].as_array().unwrap()[..], eigenvalues[..4]);
    assert_eq!(short["cached"], true);

    let array = server.get(&path).header("accept", "application/x-npy").send().await.unwrap();
    assert_eq!(array.bytes().await.unwrap().len() % 64, 178 * 10 * 8 % 64);
    let tensors = server.get(&path).header("accept", "application/vnd.safetensors").send().await.unwrap();
    let tensors = tensors.bytes().await.unwrap();
    let tensors = SafeTensors::deserialize(&tensors).unwrap();
    assert_eq!(tensors.tensor("eigenfunctions").unwrap().shape(), [178, 10]);
    assert_eq!(tensors.tensor("mass").unwrap().shape(), [178]);
}

#[tokio::test(flavor = "multi_thread")]
async fn a_sketch_has_a_spectrum_for_either_boundary() {
    let server = Server::working().await;
    let path = format!("/v1/sketches/{}/spectrum?k=5&boundary=", server.sketch().await);
    let free = spectrum(&server, &format!("{path}neumann")).await;
    let fixed = spectrum(&server, &format!("{path}dirichlet")).await;
    assert!(free["eigenvalues"][0].as_f64() < fixed["eigenvalues"][0].as_f64(), "{free} {fixed}");
}

#[tokio::test(flavor = "multi_thread")]
async fn only_the_largest_component_has_eigenfunctions() {
    let server = Server::working().await;
    let obj = format!("{}v 9 9 9\nv 9.1 9 9\nv 9 9.1 9\nf 179 180 181\n", crate::drawings::ellipsoid(16, 12));
    let mesh = json_of(server.post("/v1/meshes?format=obj").body(obj).send().await.unwrap(), 201).await;
    assert_eq!(mesh["components"], 2);
    let path = format!("/v1/meshes/{}/spectrum?k=3&boundary=neumann", mesh["id"].as_str().unwrap());
    spectrum(&server, &path).await;
    let array = server.get(&path).header("accept", "application/x-npy").send().await.unwrap().bytes().await.unwrap();
    let values: Vec<f64> =
        array[array.len() - 181 * 3 * 8..].as_chunks().0.iter().map(|b| f64::from_le_bytes(*b)).collect();
    assert!(values[..178 * 3].iter().all(|value| value.is_finite()));
    assert!(values[178 * 3..].iter().all(|value| value.is_nan()));
}

#[tokio::test(flavor = "multi_thread")]
async fn more_eigenpairs_than_there_are_cannot_be_asked_for() {
    let server = Server::idle(Config::default()).await;
    let path = format!("/v1/meshes/{}/spectrum", server.mesh().await);
    for (k, most) in [(0, 500), (178, 177), (501, 500)] {
        let answer = server.get(&format!("{path}?k={k}")).send().await.unwrap();
        let problem = problem_of(answer, 422).await;
        let detail = format!("k is from 1 to {most} here");
        assert_eq!(problem["errors"], json!([{"place": "query parameter k", "detail": detail}]), "{k}");
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn more_than_a_job_may_take_cannot_be_asked_for() {
    let server = Server::idle(Config { max_job_memory: 1 << 10, ..Config::default() }).await;
    let path = format!("/v1/sketches/{}/spectrum", server.sketch().await);
    let problem = problem_of(server.get(&path).send().await.unwrap(), 422).await;
    assert_eq!(problem["errors"][0]["place"], "query parameter k", "{problem}");
    let answer = server.request_match(json!({})).await.send().await.unwrap();
    let problem = problem_of(answer, 422).await;
    let pointers = [0, 1].map(|i| problem["errors"][i]["pointer"].as_str());
    assert_eq!(pointers, [Some("/basis/k"), Some("/basis/k_mesh")], "{problem}");
    assert_eq!(server.read("/v1/matches").await["items"], json!([]));
}
