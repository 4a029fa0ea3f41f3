//! Meshes and sketches in every form they may arrive in.

use image::ImageFormat;
use reqwest::multipart::{Form, Part};
use serde_json::json;
use sketchmatch::http::Config;

use crate::drawings::{SQUARE_SVG, disk, ellipse, ellipsoid, encoded};
use crate::server::{Server, header, id, json_of, problem_of};

#[tokio::test(flavor = "multi_thread")]
async fn the_same_mesh_is_stored_once() {
    let server = Server::idle(Config::default()).await;
    let upload = || server.post("/v1/meshes?format=obj&name=ellipsoid").body(ellipsoid(16, 12)).send();
    let first = upload().await.unwrap();
    let location = header(&first, "location").to_owned();
    let first = json_of(first, 201).await;
    assert_eq!(location, format!("/v1/meshes/{}", id(&first)));
    let measures =
        json!([first["vertices"], first["triangles"], first["components"], first["boundary_edges"], first["closed"]]);
    assert_eq!(measures, json!([178, 352, 1, 0, true]));
    assert_eq!(first["name"], "ellipsoid");
    assert_eq!(json_of(upload().await.unwrap(), 200).await, first);
    assert_eq!(server.read(&location).await, first);
    assert_eq!(server.read("/v1/meshes").await["items"], json!([first]));
    let mesh = server.read(&format!("{location}/mesh")).await;
    assert_eq!(mesh["vertices"][0], json!([0.0, 0.0, 0.4]));
    assert_eq!(mesh["triangles"].as_array().unwrap().len(), 352);
}

