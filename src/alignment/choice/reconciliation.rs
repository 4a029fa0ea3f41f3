//! What landmarks change. An answer that they contradict is held against other layings of the sketch. All of these are led
//! by the landmarks, so that agreeing with them is little merit; what tells layings apart is how they bend distances, and
//! how much they change of what no landmark contradicts. What then still misses a landmark is moved with its surroundings.

use super::attempt::Attempt;
use crate::alignment::error::AlignmentError;
use crate::alignment::prepared::sampled_distances::Place;
use crate::alignment::scene::Scene;
use crate::alignment::scene::landmarks::{Landmarks, MISSED};
use crate::alignment::search::pose::exchanges;

/// What landmarks missed, and answers changed that they do not contradict, weigh beside distances bent.
const MISSED_PRICE: f64 = 0.1;
const CHANGE_PRICE: f64 = 0.3;
/// The change of an answer that counts most, in units of √area.
const MOST: f64 = 0.4;
/// By how much the price must fall for another laying.
const MARGIN: f64 = 0.003;
/// Another laying than the answer's, moved as the landmarks say, where it agrees better than the answer so `moved`: that of
/// the view the landmarks lead to, either looked at from behind, or laid anew by them with the limbs as they are or
/// exchanged.
///
/// # Errors
/// [`AlignmentError`]; the watcher is asked at every exchange.
pub fn reconciled(
    answer: &Attempt,
    moved: &Attempt,
    of_led_view: Attempt,
    scene: &Scene<'_>,
    landmarks: &Landmarks,
) -> Result<Option<Attempt>, AlignmentError> {
    let known = Known::new(scene, landmarks, &answer.map);
    let mut best = answer.clone();
    for start in [answer.clone(), of_led_view] {
        best = known.better(best, start.turned_round(scene, landmarks));
        for moves in exchanges(scene.mesh, &start.view.frame, &start.moves) {
            scene.watch.proceed(0.0)?;
            best = start.led(scene, landmarks, moves)?.into_iter().fold(best, |a, b| known.better(a, b));
        }
        best = known.better(best, start);
    }
    // Moved as well it would be what is there.
    if best.map == answer.map {
        return Ok(None);
    }
    let best = best.moved(scene, landmarks)?;
    Ok((known.price(&best) < known.price(moved) - MARGIN).then_some(best))
}

/// Both shapes, what the user knows of them, and what is to stay.
struct Known<'a> {
    scene: &'a Scene<'a>,
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
        Known { scene, confirmed: scene.shape.samples.iter().map(confirmed).collect() }
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
}
