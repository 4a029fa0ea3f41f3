//! An attempt reconciled with landmarks: seen from the other side, mended, limbs exchanged, and what still contradicts
//! them answered anew. Each is done only where it betters the whole, so that a landmark does not spoil what it is far
//! from.

use super::attempt::Attempt;
use super::by_distances::{Anchor, answered};
use super::exchange::{exchanged, partners};
use super::flat_shape::FlatShape;
use super::landmarks::Landmarks;
use super::prepared::PreparedMesh;
use super::{AlignmentError, Pair};
use crate::numerics::{Cancelled, Watch};

/// What landmarks missed weigh beside distances bent.
const MISSED_PRICE: f64 = 0.2;
/// By how much the price must fall for the other side of the body and for limbs exchanged, for another laying of the
/// sketch, and for answers by distances alone, which are coarser than those seen.
const EXCHANGED: f64 = 0.001;
const MENDED: f64 = 0.01;
const ANEW: f64 = 0.03;
/// The distance from a landmark at which its answer misses it.
const MISSED: f64 = 0.08;
/// How much a distance from a landmark may be off, as such and as a share of it.
const SLACK: f64 = 0.06;
const SHARE: f64 = 0.3;
/// Vertices that do not contradict a landmark, from which those that do are answered.
const ANCHORS: usize = 30;
/// Landmarks that answers are found anew for, and from: a thousand of them, each with the distances of all, would take
/// hours.
const TOLD: usize = 30;

/// The attempt, or one made of it that agrees better with the landmarks, of which there is one at least.
///
/// # Errors
/// [`AlignmentError`].
pub(super) fn reconciled(
    attempt: Attempt,
    shape: &FlatShape,
    mesh: &PreparedMesh,
    landmarks: &Landmarks,
    watch: &dyn Watch,
) -> Result<Attempt, AlignmentError> {
    let known = Known { shape, mesh, landmarks };
    let turned = attempt.turned_round(shape, mesh, landmarks);
    let mended = attempt.mended(shape, mesh, landmarks, watch)?;
    let mut best = known.with_limbs_exchanged(attempt);
    for (other, margin) in [(turned, EXCHANGED), (mended, MENDED)] {
        watch.proceed(0.0)?;
        best = known.better(best, known.with_limbs_exchanged(other), margin);
    }
    Ok(known.answered_anew(best, watch)?)
}

/// Both shapes and what the user knows of them.
struct Known<'a> {
    shape: &'a FlatShape,
    mesh: &'a PreparedMesh,
    landmarks: &'a Landmarks,
}

impl Known<'_> {
    /// How far an attempt's map bends distances, those from landmarks above all, and misses landmarks.
    fn price(&self, attempt: &Attempt) -> f64 {
        let distortion = &attempt.distortion;
        let bent = self.landmarks.bent(self.shape, self.mesh, &attempt.map, distortion.scale);
        distortion.mean + bent + MISSED_PRICE * attempt.astray
    }

    /// The other attempt, where it costs less by the margin.
    fn better(&self, attempt: Attempt, other: Attempt, margin: f64) -> Attempt {
        if self.price(&other) < self.price(&attempt) - margin { other } else { attempt }
    }

    /// The attempt, or that with another map where it costs less by the margin.
    fn bettered(&self, attempt: Attempt, map: Vec<u32>, margin: f64) -> Attempt {
        let other = attempt.clone().answering(self.shape, self.mesh, self.landmarks, map);
        self.better(attempt, other, margin)
    }

    /// The attempt with those pairs of limbs exchanged in its map that better it.
    fn with_limbs_exchanged(&self, mut attempt: Attempt) -> Attempt {
        for pair in partners(self.mesh) {
            let map = exchanged(self.mesh, &attempt.view.frame, pair, &attempt.map);
            attempt = self.bettered(attempt, map, EXCHANGED);
        }
        attempt
    }

    /// The attempt with the answers that contradict a landmark it misses found from the distances to the others.
    fn answered_anew(&self, mut attempt: Attempt, watch: &dyn Watch) -> Result<Attempt, Cancelled> {
        for (pair, near) in self.landmarks.pairs.iter().zip(&self.landmarks.fields).take(TOLD) {
            let (distances, place) = (&self.mesh.distances, self.mesh.distances.at(pair.mesh));
            let miss = distances.at(attempt.map[pair.sketch as usize]).to(&place);
            if miss < MISSED {
                continue;
            }
            let scale = attempt.distortion.scale;
            // A landmark that is missed by some way tells nothing of what is farther from it.
            let contradicts = |x: usize| {
                let wanted = scale * near[x];
                let found = distances.at(attempt.map[x]).to(&place);
                wanted < miss && (wanted - found).abs() > SLACK + SHARE * wanted
            };
            let wrong: Vec<bool> = (0..attempt.map.len()).map(contradicts).collect();
            let anchors = self.anchors(&attempt.map, &wrong, watch)?;
            let map = answered(self.mesh, &attempt.map, &wrong, &anchors, scale, watch)?;
            attempt = self.bettered(attempt, map, ANEW);
        }
        Ok(attempt)
    }

    /// The landmarks, and vertices far from them and from each other that are not wrong.
    fn anchors(&self, map: &[u32], wrong: &[bool], watch: &dyn Watch) -> Result<Vec<Anchor>, Cancelled> {
        let told = self.landmarks.pairs.iter().take(TOLD);
        let mut anchors: Vec<Anchor> = told.map(|&pair| Anchor::of(self.shape, pair)).collect();
        let most = anchors.len() + ANCHORS;
        let mut away = vec![f64::INFINITY; map.len()];
        let mut passed = 0;
        while anchors.len() < most {
            watch.proceed(0.0)?;
            for anchor in &anchors[passed..] {
                away.iter_mut().zip(&anchor.near).for_each(|(away, &d)| *away = away.min(d));
            }
            passed = anchors.len();
            let right = (0..map.len()).filter(|&x| !wrong[x]);
            let Some(next) = right.max_by(|&a, &b| away[a].total_cmp(&away[b])) else { break };
            anchors.push(Anchor::of(self.shape, Pair { sketch: next as u32, mesh: map[next] }));
        }
        Ok(anchors)
    }
}
