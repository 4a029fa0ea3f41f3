//! Which attempt is the answer: what speaks against each, and who is heard again before one is taken.

pub mod attempt;
mod explanation;
pub mod leaning;
pub mod reconciliation;
pub mod terms;
pub mod trust;

use attempt::Attempt;

use crate::alignment::distances::by_distances;
use crate::alignment::error::AlignmentError;
use crate::alignment::scene::Scene;
use crate::alignment::scene::landmarks::Landmarks;
use crate::numerics::side_by_side;

/// Views that score at most so much more than the best, and at most so many, take the pose that follows from the warp of
/// the outlines, and those in which the pose is searched on.
const FOLLOWED: (f64, usize) = (0.08, 5);
const REFINED: (f64, usize) = (0.015, 2);
/// The distortion above which geodesic distances are believed rather than the view.
const BENT: f64 = 0.075;
/// How much less an answer by distances has to score than the view: it is made to have little distortion, so that little of it
/// speaks less for such an answer than for another.
const MADE_TO_FIT: f64 = 0.02;

/// The best of the attempts, at least one, best first, once those that are nearly as good have found their poses, and the
/// others.
pub fn best_view(
    scene: &Scene<'_>,
    attempts: Vec<Attempt>,
    landmarks: &Landmarks,
) -> Result<(Attempt, Vec<Attempt>), AlignmentError> {
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

/// The attempt, or what geodesic distances to its sure points make of it where they are bent and that explains the
/// drawing better; and which of them.
pub fn believed(scene: &Scene<'_>, attempt: Attempt) -> Result<(Attempt, bool), AlignmentError> {
    if attempt.distortion.mean <= BENT {
        return Ok((attempt, false));
    }
    let map = by_distances::mapped(scene.shape, scene.mesh, &attempt.map, &attempt.laying.costs, scene.watch)?;
    let none = &Landmarks::new(scene.shape, &[], scene.watch)?;
    let other = map.map(|map| attempt.clone().answering(scene, none, map));
    Ok(match other {
        Some(other) if other.score() + MADE_TO_FIT < attempt.score() => (other, true),
        _ => (attempt, false),
    })
}
