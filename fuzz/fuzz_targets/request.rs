//! Requests: a match, a pose, or what is known of a match, of one small sketch and one small mesh.
#![no_main]

use std::sync::LazyLock;

use libfuzzer_sys::fuzz_target;
use sketchmatch::evaluation::Known;
use sketchmatch::mesh::file_mesh::FileMesh;
use sketchmatch::mesh::formats::{Format, Limits};
use sketchmatch::mesh::validation::import;
use sketchmatch::pipeline::request::MatchRequest;
use sketchmatch::pipeline::{Settings, check, faults_on_shapes};
use sketchmatch::posing;
use sketchmatch::posing::request::PoseRequest;
use sketchmatch::sketch::outline::Drawing;
use sketchmatch::sketch::{Config, Sketch, from_outline};

/// A tetrahedron, one of whose corners is there twice.
const MESH: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 5\nf 3 1 4\n";

static SHAPES: LazyLock<(Sketch, FileMesh)> = LazyLock::new(|| {
    let square = Drawing { outline: vec![[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]], holes: Vec::new() };
    let sketch = from_outline(&square, 50, &Config::default()).expect("a square").sketch;
    let mesh = import(MESH.as_bytes(), Format::Obj, &Limits::default()).expect("a tetrahedron").mesh;
    (sketch, mesh)
});

fuzz_target!(|bytes: &[u8]| {
    let (sketch, mesh) = &*SHAPES;
    let (m, n) = (sketch.mesh().positions().len(), mesh.positions().len());
    if let Ok(request) = serde_json::from_slice::<MatchRequest>(bytes)
        && let Ok(settings) = Settings::resolve(&request)
        && check(&settings, m, n).is_empty()
    {
        faults_on_shapes(&settings, sketch, mesh);
    }
    if let Ok(request) = serde_json::from_slice::<PoseRequest>(bytes) {
        posing::faults(&request, sketch);
    }
    if let Ok(known) = serde_json::from_slice::<Known>(bytes)
        && known.faults(m, n).is_empty()
    {
        let at: Vec<[f64; 2]> = (0..m).map(|vertex| sketch.point(vertex)).collect();
        let to: Vec<u32> = (0..m).map(|vertex| (vertex % n) as u32).collect();
        known.evaluation(mesh, &at, &to);
    }
});
