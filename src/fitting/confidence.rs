//! How far an answer is to be trusted, fitted to answers whose truth is known.

use faer::linalg::solvers::{Llt, Solve};
use faer::{Mat, Side};

use super::Judged;
use crate::alignment::{DOUBTS, Regression, logarithms};

/// An answer is right within this distance of the truth, in the units of errors: √area, √(area / 2) where one side is shown.
const RIGHT: f64 = 0.1;
/// Newton steps: the likelihood is concave, and ten are enough.
const STEPS: usize = 30;
/// The price of a squared weight, in units of cases.
const PRICE: f64 = 0.2;
/// The least deviation of a doubt.
const LEAST: f64 = 1e-9;

/// A place whose truth is known: the logarithms of its doubts, whether its answer is right, and what it weighs.
struct Place {
    doubts: [f64; DOUBTS],
    right: f64,
    weight: f64,
}

/// The regression of greatest likelihood, each case weighing the same however many of its places are known; none where the
/// cases do not determine it.
pub fn fitted<'a>(cases: impl Iterator<Item = &'a Judged>) -> Option<Regression> {
    let places: Vec<Place> = cases
        .flat_map(|case| {
            case.points.iter().map(|(doubts, error)| Place {
                doubts: logarithms(doubts),
                right: f64::from(*error < RIGHT),
                weight: 1.0 / case.points.len() as f64,
            })
        })
        .collect();
    let total: f64 = places.iter().map(|place| place.weight).sum();
    let mean = |of: &dyn Fn(&Place) -> f64| places.iter().map(|p| p.weight * of(p)).sum::<f64>() / total;
    let means: [f64; DOUBTS] = std::array::from_fn(|i| mean(&|p| p.doubts[i]));
    let deviations: [f64; DOUBTS] =
        std::array::from_fn(|i| mean(&|p| (p.doubts[i] - means[i]).powi(2)).sqrt().max(LEAST));
    // The last unknown is the bias.
    let row = |p: &Place| -> [f64; DOUBTS + 1] {
        std::array::from_fn(|i| if i < DOUBTS { (p.doubts[i] - means[i]) / deviations[i] } else { 1.0 })
    };
    let price = |i: usize| if i < DOUBTS { PRICE } else { 0.0 };
    let mut unknowns = [0.0; DOUBTS + 1];
    for _ in 0..STEPS {
        let mut gradient = Mat::from_fn(DOUBTS + 1, 1, |i, _| -price(i) * unknowns[i]);
        let mut curvature = Mat::from_fn(DOUBTS + 1, DOUBTS + 1, |i, j| if i == j { price(i) } else { 0.0 });
        for place in &places {
            let row = row(place);
            let score: f64 = row.iter().zip(&unknowns).map(|(x, w)| x * w).sum();
            let chance = 1.0 / (1.0 + (-score).exp());
            for i in 0..=DOUBTS {
                gradient[(i, 0)] += place.weight * (place.right - chance) * row[i];
                for j in 0..=DOUBTS {
                    curvature[(i, j)] += place.weight * chance * (1.0 - chance) * row[i] * row[j];
                }
            }
        }
        let step = Llt::new(curvature.as_ref(), Side::Lower).ok()?.solve(&gradient);
        unknowns.iter_mut().enumerate().for_each(|(i, unknown)| *unknown += step[(i, 0)]);
    }
    let weights = std::array::from_fn(|i| unknowns[i]);
    Some(Regression { means, deviations, weights, bias: unknowns[DOUBTS] })
}

/// The mean chance of a case's answers.
pub fn confidence(case: &Judged, regression: &Regression) -> f64 {
    let chances = case.points.iter().map(|(doubts, _)| regression.chance(doubts));
    chances.sum::<f64>() / case.points.len().max(1) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_doubt_that_tells_is_believed_and_chances_are_those_of_the_cases() {
        let random = |k: usize| ((k * 37 + 11) % 101) as f64 / 101.0;
        let point = |k: usize| {
            let distortion = 0.02 + 0.2 * random(k);
            let is_wrong = distortion + 0.1 * random(7 * k + 3) > 0.2;
            ([distortion, 0.1 + random(3 * k), 0.1, 0.1, 0.0, 1e-3], if is_wrong { 0.3 } else { 0.02 })
        };
        let case = |i: usize| Judged {
            name: i.to_string(),
            set: String::new(),
            held_back: false,
            attempts: Vec::new(),
            points: (10 * i..10 * i + 10).map(point).collect(),
        };
        let cases: Vec<Judged> = (0..100).map(case).collect();
        let regression = fitted(cases.iter()).unwrap();
        let [told, noise, ..] = regression.weights;
        assert!(told < -1.0 && noise.abs() < 0.1 * told.abs(), "{regression:?}");
        let right = cases.iter().flat_map(|case| &case.points).filter(|(_, error)| *error < RIGHT).count() as f64;
        let all = cases.iter().map(|case| confidence(case, &regression)).sum::<f64>();
        assert!((all / 100.0 - right / 1000.0).abs() < 0.01, "{all} {right}");
    }
}
