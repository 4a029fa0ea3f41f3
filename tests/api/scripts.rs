//! The examples in other languages, carried out as they stand where those are there.

use std::fs;
use std::path::PathBuf;
use std::process::{Command, Stdio};

use tokio::task::block_in_place;

use crate::drawings;
use crate::server::Server;

/// Whether a program is there and takes these arguments; says so where not.
fn is_there(program: &str, arguments: &[&str]) -> bool {
    let status = Command::new(program).args(arguments).stdout(Stdio::null()).stderr(Stdio::null()).status();
    let there = status.is_ok_and(|status| status.success());
    if !there {
        eprintln!("not carried out: `{program} {}` does not work here", arguments.join(" "));
    }
    there
}

/// What an example prints that is given the server, a mesh, a sketch and a file to write, and that file.
fn carried_out(server: &Server, program: &str, script: &str, output: &str) -> (String, String) {
    let dir = tempfile::tempdir().unwrap();
    let [mesh, sketch, output] = ["mesh.obj", "sketch.json", output].map(|name| dir.path().join(name));
    fs::write(&mesh, drawings::ellipsoid(16, 12)).unwrap();
    fs::write(&sketch, drawings::ellipse().to_string()).unwrap();
    let script = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("examples").join(script);
    let mut command = Command::new(program);
    command.arg(script).arg(server.address()).args([&mesh, &sketch, &output]);
    let ran = block_in_place(|| command.output()).unwrap();
    let [said, complained] = [ran.stdout, ran.stderr].map(|text| String::from_utf8(text).unwrap());
    assert!(ran.status.success(), "{said}{complained}");
    (said, fs::read_to_string(output).unwrap())
}

#[tokio::test(flavor = "multi_thread")]
async fn the_example_in_python_finds_the_map_again() {
    if !is_there("python3", &["-c", "import numpy"]) {
        return;
    }
    let server = Server::working().await;
    let (said, figure) = carried_out(&server, "python3", "python/look_inside.py", "figure.svg");
    assert!(said.contains("C is 20 x 20") && said.contains("100% of the points"), "{said}");
    let ratio = said.split("least times ").nth(1).unwrap().split_whitespace().next().unwrap();
    assert!((ratio.parse::<f64>().unwrap() - 1.0).abs() < 1e-4, "{said}");
    assert!(figure.starts_with("<svg") && figure.matches("<polyline").count() == 2);
}

#[tokio::test(flavor = "multi_thread")]
async fn the_example_in_javascript_poses_the_mesh() {
    if !is_there("node", &["-e", "process.exit(Number(process.versions.node.split('.')[0]) < 20)"]) {
        return;
    }
    let server = Server::working().await;
    let (said, mesh) = carried_out(&server, "node", "javascript/match_and_pose.mjs", "posed.obj");
    assert!(said.contains("triangles turned over: 0"), "{said}");
    assert!(mesh.starts_with("# an ellipsoid\n") && mesh.lines().any(|line| line.starts_with("v ")));
}
