//! One pose, or a sequence of them, from beginning to end.

use std::collections::BTreeMap;

use faer::Mat;

use super::PoseError;
use super::maps::{Map, applied, moves};
use super::outcome::{HandleWeights, PoseResult, PosedFrame};
use super::request::PoseRequest;
use crate::deformation::as_rigid_as_possible::{Elastic, Pull, deformed};
use crate::deformation::biharmonic_weights::{Weights, weights};
use crate::deformation::joined;
use crate::deformation::similarity::Similarity;
use crate::deformation::strain::strain;
use crate::deformation::transfer::{Pair, Transfer};
use crate::geometry::cross;
use crate::geometry::frame::Frame;
use crate::mesh::file_mesh::FileMesh;
use crate::numerics::{Cancelled, Watch};
use crate::picture::{Matched, matched_view};
use crate::pipeline::TOTAL;
use crate::pipeline::outcome::{AlternativeKind, MatchResult, SeenPart, ViewReport};
use crate::sketch::Sketch;
use crate::spectral::laplacian::{Lumping, mass};

/// What a point without any confidence still weighs: where all are doubtful, they are all there is.
const DOUBTFUL: f64 = 0.01;

/// How strongly the mesh is drawn to the places of the drawing beside its rigidity, both at area 1.
const DRAWN: f64 = 100.0;

/// A match as it is posed by: pairs of vertices, and the mesh in the plane of the drawing.
struct Seen {
    frame: Frame,
    pairs: Vec<Pair>,
    /// From the picture to the drawing.
    laid: Similarity,
    /// Vertices of the sound mesh in the plane of the drawing.
    places: Vec<[f64; 2]>,
}

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
    let seen = Seen::of(sketch, mesh, matched)?;
    let flat: Vec<[f64; 2]> = sketch.mesh().positions().iter().map(|&[x, y, _]| [x, y]).collect();
    let (weights, frames) = match moves {
        Some(moves) => {
            let found = weights(&moves.held, &Share { watch, begin: 0.0, end: 0.6 })?;
            let since = timed("weights", begun);
            let transfer = Transfer::new(sketch.mesh(), mesh.sound(), &seen.places, &seen.pairs)?;
            let since = timed("transfer", since);
            let mut frames = Vec::new();
            for (f, maps) in moves.frames.iter().enumerate() {
                watch.proceed(0.7 + 0.3 * f as f64 / moves.frames.len() as f64)?;
                let drawing = blended(&flat, &found, maps);
                let moved = |v: usize, axis: usize| drawing[v][axis] - flat[v][axis];
                let moved = transfer.carried(&Mat::from_fn(flat.len(), 2, moved));
                let offsets = (0..seen.places.len()).map(|v| [moved[(v, 0)], moved[(v, 1)]]).collect();
                frames.push((drawing, offsets));
            }
            timed("frames", since);
            (Some(reported(&found)), frames)
        }
        None => {
            watch.proceed(0.1)?;
            let offsets = seen.as_drawn(sketch, mesh)?;
            timed("frames", begun);
            (None, vec![(flat.clone(), offsets)])
        }
    };
    let frames = frames.into_iter().map(|(drawing, offsets)| posed(sketch, mesh, &seen, drawing, offsets)).collect();
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

impl Seen {
    fn of(sketch: &Sketch, mesh: &FileMesh, matched: &MatchResult) -> Result<Seen, PoseError> {
        let sound = mesh.sound();
        // Where there is no such vertex this is one past the last, and refused.
        let own = |vertex: u32| mesh.sound_vertices(vertex).next().unwrap_or(sound.positions().len() as u32);
        let points: Vec<(u32, f64)> =
            matched.correspondences.iter().map(|point| (own(point.mesh_vertex), point.confidence)).collect();
        let view = matched.alignment.as_ref().map(|alignment| {
            let ViewReport { toward_camera, up } = alignment.view;
            Frame { right: cross(up, toward_camera), up, toward_camera }
        });
        let frame = matched_view(&Matched::new(sketch, sound, points.iter().copied(), view)?);
        let seen: Vec<[f64; 2]> = sound.positions().iter().map(|&p| frame.project(p)).collect();
        let weight = |confidence: f64| DOUBTFUL + (1.0 - DOUBTFUL) * confidence.clamp(0.0, 1.0);
        let near: Vec<Pair> = points
            .iter()
            .zip(0..)
            .map(|(&(surface, confidence), drawing)| Pair { drawing, surface, weight: weight(confidence) })
            .collect();
        let drawn = |pair: &Pair| {
            let [x, y, _] = sketch.mesh().positions()[pair.drawing as usize];
            (seen[pair.surface as usize], [x, y], pair.weight)
        };
        let laid = Similarity::fitted(near.iter().map(drawn));
        let places = seen.iter().map(|&p| laid.apply(p)).collect();
        let twins = twins(mesh, matched, &near, &frame);
        Ok(Seen { frame, pairs: near.into_iter().chain(twins).collect(), laid, places })
    }

