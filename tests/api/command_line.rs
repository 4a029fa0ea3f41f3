//! What the program does without a server, and what it says of it.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use serde_json::Value;
use tempfile::TempDir;

use crate::drawings;
use crate::program::Program;

/// A directory with a sketch and a mesh in it.
struct Desk {
    dir: TempDir,
    sketch: PathBuf,
    mesh: PathBuf,
}

impl Desk {
    fn new() -> Desk {
        let dir = tempfile::tempdir().unwrap();
        let (sketch, mesh) = (dir.path().join("s.json"), dir.path().join("m.obj"));
        fs::write(&sketch, drawings::ellipse().to_string()).unwrap();
        fs::write(&mesh, drawings::ellipsoid(16, 12)).unwrap();
        Desk { dir, sketch, mesh }
    }

    fn path(&self, name: &str) -> PathBuf {
        self.dir.path().join(name)
    }
}

fn program(command: &str) -> Command {
    let mut program = Command::new(env!("CARGO_BIN_EXE_sketchmatch"));
    // What users set for programs of their own is no reason to show them ours.
    program.env("RUST_BACKTRACE", "1").arg(command);
    program
}

fn said(output: &Output) -> String {
    String::from_utf8(output.stderr.clone()).unwrap()
}

/// What a command says that has to fail: one message, no backtrace, no colours.
#[track_caller]
fn refusal(command: &mut Command) -> String {
    let output = command.output().unwrap();
    let said = said(&output);
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(said.starts_with("sketchmatch: ") && !said.contains("backtrace") && !said.contains('\x1b'), "{said}");
    said
}

#[test]
fn a_match_writes_its_result_and_sums_it_up_in_a_line() {
    let desk = Desk::new();
    let (result, picture) = (desk.path("r.json"), desk.path("p.svg"));
    let mut command = program("match");
    command.args([&desk.sketch, &desk.mesh]).arg("-o").arg(&result).arg("--picture").arg(&picture);
    let output = command.output().unwrap();
    let said = said(&output);
    assert!(output.status.success() && output.stdout.is_empty(), "{said}");
    let result_read: Value = serde_json::from_slice(&fs::read(&result).unwrap()).unwrap();
    assert!(!result_read["correspondences"].as_array().unwrap().is_empty());
    assert!(fs::read_to_string(&picture).unwrap().starts_with("<svg"));
    let line = said.lines().last().unwrap();
    let rated = format!("rated {}", result_read["rating"].as_str().unwrap());
    for part in ["matched to", &rated, result.to_str().unwrap(), picture.to_str().unwrap()] {
        assert!(line.contains(part), "{line}");
    }

    let output = program("match").args([&desk.sketch, &desk.mesh]).output().unwrap();
    let printed: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(printed["correspondences"], result_read["correspondences"]);
}

