//! Matches of sheets and balls, too small to look like anything.

use serde_json::{Value, json};

use super::outcome::MatchResult;
use super::request::MatchRequest;
use super::{Computing, Inside, MatchError, Settings, Stage, Surroundings, Watcher, faults_on_shapes, functions, run};
use crate::mesh::TriangleMesh;
use crate::mesh::file_mesh::FileMesh;
use crate::mesh::solids::{sheet, sphere};
use crate::numerics::{Cancelled, Unwatched};
use crate::sketch::{Sketch, YAxis};

struct Patient;

impl Watcher for Patient {
    fn proceed(&self, _stage: Stage, _fraction: f64) -> Result<(), Cancelled> {
        Ok(())
    }
}

fn drawing(columns: u32, rows: u32) -> Sketch {
    Sketch::new(sheet(columns, rows), YAxis::Up).unwrap()
}

/// A match by the map alone, of few functions, unless the request says otherwise.
fn settings(request: Value) -> Settings {
    let mut whole = json!({
        "mesh": "mesh", "sketch": "sketch", "preset": "thesis", "basis": {"k": 8},
        "descriptors": {"hks": {"count": 5}, "wks": {"count": 5}}, "regions": {"method": "auto", "count": 3},
    });
    whole.as_object_mut().unwrap().extend(request.as_object().unwrap().clone());
    let request: MatchRequest = serde_json::from_value(whole).unwrap();
    Settings::resolve(&request).unwrap()
}

fn matched(sketch: &Sketch, mesh: &FileMesh, request: Value) -> Result<MatchResult, MatchError> {
    let surroundings = Surroundings {
        spectra: &Computing,
        preparations: &Computing,
        watcher: &Patient,
        clock: &|| 0.0,
        preview: None,
    };
    run(sketch, mesh, &settings(request), &surroundings)
}

/// Two balls of area 1 that overlap.
fn balls() -> FileMesh {
    let ball = sphere(24, 48);
    let [left, right] = [-0.2, 0.2].map(|beside| ball.positions().iter().map(move |&[x, y, z]| [x + beside, y, z]));
    let first = ball.positions().len() as u32;
    let triangles = [0, first].into_iter().flat_map(|first| ball.triangles().iter().map(move |t| t.map(|v| first + v)));
    TriangleMesh::new(left.chain(right).collect(), triangles.collect()).unwrap().into()
}

#[test]
fn landmarks_answer_with_their_own_vertex_also_of_a_figure_joined_of_components() {
    let (sketch, mesh) = (drawing(9, 4), balls());
    let landmarks: Vec<Value> =
        (0..10).map(|i| json!({"sketch": sketch.point(5 * i), "mesh": 300 + 170 * i})).collect();
    let result = matched(&sketch, &mesh, json!({"components": [0, 1], "landmarks": landmarks})).unwrap();
    for i in 0..10 {
        let answer = &result.correspondences[5 * i];
        assert_eq!(answer.mesh_vertex as usize, 300 + 170 * i);
        let corners = answer.triangle.unwrap().into_iter().zip(answer.barycentric.unwrap());
        let own = corners.filter(|(corner, _)| *corner == answer.mesh_vertex);
        assert_eq!(own.map(|(_, weight)| weight).sum::<f64>(), 1.0);
    }
}

#[test]
fn what_a_map_of_ones_own_is_worth_counts_the_regions_whatever_the_regulariser() {
    let (sketch, mesh) = (drawing(9, 4), FileMesh::from(sheet(12, 9)));
    let rows = |i: usize| (0..8).map(move |j| if i == j { 1.0 } else { 0.1 }).collect::<Vec<f64>>();
    let own = json!({"type": "c", "rows": (0..8).map(rows).collect::<Vec<_>>()});
    let objective = |regulariser: &str| {
        let request = json!({"given_map": own, "regulariser": {"type": regulariser}});
        matched(&sketch, &mesh, request).unwrap().solver.objective
    };
    let wanted = objective("none");
    assert!(wanted > 1.0);
    assert_eq!([objective("permuted_l1"), objective("part_indicator")], [wanted; 2]);
}

