//! Functions, labels and colours taken from one shape of a match to the other.

use serde_json::{Value, json};
use sketchmatch::http::Config;

use crate::server::{Server, header, id, json_of, problem_of};

/// The places of the vertices of a shape.
async fn places(server: &Server, path: &str) -> Vec<Vec<f64>> {
    serde_json::from_value(server.read(&format!("{path}/mesh")).await["vertices"].clone()).unwrap()
}

fn numbers(answer: &Value) -> Vec<Option<f64>> {
    serde_json::from_value(answer["values"].clone()).unwrap()
}

#[tokio::test(flavor = "multi_thread")]
async fn a_function_is_taken_either_way_by_either_means() {
    let server = Server::working().await;
    let matched = server.intrinsic_match(json!({})).await;
    let result = server.read(&format!("{matched}/result")).await;
    let [sketch, mesh] = ["sketch", "mesh"].map(|kind| result[kind].as_str().unwrap().to_owned());
    let flat = places(&server, &format!("/v1/sketches/{sketch}")).await;
    let solid = places(&server, &format!("/v1/meshes/{mesh}")).await;
    let path = format!("{matched}/transfers");
    // How far along the ellipse, led to the ellipsoid and back: it still grows along it.
    let along: Vec<f64> = flat.iter().map(|p| p[0]).collect();
    for by in ["points", "map"] {
        let there = json!({"from": "sketch", "by": by, "given": {"type": "function", "values": along}});
        let moved = json_of(server.post(&path).json(&there).send().await.unwrap(), 200).await;
        let values = numbers(&moved);
        assert_eq!((values.len(), &moved["type"]), (solid.len(), &json!("function")));
        let known = values.iter().flatten().count();
        assert!(known * 4 > solid.len(), "{by}: {known} of {}", solid.len());
        let back = json!({"from": "mesh", "by": by, "given": {"type": "function", "values": values.iter().map(|v| v.unwrap_or(0.0)).collect::<Vec<_>>()}});
        let back = numbers(&json_of(server.post(&path).json(&back).send().await.unwrap(), 200).await);
        // By points a vertex comes back with the number of one that shares its answer or lies near.
        let known: Vec<f64> = back.iter().flatten().copied().collect();
        let (least, most) = along.iter().fold((f64::MAX, f64::MIN), |(a, b), &x| (a.min(x), b.max(x)));
        assert_eq!(known.len(), along.len());
        assert!(by == "map" || known.iter().all(|x| (least..=most).contains(x)), "{by}");
        let constant =
            json!({"from": "sketch", "by": by, "given": {"type": "function", "values": vec![2.5; flat.len()]}});
        let moved = numbers(&json_of(server.post(&path).json(&constant).send().await.unwrap(), 200).await);
        assert!(by == "map" || moved.iter().flatten().all(|x| *x == 2.5));
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn what_takes_more_memory_than_there_is_is_answered_alone() {
    let server = Server::working_within(Config { max_reading_bytes: 1, ..Config::default() }).await;
    let matched = server.intrinsic_match(json!({})).await;
    let result = server.read(&format!("{matched}/result")).await;
    let [sketch, mesh] = ["sketch", "mesh"].map(|kind| format!("/v1/{kind}es/{}", result[kind].as_str().unwrap()));
    let mut paths: Vec<String> =
        ["inside", "inverse", "inverse?by=map", "picture", "mesh.glb"].map(|part| format!("{matched}/{part}")).into();
    for shape in [sketch, mesh] {
        paths.extend(["mesh", "picture"].map(|part| format!("{shape}/{part}")));
        paths.extend(["spectrum", "functions?kind=wave_kernel", "segmentation", "rebuilt"].map(|part| {
            let (part, query) = part.split_once('?').unwrap_or((part, ""));
            format!("{shape}/{part}?k=10&boundary=neumann&{query}")
        }));
    }
    // All at once: of those that held what another waits for none would be answered.
    let answers = paths.iter().map(|path| server.get(path).send());
    for (answer, path) in futures::future::join_all(answers).await.into_iter().zip(&paths) {
        let status = answer.unwrap().status();
        assert!([200, 202].contains(&status.as_u16()), "{path}: {status}");
    }
    let drawn = json!({"from": "sketch", "by": "map", "given": {"type": "labels", "values": vec![1; result["correspondences"].as_array().unwrap().len()]}});
    json_of(server.post(&format!("{matched}/transfers")).json(&drawn).send().await.unwrap(), 200).await;
    let labels = json!({"labels": {"sketch": [], "mesh": []}});
    problem_of(server.post(&format!("{matched}/evaluations")).json(&labels).send().await.unwrap(), 422).await;
}

#[tokio::test(flavor = "multi_thread")]
async fn what_is_taken_over_comes_as_a_coloured_mesh_and_as_an_array() {
    let server = Server::working().await;
    let matched = server.intrinsic_match(json!({})).await;
    let result = server.read(&format!("{matched}/result")).await;
    let m = result["correspondences"].as_array().unwrap().len();
    let path = format!("{matched}/transfers");
    let function = json!({"from": "sketch", "given": {"type": "function", "values": vec![1.5; m]}});
    let labels = json!({"from": "sketch", "given": {"type": "labels", "values": vec![3; m]}});
    let form =
        async |body: &Value, accept: &str| server.post(&path).json(body).header("accept", accept).send().await.unwrap();
    let glb = form(&labels, "model/gltf-binary").await;
    assert_eq!(header(&glb, "content-type"), "model/gltf-binary");
    assert_eq!(&glb.bytes().await.unwrap()[..4], b"glTF");
    assert_eq!(&form(&function, "application/x-npy").await.bytes().await.unwrap()[1..6], b"NUMPY");
    problem_of(form(&labels, "application/x-npy").await, 406).await;
    let moved = json_of(form(&labels, "application/json").await, 200).await;
    assert!(moved["values"].as_array().unwrap().iter().all(|label| *label == 3 || *label == -1));

    let inverse = server.read(&format!("{matched}/inverse")).await;
    let by_map = server.read(&format!("{matched}/inverse?by=map")).await;
    for inverse in [&inverse, &by_map] {
        let vertices: Vec<Option<usize>> = serde_json::from_value(inverse["sketch_vertices"].clone()).unwrap();
        assert!(vertices.iter().flatten().all(|v| *v < m) && vertices.iter().flatten().count() > vertices.len() / 4);
    }
    // An answered vertex goes back to a vertex that it answers.
    let answered = result["correspondences"][7]["mesh_vertex"].as_u64().unwrap() as usize;
    let back = inverse["sketch_vertices"][answered].as_u64().unwrap() as usize;
    assert_eq!(result["correspondences"][back]["mesh_vertex"], answered as u64);
}

#[tokio::test(flavor = "multi_thread")]
async fn the_colours_of_a_drawing_are_taken_to_the_mesh() {
    let server = Server::working().await;
    let mesh = server.mesh().await;
    let svg = r##"<svg xmlns="http://www.w3.org/2000/svg" width="400" height="220"><ellipse cx="200" cy="110" rx="180" ry="90" fill="#00aa22"/></svg>"##;
    let upload = server.post("/v1/sketches").header("content-type", "image/svg+xml").body(svg).send().await.unwrap();
    let request = json!({"mesh": mesh, "sketch": id(&upload.json().await.unwrap()), "preset": "thesis"});
    let asked = server.post("/v1/matches").json(&request).header("prefer", "wait=60").send().await.unwrap();
    let matched = json_of(asked, 200).await;
    assert_eq!(matched["status"], "succeeded", "{matched}");
    let path = format!("{}/transfers", matched["links"]["self"].as_str().unwrap());
    let drawing = json!({"from": "sketch", "given": {"type": "drawing"}});
    let moved = json_of(server.post(&path).json(&drawing).send().await.unwrap(), 200).await;
    let colours: Vec<Option<[f64; 3]>> = serde_json::from_value(moved["values"].clone()).unwrap();
    let green =
        colours.iter().flatten().filter(|[r, g, b]| *r < 0.1 && (g - 2.0 / 3.0).abs() < 0.05 && *b < 0.2).count();
    assert!(green * 5 > colours.len(), "{green} of {}", colours.len());

    let sketch = format!("/v1/sketches/{}", matched["sketch"].as_str().unwrap());
    assert_eq!(server.request("DELETE", &sketch).send().await.unwrap().status(), 204);
    let problem = problem_of(server.post(&path).json(&drawing).send().await.unwrap(), 422).await;
    assert_eq!(problem["errors"][0]["detail"], "the sketch of the match was deleted", "{problem}");
}

#[tokio::test(flavor = "multi_thread")]
async fn what_cannot_be_taken_over_is_refused_with_its_place() {
    let server = Server::working().await;
    let matched = server.intrinsic_match(json!({})).await;
    let path = format!("{matched}/transfers");
    let refused = async |body: Value| {
        let problem = problem_of(server.post(&path).json(&body).send().await.unwrap(), 422).await;
        problem["errors"][0]["pointer"].as_str().unwrap().to_owned()
    };
    let m = server.read(&format!("{matched}/result")).await["correspondences"].as_array().unwrap().len();
    let given = |from: &str, given: Value| json!({"from": from, "given": given});
    assert_eq!(refused(given("sketch", json!({"type": "function", "values": [1]}))).await, "/given/values");
    assert_eq!(refused(given("sketch", json!({"type": "labels", "values": vec![64; m]}))).await, "/given/values/0");
    assert_eq!(
        refused(given("sketch", json!({"type": "colours", "values": vec![[0, 0, 2]; m]}))).await,
        "/given/values/0"
    );
    assert_eq!(refused(given("sketch", json!({"type": "drawing"}))).await, "/given/type");
    assert_eq!(refused(given("mesh", json!({"type": "drawing"}))).await, "/given/type");
    let twins = json!({"from": "sketch", "both_sides": true, "given": {"type": "function", "values": vec![1; m]}});
    assert_eq!(refused(twins).await, "/both_sides");
    assert_eq!(refused(given("sky", json!({"type": "drawing"}))).await, "/from");
    let idle = Server::idle(Config::default()).await;
    let waiting = json_of(idle.request_match(json!({})).await.send().await.unwrap(), 202).await;
    let path = format!("{}/transfers", waiting["links"]["self"].as_str().unwrap());
    let body = given("sketch", json!({"type": "drawing"}));
    problem_of(idle.post(&path).json(&body).send().await.unwrap(), 409).await;
}
