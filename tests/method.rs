//! The method as a whole, on the example creatures, without the service.

use std::cell::RefCell;
use std::collections::BTreeSet;
use std::sync::atomic::{AtomicUsize, Ordering};

use serde_json::{Value, json};
use sketchmatch::correspondence::{functional_map, points};
use sketchmatch::evaluation::measures::mean;
use sketchmatch::evaluation::truth::Truth;
use sketchmatch::example;
use sketchmatch::mesh::TriangleMesh;
use sketchmatch::mesh::file_mesh::FileMesh;
use sketchmatch::mesh::formats::{Format, Limits};
use sketchmatch::mesh::validation::import;
use sketchmatch::numerics::{Cancelled, Unwatched};
use sketchmatch::pipeline::outcome::{MatchResult, Rating};
use sketchmatch::pipeline::request::MatchRequest;
use sketchmatch::pipeline::{self, Computing, Inside, MatchError, Settings, Stage, Surroundings, Watcher, functions};
use sketchmatch::sketch::outline::OutlineRequest;
use sketchmatch::sketch::{self, Sketch};
use sketchmatch::spectral::laplacian::Lumping;
use sketchmatch::spectral::{Boundary, spectrum, spectrum_with};

struct Case {
    sketch: Sketch,
    mesh: TriangleMesh,
    truth: Truth,
}

/// A creature with a mesh and a sketch small enough for many matches.
fn case(creature: &str) -> Case {
    sized(creature, 2000, 400)
}

fn sized(creature: &str, mesh_vertices: usize, sketch_vertices: usize) -> Case {
    let files = example::files(mesh_vertices).unwrap();
    let file = |name: &str| &files.iter().find(|(path, _)| *path == format!("{creature}/{name}")).unwrap().1;
    let drawing: OutlineRequest = serde_json::from_slice(file("sketch.json")).unwrap();
    let (drawing, _) = drawing.into_parts();
    Case {
        sketch: sketch::from_outline(&drawing, sketch_vertices, &sketch::Config::default()).unwrap().sketch,
        mesh: import(file("mesh.obj"), Format::Obj, &Limits::default()).unwrap().mesh.sound().clone(),
        truth: serde_json::from_slice(file("truth.json")).unwrap(),
    }
}

/// Cancels at the question with this number.
struct CancelsAt {
    question: usize,
    asked: AtomicUsize,
}

impl Watcher for CancelsAt {
    fn proceed(&self, _stage: Stage, fraction: f64) -> Result<(), Cancelled> {
        assert!((0.0..=1.0).contains(&fraction));
        let asked = self.asked.fetch_add(1, Ordering::Relaxed);
        if asked == self.question { Err(Cancelled) } else { Ok(()) }
    }
}

fn settings(request: Value) -> Settings {
    let mut whole = json!({"mesh": "mesh", "sketch": "sketch"});
    whole.as_object_mut().unwrap().extend(request.as_object().unwrap().clone());
    let request: MatchRequest = serde_json::from_value(whole).unwrap();
    Settings::resolve(&request).unwrap()
}

fn matched(case: &Case, request: Value, watcher: &dyn Watcher) -> Result<MatchResult, MatchError> {
    let surroundings =
        Surroundings { spectra: &Computing, preparations: &Computing, watcher, clock: &|| 0.0, preview: None };
    pipeline::run(&case.sketch, &case.mesh.clone().into(), &settings(request), &surroundings)
}

fn patient() -> CancelsAt {
    CancelsAt { question: usize::MAX, asked: AtomicUsize::new(0) }
}

#[test]
fn eigenvalues_agree_with_those_of_scipy() {
    let golden: Value = serde_json::from_str(include_str!("golden/quadruped_eigenvalues.json")).unwrap();
    let mesh = case("quadruped").mesh;
    let spectrum = spectrum_with(&mesh, Lumping::Barycentric, 60, Boundary::Neumann, &Unwatched).unwrap();
    for (j, expected) in golden["eigenvalues"].as_array().unwrap().iter().enumerate().skip(1) {
        let ratio = spectrum.eigenvalues[j] / expected.as_f64().unwrap();
        assert!((ratio - 1.0).abs() < 1e-6, "λ_{j}: {ratio}");
    }
}

