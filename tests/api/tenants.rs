//! A tenant sees its own only, and learns nothing of what others have.

use std::collections::BTreeSet;
use std::num::NonZeroU32;
use std::time::{Duration, SystemTime};

use futures::future::join_all;
use reqwest::RequestBuilder;
use serde_json::{Value, json};
use sketchmatch::http::Config;
use sketchmatch::http::admission::Admission;
use sketchmatch::http::limits::TenantLimits;

use crate::drawings;
use crate::poses::{bend, corners};
use crate::server::{Server, header, id, json_of, problem_of};

/// A call to be made with one key after another.
struct Call {
    operation: &'static str,
    method: &'static str,
    path: String,
    body: Body,
    /// Status of the answer to the tenant whose everything is, and to another.
    own: u16,
    other: u16,
}

enum Body {
    None,
    Json(Value),
    File(String),
}

impl Call {
    fn with(&self, server: &Server, key: Option<&str>) -> RequestBuilder {
        let request = server.request_with(key, self.method, &self.path);
        match &self.body {
            Body::None => request,
            Body::Json(body) => request.json(body),
            Body::File(file) => request.body(file.clone()),
        }
    }
}

fn call(operation: &'static str, method: &'static str, path: String, own: u16, other: u16) -> Call {
    Call { operation, method, path, body: Body::None, own, other }
}

