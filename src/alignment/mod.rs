//! The automatic part: a sketch laid on a mesh by the view it is drawn from, with nobody clicking.
//!
//! Both shapes are scaled to area 1, so that every length is in units of the square root of the shape's own area unless
//! it says pixels. A mesh is [`prepared`](prepared::PreparedMesh) once; a sketch is laid on the views whose outlines are
//! like its own, the mesh put into its pose, and the places in the picture lifted to the surface behind them.

mod attempt;
mod by_distances;
mod candidates;
pub mod contour;
pub mod energy;
mod explanation;
pub mod flat_shape;
mod following;
mod inner_paths;
mod landmarks;
mod laying;
pub mod limbs;
mod pose;
pub mod prepared;
mod reconciliation;
mod rigidity;
pub mod sampled_distances;
mod scene;
mod shape_context;
pub mod single_outline;
pub mod standing;
pub mod symmetry;
pub mod terms;
mod trust;
pub mod upright;
pub mod view;
pub mod views;
pub mod warping;

use crate::geometry::frame::Frame;
use attempt::{Attempt, attempts};
use candidates::{Candidate, candidates};
use flat_shape::FlatShape;
use landmarks::Landmarks;
use prepared::PreparedMesh;
use reconciliation::reconciled;
use scene::Scene;
use terms::Terms;
use upright::Upright;

use crate::geometry::dot;
use crate::numerics::cholesky::FactorisationError;
use crate::numerics::{Cancelled, Watch, side_by_side};

/// Views that score at most so much more than the best, and at most so many, take the pose that follows from the warp of
/// the outlines, and those in which the pose is searched on.
const FOLLOWED: (f64, usize) = (0.08, 8);
const REFINED: (f64, usize) = (0.04, 3);
/// The distortion above which geodesic distances are believed rather than the view.
const BENT: f64 = 0.075;
/// Another view is plausible where it costs less than this much more.
const PLAUSIBLE: f64 = 0.05;
/// Directions further apart than the angle of this cosine are different views.
const SAME_VIEW: f64 = 0.8;
/// A view from the side looks along the normal of the plane of symmetry, within the angle of this cosine.
const SIDEWAYS: f64 = 0.8;

/// A vertex of the sketch and the vertex of the mesh it is known to be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Pair {
    pub sketch: u32,
    pub mesh: u32,
}

/// Why no alignment was found.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum AlignmentError {
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    #[error("the sketch cannot be laid on the mesh: {0}")]
    Factorisation(#[from] FactorisationError),
}

/// What the answer was found by.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Way {
    /// A view of the mesh as it is.
    View,
    /// A view of the mesh with its limbs swung.
    Pose,
    /// Geodesic distances to the points that are sure.
    Distances,
}

/// A sketch laid on a mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct Alignment {
    /// A vertex of the mesh for every one of the m vertices of the sketch.
    pub map: Vec<u32>,
    /// For every vertex the chance that its answer is less than 0.1 √area from the truth.
    pub confidence: Vec<f64>,
    pub frame: Frame,
    pub way: Way,
    /// Whether the body is seen from its side.
    pub sideways: bool,
    /// What the outlines cost per sample, in [0, 0.4].
    pub contour: f64,
    /// Mean distortion of geodesic distances.
    pub distortion: f64,
    /// Costs of the view as they are compared; the less the better.
    pub score: f64,
    pub alternatives: Vec<Alternative>,
    /// The places of the landmarks whose distances from most others are not those in the sketch, ascending.
    pub at_odds: Vec<usize>,
}

/// Another plausible answer.
#[derive(Clone, Debug, PartialEq)]
pub struct Alternative {
    /// Whether it is the answer's twin on the other side of the body; another view otherwise.
    pub mirrored: bool,
    pub frame: Frame,
    pub score: f64,
    pub map: Vec<u32>,
}