#[test]
fn a_map_fitted_to_the_truth_gives_the_true_points_within_the_limit_of_its_basis() {
    for creature in ["quadruped", "biped"] {
        let Case { sketch, mesh, truth } = sized(creature, 5000, 800);
        let file = FileMesh::from(mesh.clone());
        let at: Vec<[f64; 2]> = (0..sketch.mesh().positions().len()).map(|v| sketch.point(v)).collect();
        // The true image of a vertex of the sketch: that of the nearest point of the truth.
        let nearest = |[x, y]: [f64; 2]| {
            let distance = |p: &[f64; 2]| (p[0] - x).hypot(p[1] - y);
            let points = &truth.points;
            (0..points.len()).min_by(|&a, &b| distance(&points[a]).total_cmp(&distance(&points[b]))).unwrap()
        };
        let map: Vec<u32> = at.iter().map(|&p| truth.variants["front"][nearest(p)] as u32).collect();
        // What was measured on other shapes is 0.044 and 0.016.
        for (k, limit) in [(20, 0.05), (100, 0.02)] {
            let [phi, psi] = [sketch.mesh(), &mesh]
                .map(|shape| spectrum(shape, k, Boundary::Neumann, &Unwatched).unwrap().at_unit_area(k));
            let (phi, psi, mass) = (phi.eigenfunctions.as_ref(), psi.eigenfunctions.as_ref(), &phi.mass);
            let c = functional_map(phi, mass, psi, &map);
            let read = points::by_nearest_neighbour(c.as_ref(), phi, psi, &Unwatched).unwrap();
            let error = mean(truth.errors(&file, &truth.answers(&at, &read)).coherent());
            assert!(error < limit, "{creature}, k = {k}: {error}");
        }
    }
}

#[test]
fn the_answer_at_first_sight_comes_once_and_first() {
    let case = sized("quadruped", 800, 300);
    let (watcher, previews) = (patient(), RefCell::new(Vec::new()));
    let keep = |result: MatchResult| previews.borrow_mut().push((watcher.asked.load(Ordering::Relaxed), result));
    let surroundings = Surroundings {
        spectra: &Computing,
        preparations: &Computing,
        watcher: &watcher,
        clock: &|| 0.0,
        preview: Some(&keep),
    };
    let mesh = case.mesh.clone().into();
    let result = pipeline::run(&case.sketch, &mesh, &settings(json!({})), &surroundings).unwrap();
    let [(asked, preview)] = &previews.take()[..] else { panic!("not one") };
    assert!(*asked < watcher.asked.load(Ordering::Relaxed));
    assert!(preview.preview && !result.preview);
    assert!(preview.alternatives.is_empty() && !result.alternatives.is_empty());
    assert_eq!(preview.correspondences.len(), result.correspondences.len());
    assert_eq!(result, matched(&case, json!({}), &patient()).unwrap());
}

#[test]
fn every_point_lies_on_a_triangle_of_its_vertex() {
    let case = sized("quadruped", 800, 300);
    let result = matched(&case, json!({}), &patient()).unwrap();
    let triangles: BTreeSet<[u32; 3]> = case.mesh.triangles().iter().copied().collect();
    let mut between = 0;
    for point in &result.correspondences {
        let (triangle, weights) = (point.triangle.unwrap(), point.barycentric.unwrap());
        assert!(triangles.contains(&triangle) && triangle.contains(&point.mesh_vertex));
        assert!(weights.iter().all(|w| (0.0..=1.0).contains(w)) && (weights.iter().sum::<f64>() - 1.0).abs() < 1e-9);
        between += usize::from(weights.iter().all(|&w| w < 1.0));
    }
    assert!(2 * between > result.correspondences.len(), "{between}");
    let by_map = matched(&case, json!({"conversion": {"method": "nearest"}}), &patient()).unwrap();
    for point in &by_map.correspondences {
        let corner = point.triangle.unwrap().iter().position(|&v| v == point.mesh_vertex).unwrap();
        assert_eq!(point.barycentric.unwrap()[corner], 1.0);
    }
}

