//! One pose, or a sequence of them, from beginning to end.

use std::collections::BTreeMap;

use faer::Mat;

use super::maps::{Map, applied, moves};
use super::of_file::{Beside, beside};
use super::outcome::{HandleWeights, PoseResult, PosedFrame};
use super::request::PoseRequest;
use super::seen::Seen;
use super::{PoseError, WeightSource};
use crate::deformation::biharmonic_weights::Weights;
use crate::deformation::strain::strain;
use crate::deformation::transfer::{Carried, Transfer};
use crate::mesh::file_mesh::FileMesh;
use crate::numerics::{Share, Watch};
use crate::pipeline::TOTAL;
use crate::pipeline::outcome::{MatchResult, ViewReport};
use crate::sketch::Sketch;

/// Shares of the progress that is told: weights are minimised for every handle, the transfer is factored once, and each frame is
/// solved for.
const WEIGHTS: f64 = 0.6;
const TRANSFER: f64 = 0.1;
const FRAMES: f64 = 0.3;

/// The mesh of a match, posed as asked; the same input gives the same answer but for `timings_ms`. `clock` counts
/// milliseconds.
///
/// # Errors
/// [`PoseError`].
pub fn run(
    sketch: &Sketch,
    mesh: &FileMesh,
    matched: &MatchResult,
    request: &PoseRequest,
    source: &dyn WeightSource,
    watch: &dyn Watch,
    clock: &dyn Fn() -> f64,
) -> Result<PoseResult, PoseError> {
    let moves = moves(request, sketch).map_err(PoseError::Faults)?;
    let mut timings_ms = BTreeMap::new();
    let begun = clock();
    let mut timed = |stage: &str, since: f64| {
        timings_ms.insert(stage.to_owned(), clock() - since);
        clock()
    };
    let mut seen = Seen::of(sketch, mesh, matched)?;
    let flat: Vec<[f64; 2]> = sketch.mesh().positions().iter().map(|&[x, y, _]| [x, y]).collect();
    let (weights, frames) = match moves {
        Some(moves) => {
            let found = source.weights(&moves.held, &Share::between(watch, 0.0, WEIGHTS))?;
            let since = timed("weights", begun);
            let ask = || watch.proceed(WEIGHTS).map_err(PoseError::from);
            let transfer = Transfer::new(sketch.mesh(), mesh.sound(), &seen.places, &seen.pairs, ask)?;
            let since = timed("transfer", since);
            let mut frames = Vec::new();
            for (f, maps) in moves.frames.iter().enumerate() {
                let done = WEIGHTS + TRANSFER + FRAMES * f as f64 / moves.frames.len() as f64;
                let ask = || watch.proceed(done).map_err(PoseError::from);
                let drawing = blended(&flat, &found, maps);
                let moved = |v: usize, axis: usize| drawing[v][axis] - flat[v][axis];
                let offsets = transfer.carried(&Mat::from_fn(flat.len(), 2, moved), ask)?;
                frames.push((drawing, offsets));
            }
            timed("frames", since);
            (Some(reported(&found)), frames)
        }
        None => {
            let offsets = seen.as_drawn(sketch, mesh, watch)?;
            timed("frames", begun);
            (None, vec![(flat.clone(), offsets)])
        }
    };
    let of_file = beside(mesh, &seen);
    let posed = |(drawing, offsets)| posed(sketch, mesh, &seen, &of_file, drawing, &offsets);
    let frames = frames.into_iter().map(posed).collect();
    timed(TOTAL, begun);
    Ok(PoseResult {
        id: None,
        version: env!("CARGO_PKG_VERSION").to_owned(),
        matching: request.matching.clone(),
        sketch: matched.sketch.clone(),
        mesh: matched.mesh.clone(),
        request: request.clone(),
        view: ViewReport { toward_camera: seen.frame.toward_camera, up: seen.frame.up },
        weights,
        frames,
        timings_ms,
    })
}

/// The drawing moved by its handles (eq. 5.1).
fn blended(flat: &[[f64; 2]], weights: &Weights, maps: &[Map]) -> Vec<[f64; 2]> {
    let place = |(v, &p): (usize, &[f64; 2])| {
        maps.iter().enumerate().fold([0.0; 2], |[x, y], (function, map)| {
            let (weight, [u, w]) = (weights.values[(v, function)], applied(map, p));
            [x + weight * u, y + weight * w]
        })
    };
    flat.iter().enumerate().map(place).collect()
}

