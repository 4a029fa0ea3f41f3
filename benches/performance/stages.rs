//! The stages of a match on one thread.

use faer::MatRef;
use sketchmatch::alignment::prepared::PreparedMesh;
use sketchmatch::correspondence::{points, zoomout};
use sketchmatch::descriptors::projection::projections;
use sketchmatch::descriptors::{heat_kernel, wave_kernel};
use sketchmatch::example::{Creature, VERTICES};
use sketchmatch::functional_map::problem::{Problem, least_squares};
use sketchmatch::functional_map::regulariser::Regulariser;
use sketchmatch::functional_map::solve::solve;
use sketchmatch::functional_map::weights::{Weights, weights};
use sketchmatch::mesh::TriangleMesh;
use sketchmatch::mesh::formats::{Format, Limits};
use sketchmatch::mesh::validation::import;
use sketchmatch::numerics::{Cancelled, Unwatched, Watch};
use sketchmatch::regions::Regions;
use sketchmatch::sketch::Sketch;
use sketchmatch::spectral::Spectrum;

use crate::known::{Match, eigenpairs};
use crate::table::{Reach, Table, timed};
use crate::{pen, posing, shapes};

const REGIONS: usize = 7;
const COMPONENTS: usize = 100;

/// All rows of one thread but growth.
pub fn rows(table: &Table) {
    let (mesh, sketch) = (shapes::body(shapes::LARGE), shapes::drawn());
    for k in [20, 50, 100] {
        let sample = timed(|| eigenpairs(&mesh, k));
        table.time(&format!("eigenpairs k = {k}, 50K"), &sample, Some(&format!("eig {k}")), Reach::Times(8.0));
    }
    let (psi, phi) = (eigenpairs(&mesh, 100).at_unit_area(100), eigenpairs(sketch.mesh(), 100).at_unit_area(100));
    let (l20, k20) = (psi.at_unit_area(20), phi.at_unit_area(20));

    let (on_mesh, on_sketch) = (strips(&mesh), strips(sketch.mesh()));
    let sample = timed(|| descriptors(&l20, &l20.eigenvalues, &on_mesh));
    let name = "HKS 100 + WKS 100 × 7 regions, k = 20, 50K";
    table.time(name, &sample, Some("descriptors"), Reach::Times(20.0));

    let mut problem = Problem::unconstrained(20, 20);
    let sides = [descriptors(&k20, &k20.eigenvalues, &on_sketch), descriptors(&l20, &k20.eigenvalues, &on_mesh)];
    for (a, b) in sides[0].iter().zip(&sides[1]) {
        problem.constrain(a.as_ref(), b.as_ref()).expect("descriptors are finite");
    }
    let start = least_squares(&problem).expect("there is a least C");
    let kind = Weights::Cosamp { sparsity: 0.8, power: 1.2 };
    let w = weights(&kind, start.as_ref(), &k20.eigenvalues, &l20.eigenvalues);
    for (kind, most) in [("none", 5.0), ("l2", 5.0), ("l1", 5.0), ("nuclear", 20.0)] {
        let regulariser: Regulariser =
            serde_json::from_value(serde_json::json!({"type": kind})).expect("a regulariser");
        let sample = timed(|| solve(&problem, &regulariser, &w, start.clone(), &Unwatched).expect("there is a C"));
        table.time(&format!("C, {kind}, k = 20, 200 iterations"), &sample, Some("fit"), Reach::Most(most));
    }

    let (c, small, large) = (start.as_ref(), k20.eigenfunctions.as_ref(), l20.eigenfunctions.as_ref());
    type Conversion = fn(MatRef<f64>, MatRef<f64>, MatRef<f64>, &dyn Watch) -> Result<Vec<u32>, Cancelled>;
    let kinds: [(&str, Conversion, f64); 2] =
        [("indicator", points::by_indicator, 40.0), ("nearest", points::by_nearest_neighbour, 20.0)];
    for (kind, convert, most) in kinds {
        let sample = timed(|| convert(c, small, large, &Unwatched));
        let name = format!("point map, {kind}, {} to 50K, k = 20", small.nrows());
        table.time(&name, &sample, Some(kind), Reach::Most(most));
    }
    let (small, large) = (phi.eigenfunctions.as_ref(), psi.eigenfunctions.as_ref());
    let sample = timed(|| zoomout::refined(start.clone(), small, &phi.mass, large, None, &Unwatched));
    table.time("ZoomOut 20 → 100, 50K", &sample, Some("zoomout"), Reach::Times(8.0));

    let small_mesh = shapes::body(shapes::SMALL);
    matches(table, &sketch, &small_mesh, &mesh);
    scribbles(table);
    posing::rows(table, &sketch, &mesh);
    for (size, mesh, most) in [("5K", &small_mesh, 1e3), ("50K", &mesh, 8e3)] {
        let sample = timed(|| (eigenpairs(mesh, 150), PreparedMesh::new(mesh, &Unwatched)));
        table.time(&format!("a new mesh: 150 pairs and preparation, {size}"), &sample, None, Reach::Most(most));
    }
    let file = shapes::obj(&mesh);
    let sample = timed(|| {
        let mesh =
            import(file.as_bytes(), Format::Obj, &Limits::default()).expect("the body is valid").mesh.sound().clone();
        mesh.content_hash()
    });
    table.time("upload of an OBJ: parse, validate, hash, 50K", &sample, None, Reach::Most(150.0));
}

