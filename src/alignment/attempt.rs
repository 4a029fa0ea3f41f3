//! A sketch laid on one view of a mesh, and how well it lies there.

use super::candidates::{Candidate, Kind};
use super::energy::{Distortion, distortion};
use super::flat_shape::FlatShape;
use super::frame::Frame;
use super::landmarks::Landmarks;
use super::laying::{Laying, laid};
use super::pose::{self, posed};
use super::prepared::PreparedMesh;
use super::view::View;
use super::visible::Visible;
use super::warping::{differences, warp};
use super::{AlignmentError, Pair};
use crate::numerics::Watch;

/// The cost of the outlines above which another pose is looked for.
const POSE_FROM: f64 = 0.05;
/// What a radian of swing must be worth.
const EFFORT: f64 = 0.005;
/// The price of landmarks missed beside the other costs.
const LANDMARK_PRICE: f64 = 0.2;

/// A sketch on one view.
#[derive(Clone)]
pub(super) struct Attempt {
    pub view: View,
    pub kind: Kind,
    /// The swing of every limb, in radians; 0 for the mesh as it is.
    pub angles: Vec<f64>,
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
        landmarks: &Landmarks,
    ) -> Result<Attempt, AlignmentError> {
        let angles = vec![0.0; mesh.limbs.len()];
        Attempt::seen(shape, mesh, candidate, mesh.positions.clone(), angles, landmarks)
    }

    pub fn seen(
        shape: &FlatShape,
        mesh: &PreparedMesh,
        candidate: Candidate,
        positions: Vec<[f64; 3]>,
        angles: Vec<f64>,
        landmarks: &Landmarks,
    ) -> Result<Attempt, AlignmentError> {
        let Candidate { view, kind, differences, warp } = candidate;
        let laying = laid(shape, &view, &differences, &warp, &[])?;
        let map = lifted(mesh, &positions, &view.frame, &laying.positions);
        let distortion = distortion(shape, &mesh.distances, &map);
        let astray = landmarks.astray(mesh, &map);
        Ok(Attempt { view, kind, angles, positions, laying, map, distortion, astray })
    }

    /// What the attempt costs: outlines, distortion, landmarks missed; the less the better.
    pub fn score(&self) -> f64 {
        let own = self.laying.cost + self.distortion.mean + LANDMARK_PRICE * self.astray + EFFORT * self.swing();
        own + self.kind.penalty()
    }

    /// All swings of the pose together, in radians.
    pub fn swing(&self) -> f64 {
        self.angles.iter().map(|angle| angle.abs()).sum()
    }

    /// The attempt with the mesh's limbs swung as the sketch has them, where that explains it better and is likely to
    /// score no more than `most`.
    pub fn in_pose(
        self,
        shape: &FlatShape,
        mesh: &PreparedMesh,
        landmarks: &Landmarks,
        most: f64,
        watch: &dyn Watch,
    ) -> Result<Attempt, AlignmentError> {
        if self.laying.cost <= POSE_FROM || mesh.limbs.is_empty() {
            return Ok(self);
        }
        // As if the other costs were to remain.
        let most = most - (self.score() - self.laying.cost);
        let Some(pose) = pose::fitted(shape, mesh, &self.view, most, watch)? else { return Ok(self) };
        let positions = posed(mesh, &self.view.frame, &pose.angles);
        let candidate = Candidate::new(shape, pose.view, self.kind);
        let posed = Attempt::seen(shape, mesh, candidate, positions, pose.angles, landmarks)?;
        Ok(if posed.score() < self.score() { posed } else { self })
    }

    /// The sketch laid by the help of the landmarks on the mesh in another pose, in every way and from both sides.
    pub fn led(
        &self,
        shape: &FlatShape,
        mesh: &PreparedMesh,
        landmarks: &Landmarks,
        angles: Vec<f64>,
    ) -> Result<Vec<Attempt>, AlignmentError> {
        let positions = posed(mesh, &self.view.frame, &angles);
        let front = View::through(self.view.frame, &positions, &mesh.triangles, mesh.closed);
        let layings = self.layings(shape, mesh, landmarks, &front, &positions)?;
        let behind = front.from_behind();
        let mut attempts = Vec::new();
        for (view, turned) in [(behind, true), (front, false)] {
            let visible = Visible::new(&positions, &mesh.triangles, mesh.closed, &view.frame);
            for laying in &layings {
                let laying = if turned { laying.turned_round() } else { laying.clone() };
                let map: Vec<u32> = laying.positions.iter().map(|&place| visible.vertex(place)).collect();
                let (view, kind, angles, positions) = (view.clone(), self.kind, angles.clone(), positions.clone());
                let (distortion, astray) = (distortion(shape, &mesh.distances, &map), landmarks.astray(mesh, &map));
                attempts.push(Attempt { view, kind, angles, positions, laying, map, distortion, astray });
            }
        }
        Ok(attempts)
    }

    /// The attempt with another map.
    pub fn answering(self, shape: &FlatShape, mesh: &PreparedMesh, landmarks: &Landmarks, map: Vec<u32>) -> Attempt {
        let (distortion, astray) = (distortion(shape, &mesh.distances, &map), landmarks.astray(mesh, &map));
        Attempt { map, distortion, astray, ..self }
    }

    /// The sketch laid on a view without the landmarks, with the contours led by them, and pinned to them besides.
    fn layings(
        &self,
        shape: &FlatShape,
        mesh: &PreparedMesh,
        landmarks: &Landmarks,
        view: &View,
        positions: &[[f64; 3]],
    ) -> Result<[Laying; 3], AlignmentError> {
        let differences = differences(&shape.contour, &view.contour);
        let mut biased = differences.clone();
        landmarks.bias(&mut biased, mesh, view, positions, self.distortion.scale);
        let (plain, led) = (warp(&differences), warp(&biased));
        let place = |pair: &Pair| (pair.sketch, view.frame.project(positions[pair.mesh as usize]));
        let pinned: Vec<(u32, [f64; 2])> = landmarks.pairs.iter().map(place).collect();
        Ok([
            laid(shape, view, &differences, &plain, &[])?,
            laid(shape, view, &differences, &led, &[])?,
            laid(shape, view, &differences, &led, &pinned)?,
        ])
    }

    /// The same places on the other side of the body, as a map: the answer were the sketch drawn from behind.
    pub fn mirrored(&self, mesh: &PreparedMesh) -> (Frame, Vec<u32>) {
        let behind = self.view.frame.from_behind();
        (behind, lifted(mesh, &self.positions, &behind, &self.laying.turned_round().positions))
    }

    /// The same places on the other side of the body, as an attempt.
    pub fn turned_round(&self, shape: &FlatShape, mesh: &PreparedMesh, landmarks: &Landmarks) -> Attempt {
        let (view, laying) = (self.view.from_behind(), self.laying.turned_round());
        let (_, map) = self.mirrored(mesh);
        Attempt { view, laying, ..self.clone() }.answering(shape, mesh, landmarks, map)
    }
}