/// A frame in the coordinates of the uploads.
fn posed(
    sketch: &Sketch,
    mesh: &FileMesh,
    seen: &Seen,
    of_file: &[Option<Beside<'_>>],
    drawing: Vec<[f64; 2]>,
    offsets: &Carried,
) -> PosedFrame {
    let axes = seen.axes();
    let moved = |p: &[f64; 3], [x, y]: [f64; 2]| std::array::from_fn(|i| p[i] + x * axes[0][i] + y * axes[1][i]);
    let own = |v: usize| [offsets.values[(v, 0)], offsets.values[(v, 1)]];
    let places: Vec<[f64; 3]> = mesh.sound().positions().iter().zip(0..).map(|(p, v)| moved(p, own(v))).collect();
    let solid: Vec<[f64; 3]> = drawing.iter().map(|&[x, y]| [x, y, 0.0]).collect();
    let positions = mesh.positions().iter().zip(of_file).map(|(p, beside)| {
        // A vertex of no triangle stays.
        let place = beside.as_ref().map_or(*p, |beside| moved(p, [0, 1].map(|axis| beside.value(offsets, axis))));
        place.map(|x| Some(x).filter(|x| x.is_finite()))
    });
    PosedFrame {
        positions: positions.collect(),
        strain: strain(mesh.sound(), &places),
        drawing_strain: strain(sketch.mesh(), &solid),
        drawing: drawing.into_iter().map(|p| sketch.to_upload(p)).collect(),
    }
}

fn reported(weights: &Weights) -> HandleWeights {
    let rows = weights.values.row_iter().map(|row| row.iter().copied().collect());
    HandleWeights { values: rows.collect(), local_extrema: weights.extrema }
}

#[cfg(test)]
mod tests {
    use serde_json::{Value, json};

    use super::*;
    use crate::geometry::frame::Frame;
    use crate::geometry::{cross, dot, length, subtract, triangle_area};
    use crate::mesh::TriangleMesh;
    use crate::mesh::formats::{Format, Limits};
    use crate::mesh::solids::{ball, sheet, turned};
    use crate::mesh::validation::import;
    use crate::numerics::Unwatched;
    use crate::pipeline::Computing;
    use crate::posing::{Basis, basis};
    use crate::sketch::YAxis;

    /// How the body lies.
    const ANGLES: [f64; 2] = [0.7, 2.1];

    /// An ellipsoid drawn as a sheet with y down, 3.2 times as large, and the match of them: every vertex of the drawing
    /// answers with the nearest of those in front.
    struct Drawn {
        sketch: Sketch,
        mesh: FileMesh,
        matched: MatchResult,
    }

    fn drawn() -> Drawn {
        let (flat, upright) = (sheet(16, 8), ball(20, 40, |[x, y, z]| [2.0 * x, y, z]));
        let large = flat.positions().iter().map(|&[x, y, z]| [2.0 * x + 5.0, 2.0 * y - 3.0, z]).collect();
        let sketch = Sketch::new(TriangleMesh::new(large, flat.triangles().to_vec()).unwrap(), YAxis::Down).unwrap();
        let lying = upright.positions().iter().map(|&p| turned(p, ANGLES)).collect();
        let mesh: FileMesh = TriangleMesh::new(lying, upright.triangles().to_vec()).unwrap().into();
        let correspondences: Vec<Value> = (0..flat.positions().len())
            .map(|v| {
                let [x, y, _] = flat.positions()[v];
                let gap = |s: &usize| {
                    let [u, w, _] = upright.positions()[*s];
                    (1.6 * u + 0.707 - x).powi(2) + (1.6 * w + 0.354 - y).powi(2)
                };
                let front = (0..upright.positions().len()).filter(|&s| upright.positions()[s][2] > 0.0);
                let nearest = front.min_by(|a, b| gap(a).total_cmp(&gap(b))).unwrap();
                json!({"sketch_vertex": v, "point": sketch.point(v), "mesh_vertex": nearest, "confidence": 1.0})
            })
            .collect();
        let [toward_camera, up] = [[0.0, 0.0, 1.0], [0.0, 1.0, 0.0]].map(|axis| turned(axis, ANGLES));
        let nothing = json!({"rows": 0, "columns": 0, "values": []});
        let request = crate::pipeline::Settings::resolve(&crate::pipeline::request::MatchRequest::default()).unwrap();
        let matched = json!({
            "match": "m", "sketch": "s", "mesh": "b", "request": request, "c": nothing, "confidence": 1.0,
            "correspondences": correspondences, "alternatives": [], "warnings": [], "timings_ms": {},
            "alignment": {
                "view": {"toward_camera": toward_camera, "up": up}, "part": "whole", "by": "view",
                "contour_cost": 0.0, "distortion": 0.0, "score": 0.0, "mesh_vertices": [],
            },
            "solver": {"regulariser": "l1", "iterations": 0, "objective": 0.0, "stopped": "converged", "history": []},
            "intermediate": {
                "sketch_eigenvalues": [], "mesh_eigenvalues": [], "spectral_scale": 1.0, "initial_c": nothing,
                "weights": nothing, "regions": {"sketch": [], "mesh": [], "pairs": [], "cost": 0.0},
            },
        });
        Drawn { sketch, mesh, matched: serde_json::from_value(matched).unwrap() }
    }

    /// The same with a file of so many triangles that those matched are a third of them.
    fn drawn_of_many() -> Drawn {
        let whole = drawn();
        let mut obj = String::new();
        whole.mesh.positions().iter().for_each(|[x, y, z]| obj += &format!("v {x} {y} {z}\n"));
        whole.mesh.triangles().iter().for_each(|t| obj += &format!("f {} {} {}\n", t[0] + 1, t[1] + 1, t[2] + 1));
        let limits = Limits { triangles: whole.mesh.triangles().len() / 3, ..Limits::default() };
        let mesh = import(obj.as_bytes(), Format::Obj, &limits).unwrap().mesh;
        assert!(mesh.is_decimated() && mesh.positions() == whole.mesh.positions());
        Drawn { mesh, ..whole }
    }

    /// The areas of the file's triangles where its vertices are at these places.
    fn areas(mesh: &FileMesh, places: &[[f64; 3]]) -> Vec<f64> {
        mesh.triangles().iter().map(|t| triangle_area(t.map(|v| places[v as usize]))).collect()
    }

    fn handles() -> Value {
        // The sheet reaches from (5, 3) to (7.8, 1.6), y down.
        json!([
            {"type": "point", "at": [5.2, 2.2]}, {"type": "bone", "from": [6.0, 2.3], "to": [6.6, 2.3]},
            {"type": "point", "at": [7.6, 2.4]},
        ])
    }

    fn run_with(drawn: &Drawn, request: Value) -> PoseResult {
        let request = serde_json::from_value(request).unwrap();
        run(&drawn.sketch, &drawn.mesh, &drawn.matched, &request, &Computing, &Unwatched, &|| 0.0).unwrap()
    }

    fn places(frame: &PosedFrame) -> Vec<[f64; 3]> {
        frame.positions.iter().map(|p| p.map(Option::unwrap)).collect()
    }

    #[test]
    fn handles_that_stay_leave_everything_where_it_is() {
        [drawn(), drawn_of_many()].iter().for_each(stays);
    }

    fn stays(drawn: &Drawn) {
        let stay = json!({"type": "stay"});
        let turns_nothing = json!({"type": "rotation", "degrees": 0});
        let frames = json!([[stay, stay, stay], [turns_nothing, turns_nothing, turns_nothing]]);
        let result = run_with(drawn, json!({"match": "m", "handles": handles(), "frames": frames}));
        for frame in &result.frames {
            for (now, was) in places(frame).iter().zip(drawn.mesh.positions()) {
                assert!(length(subtract(*now, *was)) < 1e-8);
            }
            assert!(frame.strain.max_edge_change < 1e-8 && frame.strain.flipped_triangles == 0);
        }
        let rows = &result.weights.unwrap().values;
        assert!(rows.iter().all(|row| (row.iter().sum::<f64>() - 1.0).abs() < 1e-9));
    }

    #[test]
    fn a_motion_of_all_handles_moves_the_mesh_so() {
        [drawn(), drawn_of_many()].iter().for_each(moves_so);
    }

    fn moves_so(drawn: &Drawn) {
        let motion = json!({"type": "rotation", "degrees": 50, "about": [6, 2], "by": [0.5, -1]});
        let request = json!({"match": "m", "handles": handles(), "frames": [[motion, motion, motion]]});
        let result = run_with(drawn, request);
        let now = places(&result.frames[0]);
        // The motion in space: a turn about the line of sight, that takes a point of the drawing's plane where it goes.
        let (toward_camera, up) = (result.view.toward_camera, result.view.up);
        let right = cross(up, toward_camera);
        let frame = Frame { right, up, toward_camera };
        let (sin, cos) = 50f64.to_radians().sin_cos();
        let [before, after] = [drawn.mesh.positions(), &now].map(|all| all.iter().map(|&p| frame.project(p)).collect());
        let (before, after): (Vec<[f64; 2]>, Vec<[f64; 2]>) = (before, after);
        let shift = [0, 1].map(|axis| {
            let turned = |[x, y]: [f64; 2]| [cos * x - sin * y, sin * x + cos * y][axis];
            after[0][axis] - turned(before[0])
        });
        for v in 0..now.len() {
            let [x, y] = before[v];
            let expected = [cos * x - sin * y + shift[0], sin * x + cos * y + shift[1]];
            assert!((after[v][0] - expected[0]).hypot(after[v][1] - expected[1]) < 1e-8);
            assert!((dot(toward_camera, now[v]) - dot(toward_camera, drawn.mesh.positions()[v])).abs() < 1e-8);
        }
        // The middle of the drawing, which is 3.2 times as large, goes 1.53 far.
        let middle =
            [before, after].map(|all| [0, 1].map(|axis| all.iter().map(|p| p[axis]).sum::<f64>() / all.len() as f64));
        let went = (middle[1][0] - middle[0][0]).hypot(middle[1][1] - middle[0][1]);
        assert!((0.43..0.53).contains(&went), "{went}");
        let strain = &result.frames[0].strain;
        assert!(strain.max_edge_change < 1e-8 && strain.volume_change.unwrap().abs() < 1e-8);
    }

    #[test]
    fn a_bend_goes_over_to_both_sides_and_leaves_the_rest_alone() {
        let drawn = drawn();
        let (stay, turn) = (json!({"type": "stay"}), json!({"type": "rotation", "degrees": 30, "about": [6.9, 2.3]}));
        let request = json!({"match": "m", "handles": handles(), "frames": [[stay, stay, turn]]});
        let result = run_with(&drawn, request);
        let frame = &result.frames[0];
        assert_eq!((frame.strain.flipped_triangles, frame.drawing_strain.flipped_triangles), (0, 0));
        assert!(frame.strain.mean_edge_change < frame.drawing_strain.mean_edge_change + 0.02);
        let upright = ball(20, 40, |[x, y, z]| [2.0 * x, y, z]);
        let moved: Vec<f64> =
            places(frame).iter().zip(drawn.mesh.positions()).map(|(now, was)| length(subtract(*now, *was))).collect();
        for (v, &[x, y, z]) in upright.positions().iter().enumerate() {
            let behind = upright.positions().iter().position(|q| length(subtract(*q, [x, y, -z])) < 1e-9);
            if let Some(behind) = behind {
                // Within a thirtieth of its length.
                assert!((moved[v] - moved[behind]).abs() < 0.03, "{x} {y} {z}: {} {}", moved[v], moved[behind]);
            }
            assert!(x > -0.15 || moved[v] < 0.02, "{x} {y} {z}: {}", moved[v]);
            assert!(x < 0.35 || moved[v] > 0.05, "{x} {y} {z}: {}", moved[v]);
        }
    }

    #[test]
    fn a_file_of_many_triangles_is_bent_as_smoothly_as_one_of_few() {
        let (few, many) = (drawn(), drawn_of_many());
        let (stay, turn) = (json!({"type": "stay"}), json!({"type": "rotation", "degrees": 30, "about": [6.9, 2.3]}));
        let bend = json!({"match": "m", "handles": handles(), "frames": [[stay, stay, turn]]});
        for request in [bend, json!({"match": "m", "sketch": "s"})] {
            let [expected, found] = [&few, &many].map(|drawn| places(&run_with(drawn, request.clone()).frames[0]));
            let [whole, bent] = [&expected, &found].map(|places| areas(&few.mesh, places));
            let apart = found.iter().zip(&expected).map(|(a, b)| length(subtract(*a, *b))).fold(0.0, f64::max);
            let shares = || bent.iter().zip(&whole).map(|(a, b)| a / b);
            let (least, most) = (shares().fold(f64::INFINITY, f64::min), shares().fold(0.0, f64::max));
            assert!(apart < 0.02 && least > 0.75 && most < 1.25, "{apart} {least} {most}");
        }
    }

    #[test]
    fn the_basis_gives_the_same_places() {
        [drawn(), drawn_of_many()].iter().for_each(is_given_by_the_basis);
    }

    fn is_given_by_the_basis(drawn: &Drawn) {
        let frame = json!([
            {"type": "stay"}, {"type": "translation", "by": [0.1, 0.2]},
            {"type": "affine", "matrix": [[1.1, 0.2, -1.0], [0.1, 0.9, 0.3]]},
        ]);
        let result = run_with(drawn, json!({"match": "m", "handles": handles(), "frames": [frame]}));
        let Basis { values, places: flat, axes } =
            basis(&drawn.sketch, &drawn.mesh, &drawn.matched, result.weights.as_ref().unwrap()).unwrap();
        let maps = [
            [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
            [[1.0, 0.0, 0.1], [0.0, 1.0, 0.2]],
            [[1.1, 0.2, -1.0], [0.1, 0.9, 0.3]],
        ];
        for (v, now) in places(&result.frames[0]).iter().enumerate() {
            let sum = |row: usize| (0..9).map(|i| values[(v, i)] * maps[i / 3][row][i % 3]).sum::<f64>();
            let offset = [sum(0) - flat[v][0], sum(1) - flat[v][1]];
            let was = drawn.mesh.positions()[v];
            let found = std::array::from_fn(|i| was[i] + offset[0] * axes[0][i] + offset[1] * axes[1][i]);
            assert!(length(subtract(found, *now)) < 1e-8, "{v}: {found:?} {now:?}");
        }
    }

    #[test]
    fn a_mesh_takes_the_pose_it_is_drawn_in_and_stays_as_large() {
        let mut drawn = drawn();
        let asked = json!({"match": "m", "sketch": "s"});
        let still = run_with(&drawn, asked.clone()).frames[0].strain;
        // Drawn bent: a parabola for what is straight.
        let bent = |&[x, y, z]: &[f64; 3]| [x, y + 0.4 * (x - 6.4).powi(2), z];
        let (positions, triangles) =
            (drawn.sketch.mesh().positions().iter().map(bent), drawn.sketch.mesh().triangles());
        let mesh = TriangleMesh::new(positions.collect(), triangles.to_vec()).unwrap();
        drawn.sketch = Sketch::new(mesh, YAxis::Down).unwrap();
        let result = run_with(&drawn, asked);
        let strain = result.frames[0].strain;
        assert!(still.volume_change.unwrap().abs() < 0.15 && strain.volume_change.unwrap().abs() < 0.15, "{strain:?}");
        assert!(strain.mean_edge_change < 0.15 && strain.flipped_triangles == 0, "{strain:?}");
        let upright = ball(20, 40, |[x, y, z]| [2.0 * x, y, z]);
        let up = result.view.up;
        let height = |wanted: &dyn Fn(f64) -> bool| {
            let chosen = (0..upright.positions().len()).filter(|&v| wanted(upright.positions()[v][0]));
            let heights: Vec<f64> = chosen.map(|v| dot(up, places(&result.frames[0])[v])).collect();
            heights.iter().sum::<f64>() / heights.len() as f64
        };
        let lifted = height(&|x| x.abs() > 0.35) - height(&|x| x.abs() < 0.1);
        assert!((0.05..0.3).contains(&lifted), "{lifted}");
    }
}