/// The sketch laid on the mesh, landmarks kept.
///
/// # Errors
/// [`AlignmentError`].
pub fn aligned(
    shape: &FlatShape,
    mesh: &PreparedMesh,
    upright: Option<Upright>,
    landmarks: &[Pair],
    watch: &dyn Watch,
) -> Result<Alignment, AlignmentError> {
    let scene = &Scene { shape, mesh, upright, watch };
    let (landmarks, none) = (&Landmarks::new(shape, landmarks), &Landmarks::new(shape, &[]));
    let candidates = candidates(scene)?;
    let (best, others) = best_view(scene, &candidates, none)?;
    let (mut best, mut by_distances) = believed(scene, best)?;
    if landmarks.contradict(mesh, &best.map) {
        let (of_led_view, _) = best_view(scene, &candidates, landmarks)?;
        let reconciled =
            reconciled(best.clone().answering(scene, landmarks, best.map.clone()), of_led_view, scene, landmarks)?;
        by_distances &= reconciled.map == best.map;
        best = reconciled;
    }
    let second = others.into_iter().find(|other| {
        dot(other.view.frame.toward_camera, best.view.frame.toward_camera) < SAME_VIEW
            && other.score() < best.score() + PLAUSIBLE
    });
    let drawn = best.as_drawn(scene);
    let (_, mut twin) = best.mirrored(mesh);
    if by_distances && let Some(map) = by_distances::mapped(shape, mesh, &twin, &best.laying.costs, watch)? {
        twin = map;
    }
    let twin = Alternative { mirrored: true, frame: drawn.from_behind(), score: best.score(), map: twin };
    let second = second.map(|other| Alternative {
        mirrored: false,
        frame: other.as_drawn(scene),
        score: other.score(),
        map: other.map,
    });
    // What the user knows is not traded for anything, and whether it fits shows in the distances.
    let mut map = best.map.clone();
    landmarks.pairs.iter().for_each(|pair| map[pair.sketch as usize] = pair.mesh);
    let best = if map == best.map { best } else { best.answering(scene, landmarks, map) };
    let at_odds = landmarks.at_odds(mesh, best.distortion.scale);
    let way = match (by_distances, best.is_posed()) {
        (true, _) => Way::Distances,
        (false, true) => Way::Pose,
        (false, false) => Way::View,
    };
    Ok(Alignment {
        confidence: trust::trust(shape, mesh, &best.laying, &best.map, &best.distortion),
        frame: drawn,
        way,
        sideways: dot(drawn.toward_camera, mesh.symmetry.normal).abs() > SIDEWAYS,
        contour: best.laying.cost,
        distortion: best.distortion.mean,
        score: best.score(),
        map: best.map,
        at_odds,
        alternatives: [twin].into_iter().chain(second).collect(),
    })
}

/// The attempt, or what geodesic distances to its sure points make of it where they are bent and that explains the
/// drawing better; and which of them.
fn believed(scene: &Scene<'_>, attempt: Attempt) -> Result<(Attempt, bool), AlignmentError> {
    if attempt.distortion.mean <= BENT {
        return Ok((attempt, false));
    }
    let map = by_distances::mapped(scene.shape, scene.mesh, &attempt.map, &attempt.laying.costs, scene.watch)?;
    let none = &Landmarks::new(scene.shape, &[]);
    let other = map.map(|map| attempt.clone().answering(scene, none, map));
    Ok(match other {
        Some(other) if other.score() < attempt.score() => (other, true),
        _ => (attempt, false),
    })
}

/// An answer that was weighed.
#[derive(Clone, Debug)]
pub struct Weighed {
    pub terms: Terms,
    /// As [`Alignment::map`].
    pub map: Vec<u32>,
}

/// Every attempt that is weighed where there are no landmarks, the answer first: for those who fit what chooses.
///
/// # Errors
/// [`AlignmentError`].
pub fn weighed(
    shape: &FlatShape,
    mesh: &PreparedMesh,
    upright: Option<Upright>,
    watch: &dyn Watch,
) -> Result<Vec<Weighed>, AlignmentError> {
    let scene = &Scene { shape, mesh, upright, watch };
    let (best, others) = best_view(scene, &candidates(scene)?, &Landmarks::new(shape, &[]))?;
    let (answer, by_distances) = believed(scene, best.clone())?;
    let rejected = by_distances.then_some(best);
    let all = [answer].into_iter().chain(rejected).chain(others);
    Ok(all.map(|attempt| Weighed { terms: attempt.terms, map: attempt.map }).collect())
}

/// The best attempt on the candidates, once those that are nearly as good have found their poses, and the others.
fn best_view(
    scene: &Scene<'_>,
    candidates: &[Candidate],
    landmarks: &Landmarks,
) -> Result<(Attempt, Vec<Attempt>), AlignmentError> {
    let attempts = attempts(scene, candidates, landmarks)?;
    let attempts = improved(attempts, FOLLOWED, |attempt| attempt.following(scene, landmarks))?;
    let mut attempts = improved(attempts, REFINED, |attempt| attempt.refined(scene, landmarks))?;
    // Every mesh has a view along the normal of its plane of symmetry, so that there is an attempt.
    Ok((attempts.remove(0), attempts))
}

/// The attempts, best first, with at most `most` of those that score no more than the best and `margin` improved.
fn improved(
    mut attempts: Vec<Attempt>,
    (margin, most): (f64, usize),
    improve: impl Fn(Attempt) -> Result<Attempt, AlignmentError> + Sync,
) -> Result<Vec<Attempt>, AlignmentError> {
    let limit = attempts.first().map_or(f64::INFINITY, |best| best.score() + margin);
    let undecided = attempts.iter().take(most).take_while(|attempt| attempt.score() <= limit).count();
    let others = attempts.split_off(undecided);
    let improved = side_by_side(&attempts, |attempt| improve(attempt.clone()));
    let mut improved = improved.into_iter().collect::<Result<Vec<_>, _>>()?;
    improved.extend(others);
    improved.sort_by(|a, b| a.score().total_cmp(&b.score()));
    Ok(improved)
}