    /// Offsets in the plane of the drawing that take the mesh to the pose it is drawn in, as rigidly as may be.
    fn as_drawn(&self, sketch: &Sketch, mesh: &FileMesh) -> Result<Vec<[f64; 2]>, PoseError> {
        let reached: Vec<u32> = self.pairs.iter().map(|pair| pair.surface).collect();
        let elastic = Elastic::of(joined(mesh.sound(), &reached), self.places.len())?;
        let masses = mass(sketch.mesh(), Lumping::Barycentric);
        let total: f64 = self.pairs.iter().map(|pair| masses[pair.drawing as usize] * pair.weight).sum();
        let pull = |pair: &Pair| {
            let [x, y, _] = sketch.mesh().positions()[pair.drawing as usize];
            let share = masses[pair.drawing as usize] * pair.weight / total;
            Pull { vertex: pair.surface, target: [x, y], weight: DRAWN * share }
        };
        let pulls: Vec<Pull> = self.pairs.iter().map(pull).collect();
        let now = deformed(&elastic, &self.places, &pulls)?;
        Ok(now.iter().zip(&self.places).map(|(now, was)| [now[0] - was[0], now[1] - was[1]]).collect())
    }
}

/// The pairs of the side that is not seen, where one side is drawn for both: the twins of those in front, if they do lie
/// behind them.
fn twins(mesh: &FileMesh, matched: &MatchResult, near: &[Pair], frame: &Frame) -> Vec<Pair> {
    let sideways = matched.alignment.as_ref().is_some_and(|alignment| alignment.part == SeenPart::Side);
    let mirrored = matched.alternatives.iter().find(|other| other.kind == AlternativeKind::Mirrored);
    let (true, Some(mirrored)) = (sideways, mirrored) else { return Vec::new() };
    let positions = mesh.sound().positions();
    let mut twins = Vec::new();
    let (mut aside, mut behind) = (0.0, 0.0);
    for (pair, &vertex) in near.iter().zip(&mirrored.mesh_vertices) {
        let Some(twin) = mesh.sound_vertices(vertex).next() else { continue };
        let (p, q) = (positions[pair.surface as usize], positions[twin as usize]);
        let ([x, y], [u, v]) = (frame.project(p), frame.project(q));
        aside += pair.weight * (x - u).hypot(y - v);
        behind += pair.weight * (frame.depth(p) - frame.depth(q)).abs();
        twins.push(Pair { surface: twin, ..*pair });
    }
    if aside < behind { twins } else { Vec::new() }
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
fn posed(sketch: &Sketch, mesh: &FileMesh, seen: &Seen, drawing: Vec<[f64; 2]>, offsets: Vec<[f64; 2]>) -> PosedFrame {
    let Frame { right, up, .. } = seen.frame;
    let places: Vec<[f64; 3]> = mesh
        .sound()
        .positions()
        .iter()
        .zip(offsets)
        .map(|(p, offset)| {
            let [x, y] = seen.laid.difference_back(offset);
            std::array::from_fn(|i| p[i] + x * right[i] + y * up[i])
        })
        .collect();
    let solid: Vec<[f64; 3]> = drawing.iter().map(|&[x, y]| [x, y, 0.0]).collect();
    let of_file = mesh.positions().iter().zip(0..).map(|(&p, v)| {
        // A vertex of no triangle stays.
        let place = mesh.sound_vertices(v).next().map_or(p, |own| places[own as usize]);
        place.map(|x| Some(x).filter(|x| x.is_finite()))
    });
    PosedFrame {
        positions: of_file.collect(),
        strain: strain(mesh.sound(), &places),
        drawing_strain: strain(sketch.mesh(), &solid),
        drawing: drawing.into_iter().map(|p| sketch.to_upload(p)).collect(),
    }
}

fn reported(weights: &Weights) -> HandleWeights {
    let rows = weights.values.row_iter().map(|row| row.iter().copied().collect());
    HandleWeights { values: rows.collect(), local_extrema: weights.extrema }
}

/// A part of the whole.
struct Share<'a> {
    watch: &'a dyn Watch,
    begin: f64,
    end: f64,
}

impl Watch for Share<'_> {
    fn proceed(&self, fraction: f64) -> Result<(), Cancelled> {
        self.watch.proceed(self.begin + (self.end - self.begin) * fraction)
    }
}