#[test]
fn regions_in_an_unknown_order_are_those_that_there_are() {
    let (sketch, mesh) = (drawing(9, 4), FileMesh::from(sheet(12, 9)));
    let halves = |vertices: usize, last: i32| -> Vec<i32> {
        (0..vertices).map(|v| if 2 * v < vertices { 0 } else { last }).collect()
    };
    let given = |last: i32| {
        let regions = json!({"method": "given", "sketch": halves(50, last), "mesh": halves(130, last)});
        matched(&sketch, &mesh, json!({"regulariser": {"type": "permuted_l1"}, "regions": regions})).unwrap()
    };
    let [counted, apart] = [1, 20].map(given);
    let pairs = |result: &MatchResult| -> Vec<[usize; 2]> {
        result.intermediate.regions.pairs.iter().map(|pair| [pair.sketch, pair.mesh]).collect()
    };
    let renamed = pairs(&counted).iter().map(|pair| pair.map(|number| 20 * number)).collect::<Vec<_>>();
    assert_eq!((pairs(&apart), apart.c), (renamed, counted.c));
}

#[test]
fn the_functions_of_a_part_are_those_of_its_objective() {
    let (sketch, mesh) = (drawing(9, 4), FileMesh::from(sheet(12, 9)));
    let landmarks = json!([{"sketch": sketch.point(7), "mesh": 30}]);
    let part = json!({"type": "part_indicator", "gamma": 0, "area_weight": 0, "boundary_weight": 0, "area": 0.6});
    let result = matched(&sketch, &mesh, json!({"landmarks": landmarks, "regulariser": part})).unwrap();
    let inside = Inside::of(&sketch, &mesh, &result, &Computing, &Unwatched).unwrap();
    assert_eq!(inside.a.ncols(), functions(&result));
    let energy = (result.c.to_mat() * &inside.a - &inside.b).squared_norm_l2();
    assert!((energy - result.solver.objective).abs() < 1e-9 * inside.b.squared_norm_l2());
}

#[test]
fn fewer_regions_than_asked_for_are_warned_of() {
    let (sketch, mesh) = (drawing(9, 4), FileMesh::from(sheet(12, 9)));
    let segmented = json!({"method": "segmented", "sketch_regions": 60, "mesh_regions": 2, "pairs": [[0, 0]]});
    let warnings = matched(&sketch, &mesh, json!({"regions": segmented})).unwrap().warnings;
    assert_eq!(warnings.len(), 1);
    assert!(warnings[0].ends_with("regions were found on the sketch where 60 were asked for"), "{warnings:?}");
}

#[test]
fn what_contradicts_itself_or_is_off_the_figure_is_found_before_the_match() {
    let sketch = drawing(9, 4);
    // A sheet, and beside it a smaller one.
    let [large, small] = [sheet(12, 9), sheet(2, 2)];
    let first = large.positions().len() as u32;
    let beside = small.positions().iter().map(|&[x, y, _]| [0.1 * x, 0.1 * y, 5.0]);
    let positions = large.positions().iter().copied().chain(beside).collect();
    let triangles = small.triangles().iter().map(|t| t.map(|v| first + v));
    let triangles = large.triangles().iter().copied().chain(triangles).collect();
    let mesh = FileMesh::from(TriangleMesh::new(positions, triangles).unwrap());
    let pointers = |request: Value| -> Vec<String> {
        let faults = faults_on_shapes(&settings(request.clone()), &sketch, &mesh);
        match matched(&sketch, &mesh, request) {
            Err(MatchError::Faults(later)) => assert_eq!(later, faults),
            other => assert!(other.is_ok() && faults.is_empty()),
        }
        faults.into_iter().map(|fault| fault.pointer).collect()
    };
    let twice = |mesh: u32| {
        let landmark = |mesh: u32| json!({"sketch": sketch.point(7), "mesh": mesh});
        json!({"landmarks": [landmark(0), landmark(mesh)]})
    };
    assert_eq!(pointers(twice(0)), [""; 0]);
    assert_eq!(pointers(twice(first - 1)), ["/landmarks/1/mesh"]);
    let points = |last: u32| {
        let vertices: Vec<u32> = (0..49).chain([last]).collect();
        json!({"given_map": {"type": "points", "mesh_vertices": vertices}})
    };
    assert_eq!(pointers(points(9)), [""; 0]);
    assert_eq!(pointers(points(first)), ["/given_map/mesh_vertices/49"]);
}