#[test]
fn what_is_seen_is_drawn_and_printed() {
    let desk = Desk::new();
    let (drawing, vector, raster) = (desk.path("d.svg"), desk.path("p.svg"), desk.path("p.png"));
    let two = r#"<rect x="20" y="100" width="100" height="300"/><rect x="260" y="80" width="120" height="320"/>"#;
    fs::write(&drawing, format!(r#"<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 400 500">{two}</svg>"#))
        .unwrap();
    let output = program("read").arg(&drawing).arg("-o").arg(&vector).output().unwrap();
    let printed = String::from_utf8(output.stdout.clone()).unwrap();
    assert!(output.status.success() && printed.contains("figure 0 of 2"), "{printed}{}", said(&output));
    assert!(printed.lines().any(|line| line.starts_with("warning: another figure")), "{printed}");
    // A mark for the figure that is left out.
    assert_eq!(fs::read_to_string(&vector).unwrap().matches("<rect ").count(), 1);

    let output = program("read").args([&desk.sketch]).arg("-o").arg(&raster).output().unwrap();
    assert!(output.status.success(), "{}", said(&output));
    assert!(fs::read(&raster).unwrap().starts_with(b"\x89PNG"));

    let said = refusal(program("read").arg(&drawing).args(["--figure", "2", "-o"]).arg(desk.path("none.png")));
    assert!(said.contains("figure 2 was asked for") && !desk.path("none.png").exists(), "{said}");
    assert!(refusal(program("read").arg(&drawing).arg("-o").arg(desk.path("p.glb"))).contains(".png or .svg"));
}

#[test]
fn a_match_that_is_refused_says_why_in_the_words_of_the_file() {
    let desk = Desk::new();
    let broken = desk.path("broken.obj");
    fs::write(&broken, "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n").unwrap();
    let said = refusal(program("match").args([&desk.sketch, &broken]));
    assert!(said.contains("broken.obj") && said.contains("line 4"), "{said}");
    let letter = desk.path("letter.txt");
    fs::write(&letter, "Dear Sir or Madam").unwrap();
    let said = refusal(program("match").args([&desk.sketch, &letter]));
    assert!(said.contains("letter.txt") && said.contains("OBJ, OFF, PLY, STL, GLB or glTF"), "{said}");
    let said = refusal(program("match").args([&desk.sketch, &desk.path("absent.obj")]));
    assert!(said.contains("absent.obj"), "{said}");
}

#[test]
fn a_sketch_and_a_mesh_that_change_places_are_named() {
    let desk = Desk::new();
    let said = refusal(program("match").args([&desk.mesh, &desk.sketch]));
    assert!(said.contains("m.obj is a mesh") && said.contains("match SKETCH MESH"), "{said}");
    let said = refusal(program("match").args([&desk.sketch, &desk.sketch]));
    assert!(said.contains("s.json is a drawing"), "{said}");
}

#[test]
fn where_a_result_goes_is_looked_at_before_the_files_are() {
    let desk = Desk::new();
    fs::write(&desk.mesh, "v 0 0 0\nf 1 1 1\n").unwrap();
    let refused = |output: &Path| refusal(program("match").args([&desk.sketch, &desk.mesh]).arg("-o").arg(output));
    let said = refused(&desk.path("no/such/directory/r.json"));
    assert!(said.contains("no/such/directory/r.json"), "{said}");
    let said = refused(&desk.mesh);
    assert!(said.contains("another file is wanted"), "{said}");
    assert_eq!(fs::read(&desk.mesh).unwrap(), b"v 0 0 0\nf 1 1 1\n");
    // The mesh is at fault here: nothing is left behind.
    refused(&desk.path("r.json"));
    assert!(!desk.path("r.json").exists());
}

#[test]
fn eigenvalues_come_with_what_tells_how_exact_they_are() {
    let desk = Desk::new();
    let output = program("eigenvalues").arg(&desk.mesh).arg("6").output().unwrap();
    let report: Value = serde_json::from_slice(&output.stdout).unwrap();
    let eigenvalues: Vec<f64> = serde_json::from_value(report["eigenvalues"].clone()).unwrap();
    assert!(eigenvalues.len() == 6 && eigenvalues.is_sorted() && eigenvalues[0].abs() < 1e-9, "{report}");
    for measure in ["worst_residual", "worst_orthonormality"] {
        assert!(report[measure].as_f64().unwrap() < 1e-6, "{report}");
    }
    let said = refusal(program("eigenvalues").arg(&desk.sketch));
    assert!(said.contains("s.json"), "{said}");
}

#[test]
fn a_server_is_asked_for_its_health() {
    let data = tempfile::tempdir().unwrap();
    let program_serving = Program::start(data.path(), 1);
    let ask = |url: &str| program("health").args(["--url", url]).output().unwrap();
    let url = program_serving.url("");
    let output = ask(&url);
    assert!(output.status.success() && output.stderr.is_empty(), "{}", said(&output));
    drop(program_serving);
    for url in [url.as_str(), "https://127.0.0.1:1", "nowhere"] {
        assert!(refusal(program("health").args(["--url", url])).contains(url));
    }
}

/// A case whose truth is known, the ellipse and the ellipsoid, in a folder of cases.
fn cases(desk: &Desk) -> PathBuf {
    let (dir, truth) = (desk.path("cases"), r#"{"side": false, "points": [[0, 0]], "variants": {"front": [5]}}"#);
    fs::create_dir_all(dir.join("one")).unwrap();
    fs::copy(&desk.sketch, dir.join("one/sketch.json")).unwrap();
    fs::copy(&desk.mesh, dir.join("one/mesh.obj")).unwrap();
    fs::write(dir.join("one/truth.json"), truth).unwrap();
    dir
}

#[test]
fn a_result_is_judged_by_its_truth() {
    let desk = Desk::new();
    let (truth, result) = (cases(&desk).join("one/truth.json"), desk.path("r.json"));
    let matched = program("match").args([&desk.sketch, &desk.mesh]).arg("-o").arg(&result).output().unwrap();
    assert!(matched.status.success(), "{}", said(&matched));
    let judged = program("evaluate").args([&result, &truth]).output().unwrap();
    assert!(said(&judged).contains("held to front") && judged.status.success(), "{}", said(&judged));
    let found: Value = serde_json::from_slice(&judged.stdout).unwrap();
    assert_eq!(found["pairs"]["points"].as_array().unwrap().len(), 1, "{found}");
    for (name, begins) in [("e.csv", "point,x,y,"), ("e.svg", "<svg"), ("e.json", "{\"pairs\"")] {
        let path = desk.path(name);
        assert!(program("evaluate").args([&result, &truth]).arg("-o").arg(&path).output().unwrap().status.success());
        assert!(fs::read_to_string(&path).unwrap().starts_with(begins), "{name}");
    }
    let tetrahedron = desk.path("t.obj");
    fs::write(&tetrahedron, "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n").unwrap();
    let other = refusal(program("evaluate").args([&result, &truth]).arg("--mesh").arg(&tetrahedron));
    assert!(other.contains("names vertex"), "{other}");
    fs::write(desk.path("t.json"), r#"{"labels": {"sketch": [], "mesh": []}}"#).unwrap();
    let unfit = refusal(program("evaluate").args([&result, &desk.path("t.json")]));
    assert!(unfit.contains("/labels/mesh: must have a label for each"), "{unfit}");
}

#[test]
fn a_matrix_of_requests_is_judged_over_all_cases_and_not_again() {
    let desk = Desk::new();
    let (cases, out, matrix) = (cases(&desk), desk.path("out"), desk.path("m.json"));
    let kinds = r#"{"l1": {"regulariser": {"type": "l1"}}, "l2": {"regulariser": {"type": "l2"}}}"#;
    fs::write(&matrix, format!(r#"[{{"thesis": {{"preset": "thesis"}}}}, {kinds}]"#)).unwrap();
    let run = || {
        let mut command = program("evaluate-all");
        let output = command.arg(&cases).arg("--matrix").arg(&matrix).arg("-o").arg(&out).output().unwrap();
        assert!(output.status.success(), "{}", said(&output));
        ["records.csv", "summary.csv", "curves.svg", "curves.png"].map(|name| fs::read(out.join(name)).unwrap())
    };
    let first = run();
    let records = String::from_utf8(first[0].clone()).unwrap();
    assert_eq!(records.lines().count(), 3, "{records}");
    assert!(records.lines().nth(1).unwrap().starts_with("thesis l1,one,false,"), "{records}");
    let written = fs::metadata(out.join("records/thesis/l1/one.json")).unwrap().modified().unwrap();
    assert_eq!(run(), first);
    assert_eq!(fs::metadata(out.join("records/thesis/l1/one.json")).unwrap().modified().unwrap(), written);
    fs::write(&matrix, r#"[{"wrong": {"basis": {"k": 0}}}]"#).unwrap();
    let refused = refusal(program("evaluate-all").arg(&cases).arg("--matrix").arg(&matrix).arg("-o").arg(&out));
    assert!(refused.contains("request \"wrong\": /basis/k"), "{refused}");
}
