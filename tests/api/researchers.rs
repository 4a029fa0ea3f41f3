//! What those who study the method bring themselves: maps, points, functions, terms, and sweeps of a value.

use serde_json::{Value, json};
use sketchmatch::http::Config;

use crate::server::{Server, header, json_of, problem_of};

#[tokio::test(flavor = "multi_thread")]
async fn a_map_of_ones_own_is_converted_as_others_are() {
    let server = Server::working().await;
    let found = server.read(&format!("{}/result", server.intrinsic_match(json!({})).await)).await;
    let given = json!({"given_map": {"type": "c", "rows": found["c"]["values"]}});
    let own = server.read(&format!("{}/result", server.intrinsic_match(given).await)).await;
    assert_eq!((&own["c"], &own["correspondences"]), (&found["c"], &found["correspondences"]));
    assert_eq!(own["solver"]["iterations"], 0);

    let vertices: Vec<&Value> =
        found["correspondences"].as_array().unwrap().iter().map(|point| &point["mesh_vertex"]).collect();
    let points = json!({"given_map": {"type": "points", "mesh_vertices": vertices}, "refinement": {"method": "zoomout", "k": 17}});
    let refined = server.read(&format!("{}/result", server.intrinsic_match(points).await)).await;
    assert_eq!((&refined["c"]["rows"], &refined["c"]["columns"]), (&json!(17), &json!(17)));

    let m = vertices.len();
    let mesh = server.read(&format!("/v1/meshes/{}/mesh", found["mesh"].as_str().unwrap())).await;
    let n = mesh["vertices"].as_array().unwrap().len();
    let pair = json!({"sketch": vec![1.0; m], "mesh": vec![1.0; n]});
    let with = json!({"functions": [pair], "terms": [{"type": "laplacian"}, {"type": "descriptors"}, {"type": "orientation"}]});
    let path = server.intrinsic_match(with).await;
    let bytes = server.get(&format!("{path}/inside")).send().await.unwrap().bytes().await.unwrap();
    let length = u64::from_le_bytes(bytes[..8].try_into().unwrap()) as usize;
    let head: Value = serde_json::from_slice(&bytes[8..8 + length]).unwrap();
    let result = server.read(&format!("{path}/result")).await;
    let pairs = result["intermediate"]["regions"]["pairs"].as_array().unwrap().len();
    assert_eq!(head["a"]["shape"], json!([12, 201 * pairs + 1]));
}

#[tokio::test(flavor = "multi_thread")]
async fn every_regulariser_and_term_can_be_asked_for() {
    let server = Server::working().await;
    let regularisers = server.read("/v1/regularisers").await;
    let names: Vec<&str> = regularisers.as_array().unwrap().iter().map(|r| r["type"].as_str().unwrap()).collect();
    assert_eq!(names, ["none", "l2", "l1", "nuclear", "permuted_l1", "matrix_completion", "part_indicator"]);
    for name in ["permuted_l1", "matrix_completion", "part_indicator"] {
        let path = server.intrinsic_match(json!({"regulariser": {"type": name, "max_iterations": 20}})).await;
        let result = server.read(&format!("{path}/result")).await;
        assert_eq!(result["solver"]["regulariser"], name);
        let history: Vec<f64> = serde_json::from_value(result["solver"]["history"].clone()).unwrap();
        assert!(history.is_sorted_by(|before, after| after <= before), "{name}: {history:?}");
        let part = result["intermediate"]["part"].as_array();
        assert_eq!(part.is_some(), name == "part_indicator");
        if let Some(part) = part {
            assert_eq!(part.len(), result["intermediate"]["regions"]["mesh"].as_array().unwrap().len());
            assert!(part.iter().all(|share| (0.0..=1.0).contains(&share.as_f64().unwrap())));
            let shown = |point: &Value| part[point["mesh_vertex"].as_u64().unwrap() as usize].as_f64().unwrap() >= 0.5;
            assert!(result["correspondences"].as_array().unwrap().iter().all(shown));
        }
    }
    let terms = server.read("/v1/terms").await;
    assert!(terms.as_array().unwrap().iter().all(|term| term["parameters"][0]["name"] == "weight"));
    let request = server.request_match(json!({"terms": [{"type": "laplacian"}, {"type": "laplacian", "weight": -1}]}));
    let problem = problem_of(request.await.send().await.unwrap(), 422).await;
    assert_eq!(problem["errors"][0]["pointer"], "/terms/1/weight");
}

