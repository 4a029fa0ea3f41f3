//! A match as a pose needs it: which vertices are pairs, and the mesh in the plane of the drawing.

use faer::Mat;
use kd_tree::KdTree;

use super::PoseError;
use crate::deformation::as_rigid_as_possible::{Elastic, Pull, led, rotations};
use crate::deformation::joined;
use crate::deformation::similarity::Similarity;
use crate::deformation::transfer::{Carried, Pair};
use crate::geometry::cross;
use crate::geometry::frame::Frame;
use crate::mesh::file_mesh::FileMesh;
use crate::numerics::Watch;
use crate::picture::{Matched, matched_view};
use crate::pipeline::outcome::{AlternativeKind, MatchResult, ViewReport};
use crate::sketch::Sketch;
use crate::spectral::laplacian::{Lumping, mass};

/// What a point without any confidence still weighs: where all are doubtful, they are all there is.
const DOUBTFUL: f64 = 0.01;

/// How near a vertex is to an answer that tells what becomes of it, in units of √area: what lies farther follows its twin.
const ANSWERED: f64 = 0.08;

/// How strongly the mesh is drawn to the places of the drawing beside its rigidity, both at area 1.
const DRAWN: f64 = 100.0;
/// Times the size of the mesh in the drawing is corrected, so that it stays as large as it is.
const SIZED: usize = 3;

/// Where the vertices are that are drawn elsewhere: as they are.
const AS_IS: Similarity = Similarity { scale: 1.0, turn: [1.0, 0.0], shift: [0.0; 2] };

pub(super) struct Seen {
    pub frame: Frame,
    pub pairs: Vec<Pair>,
    /// From the picture to the drawing.
    laid: Similarity,
    /// Vertices of the sound mesh in the plane of the drawing.
    pub places: Vec<[f64; 2]>,
}

impl Seen {
    /// # Errors
    /// [`PoseError::Unfit`] where the result is of other shapes.
    pub fn of(sketch: &Sketch, mesh: &FileMesh, matched: &MatchResult) -> Result<Seen, PoseError> {
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
        let drawn = |pair: &Pair| (seen[pair.surface as usize], drawn_at(sketch, pair), pair.weight);
        let laid = Similarity::fitted(near.iter().map(drawn));
        let places = seen.iter().map(|&p| laid.apply(p)).collect();
        let twins = twins(mesh, matched, &near, &frame);
        Ok(Seen { frame, pairs: near.into_iter().chain(twins).collect(), laid, places })
    }

    /// How a vertex of the mesh moves in space where its place in the plane of the drawing moves by 1 along x and along y.
    pub fn axes(&self) -> [[f64; 3]; 2] {
        let Frame { right, up, .. } = self.frame;
        [[1.0, 0.0], [0.0, 1.0]].map(|unit| {
            let [x, y] = self.laid.difference_back(unit);
            std::array::from_fn(|i| x * right[i] + y * up[i])
        })
    }

    /// Where a point of space lies in the plane of the drawing.
    pub fn place(&self, p: [f64; 3]) -> [f64; 2] {
        self.laid.apply(self.frame.project(p))
    }

    /// Offsets in the plane of the drawing that take the mesh to the pose it is drawn in, as rigidly as may be. The mesh
    /// stays as large as it is: what tells its size in the drawing is how far the links between its vertices are stretched.
    ///
    /// # Errors
    /// [`PoseError::Factorisation`], [`PoseError::Cancelled`].
    pub fn as_drawn(&mut self, sketch: &Sketch, mesh: &FileMesh, watch: &dyn Watch) -> Result<Carried, PoseError> {
        let reached: Vec<u32> = self.pairs.iter().map(|pair| pair.surface).collect();
        let elastic = Elastic::of(joined(mesh.sound(), &reached), self.places.len())?;
        let masses = mass(sketch.mesh(), Lumping::Barycentric);
        let share = |pair: &Pair| masses[pair.drawing as usize] * pair.weight;
        let total: f64 = self.pairs.iter().map(share).sum();
        let pull = |pair: &Pair| Pull {
            vertex: pair.surface,
            target: drawn_at(sketch, pair),
            weight: DRAWN * share(pair) / total,
        };
        let pulls: Vec<Pull> = self.pairs.iter().map(pull).collect();
        let middle: [f64; 2] =
            [0, 1].map(|axis| pulls.iter().map(|pull| pull.weight * pull.target[axis]).sum::<f64>() / DRAWN);
        for round in 0..SIZED {
            let ask = || watch.proceed(round as f64 / (SIZED + 1) as f64).map_err(PoseError::from);
            let now = led(&elastic, &self.places, &pulls, &AS_IS, ask)?;
            let [was, is] = [&self.places, &now].map(|places| elastic.size(places));
            let growth = if was > 0.0 && is > 0.0 { (is / was).sqrt() } else { 1.0 };
            let grown = |[x, y]: [f64; 2]| [middle[0] + growth * (x - middle[0]), middle[1] + growth * (y - middle[1])];
            self.laid = Similarity { scale: growth * self.laid.scale, shift: grown(self.laid.shift), ..self.laid };
            self.places.iter_mut().for_each(|place| *place = grown(*place));
        }
        let ask = || watch.proceed(SIZED as f64 / (SIZED + 1) as f64).map_err(PoseError::from);
        let now = led(&elastic, &self.places, &pulls, &AS_IS, ask)?;
        // What lies beside a vertex turns with its star.
        let turns = rotations(&elastic, &self.places, &now);
        let turned = |v: usize, column: usize| {
            let [c, s] = turns[v];
            [c - 1.0, -s, s, c - 1.0][column]
        };
        let n = now.len();
        let values = Mat::from_fn(n, 2, |v, axis| now[v][axis] - self.places[v][axis]);
        Ok(Carried { values, gradients: Mat::from_fn(n, 4, turned) })
    }
}

fn drawn_at(sketch: &Sketch, pair: &Pair) -> [f64; 2] {
    let [x, y, _] = sketch.mesh().positions()[pair.drawing as usize];
    [x, y]
}

/// The pairs of what is not seen of a body that is drawn from its side: the twins of those in front on its other side, where
/// no answer is near. Seen from another direction twins lie beside each other and not behind, and there are none.
fn twins(mesh: &FileMesh, matched: &MatchResult, near: &[Pair], frame: &Frame) -> Vec<Pair> {
    let mirrored = matched.alternatives.iter().find(|other| other.kind == AlternativeKind::Mirrored);
    let Some(mirrored) = mirrored else { return Vec::new() };
    let positions = mesh.sound().positions();
    let answers: Vec<[f64; 3]> = near.iter().map(|pair| positions[pair.surface as usize]).collect();
    let answers = KdTree::build_by_ordered_float(answers);
    let reach = ANSWERED * ANSWERED * mesh.sound().area();
    let mut twins = Vec::new();
    let (mut aside, mut behind) = (0.0, 0.0);
    for (pair, &vertex) in near.iter().zip(&mirrored.mesh_vertices) {
        let Some(twin) = mesh.sound_vertices(vertex).next() else { continue };
        let (p, q) = (positions[pair.surface as usize], positions[twin as usize]);
        let ([x, y], [u, v]) = (frame.project(p), frame.project(q));
        aside += pair.weight * (x - u).hypot(y - v);
        behind += pair.weight * (frame.depth(p) - frame.depth(q)).abs();
        if answers.nearest(&q).is_none_or(|answer| answer.squared_distance > reach) {
            twins.push(Pair { surface: twin, ..*pair });
        }
    }
    if aside < behind { twins } else { Vec::new() }
}
