//! Poses of a matched mesh: the whole way, and every refusal.

use serde_json::{Value, json};
use sketchmatch::http::Config;

use crate::server::{Server, header, id, json_of, problem_of};

/// Where the ellipse that is matched ends, along x and along y.
pub async fn corners(server: &Server, result: &Value) -> [[f64; 2]; 2] {
    let sketch = server.read(&format!("/v1/sketches/{}/mesh", result["sketch"].as_str().unwrap())).await;
    let points: Vec<[f64; 2]> = serde_json::from_value(sketch["vertices"].clone()).unwrap();
    [f64::min as fn(f64, f64) -> f64, f64::max]
        .map(|pick| [0, 1].map(|axis| points.iter().map(|p| p[axis]).reduce(pick).unwrap()))
}

/// A request that bends the ellipse: its right end turned by each of the angles.
pub fn bend(matched: &str, [low, high]: [[f64; 2]; 2], degrees: &[f64]) -> Value {
    let at = |share: f64| [low[0] + share * (high[0] - low[0]), 0.5 * (low[1] + high[1])];
    let frames = degrees.iter().map(|degrees| {
        json!([
            {"type": "stay"}, {"type": "stay"}, {"type": "rotation", "degrees": degrees, "about": at(0.6)},
        ])
    });
    json!({
        "match": matched,
        "handles": [
            {"type": "point", "at": at(0.05)}, {"type": "bone", "from": at(0.3), "to": at(0.5)},
            {"type": "point", "at": at(0.95)},
        ],
        "frames": frames.collect::<Vec<Value>>(),
    })
}

#[tokio::test(flavor = "multi_thread")]
async fn a_pose_is_asked_for_followed_read_and_deleted() {
    let server = Server::working().await;
    let matched = server.finished_match().await;
    let result = server.read(&format!("{matched}/result")).await;
    let match_id = result["match"].as_str().unwrap();
    let request = bend(match_id, corners(&server, &result).await, &[0.0, 25.0]);

    let asked = server.post("/v1/poses?name=bent").json(&request).send().await.unwrap();
    assert_eq!(header(&asked, "retry-after"), "1");
    let path = header(&asked, "location").to_owned();
    let document = json_of(asked, 202).await;
    assert_eq!(path, format!("/v1/poses/{}", id(&document)));
    assert_eq!((&document["name"], &document["request"]["handles"]), (&json!("bent"), &request["handles"]));
    let events = server.get(&format!("{path}/events")).send().await.unwrap().text().await.unwrap();
    let last = events.lines().filter_map(|line| line.strip_prefix("data: ")).next_back().unwrap();
    assert_eq!(serde_json::from_str::<Value>(last).unwrap()["status"], "succeeded", "{events}");
    assert_eq!(server.read("/v1/poses").await["items"][0]["id"], document["id"]);
    assert_eq!(server.read("/v1/matches").await["items"].as_array().unwrap().len(), 1);
    assert_eq!(json_of(server.post(&format!("{path}/cancel")).send().await.unwrap(), 200).await["status"], "succeeded");

    let pose = server.read(&format!("{path}/result")).await;
    let mesh = server.read(&format!("/v1/meshes/{}/mesh", pose["mesh"].as_str().unwrap())).await;
    let rest: Vec<[f64; 3]> = serde_json::from_value(mesh["vertices"].clone()).unwrap();
    let frames: Vec<Vec<[f64; 3]>> = pose["frames"]
        .as_array()
        .unwrap()
        .iter()
        .map(|f| serde_json::from_value(f["positions"].clone()).unwrap())
        .collect();
    let moved = |frame: &[[f64; 3]]| {
        let each = frame.iter().zip(&rest).map(|(p, q)| (0..3).map(|i| (p[i] - q[i]).powi(2)).sum::<f64>().sqrt());
        each.fold(0.0, f64::max)
    };
    assert!(moved(&frames[0]) < 1e-8 && moved(&frames[1]) > 0.1);
    assert_eq!(pose["frames"][1]["strain"]["flipped_triangles"], 0);
    assert!(pose["frames"][1]["strain"]["volume_change"].as_f64().unwrap().abs() < 0.2);

    // The file itself: its comment, its quadrilaterals, and the vertices in their new places.
    let form = async |accept: &str, query: &str| {
        server.get(&format!("{path}/result{query}")).header("accept", accept).send().await.unwrap()
    };
    let obj = form("model/obj", "?frame=1").await.text().await.unwrap();
    assert!(obj.starts_with("# an ellipsoid\n") && obj.lines().any(|line| line.split(' ').count() == 5), "{obj}");
    let vertices: Vec<[f64; 3]> = obj
        .lines()
        .filter_map(|line| line.strip_prefix("v "))
        .map(|line| line.split(' ').map(|x| x.parse().unwrap()).collect::<Vec<f64>>().try_into().unwrap())
        .collect();
    assert_eq!(vertices, frames[1]);
    assert_eq!(&form("model/gltf-binary", "").await.bytes().await.unwrap()[..4], b"glTF");
    problem_of(form("text/csv", "").await, 406).await;
    problem_of(form("model/obj", "?frame=2").await, 404).await;
    let picture = server.get(&format!("{path}/picture?frame=1&width=400")).send().await.unwrap();
    assert_eq!(header(&picture, "content-type"), "image/png");
    let tag = header(&picture, "etag").to_owned();
    assert_eq!(&picture.bytes().await.unwrap()[1..4], b"PNG");
    let again = server.get(&format!("{path}/picture?frame=1&width=400")).header("if-none-match", tag);
    assert_eq!(again.send().await.unwrap().status(), 304);
    let basis = server.get(&format!("{path}/basis")).send().await.unwrap();
    assert_eq!(header(&basis, "content-type"), "application/vnd.safetensors");
    assert!(basis.bytes().await.unwrap().len() > rest.len() * 9 * 4);

    assert_eq!(server.request("DELETE", &path).send().await.unwrap().status(), 204);
    problem_of(server.get(&path).send().await.unwrap(), 404).await;
    problem_of(server.get(&format!("{matched}x")).send().await.unwrap(), 404).await;
}

