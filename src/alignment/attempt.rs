//! A sketch laid on one view of a mesh, and how well it lies there.

use super::candidates::{Candidate, Kind};
use super::energy::{Distortion, distortion};
use super::flat_shape::FlatShape;
use super::frame::Frame;
use super::laying::{Laying, laid};
use super::pose::{self, posed};
use super::prepared::PreparedMesh;
use super::view::View;
use super::visible::Visible;
use super::{AlignmentError, Pair};
use crate::numerics::Watch;

/// What a view from anywhere must be better by than one along an axis of the body.
const SPHERE_PENALTY: f64 = 0.02;
/// The cost of the outlines above which another pose is looked for.
const POSE_FROM: f64 = 0.05;
/// What a radian of swing must be worth.
const EFFORT: f64 = 0.005;
/// The distance from a landmark's vertex a landmark counts with at most, and its price beside the other costs.
const LANDMARK_MOST: f64 = 0.4;
const LANDMARK_PRICE: f64 = 1.0;

/// A sketch on one view.
pub(super) struct Attempt {
    pub view: View,
    pub kind: Kind,
    /// All swings of the pose together, in radians; 0 for the mesh as it is.
    pub swing: f64,
    /// n × 3, as seen.
    pub positions: Vec<[f64; 3]>,
    pub laying: Laying,
    /// A vertex of the mesh for every vertex of the sketch.
    pub map: Vec<u32>,
    pub distortion: Distortion,
    /// Mean truncated distance of the landmarks' answers from the landmarks; 0 without any.
    pub astray: f64,
}

impl Attempt {
    /// The sketch on the candidate's view of the mesh as it is.
    pub fn on(
        shape: &FlatShape,
        mesh: &PreparedMesh,
        candidate: Candidate,
        landmarks: &[Pair],
    ) -> Result<Attempt, AlignmentError> {
        let Candidate { view, kind, .. } = candidate;
        Attempt::seen(shape, mesh, (view, kind), mesh.positions.clone(), 0.0, landmarks)
    }

    pub fn seen(
        shape: &FlatShape,
        mesh: &PreparedMesh,
        (view, kind): (View, Kind),
        positions: Vec<[f64; 3]>,
        swing: f64,
        landmarks: &[Pair],
    ) -> Result<Attempt, AlignmentError> {
        let laying = laid(shape, &view)?;
        let map = lifted(mesh, &positions, &view.frame, &laying.positions);
        let distortion = distortion(shape, &mesh.distances, &map);
        let astray = astray(mesh, &map, landmarks);
        Ok(Attempt { view, kind, swing, positions, laying, map, distortion, astray })
    }

    /// What the attempt costs: outlines, distortion, landmarks missed; the less the better.
    pub fn score(&self) -> f64 {
        let unusual = if matches!(self.kind, Kind::Sphere(_)) { SPHERE_PENALTY } else { 0.0 };
        self.laying.cost + self.distortion.mean + LANDMARK_PRICE * self.astray + EFFORT * self.swing + unusual
    }

    /// The attempt with the mesh's limbs swung as the sketch has them, where that explains it better.
    pub fn in_pose(
        self,
        shape: &FlatShape,
        mesh: &PreparedMesh,
        landmarks: &[Pair],
        watch: &dyn Watch,
    ) -> Result<Attempt, AlignmentError> {
        if self.laying.cost <= POSE_FROM || mesh.limbs.is_empty() {
            return Ok(self);
        }
        let pose = pose::fitted(shape, mesh, &self.view, watch)?;
        let positions = posed(mesh, &self.view.frame, &pose.angles);
        let swing = pose.angles.iter().map(|angle| angle.abs()).sum();
        let posed = Attempt::seen(shape, mesh, (pose.view, self.kind), positions, swing, landmarks)?;
        Ok(if posed.score() < self.score() { posed } else { self })
    }

    /// The same places on the other side of the body: the answer were the sketch drawn from behind.
    pub fn mirrored(&self, mesh: &PreparedMesh) -> (Frame, Vec<u32>) {
        let behind = self.view.frame.from_behind();
        let flat: Vec<[f64; 2]> = self.laying.positions.iter().map(|&[x, y]| [-x, y]).collect();
        (behind, lifted(mesh, &self.positions, &behind, &flat))
    }
}

/// The vertices in front of places in the picture.
fn lifted(mesh: &PreparedMesh, positions: &[[f64; 3]], frame: &Frame, places: &[[f64; 2]]) -> Vec<u32> {
    let visible = Visible::new(positions, &mesh.triangles, frame);
    places.iter().map(|&place| visible.vertex(place)).collect()
}

fn astray(mesh: &PreparedMesh, map: &[u32], landmarks: &[Pair]) -> f64 {
    let distance = |pair: &Pair| mesh.distances.between(map[pair.sketch as usize], pair.mesh).min(LANDMARK_MOST);
    landmarks.iter().map(distance).sum::<f64>() / landmarks.len().max(1) as f64
}