#[tokio::test(flavor = "multi_thread")]
async fn a_mesh_comes_raw_or_in_a_form_and_tells_its_format() {
    let server = Server::idle(Config::default()).await;
    let off = "OFF\n4 4 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n";
    let sniffed = json_of(server.post("/v1/meshes").body(off).send().await.unwrap(), 201).await;
    let file = Part::text(off).file_name("tetrahedron.off");
    let form = server.post("/v1/meshes").multipart(Form::new().part("file", file)).send().await.unwrap();
    assert_eq!(id(&json_of(form, 200).await), id(&sniffed));
    let file = Part::text(ellipsoid(8, 6)).file_name("ellipsoid.obj");
    let form = server.post("/v1/meshes").multipart(Form::new().part("file", file)).send().await.unwrap();
    assert_eq!(json_of(form, 201).await["name"], "ellipsoid.obj");
    // What somebody called it stays, and folders are nobody's business.
    let named = server.post("/v1/meshes?name=mine").header("content-type", "model/obj").body(ellipsoid(8, 6));
    assert_eq!(json_of(named.send().await.unwrap(), 200).await["name"], "mine");
    for (path, rings, status, name) in [
        ("other.obj", 6, 200, json!("mine")),
        ("/home/me/models/b.obj", 7, 201, json!("b.obj")),
        ("C:\\models\\c.obj", 8, 201, json!("c.obj")),
        ("", 9, 201, json!(null)),
    ] {
        let file = Part::text(ellipsoid(8, rings)).file_name(path);
        let form = server.post("/v1/meshes?format=obj").multipart(Form::new().part("file", file)).send().await.unwrap();
        assert_eq!(json_of(form, status).await["name"], name, "{path}");
    }
    let typed =
        server.post("/v1/meshes").header("content-type", "model/obj").body(ellipsoid(8, 6)).send().await.unwrap();
    json_of(typed, 200).await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_form_may_be_as_large_as_a_raw_body() {
    let server = Server::idle(Config { max_upload_bytes: 5 << 20, ..Config::default() }).await;
    let form = |length: usize| {
        let mesh = format!("{}{}", ellipsoid(8, 6), "# a line of nothing\n".repeat(length / 20));
        server.post("/v1/meshes").multipart(Form::new().part("file", Part::text(mesh).file_name("ellipsoid.obj")))
    };
    json_of(form(4 << 20).send().await.unwrap(), 201).await;
    assert_eq!(problem_of(form(6 << 20).send().await.unwrap(), 413).await["status"], 413);
}

#[tokio::test(flavor = "multi_thread")]
async fn a_sketch_keeps_the_coordinates_of_its_upload() {
    let server = Server::idle(Config::default()).await;
    let outline = server.post("/v1/sketches").json(&ellipse()).send().await.unwrap();
    let location = header(&outline, "location").to_owned();
    let outline = json_of(outline, 201).await;
    assert_eq!(server.read(&location).await, outline);
    assert_eq!(server.read("/v1/sketches").await["items"], json!([outline]));
    let vertices = server.read(&format!("{location}/mesh")).await["vertices"].clone();
    let (low, high) = bounds(&vertices);
    assert!((low[0] + 100.0).abs() < 1e-6 && (high[0] - 100.0).abs() < 1e-6, "{low:?} {high:?}");

    let svg = server.post("/v1/sketches?target_vertices=60").header("content-type", "image/svg+xml").body(SQUARE_SVG);
    let svg = json_of(svg.send().await.unwrap(), 201).await;
    let (low, high) = bounds(&server.read(&format!("/v1/sketches/{}/mesh", id(&svg))).await["vertices"]);
    assert!(
        [low[0] - 10.0, low[1] - 10.0, high[0] - 90.0, high[1] - 90.0].iter().all(|d| d.abs() < 0.1),
        "{low:?} {high:?}"
    );
}

#[tokio::test(flavor = "multi_thread")]
async fn a_picture_is_a_sketch() {
    let server = Server::idle(Config::default()).await;
    for (media_type, format) in [("image/png", ImageFormat::Png), ("image/jpeg", ImageFormat::Jpeg)] {
        let upload = server.post("/v1/sketches?target_vertices=100").header("content-type", media_type);
        let sketch = json_of(upload.body(encoded(disk(), format)).send().await.unwrap(), 201).await;
        let expected = std::f64::consts::PI * 20.0 * 20.0;
        assert!((sketch["area"].as_f64().unwrap() / expected - 1.0).abs() < 0.1, "{sketch}");
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn a_sketch_tells_what_it_is_where_its_type_does_not() {
    let server = Server::idle(Config::default()).await;
    let json = [b"\xef\xbb\xbf".to_vec(), ellipse().to_string().into_bytes()].concat();
    let files = [SQUARE_SVG.as_bytes().to_vec(), encoded(disk(), ImageFormat::Png), encoded(disk(), ImageFormat::Jpeg)];
    for file in files.into_iter().chain([json.clone()]) {
        for media_type in [None, Some("application/octet-stream"), Some("application/x-www-form-urlencoded")] {
            let upload = server.post("/v1/sketches").body(file.clone());
            let upload = media_type.into_iter().fold(upload, |upload, name| upload.header("content-type", name));
            let answer = upload.send().await.unwrap();
            assert!(answer.status().is_success(), "{media_type:?} {:?}", answer.text().await);
        }
    }
    let jpeg = encoded(disk(), ImageFormat::Jpeg);
    for (media_type, body) in [("image/jpg", jpeg), ("application/json; charset=utf-8", json)] {
        let upload =
            server.post("/v1/sketches").header("content-type", media_type).header("content-encoding", "identity");
        assert!(upload.body(body).send().await.unwrap().status().is_success(), "{media_type}");
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn a_file_whose_lines_were_joined_by_its_client_is_told_of() {
    let server = Server::idle(Config::default()).await;
    let joined = ellipsoid(8, 6).replace('\n', "");
    let upload = server.post("/v1/meshes?format=obj").header("content-type", "application/x-www-form-urlencoded");
    let problem = problem_of(upload.body(joined.clone()).send().await.unwrap(), 422).await;
    assert!(problem["errors"][2]["detail"].as_str().unwrap().contains("--data-binary"), "{problem}");
    let problem = problem_of(server.post("/v1/meshes?format=obj").body(joined).send().await.unwrap(), 422).await;
    assert_eq!(problem["errors"].as_array().unwrap().len(), 2, "{problem}");
}

#[tokio::test(flavor = "multi_thread")]
async fn how_a_body_may_be_encoded_is_told() {
    let server = Server::idle(Config::default()).await;
    let zipped = server.post("/v1/meshes?format=obj").header("content-encoding", "gzip").body("zipped");
    let refused = zipped.send().await.unwrap();
    assert_eq!(header(&refused, "accept-encoding"), "identity");
    problem_of(refused, 415).await;
}

#[tokio::test(flavor = "multi_thread")]
async fn an_outline_may_run_either_way() {
    let server = Server::idle(Config::default()).await;
    let mut clockwise = ellipse();
    clockwise["outline"].as_array_mut().unwrap().reverse();
    let sketch = json_of(server.post("/v1/sketches").json(&clockwise).send().await.unwrap(), 201).await;
    assert_eq!(sketch["warnings"], json!([]));
}

fn bounds(vertices: &serde_json::Value) -> ([f64; 2], [f64; 2]) {
    let points: Vec<[f64; 2]> = serde_json::from_value(vertices.clone()).unwrap();
    let extreme = |pick: fn(f64, f64) -> f64, start: f64| {
        points.iter().fold([start; 2], |found, point| [pick(found[0], point[0]), pick(found[1], point[1])])
    };
    (extreme(f64::min, f64::INFINITY), extreme(f64::max, f64::NEG_INFINITY))
}

/// The same square, once with a face that is stated twice.
const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n";
const SQUARE_TWICE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\nf 1 2 3 4\n";

#[tokio::test(flavor = "multi_thread")]
async fn an_answer_tells_of_its_own_upload() {
    let server = Server::idle(Config::default()).await;
    let upload = async |name: &str, obj: &'static str, status| {
        let request = server.post(&format!("/v1/meshes?format=obj{name}")).body(obj);
        json_of(request.send().await.unwrap(), status).await
    };
    let clean = upload("&name=clean", SQUARE, 201).await;
    let mended = upload("&name=mended", SQUARE_TWICE, 201).await;
    assert_eq!((&clean["name"], &mended["name"]), (&json!("clean"), &json!("mended")));
    assert_eq!(clean["warnings"], json!([]));
    assert_eq!(mended["warnings"].as_array().unwrap().len(), 1, "{mended}");
    assert_ne!(clean["id"], mended["id"]);
    let renamed = upload("&name=renamed", SQUARE, 200).await;
    assert_eq!((&renamed["name"], &renamed["id"]), (&json!("renamed"), &clean["id"]));
    assert_eq!(upload("", SQUARE, 200).await, renamed);
    assert_eq!(server.read(&format!("/v1/meshes/{}", id(&mended))).await, mended);
    let vertices = async |mesh| server.read(&format!("/v1/meshes/{}/mesh", id(mesh))).await["vertices"].clone();
    assert_eq!(vertices(&clean).await, vertices(&mended).await);
}

#[tokio::test(flavor = "multi_thread")]
async fn a_shape_is_renamed_and_deleted() {
    let server = Server::idle(Config::default()).await;
    for path in [format!("/v1/meshes/{}", server.mesh().await), format!("/v1/sketches/{}", server.sketch().await)] {
        let rename = async |body: serde_json::Value| server.request("PATCH", &path).json(&body).send().await.unwrap();
        let renamed = json_of(rename(json!({"name": "other"})).await, 200).await;
        assert_eq!(renamed["name"], "other");
        assert_eq!(server.read(&path).await, renamed);
        for body in [json!({}), json!({"name": "x".repeat(201)}), json!({"name": "x", "id": "y"})] {
            problem_of(rename(body).await, 422).await;
        }
        assert_eq!(json_of(rename(json!({"name": null})).await, 200).await.get("name"), None);
        let delete = async || server.request("DELETE", &path).send().await.unwrap();
        assert_eq!(delete().await.status(), 204);
        problem_of(delete().await, 404).await;
        problem_of(rename(json!({"name": "x"})).await, 404).await;
        problem_of(server.get(&path).send().await.unwrap(), 404).await;
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn a_shape_stays_while_a_match_needs_it() {
    let server = Server::idle(Config::default()).await;
    let asked = server.request_match(json!({})).await.send().await.unwrap();
    let job = header(&asked, "location").to_owned();
    let path = format!("/v1/meshes/{}", server.mesh().await);
    let delete = async |path: &str| server.request("DELETE", path).send().await.unwrap();
    let refused = problem_of(delete(&path).await, 409).await;
    assert!(refused["detail"].as_str().unwrap().contains("has not ended"), "{refused}");
    assert_eq!(delete(&job).await.status(), 200);
    assert_eq!(delete(&path).await.status(), 204);
    let refused = server.request_match(json!({})).await.send().await.unwrap();
    assert_eq!(refused.status(), 202, "the mesh was uploaded again");
}

#[tokio::test(flavor = "multi_thread")]
async fn triangles_come_as_text_and_as_bytes() {
    let server = Server::idle(Config::default()).await;
    let paths =
        [format!("/v1/meshes/{}/mesh", server.mesh().await), format!("/v1/sketches/{}/mesh", server.sketch().await)];
    for (path, coordinates) in paths.iter().zip([3, 2]) {
        let json = server.read(path).await;
        let vertices: Vec<Vec<f64>> = serde_json::from_value(json["vertices"].clone()).unwrap();
        let bytes = async |accept: &str| {
            let answer = server.get(path).header("accept", accept).send().await.unwrap();
            assert_eq!((answer.status().as_u16(), header(&answer, "content-type")), (200, accept));
            answer.bytes().await.unwrap()
        };
        let flat: Vec<u8> = vertices.iter().flatten().flat_map(|x| x.to_le_bytes()).collect();
        assert!(bytes("application/x-npy").await.ends_with(&flat));
        let file = bytes("application/vnd.safetensors").await;
        let tensors = safetensors::SafeTensors::deserialize(&file).unwrap();
        let (found, triangles) = (tensors.tensor("vertices").unwrap(), tensors.tensor("triangles").unwrap());
        assert_eq!((found.shape(), found.data()), ([vertices.len(), coordinates].as_slice(), flat.as_slice()));
        assert_eq!(triangles.shape(), [json["triangles"].as_array().unwrap().len(), 3]);
    }
    let file = server.get(&paths[0]).header("accept", "model/gltf-binary").send().await.unwrap().bytes().await.unwrap();
    let document = gltf::Gltf::from_slice(&file).unwrap();
    assert_eq!(document.accessors().next().unwrap().count(), 16 * 11 + 2);
    problem_of(server.get(&paths[1]).header("accept", "model/gltf-binary").send().await.unwrap(), 406).await;
}
