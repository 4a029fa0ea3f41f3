//! Who is let in, and what is said to those who are not.

use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::Path;
use std::process::Command;
use std::time::{Duration, SystemTime};

use reqwest::{Response, StatusCode};
use serde_json::json;

use crate::client::client;
use crate::drawings;
use crate::program::Program;
use crate::server::{Server, header, json_of, problem_of};

#[tokio::test(flavor = "multi_thread")]
async fn without_a_key_only_what_tells_of_nobody_is_answered() {
    let server = Server::for_keyholders().await;
    for path in ["/", "/healthz", "/readyz", "/openapi.json", "/docs/"] {
        assert_eq!(server.get(path).send().await.unwrap().status(), 200, "{path}");
    }
    for path in ["/metrics", "/v1/meshes", "/v1/matches/none", "/v1/examples", "/v1/regularisers"] {
        let refused = server.get(path).send().await.unwrap();
        assert_eq!(header(&refused, "www-authenticate"), "Bearer realm=\"sketchmatch\"", "{path}");
        problem_of(refused, 401).await;
    }
    // The body of a stranger is not read.
    let refused = server.post("/v1/meshes").body(drawings::ellipsoid(8, 6)).send().await.unwrap();
    problem_of(refused, 401).await;
    problem_of(server.get("/v1/nothing").send().await.unwrap(), 404).await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_key_opens_what_its_scopes_say_until_it_ends() {
    let server = Server::for_keyholders().await;
    let (reader, _) = server.key("acme", "read", None).await;
    let (writer, id) = server.key("acme", "write", None).await;
    let (admin, _) = server.key("acme", "admin", None).await;
    let (late, _) = server.key("acme", "read,write,admin", Some(SystemTime::now() - Duration::from_secs(1))).await;
    let status = async |key: &str, method: &str, path: &str| {
        let request = server.request(method, path).bearer_auth(key).json(&drawings::ellipse());
        request.send().await.unwrap().status().as_u16()
    };
    for (key, read, written, measured) in [(&reader, 200, 403, 403), (&writer, 403, 201, 403), (&admin, 403, 403, 200)]
    {
        assert_eq!(status(key, "GET", "/v1/sketches").await, read);
        assert_eq!(status(key, "POST", "/v1/sketches").await, written);
        assert_eq!(status(key, "GET", "/metrics").await, measured);
    }
    assert_eq!(status(&late, "GET", "/v1/sketches").await, 401);
    server.revoke(&id).await;
    assert_eq!(status(&writer, "POST", "/v1/sketches").await, 401);

    let lacking = server.post("/v1/sketches").bearer_auth(&reader).send().await.unwrap();
    let challenge = "Bearer realm=\"sketchmatch\", error=\"insufficient_scope\", scope=\"write\"";
    assert_eq!(header(&lacking, "www-authenticate"), challenge);
    problem_of(lacking, 403).await;
}

#[tokio::test(flavor = "multi_thread")]
async fn what_is_no_key_is_answered_like_an_unknown_one() {
    let server = Server::for_keyholders().await;
    let (key, _) = server.key("acme", "read", None).await;
    let asked = async |value: &str| -> Response {
        server.get("/v1/meshes").header("authorization", value).send().await.unwrap()
    };
    for value in [format!("Bearer {key}"), format!("bearer  {key}")] {
        assert_eq!(asked(&value).await.status(), StatusCode::OK, "{value}");
    }
    let long = format!("Bearer {}", "x".repeat(600));
    for value in ["Bearer stranger", "Bearer", "Bearer ", "Bearer a b", "Basic dTpw", &key, &long] {
        let refused = asked(value).await;
        let challenge = "Bearer realm=\"sketchmatch\", error=\"invalid_token\"";
        assert_eq!(header(&refused, "www-authenticate"), challenge, "{value}");
        let problem = problem_of(refused, 401).await;
        let is_told = problem["detail"].as_str().unwrap().contains("`Bearer ` is missing");
        assert_eq!(is_told, !value.starts_with("Bearer"), "{value}: {problem}");
    }
    let twice = server.get("/v1/meshes").header("authorization", format!("Bearer {key}"));
    let twice = twice.header("authorization", "Bearer other").send().await.unwrap();
    problem_of(twice, 401).await;
}

#[tokio::test(flavor = "multi_thread")]
async fn scripts_of_other_sites_may_send_a_key() {
    let server = Server::for_keyholders().await;
    let asked = server.request("OPTIONS", "/v1/meshes").header("origin", "https://a.example");
    let asked = asked.header("access-control-request-method", "GET");
    let answer = asked.header("access-control-request-headers", "authorization").send().await.unwrap();
    assert_eq!((answer.status().as_u16(), header(&answer, "access-control-allow-headers")), (200, "authorization"));
    assert_eq!(header(&answer, "access-control-max-age"), "3600");
}

fn program(command: &[&str], data: &Path) -> (bool, String) {
    let mut program = Command::new(env!("CARGO_BIN_EXE_sketchmatch"));
    let output = program.args(command).arg("--data-dir").arg(data).output().unwrap();
    let said = if output.status.success() { output.stdout } else { output.stderr };
    (output.status.success(), String::from_utf8(said).unwrap().trim().to_owned())
}

#[tokio::test(flavor = "multi_thread")]
async fn keys_are_made_rotated_and_revoked_beside_the_server() {
    let data = tempfile::tempdir().unwrap();
    // Before there is a server, too.
    let (_, first) = program(&["keys", "add", "--tenant", "acme"], data.path());
    let database = fs::metadata(data.path().join("sketchmatch.db")).unwrap();
    assert_eq!(database.permissions().mode() & 0o777, 0o600);
    let server = Program::start(data.path(), 1);
    let client = client();
    let status =
        async |key: &str| client.get(server.url("/v1/meshes")).bearer_auth(key).send().await.unwrap().status().as_u16();
    assert_eq!((status(&first).await, status("none").await), (200, 401));

    let (_, list) = program(&["keys", "list"], data.path());
    assert!(list.contains("acme\tread,write\t") && !list.contains(&first), "{list}");
    let id = list.split('\t').next().unwrap();
    let (_, second) = program(&["keys", "rotate", id], data.path());
    assert_eq!((status(&first).await, status(&second).await), (200, 200));
    assert!(program(&["keys", "revoke", id], data.path()).0);
    assert_eq!((status(&first).await, status(&second).await), (401, 200));
    for command in [["keys", "revoke", id], ["keys", "rotate", "none"]] {
        let (done, said) = program(&command, data.path());
        assert!(!done && said.contains("there is no key"), "{said}");
    }
    let (done, said) = program(&["keys", "add", "--scopes", "root"], data.path());
    assert!(!done && said.contains("read, write and admin"), "{said}");
}

#[tokio::test(flavor = "multi_thread")]
async fn a_file_of_keys_is_read_again_when_it_changes() {
    let data = tempfile::tempdir().unwrap();
    let file = data.path().join("keys");
    fs::write(&file, "first\nacme:reader:read\n").unwrap();
    let options = ["--api-keys", file.to_str().unwrap(), "--metrics-listen", "127.0.0.1:0"];
    let server = Program::with(&data.path().join("data"), &options);
    let client = client();
    let status = async |key: &str| {
        let upload = client.post(server.url("/v1/sketches")).bearer_auth(key).json(&drawings::ellipse());
        upload.send().await.unwrap().status().as_u16()
    };
    assert_eq!((status("first").await, status("reader").await, status("second").await), (201, 403, 401));
    assert_eq!(client.get(server.url("/metrics")).bearer_auth("first").send().await.unwrap().status(), 200);
    fs::write(&file, json!(["second"]).to_string()).unwrap();
    while status("second").await == 401 {
        tokio::time::sleep(Duration::from_millis(50)).await;
    }
    assert_eq!(status("first").await, 401);
}

#[test]
fn a_server_that_nobody_or_everybody_could_use_does_not_start() {
    let data = tempfile::tempdir().unwrap();
    let file = data.path().join("keys");
    fs::write(&file, "good\nno key\n").unwrap();
    let refused = |options: &[&str]| {
        let (done, said) = program(&[&["serve", "--listen"], options].concat(), &data.path().join("data"));
        assert!(!done);
        said
    };
    assert!(refused(&["0.0.0.0:0"]).contains("--api-keys"));
    let said = refused(&["127.0.0.1:0", "--api-keys", file.to_str().unwrap()]);
    assert!(said.contains("keys, line 2: ") && !said.contains("good"), "{said}");
}

#[tokio::test(flavor = "multi_thread")]
async fn a_signed_address_needs_no_key_for_what_it_is_of() {
    let mut server = Server::for_keyholders().await;
    let (key, _) = server.key("acme", "read,write", None).await;
    server.send(&key);
    let (mesh, sketch) = (server.mesh().await, server.sketch().await);
    let signed = server.get(&format!("/v1/meshes/{mesh}/links")).send().await.unwrap();
    assert_eq!(header(&signed, "cache-control"), "no-store");
    let signed = json_of(signed, 200).await;
    assert!(signed["expires_at"].is_string());
    let stranger = async |method: &str, path: &str| {
        server.request_with(None, method, path).send().await.unwrap().status().as_u16()
    };
    for name in ["self", "mesh", "picture"] {
        assert_eq!(stranger("GET", signed["links"][name].as_str().unwrap()).await, 200, "{name}");
    }
    let with = |path: String| {
        format!(
            "{path}{}signature={}",
            if path.contains('?') { "&" } else { "?" },
            signed["signature"].as_str().unwrap()
        )
    };
    assert_eq!(stranger("GET", &with(format!("/v1/meshes/{mesh}/picture?width=200&format=svg"))).await, 200);
    assert_eq!(stranger("HEAD", &with(format!("/v1/meshes/{mesh}"))).await, 200);
    // It is for nothing else, and makes no other that lasts longer.
    for path in [format!("/v1/meshes/{mesh}/links"), format!("/v1/sketches/{sketch}"), "/v1/meshes".to_owned()] {
        assert_eq!(stranger("GET", &with(path.clone())).await, 401, "{path}");
    }
    assert_eq!(stranger("DELETE", &with(format!("/v1/meshes/{mesh}"))).await, 403);
    assert_eq!(stranger("GET", &format!("/v1/meshes/{mesh}?signature=4102444800.forged.acme")).await, 401);
    // A key goes before a signature.
    let (other, _) = server.key("umbrella", "read", None).await;
    let path = with(format!("/v1/meshes/{mesh}"));
    assert_eq!(server.request_with(Some(&other), "GET", &path).send().await.unwrap().status(), 404);

    let asked = server.request_match(json!({})).await.send().await.unwrap();
    let matched = json_of(asked, 202).await["links"]["self"].as_str().unwrap().to_owned();
    let signed = server.read(&format!("{matched}/links")).await;
    let events = server.request_with(None, "GET", signed["links"]["events"].as_str().unwrap());
    let events = events.send().await.unwrap().text().await.unwrap();
    assert!(events.contains("\"succeeded\""), "{events}");
}
