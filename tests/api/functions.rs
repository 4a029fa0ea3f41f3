//! What shapes are described by, and what a match was computed from.

use serde_json::{Value, json};

use crate::server::{Server, header, problem_of};

/// What a call answers in a form once its spectrum is there.
async fn answered(server: &Server, path: &str, accept: &str) -> Vec<u8> {
    loop {
        let answer = server.get(path).header("accept", accept).send().await.unwrap();
        if answer.status() != 202 {
            assert_eq!((answer.status().as_u16(), header(&answer, "content-type")), (200, accept), "{path}");
            return answer.bytes().await.unwrap().to_vec();
        }
        tokio::task::yield_now().await;
    }
}

/// The shape that a file of numpy says it has.
fn shape(npy: &[u8]) -> String {
    let text = String::from_utf8_lossy(&npy[10..128]);
    text.split("'shape': ").nth(1).unwrap().split(", }").next().unwrap().to_owned()
}

#[tokio::test(flavor = "multi_thread")]
async fn functions_come_as_arrays_and_as_colours() {
    let server = Server::working().await;
    let (mesh, sketch) = (server.mesh().await, server.sketch().await);
    let vertices = async |path: String| server.read(&path).await["vertices"].as_array().unwrap().len();
    let n = vertices(format!("/v1/meshes/{mesh}/mesh")).await;
    let m = vertices(format!("/v1/sketches/{sketch}/mesh")).await;
    let of_mesh = |rest: &str| format!("/v1/meshes/{mesh}/{rest}");
    for (query, columns) in [
        ("kind=eigenfunctions&k=7", 7),
        ("kind=heat_kernel&count=5", 5),
        ("kind=wave_kernel&count=6&variance=2", 6),
        ("kind=global_point_signature&k=9", 8),
    ] {
        let file = answered(&server, &of_mesh(&format!("functions?{query}")), "application/x-npy").await;
        assert_eq!(shape(&file), format!("({n}, {columns})"), "{query}");
    }
    let path = format!("/v1/sketches/{sketch}/functions?kind=eigenfunctions&k=3&column=2&width=200");
    assert_eq!(shape(&answered(&server, &path, "application/x-npy").await), format!("({m}, 3)"));
    assert!(answered(&server, &path, "application/vnd.safetensors").await.len() > m * 3 * 8);
    assert_eq!(&answered(&server, &path, "image/png").await[1..4], b"PNG");
    assert_eq!(&answered(&server, &path, "model/gltf-binary").await[..4], b"glTF");
    let beyond = server.get(&path.replace("column=2", "column=3")).header("accept", "image/png");
    problem_of(beyond.send().await.unwrap(), 404).await;
    let of_constant = of_mesh("functions?kind=wave_kernel&k=1");
    assert_eq!(shape(&answered(&server, &of_constant, "application/x-npy").await), format!("({n}, 0)"));
    problem_of(server.get(&of_constant).header("accept", "image/png").send().await.unwrap(), 404).await;
    for wrong in ["kind=heat", "kind=heat_kernel&count=0", "kind=wave_kernel&variance=-1", "kind=eigenfunctions&k=0"] {
        problem_of(server.get(&of_mesh(&format!("functions?{wrong}"))).send().await.unwrap(), 422).await;
    }
    for (kind, parameter) in
        [("eigenfunctions", "count"), ("global_point_signature", "count"), ("heat_kernel", "variance")]
    {
        let answer = server.get(&of_mesh(&format!("functions?kind={kind}&{parameter}=3"))).send().await.unwrap();
        let problem = problem_of(answer, 422).await;
        assert_eq!(problem["errors"][0]["place"], format!("query parameter {parameter}"), "{kind}: {problem}");
    }

    let regions: Value =
        serde_json::from_slice(&answered(&server, &of_mesh("segmentation?regions=4"), "application/json").await)
            .unwrap();
    let labels: Vec<i64> = serde_json::from_value(regions["labels"].clone()).unwrap();
    let count = regions["regions"].as_i64().unwrap();
    assert!(
        labels.len() == n && (1..=4).contains(&count) && labels.iter().all(|l| (0..count).contains(l)),
        "{regions}"
    );
    assert_eq!(&answered(&server, &of_mesh("segmentation"), "image/png").await[1..4], b"PNG");
    problem_of(server.get(&of_mesh("segmentation?regions=65")).send().await.unwrap(), 422).await;

    assert_eq!(shape(&answered(&server, &of_mesh("rebuilt?k=5"), "application/x-npy").await), format!("({n}, 3)"));
    assert_eq!(&answered(&server, &of_mesh("rebuilt?k=5"), "model/gltf-binary").await[..4], b"glTF");
}

#[tokio::test(flavor = "multi_thread")]
async fn all_that_a_match_was_made_of_comes_in_one_file() {
    let server = Server::working().await;
    let matched = server.intrinsic_match(json!({})).await;
    let answer = server.get(&format!("{matched}/inside")).send().await.unwrap();
    assert_eq!(header(&answer, "content-type"), "application/vnd.safetensors");
    let bytes = answer.bytes().await.unwrap();
    let length = u64::from_le_bytes(bytes[..8].try_into().unwrap()) as usize;
    let head: Value = serde_json::from_slice(&bytes[8..8 + length]).unwrap();
    let result = server.read(&format!("{matched}/result")).await;
    let pairs = result["intermediate"]["regions"]["pairs"].as_array().unwrap().len();
    assert_eq!(head["a"]["shape"], json!([12, 201 * pairs]));
    assert_eq!(head["b"]["shape"], head["a"]["shape"]);
    for (name, shape) in [("w", [12, 12]), ("initial_c", [12, 12]), ("c", [12, 12])] {
        assert_eq!(head[name]["shape"], json!(shape));
    }
    let at = head["points"]["data_offsets"][0].as_u64().unwrap() as usize + 8 + length;
    let first = i32::from_le_bytes(bytes[at..at + 4].try_into().unwrap());
    assert_eq!(result["correspondences"][0]["mesh_vertex"], first);
    problem_of(server.get("/v1/matches/nobody/inside").send().await.unwrap(), 404).await;
}