/// Every call there is, of a mesh, a sketch, a match and a pose; those that end something last.
fn calls(mesh: &str, sketch: &str, matched: &str, pose: &str, bent: Value, places: &Value) -> Vec<Call> {
    let get = |operation, path: String, other| call(operation, "GET", path, 200, other);
    let ended = |operation, path: String| call(operation, "DELETE", path, 204, 404);
    let cancelled = |operation, path: String| call(operation, "POST", path, 200, 404);
    let json = |call: Call, body| Call { body: Body::Json(body), ..call };
    let name = json!({"name": "mine"});
    let asked = json!({"mesh": mesh, "sketch": sketch});
    let sweep = json!({"request": asked, "pointer": "/basis/k", "values": [10]});
    let along: Vec<&Value> = places.as_array().unwrap().iter().map(|place| &place[0]).collect();
    let function = json!({"from": "sketch", "by": "points", "given": {"type": "function", "values": along}});
    let known = json!({"pairs": {"side": false, "points": [places[0]], "variants": {"front": [0]}}});
    let uploaded = call("upload_mesh", "POST", "/v1/meshes?format=obj".to_owned(), 200, 201);
    vec![
        Call { body: Body::File(drawings::ellipsoid(16, 12)), ..uploaded },
        json(call("upload_sketch", "POST", "/v1/sketches".to_owned(), 200, 201), drawings::ellipse()),
        get("list_meshes", "/v1/meshes".to_owned(), 200),
        get("list_sketches", "/v1/sketches".to_owned(), 200),
        get("list_matches", "/v1/matches".to_owned(), 200),
        get("list_poses", "/v1/poses".to_owned(), 200),
        get("list_examples", "/v1/examples".to_owned(), 200),
        get("read_example_mesh", "/v1/examples/biped/mesh".to_owned(), 200),
        get("read_example_sketch", "/v1/examples/biped/sketch".to_owned(), 200),
        get("list_regularisers", "/v1/regularisers".to_owned(), 200),
        get("read_regulariser", "/v1/regularisers/l1".to_owned(), 200),
        get("read_mesh", format!("/v1/meshes/{mesh}"), 404),
        get("read_mesh_geometry", format!("/v1/meshes/{mesh}/mesh"), 404),
        get("read_mesh_components", format!("/v1/meshes/{mesh}/components"), 404),
        get("read_mesh_spectrum", format!("/v1/meshes/{mesh}/spectrum?k=20"), 404),
        get("draw_mesh", format!("/v1/meshes/{mesh}/picture?width=100"), 404),
        get("read_sketch", format!("/v1/sketches/{sketch}"), 404),
        get("read_sketch_geometry", format!("/v1/sketches/{sketch}/mesh"), 404),
        get("read_sketch_spectrum", format!("/v1/sketches/{sketch}/spectrum?k=20"), 404),
        get("draw_sketch", format!("/v1/sketches/{sketch}/picture?width=100"), 404),
        json(call("rename_mesh", "PATCH", format!("/v1/meshes/{mesh}"), 200, 404), name.clone()),
        json(call("rename_sketch", "PATCH", format!("/v1/sketches/{sketch}"), 200, 404), name),
        get("sign_mesh", format!("/v1/meshes/{mesh}/links"), 404),
        get("sign_sketch", format!("/v1/sketches/{sketch}/links"), 404),
        get("sign_match", format!("/v1/matches/{matched}/links"), 404),
        get("sign_pose", format!("/v1/poses/{pose}/links"), 404),
        get("read_match", format!("/v1/matches/{matched}"), 404),
        get("follow_match", format!("/v1/matches/{matched}/events"), 404),
        get("read_result", format!("/v1/matches/{matched}/result"), 404),
        get("draw_match", format!("/v1/matches/{matched}/picture?width=100"), 404),
        get("draw_matrix", format!("/v1/matches/{matched}/matrix"), 404),
        get("read_match_mesh", format!("/v1/matches/{matched}/mesh.glb"), 404),
        get("read_pose", format!("/v1/poses/{pose}"), 404),
        get("follow_pose", format!("/v1/poses/{pose}/events"), 404),
        get("read_pose_result", format!("/v1/poses/{pose}/result"), 404),
        get("read_pose_basis", format!("/v1/poses/{pose}/basis"), 404),
        get("draw_pose", format!("/v1/poses/{pose}/picture?width=100"), 404),
        get("list_terms", "/v1/terms".to_owned(), 200),
        get("list_bases", "/v1/bases".to_owned(), 200),
        get("read_inside", format!("/v1/matches/{matched}/inside"), 404),
        get("read_inverse", format!("/v1/matches/{matched}/inverse"), 404),
        get("read_mesh_functions", format!("/v1/meshes/{mesh}/functions?kind=eigenfunctions&k=20"), 404),
        get("read_mesh_segmentation", format!("/v1/meshes/{mesh}/segmentation?regions=4&k=20"), 404),
        get("rebuild_mesh", format!("/v1/meshes/{mesh}/rebuilt?k=20"), 404),
        get("read_sketch_functions", format!("/v1/sketches/{sketch}/functions?kind=eigenfunctions&k=20"), 404),
        get("read_sketch_segmentation", format!("/v1/sketches/{sketch}/segmentation?regions=4&k=20"), 404),
        get("rebuild_sketch", format!("/v1/sketches/{sketch}/rebuilt?k=20"), 404),
        json(cancelled("transfer", format!("/v1/matches/{matched}/transfers")), function),
        json(cancelled("evaluate_match", format!("/v1/matches/{matched}/evaluations")), known),
        json(call("create_sweep", "POST", "/v1/sweeps".to_owned(), 202, 422), sweep),
        json(call("create_match", "POST", "/v1/matches".to_owned(), 202, 422), asked),
        json(call("create_pose", "POST", "/v1/poses".to_owned(), 202, 422), bent),
        cancelled("cancel_match", format!("/v1/matches/{matched}/cancel")),
        cancelled("cancel_pose", format!("/v1/poses/{pose}/cancel")),
        ended("end_pose", format!("/v1/poses/{pose}")),
        ended("end_match", format!("/v1/matches/{matched}")),
        ended("delete_mesh", format!("/v1/meshes/{mesh}")),
        ended("delete_sketch", format!("/v1/sketches/{sketch}")),
    ]
}

/// The operations of the document that need a key for what is a tenant's.
async fn operations(server: &Server) -> BTreeSet<String> {
    let document = json_of(server.request_with(None, "GET", "/openapi.json").send().await.unwrap(), 200).await;
    let calls = document["paths"].as_object().unwrap().values().flat_map(|calls| calls.as_object().unwrap().values());
    let keyed = calls.filter(|call| call["security"] != json!([]));
    keyed.map(|call| call["operationId"].as_str().unwrap().to_owned()).filter(|id| id != "read_measures").collect()
}

/// The id of a job once it has ended well.
async fn ended(server: &Server, asked: RequestBuilder) -> String {
    let document = json_of(asked.send().await.unwrap(), 202).await;
    let events = server.get(document["links"]["events"].as_str().unwrap()).send().await.unwrap();
    events.text().await.unwrap();
    let path = document["links"]["self"].as_str().unwrap();
    assert_eq!(server.read(path).await["status"], "succeeded");
    id(&document)
}

