//! The automatic part: a sketch laid on a mesh by the view it is drawn from, with nobody clicking.
//!
//! Both shapes are scaled to area 1, so that every length is in units of the square root of the shape's own area unless
//! it says pixels. So are the constants, each beside the code it belongs to; where one names no source, its value was found
//! by trial on drawings of bodies whose truth is known (docs/decisions/tuning.md). The recipe, a room for each step:
//!
//! 1. [`prepared`]: what either shape brings along before the other is known. Of the mesh its axes, its plane of symmetry,
//!    geodesic distances, limbs, which way is up, and its views; of the sketch its distances and its outline.
//! 2. [`contour`]: an outline as 110 samples, each with what it sees of the others and how thick the figure is there, and
//!    the cheapest warp of one outline onto another.
//! 3. [`scene`]: both shapes, and what is known of them together: which way is up, and landmarks.
//! 4. [`search`]: the views whose outlines are like the sketch's, and the poses in which they are more so.
//! 5. [`laying`]: the sketch pulled onto a view by the warp, as rigidly as may be; each place in the picture is then
//!    lifted to the surface in front.
//! 6. [`distances`]: how much a laying bends geodesic distances, and the map that bends them least from a few points that
//!    are sure.
//! 7. [`choice`]: what speaks against each attempt, the one against which least does, what landmarks object to, and how far
//!    the answer is to be trusted, point by point.

mod answer;
mod choice;
pub mod contour;
mod distances;
mod error;
mod laying;
pub mod prepared;
mod scene;
mod search;

pub use answer::{Alignment, Alternative, Place, Way};
pub use choice::terms::{Terms, WEIGHTS};
pub use choice::trust::{DOUBTS, NAMES as DOUBT_NAMES, Regression, logarithms};
pub use error::AlignmentError;
pub use scene::landmarks::Pair;
pub use scene::upright::Upright;

use choice::attempt::{Attempt, attempts};
use choice::leaning::{FirstLook, first_look};
use choice::reconciliation::reconciled;
use choice::{believed, best_view, trust};
use distances::by_distances;
use prepared::{FlatShape, PreparedMesh};
use scene::Scene;
use scene::landmarks::Landmarks;

use crate::geometry::dot;
use crate::numerics::Watch;

/// Another view is plausible where it costs less than this much more.
const PLAUSIBLE: f64 = 0.05;
/// Directions further apart than the angle of this cosine are different views.
const SAME_VIEW: f64 = 0.8;
/// A view from the side looks along the normal of the plane of symmetry, within the angle of this cosine.
const SIDEWAYS: f64 = 0.8;

/// The sketch laid on the mesh, landmarks kept. `first`, where somebody asks, is told what it looks like at first sight, on the best view of the
/// mesh as it is, before poses are looked for: without alternatives.
///
/// # Errors
/// [`AlignmentError`].
pub fn aligned(
    shape: &FlatShape,
    mesh: &PreparedMesh,
    upright: Option<Upright>,
    landmarks: &[Pair],
    first: Option<&dyn Fn(Alignment)>,
    watch: &dyn Watch,
) -> Result<Alignment, AlignmentError> {
    let (landmarks, none) = (&Landmarks::new(shape, landmarks, watch)?, &Landmarks::new(shape, &[], watch)?);
    let FirstLook { ref scene, candidates, attempts: seen } =
        first_look(Scene::new(shape, mesh, upright, watch), none)?;
    if let (Some(first), [best, others @ ..]) = (first, &seen[..]) {
        let doubts = trust::doubts(scene, best, others, landmarks);
        first(answer(scene, best.clone().holding(scene, landmarks), &doubts, false, landmarks, Vec::new()));
    }
    let (best, others) = best_view(scene, seen, none)?;
    let (answered, by_distances) = believed(scene, best)?;
    let moved = answered.clone().moved(scene, landmarks)?;
    let other = if landmarks.contradict(mesh, &answered.map) {
        let (of_led_view, _) = best_view(scene, attempts(scene, &candidates, landmarks)?, landmarks)?;
        let answered = answered.clone().answering(scene, landmarks, answered.map);
        reconciled(&answered, &moved, of_led_view, scene, landmarks)?
    } else {
        None
    };
    let by_distances = by_distances && other.is_none();
    let best = other.unwrap_or(moved);
    let doubts = trust::doubts(scene, &best, &others, landmarks);
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
    let alternatives = [twin].into_iter().chain(second).collect();
    Ok(answer(scene, best, &doubts, by_distances, landmarks, alternatives))
}

/// What an attempt answers that holds the landmarks.
fn answer(
    scene: &Scene<'_>,
    best: Attempt,
    doubts: &[[f64; DOUBTS]],
    by_distances: bool,
    landmarks: &Landmarks,
    alternatives: Vec<Alternative>,
) -> Alignment {
    let frame = best.as_drawn(scene);
    let way = match (by_distances, best.is_posed()) {
        (true, _) => Way::Distances,
        (false, true) => Way::Pose,
        (false, false) => Way::View,
    };
    Alignment {
        confidence: trust::trust(doubts),
        way,
        sideways: dot(frame.toward_camera, scene.mesh.symmetry.normal).abs() > SIDEWAYS,
        frame,
        contour: best.laying.cost,
        distortion: best.distortion.mean,
        score: best.score(),
        at_odds: landmarks.at_odds(scene.mesh, best.distortion.scale),
        places: best.places(scene.mesh),
        map: best.map,
        alternatives,
    }
}

/// An answer that was weighed.
#[derive(Clone, Debug)]
pub struct Weighed {
    pub terms: Terms,
    /// As [`Alignment::map`].
    pub map: Vec<u32>,
}

/// Every attempt that is weighed where there are no landmarks, the answer first, and for every vertex of the sketch what
/// speaks against the answer there: for those who fit what chooses and what is trusted.
///
/// # Errors
/// [`AlignmentError`].
pub fn weighed(
    shape: &FlatShape,
    mesh: &PreparedMesh,
    upright: Option<Upright>,
    watch: &dyn Watch,
) -> Result<(Vec<Weighed>, Vec<[f64; DOUBTS]>), AlignmentError> {
    let none = &Landmarks::new(shape, &[], watch)?;
    let FirstLook { ref scene, attempts: seen, .. } = first_look(Scene::new(shape, mesh, upright, watch), none)?;
    let (best, others) = best_view(scene, seen, none)?;
    let (answer, by_distances) = believed(scene, best.clone())?;
    let doubts = trust::doubts(scene, &answer, &others, none);
    let rejected = by_distances.then_some(best);
    let all = [answer].into_iter().chain(rejected).chain(others);
    Ok((all.map(|attempt| Weighed { terms: attempt.terms, map: attempt.map }).collect(), doubts))
}
