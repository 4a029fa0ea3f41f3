//! A sketch laid on one view of a mesh, and how well it lies there.

use super::explanation::{self, Turn};
use super::terms::Terms;
use crate::alignment::answer::Place;
use crate::alignment::contour::view::View;
use crate::alignment::contour::warping::warp;
use crate::alignment::distances::distortion::{Distortion, distortion};
use crate::alignment::distances::kriging::kriged;
use crate::alignment::error::AlignmentError;
use crate::alignment::laying::{Laying, laid};
use crate::alignment::prepared::PreparedMesh;
use crate::alignment::scene::Scene;
use crate::alignment::scene::landmarks::{Landmarks, Pair};
use crate::alignment::search::candidates::{Candidate, Kind};
use crate::alignment::search::differences::differences;
use crate::alignment::search::following::followed;
use crate::alignment::search::pose::{self, Move, Pose, posed};
use crate::geometry::frame::Frame;
use crate::numerics::side_by_side;
use crate::raster::visible::Visible;

/// The cost of the outlines above which another pose is looked for.
const POSE_FROM: f64 = 0.05;
/// The price of landmarks missed beside the other costs.
const LANDMARK_PRICE: f64 = 0.2;

/// A sketch on one view.
#[derive(Clone)]
pub struct Attempt {
    pub view: View,
    pub kind: Kind,
    /// How every limb is moved.
    pub moves: Vec<Move>,
    /// n × 3, as seen.
    pub positions: Vec<[f64; 3]>,
    pub laying: Laying,
    /// A vertex of the mesh for every vertex of the sketch.
    pub map: Vec<u32>,
    pub distortion: Distortion,
    /// Mean truncated distance of the landmarks' answers from the landmarks; 0 without any.
    pub astray: f64,
    pub terms: Terms,
}

/// A mesh in a pose, and a view of it.
struct Shown {
    view: View,
    kind: Kind,
    moves: Vec<Move>,
    positions: Vec<[f64; 3]>,
}

impl Attempt {
    /// The sketch on the candidate's view of the mesh as it is.
    pub fn on(scene: &Scene<'_>, candidate: Candidate, landmarks: &Landmarks) -> Result<Attempt, AlignmentError> {
        let moves = vec![Move::default(); scene.mesh.limbs.len()];
        Attempt::seen(scene, candidate, scene.mesh.positions.clone(), moves, landmarks)
    }

    fn seen(
        scene: &Scene<'_>,
        candidate: Candidate,
        positions: Vec<[f64; 3]>,
        moves: Vec<Move>,
        landmarks: &Landmarks,
    ) -> Result<Attempt, AlignmentError> {
        let Candidate { view, kind, differences, warp } = candidate;
        let laying = laid(scene.shape, &view, &differences, &warp, &[])?;
        let map = lifted(scene.mesh, &positions, &view.frame, &laying.positions);
        Ok(Attempt::of(scene, Shown { view, kind, moves, positions }, laying, map, landmarks))
    }

    /// The attempt that consists of these, judged.
    fn of(scene: &Scene<'_>, shown: Shown, laying: Laying, map: Vec<u32>, landmarks: &Landmarks) -> Attempt {
        let Shown { view, kind, moves, positions } = shown;
        let distortion = distortion(scene.shape, &scene.mesh.distances, &map);
        let astray = landmarks.astray(scene.mesh, &map);
        let terms = terms(scene, &view, kind, &moves, &laying, &map, distortion.mean);
        Attempt { view, kind, moves, positions, laying, map, distortion, astray, terms }
    }

    /// What the attempt costs: outlines, distortion, landmarks missed; the less the better.
    pub fn score(&self) -> f64 {
        self.terms.score() + LANDMARK_PRICE * self.astray
    }

    /// Whether the mesh is in another pose than its own.
    pub fn is_posed(&self) -> bool {
        self.moves.iter().any(|step| *step != Move::default())
    }

    /// The attempt with the mesh's limbs moved as the warp of the outlines has them, where that explains it better.
    pub fn following(self, scene: &Scene<'_>, landmarks: &Landmarks) -> Result<Attempt, AlignmentError> {
        if self.laying.cost <= POSE_FROM || scene.mesh.limbs.is_empty() {
            return Ok(self);
        }
        let pose = followed(scene, &self.view)?;
        self.or_in(scene, pose, landmarks)
    }