#[tokio::test(flavor = "multi_thread")]
async fn every_call_answers_each_key_as_it_should() {
    let mut server = Server::for_keyholders().await;
    let (own, _) = server.key("acme", "read,write", None).await;
    let (other, _) = server.key("umbrella", "read,write", None).await;
    let (reader, _) = server.key("acme", "read", None).await;
    let (writer, _) = server.key("acme", "write", None).await;
    let past = SystemTime::now() - Duration::from_secs(1);
    let (expired, _) = server.key("acme", "read,write", Some(past)).await;
    let (revoked, revoked_id) = server.key("acme", "read,write", None).await;
    server.revoke(&revoked_id).await;

    server.send(&own);
    let matched = ended(&server, server.request_match(json!({})).await).await;
    let result = server.read(&format!("/v1/matches/{matched}/result")).await;
    let (mesh, sketch) = (result["mesh"].as_str().unwrap(), result["sketch"].as_str().unwrap());
    let bent = bend(&matched, corners(&server, &result).await, &[25.0]);
    let pose = ended(&server, server.post("/v1/poses").json(&bent)).await;
    let geometry = server.read(&format!("/v1/sketches/{sketch}/mesh")).await;
    let calls = calls(mesh, sketch, &matched, &pose, bent, &geometry["vertices"]);

    let covered: BTreeSet<String> = calls.iter().map(|call| call.operation.to_owned()).collect();
    assert_eq!(covered, operations(&server).await);
    for call in &calls {
        let status = async |key: Option<&str>| call.with(&server, key).send().await.unwrap().status().as_u16();
        let lacking = if call.method == "GET" { &writer } else { &reader };
        let refused = [None, Some("stranger"), Some(&revoked), Some(&expired), Some(lacking)];
        for (key, expected) in refused.into_iter().zip([401, 401, 401, 401, 403]) {
            assert_eq!(status(key).await, expected, "{}", call.operation);
        }
        assert_eq!(status(Some(&other)).await, call.other, "{}, by another tenant", call.operation);
        // What the jobs asked for here need is not deleted before they have ended.
        if call.method == "DELETE" {
            for path in ["/v1/matches", "/v1/poses"] {
                for job in server.read(path).await["items"].as_array().unwrap() {
                    let events = server.get(job["links"]["events"].as_str().unwrap()).send().await.unwrap();
                    events.text().await.unwrap();
                }
            }
        }
        assert_eq!(status(Some(&own)).await, call.own, "{}", call.operation);
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn what_another_has_is_answered_as_what_nobody_has() {
    let mut server = Server::for_keyholders().await;
    let (own, _) = server.key("acme", "read,write", None).await;
    let (other, _) = server.key("umbrella", "read,write", None).await;
    server.send(&own);
    let (mesh, sketch) = (server.mesh().await, server.sketch().await);
    let asked = server.request_match(json!({})).await.send().await.unwrap();
    let matched = id(&json_of(asked, 202).await);
    let none = |id: &str| id.chars().rev().collect::<String>();
    let no_shape = |id: &str| id.split_once('_').map(|(kind, hash)| format!("{kind}_{}", none(hash))).unwrap();

    let answer = async |method: &str, path: String, body: Value| {
        let answer = server.request_with(Some(&other), method, &path).json(&body).send().await.unwrap();
        let mut headers = answer.headers().clone();
        ["date", "x-request-id"].iter().for_each(|name| drop(headers.remove(*name)));
        (answer.status(), headers, answer.text().await.unwrap())
    };
    for (there, nowhere, paths) in [
        (&mesh, no_shape(&mesh), ["/v1/meshes/ID", "/v1/meshes/ID/mesh", "/v1/meshes/ID/spectrum"]),
        (&sketch, no_shape(&sketch), ["/v1/sketches/ID", "/v1/sketches/ID/picture", "/v1/sketches/ID/mesh"]),
        (&matched, none(&matched), ["/v1/matches/ID", "/v1/matches/ID/events", "/v1/matches/ID/result"]),
    ] {
        for (path, method) in paths.iter().flat_map(|path| ["GET", "DELETE", "PATCH"].map(|method| (path, method))) {
            let body = json!({"name": "mine"});
            let (status, headers, said) = answer(method, path.replace("ID", there), body.clone()).await;
            let (same_status, same_headers, same) = answer(method, path.replace("ID", &nowhere), body).await;
            assert_eq!((status, said.replace(there, &nowhere)), (same_status, same), "{method} {path}");
            assert_eq!(headers, same_headers, "{method} {path}");
        }
    }
    let of = |mesh: &str, sketch: &str| json!({"mesh": mesh, "sketch": sketch});
    let refused = answer("POST", "/v1/matches".to_owned(), of(&mesh, &sketch)).await;
    assert_eq!(refused, answer("POST", "/v1/matches".to_owned(), of("mesh_0", "sketch_0")).await);
}

#[tokio::test(flavor = "multi_thread")]
async fn the_same_upload_is_new_to_each_tenant_and_goes_for_one_alone() {
    let server = Server::for_keyholders().await;
    let (own, _) = server.key("acme", "read,write", None).await;
    let (other, _) = server.key("umbrella", "read,write", None).await;
    let upload = async |key: &str, name: &str| {
        let upload = server.request_with(Some(key), "POST", &format!("/v1/sketches?name={name}"));
        let upload = upload.header("idempotency-key", "one").json(&drawings::ellipse());
        json_of(upload.send().await.unwrap(), 201).await
    };
    let (mine, theirs) = (upload(&own, "secret").await, upload(&other, "public").await);
    // Each has its own answer under the one key, its own id and its own name.
    assert_eq!((&mine["name"], &theirs["name"]), (&json!("secret"), &json!("public")));
    assert_ne!(id(&mine), id(&theirs));
    let path = |shape: &Value| format!("/v1/sketches/{}", id(shape));
    let deleted = server.request_with(Some(&own), "DELETE", &path(&mine)).send().await.unwrap();
    assert_eq!(deleted.status(), 204);
    let geometry = server.request_with(Some(&other), "GET", &format!("{}/mesh", path(&theirs))).send().await.unwrap();
    assert_eq!(geometry.status(), 200);
    let list = async |key: &str| {
        let list = server.request_with(Some(key), "GET", "/v1/sketches").send().await.unwrap();
        json_of(list, 200).await["items"].as_array().unwrap().clone()
    };
    assert_eq!((list(&own).await, list(&other).await), (vec![], vec![theirs]));
}

#[tokio::test(flavor = "multi_thread")]
async fn a_spectrum_is_computed_for_each_tenant() {
    let server = Server::for_keyholders().await;
    let mut asked = Vec::new();
    for tenant in ["acme", "umbrella"] {
        let (key, _) = server.key(tenant, "read,write", None).await;
        let upload = server.request_with(Some(&key), "POST", "/v1/sketches").json(&drawings::ellipse());
        let sketch = id(&json_of(upload.send().await.unwrap(), 201).await);
        let path = format!("/v1/sketches/{sketch}/spectrum");
        // Whether it is there already would tell that another has it.
        let first = server.request_with(Some(&key), "GET", &path).send().await.unwrap();
        assert_eq!((first.status().as_u16(), header(&first, "retry-after")), (202, "1"));
        while server.request_with(Some(&key), "GET", &path).send().await.unwrap().status() == 202 {
            tokio::time::sleep(Duration::from_millis(20)).await;
        }
        let there = server.request_with(Some(&key), "GET", &path).send().await.unwrap();
        asked.push(json_of(there, 200).await);
    }
    assert_eq!(asked[0], asked[1]);
}

/// The statuses of the answers to the same request, sent so many times.
async fn statuses(request: RequestBuilder, times: usize) -> Vec<u16> {
    let mut statuses = Vec::new();
    for _ in 0..times {
        statuses.push(request.try_clone().unwrap().send().await.unwrap().status().as_u16());
    }
    statuses
}

#[tokio::test(flavor = "multi_thread")]
async fn a_tenant_that_takes_all_it_may_holds_up_itself_alone() {
    let tenant_limits = TenantLimits { queued_jobs: Some(2), stored_bytes: Some(40_000), ..TenantLimits::default() };
    let admission = Admission::Keyholders(None);
    let server = Server::idle(Config { admission, tenant_limits, ..Config::default() }).await;
    for tenant in ["acme", "umbrella"] {
        let (key, _) = server.key(tenant, "read,write", None).await;
        let upload = async |path: &str, body: String| {
            let upload = server.request_with(Some(&key), "POST", path).header("content-type", "application/json");
            upload.body(body).send().await.unwrap()
        };
        let mesh = server.request_with(Some(&key), "POST", "/v1/meshes?format=obj").body(drawings::ellipsoid(8, 6));
        let mesh = id(&json_of(mesh.send().await.unwrap(), 201).await);
        let sketch = upload("/v1/sketches", drawings::ellipse().to_string()).await;
        let sketch = id(&json_of(sketch, 201).await);
        let asked = server.request_with(Some(&key), "POST", "/v1/matches");
        let asked = asked.json(&json!({"mesh": mesh, "sketch": sketch}));
        let sweep = json!({"request": {"mesh": mesh, "sketch": sketch}, "pointer": "/basis/k", "values": [7, 8, 9]});
        let sweep = server.request_with(Some(&key), "POST", "/v1/sweeps").json(&sweep).send().await.unwrap();
        assert_eq!(problem_of(sweep, 422).await["errors"][0]["pointer"], "/values");
        // None of its matches takes a place.
        assert_eq!(statuses(asked.try_clone().unwrap(), 4).await, [202, 202, 429, 429], "{tenant}");
        let refused = asked.send().await.unwrap();
        assert_eq!(header(&refused, "retry-after"), "30");
        problem_of(refused, 429).await;
        // What is deleted makes room.
        let matches = server.request_with(Some(&key), "GET", "/v1/matches").send().await.unwrap();
        let first = id(&json_of(matches, 200).await["items"][0]);
        let cancel = server.request_with(Some(&key), "DELETE", &format!("/v1/matches/{first}")).send().await.unwrap();
        let full = upload("/v1/meshes?format=obj", drawings::ellipsoid(60, 40)).await;
        assert_eq!((cancel.status().as_u16(), full.status().as_u16()), (200, 429));
        assert_eq!(header(&full, "retry-after"), "");
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn requests_of_one_tenant_have_a_pace() {
    let tenant_limits = TenantLimits { requests_per_second: NonZeroU32::new(1), ..TenantLimits::default() };
    let admission = Admission::Keyholders(None);
    let server = Server::idle(Config { admission, tenant_limits, ..Config::default() }).await;
    let (key, _) = server.key("acme", "read,write", None).await;
    let asked = async |key: &str| server.request_with(Some(key), "GET", "/v1/regularisers/l1").send().await.unwrap();
    let first = asked(&key).await;
    assert_eq!(
        (header(&first, "ratelimit"), header(&first, "ratelimit-policy")),
        ("\"requests\";r=0;t=1", "\"requests\";q=1;w=1")
    );
    // However slowly this goes: of those at the same moment one at most is let through.
    let answers = join_all((0..20).map(|_| asked(&key))).await;
    let refused: Vec<_> = answers.into_iter().filter(|answer| answer.status() == 429).collect();
    assert!(!refused.is_empty());
    for answer in refused {
        assert!(header(&answer, "retry-after").parse::<u32>().unwrap() >= 1);
        problem_of(answer, 429).await;
    }
    let (other, _) = server.key("umbrella", "read", None).await;
    assert_eq!(asked(&other).await.status(), 200);
}

#[tokio::test(flavor = "multi_thread")]
async fn streams_and_waits_of_one_tenant_leave_room_for_others() {
    let tenant_limits = TenantLimits { open_requests: Some(2), ..TenantLimits::default() };
    let admission = Admission::Keyholders(None);
    let mut server = Server::idle(Config { admission, tenant_limits, ..Config::default() }).await;
    let (key, _) = server.key("acme", "read,write", None).await;
    server.send(&key);
    let asked = server.request_match(json!({})).await.send().await.unwrap();
    let matched = id(&json_of(asked, 202).await);
    let path = format!("/v1/matches/{matched}");
    // The match waits for ever, its streams with it; each is answered before the next is asked for.
    let follow = async || server.get(&format!("{path}/events")).send().await.unwrap();
    let (first, second) = (follow().await, follow().await);
    assert_eq!((first.status().as_u16(), second.status().as_u16()), (200, 200));
    let refused = server.get(&path).send().await.unwrap();
    assert_eq!(header(&refused, "retry-after"), "5");
    problem_of(refused, 429).await;
    let (other, _) = server.key("umbrella", "read", None).await;
    let others = server.request_with(Some(&other), "GET", "/v1/matches").send().await.unwrap();
    assert_eq!(others.status(), 200);
    // With the match the streams end, and their places are free.
    server.cancel_for("acme", &matched).await;
    for stream in [first, second] {
        stream.text().await.unwrap();
    }
    assert_eq!(server.read(&path).await["status"], "cancelled");
}