#[tokio::test(flavor = "multi_thread")]
async fn the_mesh_takes_the_pose_of_the_drawing() {
    let server = Server::working().await;
    let result = server.read(&format!("{}/result", server.finished_match().await)).await;
    let request = json!({"match": result["match"], "sketch": result["sketch"]});
    let asked = server.post("/v1/poses").json(&request).header("prefer", "wait=60").send().await.unwrap();
    assert_eq!(header(&asked, "preference-applied"), "wait=60");
    let document = json_of(asked, 200).await;
    assert_eq!(document["status"], "succeeded", "{document}");
    let pose = server.read(document["links"]["result"].as_str().unwrap()).await;
    assert_eq!(pose["frames"][0]["strain"]["flipped_triangles"], 0);
    let path = document["links"]["self"].as_str().unwrap();
    problem_of(server.get(&format!("{path}/basis")).send().await.unwrap(), 409).await;
    // What a pose is called is no match, and the reverse.
    problem_of(server.get(&path.replace("poses", "matches")).send().await.unwrap(), 404).await;

    let other = json!({"match": result["match"], "sketch": "sketch_of_somebody"});
    let problem = problem_of(server.post("/v1/poses").json(&other).send().await.unwrap(), 422).await;
    assert_eq!(problem["errors"][0]["pointer"], "/sketch");
}

#[tokio::test(flavor = "multi_thread")]
async fn what_cannot_be_posed_is_refused_with_its_place() {
    let server = Server::working().await;
    let result = server.read(&format!("{}/result", server.finished_match().await)).await;
    let good = bend(result["match"].as_str().unwrap(), corners(&server, &result).await, &[10.0]);
    let refused = async |change: &dyn Fn(&mut Value)| {
        let mut request = good.clone();
        change(&mut request);
        let problem = problem_of(server.post("/v1/poses").json(&request).send().await.unwrap(), 422).await;
        problem["errors"][0]["pointer"].as_str().unwrap().to_owned()
    };
    let far = json!({"type": "point", "at": [1e6, 0]});
    let crossed = json!({"type": "cage", "points": [[-9e3, -9e3], [9e3, 9e3], [9e3, -9e3], [-9e3, 9e3]]});
    let singular = json!({"type": "affine", "matrix": [[1, 2, 0], [2, 4, 0]]});
    assert_eq!(refused(&|r| r["match"] = json!("nobody")).await, "/match");
    assert_eq!(refused(&|r| r["handles"][0] = far.clone()).await, "/handles/0/at");
    assert_eq!(refused(&|r| r["handles"][2] = r["handles"][0].clone()).await, "/handles/2");
    assert_eq!(refused(&|r| r["handles"][1] = crossed.clone()).await, "/handles/1/points/0");
    assert_eq!(refused(&|r| r["frames"][0][1] = singular.clone()).await, "/frames/0/1/matrix");
    assert_eq!(refused(&|r| r["frames"][0] = json!([])).await, "/frames/0");
    assert_eq!(refused(&|r| r["frames"] = json!(vec![r["frames"][0].clone(); 241])).await, "/frames");
    assert_eq!(refused(&|r| r["handles"][0]["type"] = json!("hook")).await, "/handles/0/type");
    assert_eq!(refused(&|r| r["frames"][0][0]["by"] = json!(1)).await, "/frames/0/0/by");
    assert_eq!(refused(&|r| r["limbs"] = json!(1)).await, "/limbs");

    let idle = Server::idle(Config::default()).await;
    let waiting = json_of(idle.request_match(json!({})).await.send().await.unwrap(), 202).await;
    let request = json!({"match": waiting["id"], "sketch": waiting["sketch"]});
    let problem = problem_of(idle.post("/v1/poses").json(&request).send().await.unwrap(), 422).await;
    assert_eq!(problem["errors"][0], json!({"pointer": "/match", "detail": "the match is not finished"}));
}