#[test]
fn a_shape_matched_with_itself_gives_the_identity() {
    let Case { sketch, .. } = case("quadruped");
    let mesh = sketch.mesh().clone();
    let n = mesh.positions().len();
    let labels: Vec<i32> = mesh.positions().iter().map(|p| (p[0] / 60.0) as i32).collect();
    let itself = Case { sketch, mesh, truth: case("quadruped").truth };
    let request = json!({
        "regions": {"method": "given", "sketch": labels, "mesh": labels},
        "alignment": {"method": "none"}, "regulariser": {"type": "none"},
    });
    let result = matched(&itself, request, &patient()).unwrap();
    for (i, row) in result.c.values.iter().enumerate() {
        for (j, value) in row.iter().enumerate() {
            let expected = if i == j { 1.0 } else { 0.0 };
            assert!((value - expected).abs() < 1e-6, "C[{i}, {j}] = {value}");
        }
    }
    assert_eq!(result.correspondences.len(), n);
    assert!(result.correspondences.iter().all(|c| c.sketch_vertex == c.mesh_vertex));
    assert!(result.confidence > 1.0 - 1e-9);
}

/// Mean coherent error of the result.
fn error(case: &Case, result: &MatchResult) -> f64 {
    let at: Vec<[f64; 2]> = result.correspondences.iter().map(|c| c.point).collect();
    let to: Vec<u32> = result.correspondences.iter().map(|c| c.mesh_vertex).collect();
    let mesh = FileMesh::from(case.mesh.clone());
    mean(case.truth.errors(&mesh, &case.truth.answers(&at, &to)).coherent())
}

/// The case with another mesh, its vertices moved one by one.
fn moved(case: &Case, place: impl Fn([f64; 3]) -> [f64; 3]) -> Case {
    let positions = case.mesh.positions().iter().map(|&p| place(p)).collect();
    let mesh = TriangleMesh::new(positions, case.mesh.triangles().to_vec()).unwrap();
    Case { sketch: case.sketch.clone(), mesh, truth: case.truth.clone() }
}

#[test]
fn a_match_needs_no_hand_and_no_particular_place_of_the_mesh() {
    for creature in ["quadruped", "biped"] {
        let case = case(creature);
        let plain = matched(&case, json!({}), &patient()).unwrap();
        assert!(error(&case, &plain) < 0.04, "{creature}: {}", error(&case, &plain));
        assert!(plain.confidence > 0.8 && !plain.alternatives.is_empty());
        // Turned about a slanted axis by 120°, moved, and a thousand times as large.
        let turned = moved(&case, |[x, y, z]| [1e3 * y + 7.0, 1e3 * z, 1e3 * x]);
        let result = matched(&turned, json!({}), &patient()).unwrap();
        assert!(error(&turned, &result) < 0.04, "{creature} turned: {}", error(&turned, &result));
    }
}

#[test]
fn a_large_map_of_the_alignment_reads_as_its_points() {
    let case = case("biped");
    let aligned = matched(&case, json!({}), &patient()).unwrap();
    let basis = json!({"basis": {"k": 100}, "conversion": {"method": "nearest"}});
    let read = matched(&case, basis, &patient()).unwrap();
    let of_alignment = read.alignment.as_ref().unwrap().mesh_vertices.clone();
    assert!(aligned.correspondences.iter().map(|c| c.mesh_vertex).eq(of_alignment));
    assert!((error(&case, &read) - error(&case, &aligned)).abs() < 0.01, "{}", error(&case, &read));
}

#[test]
fn landmarks_are_kept_exactly() {
    let case = case("quadruped");
    let vertex = case.sketch.mesh().positions().len() / 2;
    let landmark = json!([{"sketch": case.sketch.point(vertex), "mesh": 17}]);
    for conversion in ["alignment", "nearest", "indicator"] {
        let request = json!({"landmarks": landmark, "conversion": {"method": conversion}});
        let result = matched(&case, request, &patient()).unwrap();
        assert_eq!(result.correspondences[vertex].mesh_vertex, 17, "{conversion}");
    }
}

#[test]
fn landmarks_that_contradict_the_drawing_are_not_believed() {
    let case = case("quadruped");
    let (points, vertices) = (case.sketch.mesh().positions().len(), case.mesh.positions().len());
    // Every vertex of the sketch at a vertex of the mesh that has nothing to do with it.
    let scattered: Value = (0..points)
        .map(|point| json!({"sketch": case.sketch.point(point), "mesh": (point * 7919 + 13) % vertices}))
        .collect();
    let result = matched(&case, json!({"landmarks": scattered}), &patient()).unwrap();
    assert!(result.rating.is_some_and(|rating| rating != Rating::High), "{}", result.confidence);
    assert!(result.warnings.iter().any(|warning| warning.contains("landmark")), "{:?}", result.warnings);
    // One place of the sketch at a thousand of the mesh.
    let torn: Value = (0..1000).map(|landmark| json!({"sketch": case.sketch.point(0), "mesh": landmark * 4})).collect();
    let refusal = matched(&case, json!({"landmarks": torn}), &patient()).unwrap_err().to_string();
    assert!(refusal.contains("/landmarks/"), "{refusal}");
}

