//! Matches judged by what is known.

use serde_json::{Value, json};
use sketchmatch::http::Config;

use crate::server::{Server, header, json_of, problem_of};

#[tokio::test(flavor = "multi_thread")]
async fn a_match_is_judged_by_pairs_in_every_form() {
    let server = Server::working().await;
    let matched = server.intrinsic_match(json!({})).await;
    let result = server.read(&format!("{matched}/result")).await;
    let points: Vec<&Value> = result["correspondences"].as_array().unwrap().iter().step_by(20).collect();
    let pairs = |vertices: Vec<Value>| {
        let points: Vec<&Value> = points.iter().map(|point| &point["point"]).collect();
        json!({"pairs": {"side": false, "points": points, "variants": {"front": vertices}}})
    };
    let right = pairs(points.iter().map(|point| point["mesh_vertex"].clone()).collect());
    let path = format!("{matched}/evaluations");
    let judged = json_of(server.post(&path).json(&right).send().await.unwrap(), 200).await;
    assert_eq!((&judged["pairs"]["coherent"]["mean"], &judged["pairs"]["coherent"]["auc"]), (&json!(0.0), &json!(1.0)));
    assert_eq!(judged["pairs"]["points"].as_array().unwrap().len(), points.len());

    // Held to one vertex, points lie up to half the way round the ellipsoid away.
    let one = pairs(vec![json!(0); points.len()]);
    let judged = json_of(server.post(&path).json(&one).send().await.unwrap(), 200).await;
    let mean = judged["pairs"]["coherent"]["mean"].as_f64().unwrap();
    assert!((0.2..2.0).contains(&mean), "{mean}");
    for (accept, begins) in [("text/csv", &b"point,x,y,"[..]), ("image/svg+xml", b"<svg"), ("image/png", b"\x89PNG")] {
        let answer = server.post(&path).json(&one).header("accept", accept).send().await.unwrap();
        assert_eq!((header(&answer, "content-type"), header(&answer, "etag")), (accept, ""));
        assert!(answer.bytes().await.unwrap().starts_with(begins), "{accept}");
    }

    problem_of(server.post(&format!("{path}?alternative=0")).json(&right).send().await.unwrap(), 404).await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_match_is_judged_by_labels() {
    let server = Server::working().await;
    let matched = server.intrinsic_match(json!({})).await;
    let result = server.read(&format!("{matched}/result")).await;
    let mesh = server.read(&format!("/v1/meshes/{}/mesh", result["mesh"].as_str().unwrap())).await;
    let vertices = mesh["vertices"].as_array().unwrap().len();
    let points = result["correspondences"].as_array().unwrap().len();
    let path = format!("{matched}/evaluations");
    let labels = json!({"labels": {"sketch": vec![3; points], "mesh": vec![3; vertices]}});
    let judged = json_of(server.post(&path).json(&labels).send().await.unwrap(), 200).await;
    assert_eq!((&judged["labels"]["share"], &judged["labels"]["right"]), (&json!(1.0), &json!(points)));
    let picture = server.post(&path).json(&labels).header("accept", "image/png").send().await.unwrap();
    problem_of(picture, 406).await;
}

#[tokio::test(flavor = "multi_thread")]
async fn what_does_not_fit_is_refused_with_its_place() {
    let server = Server::working().await;
    let path = format!("{}/evaluations", server.intrinsic_match(json!({})).await);
    let refused = async |body: Value| {
        let problem = problem_of(server.post(&path).json(&body).send().await.unwrap(), 422).await;
        problem["errors"][0]["pointer"].as_str().unwrap().to_owned()
    };
    let pairs =
        |points: Value, front: Value| json!({"pairs": {"side": true, "points": points, "variants": {"front": front}}});
    assert_eq!(refused(pairs(json!([]), json!([]))).await, "/pairs/points");
    assert_eq!(refused(pairs(json!([[0, 0]]), json!([1_000_000]))).await, "/pairs/variants/front/0");
    assert_eq!(refused(pairs(json!([[0, 0]]), json!([1.5]))).await, "/pairs/variants/front/0");
    assert_eq!(refused(pairs(json!([[9000, 0]]), json!([0]))).await, "/pairs/points");
    assert_eq!(refused(json!({"pairs": {"points": [[0, 0]], "variants": {}}})).await, "/pairs/side");
    assert_eq!(refused(json!({"labels": {"sketch": [0], "mesh": [0]}})).await, "/labels/sketch");
    let idle = Server::idle(Config::default()).await;
    let waiting = json_of(idle.request_match(json!({})).await.send().await.unwrap(), 202).await;
    let path = format!("{}/evaluations", waiting["links"]["self"].as_str().unwrap());
    problem_of(idle.post(&path).json(&pairs(json!([[0, 0]]), json!([0]))).send().await.unwrap(), 409).await;
}