    /// The attempt with the mesh's pose searched on, where that explains it better.
    pub fn refined(self, scene: &Scene<'_>, landmarks: &Landmarks) -> Result<Attempt, AlignmentError> {
        if self.laying.cost <= POSE_FROM || scene.mesh.limbs.is_empty() {
            return Ok(self);
        }
        let start = Pose { moves: self.moves.clone(), view: self.view.clone(), cost: self.laying.cost };
        let pose = pose::refined(scene, start)?;
        self.or_in(scene, pose, landmarks)
    }

    /// The attempt, or that in the pose if it scores less.
    fn or_in(self, scene: &Scene<'_>, pose: Pose, landmarks: &Landmarks) -> Result<Attempt, AlignmentError> {
        if pose.moves == self.moves {
            return Ok(self);
        }
        let positions = posed(scene.mesh, &self.view.frame, &pose.moves);
        let candidate = Candidate::new(scene, pose.view, self.kind);
        let posed = Attempt::seen(scene, candidate, positions, pose.moves, landmarks)?;
        Ok(if posed.score() < self.score() { posed } else { self })
    }

    /// The camera with the picture turned as the drawing is seen.
    pub fn as_drawn(&self, scene: &Scene<'_>) -> Frame {
        let (turn, frame) = turn(scene, &self.view.frame, &self.laying);
        let frame = frame.rolled(turn.of(scene.shape.turned([1.0, 0.0])));
        if self.laying.reflected { frame.from_behind() } else { frame }
    }

    /// The sketch laid by the help of the landmarks on the mesh in another pose, in every way and from both sides.
    pub fn led(
        &self,
        scene: &Scene<'_>,
        landmarks: &Landmarks,
        moves: Vec<Move>,
    ) -> Result<Vec<Attempt>, AlignmentError> {
        let mesh = scene.mesh;
        let positions = posed(mesh, &self.view.frame, &moves);
        let front = View::through(self.view.frame, &positions, &mesh.triangles, mesh.closed);
        let layings = self.layings(scene, landmarks, &front, &positions)?;
        let behind = front.from_behind();
        let mut attempts = Vec::new();
        for (view, turned) in [(behind, true), (front, false)] {
            let visible = Visible::new(&positions, &mesh.triangles, mesh.closed, &view.frame);
            for laying in &layings {
                let laying = if turned { laying.turned_round() } else { laying.clone() };
                let map: Vec<u32> = laying.positions.iter().map(|&place| visible.vertex(place)).collect();
                let (moves, positions) = (moves.clone(), positions.clone());
                let shown = Shown { view: view.clone(), kind: self.kind, moves, positions };
                attempts.push(Attempt::of(scene, shown, laying, map, landmarks));
            }
        }
        Ok(attempts)
    }

    /// The attempt with every landmark where it is known to be, and its surroundings moved along.
    pub fn moved(self, scene: &Scene<'_>, landmarks: &Landmarks) -> Result<Attempt, AlignmentError> {
        let map = kriged(&scene.mesh.distances, &self.map, landmarks, scene.watch)?;
        let moved = if map == self.map { self } else { self.answering(scene, landmarks, map) };
        Ok(moved.holding(scene, landmarks))
    }

    /// The attempt with every landmark where it is known to be: what the user knows is not traded for anything, and whether
    /// it fits shows in the distances.
    pub fn holding(self, scene: &Scene<'_>, landmarks: &Landmarks) -> Attempt {
        let mut map = self.map.clone();
        landmarks.pairs.iter().for_each(|pair| map[pair.sketch as usize] = pair.mesh);
        if map == self.map { self } else { self.answering(scene, landmarks, map) }
    }

    /// The attempt with another map.
    pub fn answering(self, scene: &Scene<'_>, landmarks: &Landmarks, map: Vec<u32>) -> Attempt {
        let Attempt { view, kind, moves, positions, laying, .. } = self;
        Attempt::of(scene, Shown { view, kind, moves, positions }, laying, map, landmarks)
    }

    /// The sketch laid on a view without the landmarks, with the contours led by them, and pinned to them besides.
    fn layings(
        &self,
        scene: &Scene<'_>,
        landmarks: &Landmarks,
        view: &View,
        positions: &[[f64; 3]],
    ) -> Result<[Laying; 3], AlignmentError> {
        let differences = differences(scene, view);
        let mut biased = differences.clone();
        landmarks.bias(&mut biased, scene.mesh, view, positions, self.distortion.scale);
        let (plain, led) = (warp(&differences), warp(&biased));
        let place = |pair: &Pair| (pair.sketch, view.frame.project(positions[pair.mesh as usize]));
        let pinned: Vec<(u32, [f64; 2])> = landmarks.pairs.iter().map(place).collect();
        let shape = scene.shape;
        Ok([
            laid(shape, view, &differences, &plain, &[])?,
            laid(shape, view, &differences, &led, &[])?,
            laid(shape, view, &differences, &led, &pinned)?,
        ])
    }

