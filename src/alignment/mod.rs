//! The automatic part: a sketch laid on a mesh by the view it is drawn from, with nobody clicking.
//!
//! Both shapes are scaled to area 1, so that every length is in units of the square root of the shape's own area unless
//! it says pixels. A mesh is [`prepared`](prepared::PreparedMesh) once; a sketch is laid on the views whose outlines are
//! like its own, the mesh put into its pose, and the places in the picture lifted to the surface behind them.

mod attempt;
pub mod axes;
mod by_distances;
mod candidates;
pub mod contour;
pub mod energy;
pub mod flat_shape;
pub mod frame;
mod inner_paths;
mod landmarks;
mod laying;
pub mod limbs;
mod pose;
pub mod prepared;
mod reconciliation;
mod rigidity;
pub mod sampled_distances;
mod shape_context;
pub mod silhouette;
pub mod single_outline;
#[cfg(test)]
pub(crate) mod solids;
pub mod symmetry;
mod trust;
pub mod view;
pub mod views;
mod visible;
pub mod warping;

use attempt::{Attempt, attempts};
use candidates::{Candidate, candidates};
use flat_shape::FlatShape;
use frame::Frame;
use landmarks::Landmarks;
use prepared::PreparedMesh;
use reconciliation::reconciled;

use crate::mesh::dot;
use crate::numerics::cholesky::FactorisationError;
use crate::numerics::{Cancelled, Watch};

/// Views that cost at most so much more than the best, and at most so many, are told apart by their poses.
const UNDECIDED: f64 = 0.03;
const POSED: usize = 5;
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
    landmarks: &[Pair],
    watch: &dyn Watch,
) -> Result<Alignment, AlignmentError> {
    let (landmarks, none) = (&Landmarks::new(shape, landmarks), &Landmarks::new(shape, &[]));
    let candidates = candidates(shape, mesh, watch)?;
    let (mut best, others) = best_view(shape, mesh, candidates.clone(), none, watch)?;
    let mut believed = if best.distortion.mean > BENT {
        by_distances::mapped(shape, mesh, &best.map, &best.laying.costs, watch)?
    } else {
        None
    };
    let map = believed.as_ref().unwrap_or(&best.map);
    if landmarks.contradict(mesh, map) {
        let answer = best.clone().answering(shape, mesh, landmarks, map.clone());
        let (of_led_view, _) = best_view(shape, mesh, candidates, landmarks, watch)?;
        let reconciled = reconciled(answer, of_led_view, shape, mesh, landmarks, watch)?;
        if reconciled.map != *map {
            (best, believed) = (reconciled, None);
        }
    }
    let second = others.into_iter().find(|other| {
        dot(other.view.frame.toward_camera, best.view.frame.toward_camera) < SAME_VIEW
            && other.score() < best.score() + PLAUSIBLE
    });

    let (frame, twin) = best.mirrored(mesh);
    let twin = Alternative { mirrored: true, frame, score: best.score(), map: twin };
    let second = second.map(|other| Alternative {
        mirrored: false,
        frame: other.view.frame,
        score: other.score(),
        map: other.map,
    });
    let confidence = trust::trust(shape, mesh, &best.laying, &best.map, &best.distortion);
    let way = match (&believed, best.swing() > 0.0) {
        (Some(_), _) => Way::Distances,
        (None, true) => Way::Pose,
        (None, false) => Way::View,
    };
    let (contour, distortion, score) = (best.laying.cost, best.distortion.mean, best.score());
    let mut map = believed.unwrap_or(best.map);
    landmarks.pairs.iter().for_each(|pair| map[pair.sketch as usize] = pair.mesh);
    Ok(Alignment {
        map,
        confidence,
        frame: best.view.frame,
        way,
        sideways: dot(best.view.frame.toward_camera, mesh.symmetry.normal).abs() > SIDEWAYS,
        contour,
        distortion,
        score,
        alternatives: [twin].into_iter().chain(second).collect(),
    })
}

/// The best attempt on the candidates, once those that are nearly as good have found their poses, and the others.
fn best_view(
    shape: &FlatShape,
    mesh: &PreparedMesh,
    candidates: Vec<Candidate>,
    landmarks: &Landmarks,
    watch: &dyn Watch,
) -> Result<(Attempt, Vec<Attempt>), AlignmentError> {
    let mut attempts = attempts(shape, mesh, candidates, landmarks, PLAUSIBLE.max(UNDECIDED))?;
    let most = attempts.first().map_or(f64::INFINITY, |best| best.score() + UNDECIDED);
    let undecided = attempts.iter().take(POSED).take_while(|attempt| attempt.score() <= most).count();
    let mut posed: Vec<Attempt> = Vec::with_capacity(undecided);
    for attempt in attempts.drain(..undecided) {
        let least = posed.iter().map(Attempt::score).fold(f64::INFINITY, f64::min);
        posed.push(attempt.in_pose(shape, mesh, landmarks, least, watch)?);
    }
    posed.sort_by(|a, b| a.score().total_cmp(&b.score()));
    attempts.splice(..0, posed);
    // Every mesh has a view along the normal of its plane of symmetry, so that there is an attempt.
    Ok((attempts.remove(0), attempts))
}