/// The attempts on the candidates, best first, but for those that cannot come within `margin` of the best.
pub(super) fn attempts(
    shape: &FlatShape,
    mesh: &PreparedMesh,
    candidates: Vec<Candidate>,
    landmarks: &Landmarks,
    margin: f64,
) -> Result<Vec<Attempt>, AlignmentError> {
    let mut candidates: Vec<(usize, Candidate)> = candidates.into_iter().enumerate().collect();
    candidates.sort_by(|a, b| a.1.least_score().total_cmp(&b.1.least_score()));
    let mut best = f64::INFINITY;
    let mut attempts: Vec<(usize, Attempt)> = Vec::new();
    for (rank, candidate) in candidates {
        if candidate.least_score() > best + margin {
            break;
        }
        let attempt = Attempt::on(shape, mesh, candidate, landmarks)?;
        best = best.min(attempt.score());
        attempts.push((rank, attempt));
    }
    attempts.sort_by(|a, b| a.1.score().total_cmp(&b.1.score()).then(a.0.cmp(&b.0)));
    Ok(attempts.into_iter().map(|(_, attempt)| attempt).collect())
}

/// The vertices in front of places in the picture.
fn lifted(mesh: &PreparedMesh, positions: &[[f64; 3]], frame: &Frame, places: &[[f64; 2]]) -> Vec<u32> {
    let visible = Visible::new(positions, &mesh.triangles, mesh.closed, frame);
    places.iter().map(|&place| visible.vertex(place)).collect()
}
