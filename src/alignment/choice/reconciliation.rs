//! An answer that landmarks contradict, against other layings of the sketch. All of these are led by the landmarks, so
//! that agreeing with them is little merit; what tells layings apart is how they bend distances, and how much they change
//! of what no landmark contradicts.

use super::attempt::Attempt;
use crate::alignment::distances::by_distances::{Anchor, answered};
use crate::alignment::error::AlignmentError;
use crate::alignment::prepared::sampled_distances::Place;
use crate::alignment::scene::Scene;
use crate::alignment::scene::landmarks::{Landmarks, MISSED, Pair};
use crate::alignment::search::pose::exchanges;
use crate::mesh::farthest_points::FarthestPoints;
use crate::numerics::Cancelled;

/// What landmarks missed, and answers changed that they do not contradict, weigh beside distances bent.
const MISSED_PRICE: f64 = 0.1;
const CHANGE_PRICE: f64 = 0.3;
/// The change of an answer that counts most, in units of √area.
const MOST: f64 = 0.4;
/// By how much the price must fall for another laying, and for answers found anew.
const MARGIN: f64 = 0.003;
/// How much a distance from a landmark may be off, as such and as a share of it.
const SLACK: f64 = 0.06;
const SHARE: f64 = 0.3;
/// Vertices that do not contradict a landmark, from which those that do are answered.
const ANCHORS: usize = 30;
/// Landmarks that answers are found anew for, and from: a thousand of them, each with the distances of all, would take
/// hours.
const TOLD: usize = 30;

/// The answer, or one that agrees better with the landmarks: that of the view they lead to, either looked at from
/// behind, or laid anew by them with the limbs as they are or exchanged; what still contradicts a landmark found anew.
///
/// # Errors
/// [`AlignmentError`]; the watcher is asked at every exchange.
pub fn reconciled(
    answer: Attempt,
    of_led_view: Attempt,
    scene: &Scene<'_>,
    landmarks: &Landmarks,
) -> Result<Attempt, AlignmentError> {
    let known = Known::new(scene, landmarks, &answer.map);
    let mut best = answer.clone();
    for start in [answer, of_led_view] {
        best = known.better(best, start.turned_round(scene, landmarks));
        for moves in exchanges(scene.mesh, &start.view.frame, &start.moves) {
            scene.watch.proceed(0.0)?;
            best = start.led(scene, landmarks, moves)?.into_iter().fold(best, |a, b| known.better(a, b));
        }
        best = known.better(best, start);
    }
    Ok(known.answered_anew(best)?)
}

/// Both shapes, what the user knows of them, and what is to stay.
struct Known<'a> {
    scene: &'a Scene<'a>,
    landmarks: &'a Landmarks,
    /// For every sample of the sketch its answer, where the landmark nearest to it is not missed.
    confirmed: Vec<Option<Place>>,
}

impl Known<'_> {
    fn new<'a>(scene: &'a Scene<'a>, landmarks: &'a Landmarks, answer: &[u32]) -> Known<'a> {
        let mesh = scene.mesh;
        let missed = landmarks.misses(mesh, answer);
        let near = |l: usize, x: u32| landmarks.fields[l][x as usize];
        let nearest = |x: u32| (0..missed.len()).min_by(|&a, &b| near(a, x).total_cmp(&near(b, x)));
        let confirmed = |&x: &u32| {
            let hit = nearest(x).is_none_or(|landmark| missed[landmark] <= MISSED);
            hit.then(|| mesh.distances.at(answer[x as usize]))
        };
        Known { scene, landmarks, confirmed: scene.shape.samples.iter().map(confirmed).collect() }
    }

    /// How far an attempt's map bends distances, misses landmarks and changes what is confirmed.
    fn price(&self, attempt: &Attempt) -> f64 {
        attempt.distortion.mean + MISSED_PRICE * attempt.astray + CHANGE_PRICE * self.change(&attempt.map)
    }

    /// Mean distance, each at most 0.4, of a map's answers from those confirmed, others counting 0.
    fn change(&self, map: &[u32]) -> f64 {
        let samples = self.scene.shape.samples.iter().zip(&self.confirmed);
        let change = |(&x, confirmed): (&u32, &Option<Place>)| {
            let answer = self.scene.mesh.distances.at(map[x as usize]);
            confirmed.as_ref().map_or(0.0, |confirmed| answer.to(confirmed).min(MOST))
        };
        samples.map(change).sum::<f64>() / self.confirmed.len().max(1) as f64
    }

    /// The other attempt, where it costs less by the margin.
    fn better(&self, attempt: Attempt, other: Attempt) -> Attempt {
        if self.price(&other) < self.price(&attempt) - MARGIN { other } else { attempt }
    }

    /// The attempt with the answers that contradict a landmark it misses found from the distances to the others.
    fn answered_anew(&self, mut attempt: Attempt) -> Result<Attempt, Cancelled> {
        for (pair, near) in self.landmarks.pairs.iter().zip(&self.landmarks.fields).take(TOLD) {
            let (distances, place) = (&self.scene.mesh.distances, self.scene.mesh.distances.at(pair.mesh));
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
            let anchors = self.anchors(&attempt.map, &wrong)?;
            let map = answered(self.scene.mesh, &attempt.map, &wrong, &anchors, scale, self.scene.watch)?;
            let other = attempt.clone().answering(self.scene, self.landmarks, map);
            attempt = self.better(attempt, other);
        }
        Ok(attempt)
    }

    /// The landmarks, and vertices far from them and from each other that are not wrong.
    fn anchors(&self, map: &[u32], wrong: &[bool]) -> Result<Vec<Anchor>, Cancelled> {
        let told = self.landmarks.pairs.iter().take(TOLD);
        let anchor = |pair| Anchor::of(self.scene.shape, pair, self.scene.watch);
        let mut anchors = told.copied().map(anchor).collect::<Result<Vec<Anchor>, Cancelled>>()?;
        let most = anchors.len() + ANCHORS;
        let mut points = FarthestPoints::new(map.len());
        let mut passed = 0;
        while anchors.len() < most {
            self.scene.watch.proceed(0.0)?;
            for anchor in &anchors[passed..] {
                points.choose(&anchor.near);
            }
            passed = anchors.len();
            // Of equals the last is taken.
            let right = (0..map.len() as u32).rev().filter(|&x| !wrong[x as usize]);
            let Some(next) = points.farthest(right) else { break };
            anchors.push(anchor(Pair { sketch: next, mesh: map[next as usize] })?);
        }
        Ok(anchors)
    }
}
