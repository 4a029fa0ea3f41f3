//! A mesh of 50K vertices posed by ten handles.

use serde_json::{Value, json};
use sketchmatch::mesh::TriangleMesh;
use sketchmatch::numerics::Unwatched;
use sketchmatch::pipeline::Computing;
use sketchmatch::posing::request::PoseRequest;
use sketchmatch::posing::{self, basis};
use sketchmatch::sketch::Sketch;

use crate::known::Match;
use crate::table::{Reach, Table, timed};

const HANDLES: usize = 10;

/// A pose by itself, and the basis in which a page drags the handles.
pub fn rows(table: &Table, sketch: &Sketch, mesh: &TriangleMesh) {
    let matched = Match::of(mesh, "automatic").run(sketch);
    let vertices = sketch.mesh().positions().len();
    let at = |handle: usize| json!({"type": "point", "at": sketch.point(handle * vertices / HANDLES)});
    let turned = json!({"type": "rotation", "degrees": 10});
    let handles: Vec<Value> = (0..HANDLES).map(at).collect();
    let request = json!({"match": "m", "handles": handles, "frames": [vec![turned; HANDLES]]});
    let request: PoseRequest = serde_json::from_value(request).expect("a request");
    let file = mesh.clone().into();
    let pose = || {
        posing::run(sketch, &file, &matched, &request, &Computing, &Unwatched, &|| 0.0).expect("the body can be posed")
    };
    table.time("a pose of 10 handles, 50K", &timed(pose), None, Reach::None);
    let weights = pose().weights.expect("handles have weights");
    let sample = timed(|| basis(sketch, &file, &matched, &weights).expect("the pose has a basis"));
    table.time("basis of a pose of 10 handles, 50K", &sample, None, Reach::None);
}