/// Landmarks of the truth's points nearest to these places, at the vertices of a variant.
fn landmarks(case: &Case, places: &[[f64; 2]], variant: &[i64]) -> Value {
    let nearest = |place: &[f64; 2]| {
        let squared = |p: &[f64; 2]| (p[0] - place[0]).powi(2) + (p[1] - place[1]).powi(2);
        let points = case.truth.points.iter().enumerate();
        points.min_by(|a, b| squared(a.1).total_cmp(&squared(b.1))).unwrap().0
    };
    let pair = |p: usize| json!({"sketch": case.truth.points[p], "mesh": variant[p]});
    places.iter().map(nearest).map(pair).collect()
}

/// Mean error of the result, held to one variant of the truth.
fn error_from(case: &Case, variant: &[i64], result: &MatchResult) -> f64 {
    let truth = Truth { variants: [("only".to_owned(), variant.to_vec())].into(), ..case.truth.clone() };
    error(&Case { sketch: case.sketch.clone(), mesh: case.mesh.clone(), truth }, result)
}

#[test]
fn landmarks_tell_the_side() {
    let case = case("quadruped");
    let points = &case.truth.points;
    let (first, last) = (points[0], points[points.len() - 1]);
    for variant in ["front", "back"].map(|variant| &case.truth.variants[variant]) {
        let told = landmarks(&case, &[first, points[points.len() / 2], last], variant);
        let result = matched(&case, json!({"landmarks": told}), &patient()).unwrap();
        let error = error_from(&case, variant, &result);
        assert!(error < 0.05, "{error}");
    }
}

#[test]
fn a_flat_mesh_can_be_aligned_with() {
    let Case { sketch, .. } = case("quadruped");
    let flat = Case { mesh: sketch.mesh().clone(), sketch, truth: case("quadruped").truth };
    let result = matched(&flat, json!({}), &patient()).unwrap();
    assert_eq!(result.correspondences.len(), flat.sketch.mesh().positions().len());
}

#[test]
fn what_needs_an_alignment_is_refused_without_one() {
    let request = json!({"mesh": "m", "sketch": "s", "preset": "thesis", "part": "side",
        "conversion": {"method": "alignment"}});
    let request: MatchRequest = serde_json::from_value(request).unwrap();
    let faults = Settings::resolve(&request).unwrap_err();
    assert!(faults.iter().any(|fault| fault.pointer == "/part"));
}

#[test]
fn every_setting_runs_with_a_rectangular_map_and_twice_the_same() {
    let case = case("quadruped");
    let requests = [
        json!({}),
        json!({"part": "side", "conversion": {"method": "indicator"}}),
        json!({"alignment": {"method": "none"}}),
        json!({"preset": "thesis"}),
        json!({"preset": "thesis", "regulariser": {"type": "l2", "solver": "conjugate_gradient"}}),
        json!({"preset": "thesis", "regulariser": {"type": "nuclear"}, "weights": {"method": "none"}}),
        json!({"regulariser": {"type": "none"}, "weights": {"method": "slant"}, "basis": {"boundary": "dirichlet"}}),
        json!({"refinement": {"method": "zoomout", "k": 40}, "basis": {"k": 15, "k_mesh": 22}}),
        json!({"refinement": {"method": "icp", "iterations": 3}, "descriptors": {"columns": "raw"}}),
        json!({"regions": {"method": "segmented", "sketch_regions": 5, "mesh_regions": 6, "pairs": [[0, 0], [1, 2]]}}),
        json!({"landmarks": [{"sketch": [300.0, 300.0], "mesh": 17}], "descriptors": {"spectral_scale": "area"}}),
    ];
    for request in requests {
        let first = matched(&case, request.clone(), &patient()).unwrap();
        let (rows, columns) = (first.c.values.len(), first.c.values[0].len());
        assert_eq!((rows, columns), (first.c.rows, first.c.columns));
        assert_eq!(first.correspondences.len(), case.sketch.mesh().positions().len());
        let vertices = case.mesh.positions().len() as u32;
        assert!(first.correspondences.iter().all(|c| c.mesh_vertex < vertices && (0.0..=1.0).contains(&c.confidence)));
        let start = first.solver.history[0];
        assert!(first.solver.objective <= start * (1.0 + 1e-12) + 1e-12, "{request}");
        // The settings the result tells are a request for the same.
        let resent = serde_json::to_value(&first.request).unwrap();
        let again = matched(&case, resent, &patient()).unwrap();
        assert_eq!(serde_json::to_string(&first).unwrap(), serde_json::to_string(&again).unwrap());
    }
}