fn matches(table: &Table, sketch: &Sketch, small: &TriangleMesh, large: &TriangleMesh) {
    for (preset, size, mesh, most) in
        [("thesis", "50K", large, 120.0), ("automatic", "5K", small, 150.0), ("automatic", "50K", large, 250.0)]
    {
        let of_mesh = Match::of(mesh, preset);
        let sample = timed(|| of_mesh.run(sketch));
        table.time(&format!("{preset} preset, mesh known, sketch new, {size}"), &sample, None, Reach::Most(most));
    }
}

/// The example creatures as a hand draws them that trembles, read and matched.
fn scribbles(table: &Table) {
    for creature in Creature::ALL {
        let mesh = creature.mesh(VERTICES).expect("the creature is a mesh");
        let silhouette = creature.silhouette(&mesh).expect("the creature can be seen");
        let picture = pen::png(&pen::line(&silhouette, true), 1024);
        let of_mesh = Match::of(&mesh, "automatic");
        let sample = timed(|| of_mesh.run(&shapes::read(&picture)));
        let name = format!("automatic preset, mesh known, {} as a scribble of 1024 × 1024, 5K", creature.name());
        table.time(&name, &sample, None, Reach::Most(800.0));
    }
}

/// The coefficients of every region's descriptors, k × 200 each.
fn descriptors(spectrum: &Spectrum, common: &[f64], regions: &Regions) -> Vec<faer::Mat<f64>> {
    let heat = heat_kernel::filters(&spectrum.eigenvalues, &heat_kernel::times(common, COMPONENTS));
    let wave = wave_kernel::filters(&spectrum.eigenvalues, &wave_kernel::energies(common, COMPONENTS, 6.0));
    let regions = projections(spectrum, regions, &Unwatched).expect("nobody cancels");
    regions.iter().flat_map(|region| [&region.gram * &heat, &region.gram * &wave]).collect()
}

/// Seven regions by the lengthwise coordinate: z of the body, x of the drawing.
fn strips(mesh: &TriangleMesh) -> Regions {
    let flat = mesh.positions().iter().all(|p| p[2] == 0.0);
    let along = |p: &[f64; 3]| if flat { -p[0] } else { p[2] };
    let (low, high) = mesh.positions().iter().map(along).fold((f64::MAX, f64::MIN), |(l, h), x| (l.min(x), h.max(x)));
    let label = |p| ((along(p) - low) / (high - low) * REGIONS as f64).min(REGIONS as f64 - 1.0) as i32;
    Regions::new(mesh.positions().iter().map(label).collect()).expect("seven labels are in range")
}
