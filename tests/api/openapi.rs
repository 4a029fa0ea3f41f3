//! The committed document is the one the code makes.

use std::process::Command;

use serde_json::Value;
use sketchmatch::http::Config;

use crate::server::Server;

const COMMITTED: &str = include_str!("../../openapi/openapi.json");

#[test]
fn the_committed_document_is_that_of_the_program() {
    let printed = Command::new(env!("CARGO_BIN_EXE_sketchmatch")).arg("openapi").output().unwrap();
    assert!(printed.status.success());
    assert!(
        String::from_utf8(printed.stdout).unwrap() == COMMITTED,
        "the routes have changed: run `cargo run -- openapi > openapi/openapi.json`"
    );
}

#[tokio::test(flavor = "multi_thread")]
async fn the_server_answers_the_committed_document() {
    let server = Server::idle(Config::default()).await;
    assert_eq!(server.read("/openapi.json").await, serde_json::from_str::<Value>(COMMITTED).unwrap());
}