#[test]
fn the_thesis_preset_runs_its_two_hundred_iterations() {
    let result = matched(&case("biped"), json!({"preset": "thesis"}), &patient()).unwrap();
    assert_eq!((result.solver.iterations, result.solver.history.len()), (200, 201));
    assert_eq!((result.c.rows, result.c.columns), (20, 20));
}

#[test]
fn a_match_can_be_cancelled_at_any_question() {
    let case = case("quadruped");
    let asked = patient();
    matched(&case, json!({"preset": "thesis"}), &asked).unwrap();
    let questions = asked.asked.into_inner();
    assert!(questions > 200, "asked only {questions} times");
    // How often is asked during a factorisation depends on how long it takes: the last questions may not come again.
    for question in (0..questions).step_by(questions / 12).take(9) {
        let watcher = CancelsAt { question, asked: AtomicUsize::new(0) };
        let cancelled = matched(&case, json!({"preset": "thesis"}), &watcher);
        assert!(matches!(cancelled, Err(MatchError::Cancelled(_))), "question {question}");
    }
}

#[test]
fn every_fault_of_a_request_is_named() {
    let request = json!({
        "mesh": "m", "sketch": "s", "basis": {"k": 0, "k_mesh": 501},
        "descriptors": {"hks": {"times": [2.0, 1.0]}, "wks": {"variance": 0.0}},
        "regions": {"method": "segmented", "sketch_regions": 3, "mesh_regions": 99, "pairs": [[3, 0]]},
        "regulariser": {"type": "l1", "gamma": -1.0, "max_iterations": 0},
        "weights": {"method": "cosamp", "sparsity": 0.0},
        "refinement": {"method": "icp", "iterations": 0},
    });
    let request: MatchRequest = serde_json::from_value(request).unwrap();
    let faults = Settings::resolve(&request).unwrap_err();
    let pointers: Vec<&str> = faults.iter().map(|fault| fault.pointer.as_str()).collect();
    for pointer in [
        "/basis/k",
        "/basis/k_mesh",
        "/descriptors/hks/times",
        "/descriptors/wks/variance",
        "/regions/mesh_regions",
        "/regions/pairs/0/0",
        "/weights/sparsity",
        "/regulariser/gamma",
        "/regulariser/max_iterations",
        "/refinement/iterations",
        "/refinement",
    ] {
        assert!(pointers.contains(&pointer), "{pointer} not among {pointers:?}");
    }
}

#[test]
fn the_constraints_made_again_of_a_result_are_those_of_its_objective() {
    let case = case("quadruped");
    let mesh = FileMesh::from(case.mesh.clone());
    let landmarks = landmarks(&case, &[case.truth.points[0]], &case.truth.variants["front"]);
    for request in [
        json!({"regulariser": {"type": "none"}, "landmarks": landmarks}),
        json!({"preset": "thesis", "regulariser": {"type": "none"}, "descriptors": {"columns": "raw"}}),
    ] {
        let result = matched(&case, request, &patient()).unwrap();
        let inside = Inside::of(&case.sketch, &mesh, &result, &Computing, &Unwatched).unwrap();
        assert_eq!(inside.a.ncols(), functions(&result));
        let c = result.c.to_mat();
        let objective = (&c * &inside.a - &inside.b).squared_norm_l2();
        let scale = inside.b.squared_norm_l2();
        assert!((objective - result.solver.objective).abs() < 1e-9 * scale, "{objective} {}", result.solver.objective);
    }
}
