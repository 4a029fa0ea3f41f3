//! Pictures of matches.

use image::GenericImageView;
use serde_json::json;
use sketchmatch::http::Config;
use sketchmatch::mesh::formats::{Format, Limits};
use sketchmatch::mesh::validation::import;
use sketchmatch::picture::WIDTH;

use crate::server::{Server, header, json_of, problem_of};

const PICTURES: [&str; 2] = ["picture", "matrix"];

#[tokio::test(flavor = "multi_thread")]
async fn a_match_is_seen_as_png_and_svg() {
    let server = Server::working().await;
    let path = server.finished_match().await;
    for name in PICTURES {
        let address = format!("{path}/{name}");
        assert_eq!(server.read(&path).await["links"][name], address);
        for (query, accept, expected) in [
            ("", "*/*", "image/png"),
            ("", "image/svg+xml", "image/svg+xml"),
            ("?format=svg", "image/png", "image/svg+xml"),
            ("?format=png", "application/json", "image/png"),
        ] {
            let answer = server.get(&format!("{address}{query}")).header("accept", accept).send().await.unwrap();
            assert_eq!((answer.status().as_u16(), header(&answer, "content-type")), (200, expected), "{name}{query}");
            let body = answer.bytes().await.unwrap();
            if expected == "image/png" {
                let (width, height) = image::load_from_memory(&body).unwrap().dimensions();
                let fits = if name == "picture" {
                    width == WIDTH && height <= WIDTH * 2 / 5
                } else {
                    (width, height) == (800, 752)
                };
                assert!(fits, "{name}: {width} × {height}");
            } else {
                usvg::Tree::from_data(&body, &usvg::Options::default()).unwrap();
            }
        }
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn the_coloured_mesh_is_the_uploaded_one() {
    let server = Server::working().await;
    let path = server.finished_match().await;
    let answer = server.get(&format!("{path}/mesh.glb")).send().await.unwrap();
    assert_eq!((answer.status().as_u16(), header(&answer, "content-type")), (200, "model/gltf-binary"));
    let file = answer.bytes().await.unwrap();
    let result = server.get(&format!("{path}/result")).header("accept", "model/gltf-binary").send().await.unwrap();
    assert_eq!(result.bytes().await.unwrap(), file);

    let mesh = import(&file, Format::Glb, &Limits::default()).unwrap().mesh;
    let id = server.read(&format!("{path}/result")).await["mesh"].as_str().unwrap().to_owned();
    let uploaded = server.read(&format!("/v1/meshes/{id}/mesh")).await;
    assert_eq!(json!(mesh.triangles()), uploaded["triangles"]);
    for (position, expected) in mesh.positions().iter().zip(uploaded["vertices"].as_array().unwrap()) {
        assert!((0..3).all(|i| (position[i] - expected[i].as_f64().unwrap()).abs() < 1e-6));
    }
    let document = gltf::Gltf::from_slice(&file).unwrap();
    let primitive = document.meshes().next().unwrap().primitives().next().unwrap();
    let colours: Vec<[f32; 3]> =
        primitive.reader(|_| document.blob.as_deref()).read_colors(0).unwrap().into_rgb_f32().collect();
    assert_eq!(colours.len(), mesh.positions().len());
    assert!(colours.iter().any(|colour| *colour != colours[0]));
}

#[tokio::test(flavor = "multi_thread")]
async fn a_match_without_a_view_is_seen_too() {
    let server = Server::working().await;
    let request = server.request_match(json!({"preset": "thesis"})).await.header("prefer", "wait=60");
    let document = json_of(request.send().await.unwrap(), 200).await;
    let path = document["links"]["picture"].as_str().unwrap();
    let picture = server.get(path).send().await.unwrap().bytes().await.unwrap();
    assert_eq!(image::load_from_memory(&picture).unwrap().width(), WIDTH);
}

#[tokio::test(flavor = "multi_thread")]
async fn a_picture_known_to_the_client_is_not_sent_again() {
    let server = Server::working().await;
    let path = server.finished_match().await;
    for name in ["picture", "picture?format=svg", "matrix", "mesh.glb"] {
        let first = server.get(&format!("{path}/{name}")).send().await.unwrap();
        let tag = header(&first, "etag").to_owned();
        assert!(tag.starts_with('"'), "{name}: {tag}");
        let again = server.get(&format!("{path}/{name}")).header("if-none-match", &tag).send().await.unwrap();
        assert_eq!((again.status().as_u16(), header(&again, "etag")), (304, tag.as_str()), "{name}");
        assert!(again.bytes().await.unwrap().is_empty());
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn what_has_no_result_has_no_picture() {
    let server = Server::idle(Config::default()).await;
    let asked = server.request_match(json!({})).await.send().await.unwrap();
    let path = header(&asked, "location").to_owned();
    for name in ["picture", "matrix", "mesh.glb"] {
        let waiting = server.get(&format!("{path}/{name}")).send().await.unwrap();
        assert_eq!(header(&waiting, "retry-after"), "1");
        problem_of(waiting, 409).await;
        problem_of(server.get(&format!("/v1/matches/nothing/{name}")).send().await.unwrap(), 404).await;
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn other_forms_are_refused_with_their_place() {
    let server = Server::idle(Config::default()).await;
    let asked = server.request_match(json!({})).await.send().await.unwrap();
    let path = header(&asked, "location").to_owned();
    for name in PICTURES {
        let foreign = server.get(&format!("{path}/{name}")).header("accept", "image/webp").send().await.unwrap();
        assert_eq!(problem_of(foreign, 406).await["errors"][0]["place"], "header accept");
        for (query, place) in [("format=webp", "query parameter format"), ("size=5", "query parameter size")] {
            let unknown = server.get(&format!("{path}/{name}?{query}")).send().await.unwrap();
            assert_eq!(problem_of(unknown, 422).await["errors"][0]["place"], place);
        }
    }
    let foreign = server.get(&format!("{path}/mesh.glb")).header("accept", "model/obj").send().await.unwrap();
    problem_of(foreign, 406).await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_picture_is_as_wide_as_asked_and_shows_the_answer_asked_for() {
    let server = Server::working().await;
    let path = server.finished_match().await;
    let alternatives = server.read(&format!("{path}/result")).await["alternatives"].as_array().unwrap().len();
    assert!(alternatives > 0);
    let bytes = async |name: &str| server.get(&format!("{path}/{name}")).send().await.unwrap().bytes().await.unwrap();
    assert_eq!(image::load_from_memory(&bytes("picture?width=320").await).unwrap().width(), 320);
    for name in ["picture", "mesh.glb"] {
        assert_ne!(bytes(name).await, bytes(&format!("{name}?alternative=0")).await, "{name}");
        let beyond = server.get(&format!("{path}/{name}?alternative={alternatives}")).send().await.unwrap();
        assert_eq!(problem_of(beyond, 404).await["errors"][0]["place"], "query parameter alternative");
    }
    let narrow = server.get(&format!("{path}/picture?width=99")).send().await.unwrap();
    assert_eq!(problem_of(narrow, 422).await["errors"][0]["place"], "query parameter width");
}

#[tokio::test(flavor = "multi_thread")]
async fn a_mesh_is_seen_by_itself() {
    let server = Server::idle(Config::default()).await;
    let path = format!("/v1/meshes/{}/picture", server.mesh().await);
    for (query, form, width) in [("", "image/png", 400), ("?format=svg&width=200", "image/svg+xml", 200)] {
        let answer = server.get(&format!("{path}{query}")).send().await.unwrap();
        assert_eq!(header(&answer, "content-type"), form);
        let body = answer.bytes().await.unwrap();
        let found = match form {
            "image/png" => image::load_from_memory(&body).unwrap().width(),
            _ => usvg::Tree::from_data(&body, &usvg::Options::default()).unwrap().size().width() as u32,
        };
        assert_eq!(found, width);
    }
}