    /// For every vertex of the sketch its place between the vertices of the mesh, where its answer is what is in front of
    /// where it lies in the picture.
    pub fn places(&self, mesh: &PreparedMesh) -> Vec<Option<Place>> {
        let visible = Visible::new(&self.positions, &mesh.triangles, mesh.closed, &self.view.frame);
        let place = |(&vertex, &at): (&u32, &[f64; 2])| {
            let (triangle, weights) = visible.place(at).filter(|_| visible.vertex(at) == vertex)?;
            Some(Place { triangle, weights })
        };
        self.map.iter().zip(&self.laying.positions).map(place).collect()
    }

    /// The same places on the other side of the body, as a map: the answer were the sketch drawn from behind.
    pub fn mirrored(&self, mesh: &PreparedMesh) -> (Frame, Vec<u32>) {
        let behind = self.view.frame.from_behind();
        (behind, lifted(mesh, &self.positions, &behind, &self.laying.turned_round().positions))
    }

    /// The same places on the other side of the body, as an attempt.
    pub fn turned_round(&self, scene: &Scene<'_>, landmarks: &Landmarks) -> Attempt {
        let (view, laying) = (self.view.from_behind(), self.laying.turned_round());
        let (_, map) = self.mirrored(scene.mesh);
        Attempt { view, laying, ..self.clone() }.answering(scene, landmarks, map)
    }
}

/// What speaks against an attempt.
fn terms(
    scene: &Scene<'_>,
    view: &View,
    kind: Kind,
    moves: &[Move],
    laying: &Laying,
    map: &[u32],
    distortion: f64,
) -> Terms {
    let (turn, frame) = turn(scene, &view.frame, laying);
    let outline = if laying.reflected { &view.from_behind().contour } else { &view.contour };
    let toward = view.frame.toward_camera;
    let sum = |of: fn(&Move) -> f64| moves.iter().map(of).sum::<f64>();
    Terms {
        contour: laying.cost,
        distortion,
        swing: sum(|step| step.swing.abs() + step.bend.abs()),
        stretch: sum(|step| step.stretch.abs()),
        sphere: f64::from(matches!(kind, Kind::Sphere(_))),
        tilt: scene.upright.map_or(0.0, |upright| explanation::tilt(&upright, &frame, &turn)),
        mismatch: explanation::mismatch(&scene.shape.contour.curve, &turn, &outline.curve),
        disorder: explanation::disorder(scene, map),
        uncovered: explanation::uncovered(scene, toward, map),
        turned_about: scene.upright.map_or(0.0, |upright| {
            let ups = [upright.sketch, frame.project(upright.mesh)];
            explanation::turned_about([&scene.shape.contour.curve, &outline.curve], ups)
        }),
        askew: scene.upright.map_or(0.0, |upright| {
            let samples = scene.mesh.distances.samples.iter().map(|&v| scene.mesh.positions[v as usize]);
            explanation::askew(samples, scene.mesh.symmetry.normal, upright.mesh, toward)
        }),
        eyes_astray: scene.eyes.map_or(0.0, |eyes| explanation::eyes_astray(eyes, map)),
    }
}

/// How the sketch lies turned in the picture, and the frame of the picture: where it is the mirror image that lies there,
/// of the picture from behind.
fn turn(scene: &Scene<'_>, frame: &Frame, laying: &Laying) -> (Turn, Frame) {
    if laying.reflected {
        return turn(scene, &frame.from_behind(), &laying.turned_round());
    }
    (Turn::between(&scene.shape.positions, &laying.positions), *frame)
}

/// The attempts on the candidates, best first.
pub fn attempts(
    scene: &Scene<'_>,
    candidates: &[Candidate],
    landmarks: &Landmarks,
) -> Result<Vec<Attempt>, AlignmentError> {
    let attempts = side_by_side(candidates, |candidate| Attempt::on(scene, candidate.clone(), landmarks));
    let mut attempts = attempts.into_iter().collect::<Result<Vec<_>, _>>()?;
    attempts.sort_by(|a, b| a.score().total_cmp(&b.score()));
    Ok(attempts)
}

/// The vertices in front of places in the picture.
fn lifted(mesh: &PreparedMesh, positions: &[[f64; 3]], frame: &Frame, places: &[[f64; 2]]) -> Vec<u32> {
    let visible = Visible::new(positions, &mesh.triangles, mesh.closed, frame);
    places.iter().map(|&place| visible.vertex(place)).collect()
}