#[tokio::test(flavor = "multi_thread")]
async fn bases_can_be_coupled_and_a_part_refined() {
    let server = Server::working().await;
    let bases = server.read("/v1/bases").await;
    assert_eq!(bases[1]["schema"]["properties"]["method"]["enum"], json!(["joint_diagonalisation"]));
    assert_eq!(bases[1]["parameters"][0]["default"], 1.0);
    let basis = |coupling: Value| json!({"basis": {"k": 12, "coupling": coupling}, "regulariser": {"type": "none"}});
    let of = async |request: Value| server.read(&format!("{}/result", server.intrinsic_match(request).await)).await;
    // Without a regulariser the least there is, is the same in whatever bases it is found.
    let [plain, coupled] =
        [of(basis(json!({"method": "none"}))).await, of(basis(json!({"method": "joint_diagonalisation"}))).await];
    let [plain, coupled] = [plain, coupled].map(|result| result["solver"]["objective"].as_f64().unwrap());
    assert!((plain - coupled).abs() < 1e-6 * plain.max(1.0), "{plain} {coupled}");
    let part = of(json!({"refinement": {"method": "zoomout", "k": 17, "within": "part"}})).await;
    assert_eq!(part["c"]["rows"], 17);

    let request = json!({"basis": {"k": 5, "k_mesh": 6, "coupling": {"method": "joint_diagonalisation", "weight": 0}}});
    let problem = problem_of(server.request_match(request).await.send().await.unwrap(), 422).await;
    let pointers: Vec<&Value> = problem["errors"].as_array().unwrap().iter().map(|error| &error["pointer"]).collect();
    assert_eq!(pointers, ["/basis/coupling/weight", "/basis/coupling"]);
}

#[tokio::test(flavor = "multi_thread")]
async fn what_one_brings_has_to_fit() {
    let server = Server::idle(Config::default()).await;
    for (besides, pointer) in [
        (json!({"given_map": {"type": "c", "rows": [[1, 2], [3]]}}), "/given_map/rows"),
        (json!({"given_map": {"type": "c", "rows": [[1]]}, "basis": {"k": 2}}), "/given_map/rows"),
        (json!({"given_map": {"type": "points", "mesh_vertices": [0]}}), "/given_map/mesh_vertices"),
        (json!({"functions": [{"sketch": [1], "mesh": [1]}]}), "/functions/0/sketch"),
        (json!({"given_map": {"type": "d"}}), "/given_map/type"),
    ] {
        let problem = problem_of(server.request_match(besides).await.send().await.unwrap(), 422).await;
        assert_eq!(problem["errors"][0]["pointer"], pointer, "{problem}");
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn a_sweep_is_a_match_for_every_value() {
    let server = Server::idle(Config { max_queue: 3, ..Config::default() }).await;
    let (mesh, sketch) = (server.mesh().await, server.sketch().await);
    let request = json!({"mesh": mesh, "sketch": sketch, "regulariser": {"type": "l2"}});
    let sweep = |pointer: &str, values: Value| json!({"request": request, "pointer": pointer, "values": values});
    let ask = async |body: Value| server.post("/v1/sweeps").json(&body).send().await.unwrap();
    for (body, pointer) in [
        (sweep("/regulariser/gamma", json!([1, -1])), "/request/regulariser/gamma"),
        (sweep("/regulariser/delta", json!([1])), "/request/regulariser/delta"),
        (sweep("gamma", json!([1])), "/pointer"),
        (sweep("/mesh/x", json!([1])), "/pointer"),
        (sweep("/regulariser/gamma", json!([])), "/values"),
    ] {
        let problem = problem_of(ask(body).await, 422).await;
        assert_eq!(problem["errors"][0]["pointer"], pointer, "{problem}");
    }
    // More than may ever wait: coming again does not help.
    let answer = ask(sweep("/basis/k", json!([5, 6, 7, 8]))).await;
    assert_eq!(header(&answer, "retry-after"), "");
    let problem = problem_of(answer, 422).await;
    assert_eq!(problem["errors"][0]["pointer"], "/values", "{problem}");
    assert!(problem["errors"][0]["detail"].as_str().unwrap().contains("no more than 3"), "{problem}");
    // All or none: nothing is listed of a refused one.
    assert_eq!(server.read("/v1/matches").await["items"], json!([]));

    let swept = json_of(ask(sweep("/regulariser/gamma", json!([0.1, 1, 10]))).await, 202).await;
    let gammas: Vec<&Value> =
        swept["matches"].as_array().unwrap().iter().map(|m| &m["request"]["regulariser"]["gamma"]).collect();
    assert_eq!(gammas, [&json!(0.1), &json!(1.0), &json!(10.0)]);
    assert_eq!(swept["matches"][1]["name"], "/regulariser/gamma = 1");
    problem_of(ask(sweep("/basis/k", json!([5]))).await, 503).await;
}

#[tokio::test(flavor = "multi_thread")]
async fn the_requests_of_a_sweep_are_together_as_long_as_four_at_most() {
    let server = Server::idle(Config { max_request_bytes: 4000, ..Config::default() }).await;
    let (mesh, sketch) = (server.mesh().await, server.sketch().await);
    let sweep = |values: usize| {
        let request = json!({"mesh": mesh, "sketch": sketch, "components": vec![0; 900]});
        json!({"request": request, "pointer": "/basis/k", "values": vec![7; values]})
    };
    let problem = problem_of(server.post("/v1/sweeps").json(&sweep(9)).send().await.unwrap(), 422).await;
    assert_eq!(problem["errors"][0]["pointer"], "/values", "{problem}");
    json_of(server.post("/v1/sweeps").json(&sweep(8)).send().await.unwrap(), 202).await;
}
