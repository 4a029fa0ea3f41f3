//! Weights of what speaks against attempts, fitted so that the attempts they choose are off least.

use super::Judged;

/// Steps of the descent, and how fast it goes.
const STEPS: usize = 3000;
const RATE: f64 = 0.02;
/// The price of a squared weight, in units of the terms' deviations.
const PRICE: f64 = 2e-4;
/// An error counts with at most this: how wrong a wrong answer is does not matter.
const MOST: f64 = 0.4;

/// A case as it is fitted to: the terms of its attempts in units of their deviations, and their errors.
struct Choice {
    terms: Vec<Vec<f64>>,
    errors: Vec<f64>,
}

/// Weights, none of them negative and the first 1, of least expected error where an attempt is chosen with a probability
/// in proportion to e^(−score): projected gradient descent [Kingma and Ba 2015] from equal weights.
pub fn fitted<'a>(cases: impl Iterator<Item = &'a Judged>) -> Vec<f64> {
    let cases: Vec<&Judged> = cases.collect();
    let deviations = deviations(&cases);
    let choices: Vec<Choice> = cases
        .iter()
        .map(|case| Choice {
            terms: case
                .attempts
                .iter()
                .map(|a| a.terms.iter().zip(&deviations).map(|(t, d)| t / d).collect())
                .collect(),
            errors: case.attempts.iter().map(|attempt| attempt.error.min(MOST)).collect(),
        })
        .collect();
    let count = deviations.len();
    let (mut weights, mut first, mut second) = (vec![1.0; count], vec![0.0; count], vec![0.0; count]);
    for step in 1..=STEPS {
        let gradient = gradient(&choices, &weights);
        for k in 0..count {
            let g = gradient[k] + 2.0 * PRICE * weights[k];
            first[k] = 0.9 * first[k] + 0.1 * g;
            second[k] = 0.999 * second[k] + 0.001 * g * g;
            let (m, v) = (first[k] / (1.0 - 0.9f64.powi(step as i32)), second[k] / (1.0 - 0.999f64.powi(step as i32)));
            weights[k] = f64::max(weights[k] - RATE * m / (v.sqrt() + 1e-9), 0.0);
        }
    }
    let weights: Vec<f64> = weights.iter().zip(&deviations).map(|(w, d)| w / d).collect();
    let unit = weights.first().copied().filter(|&unit| unit > 0.0).unwrap_or(1.0);
    weights.iter().map(|weight| weight / unit).collect()
}

/// The gradient of the mean expected error by the weights.
fn gradient(choices: &[Choice], weights: &[f64]) -> Vec<f64> {
    let mut gradient = vec![0.0; weights.len()];
    for Choice { terms, errors } in choices {
        let scores: Vec<f64> = terms.iter().map(|terms| terms.iter().zip(weights).map(|(t, w)| t * w).sum()).collect();
        let least = scores.iter().copied().fold(f64::INFINITY, f64::min);
        let chances: Vec<f64> = scores.iter().map(|score| (least - score).exp()).collect();
        let total: f64 = chances.iter().sum();
        let expected: f64 = chances.iter().zip(errors).map(|(chance, error)| chance / total * error).sum();
        for ((terms, chance), error) in terms.iter().zip(&chances).zip(errors) {
            let pull = chance / total * (error - expected) / choices.len() as f64;
            gradient.iter_mut().zip(terms).for_each(|(g, term)| *g -= pull * term);
        }
    }
    gradient
}

/// The standard deviation of every term over the attempts of a case, all cases together.
fn deviations(cases: &[&Judged]) -> Vec<f64> {
    let count = cases.first().and_then(|case| case.attempts.first()).map_or(0, |attempt| attempt.terms.len());
    let deviation = |k: usize| {
        let (mut sum, mut n) = (0.0, 0.0);
        for case in cases {
            let mean = case.attempts.iter().map(|a| a.terms[k]).sum::<f64>() / case.attempts.len().max(1) as f64;
            sum += case.attempts.iter().map(|a| (a.terms[k] - mean).powi(2)).sum::<f64>();
            n += case.attempts.len() as f64;
        }
        (sum / f64::max(n, 1.0)).sqrt().max(1e-6)
    };
    (0..count).map(deviation).collect()
}

/// The error of the attempt that these weights choose.
pub fn chosen(case: &Judged, weights: &[f64]) -> f64 {
    let score = |terms: &[f64]| terms.iter().zip(weights).map(|(t, w)| t * w).sum::<f64>();
    let attempts = case.attempts.iter();
    attempts.min_by(|a, b| score(&a.terms).total_cmp(&score(&b.terms))).map_or(f64::NAN, |attempt| attempt.error)
}

#[cfg(test)]
mod tests {
    use super::super::Attempt;
    use super::*;

    #[test]
    fn the_term_that_tells_right_from_wrong_gets_the_weight() {
        let case = |i: usize| {
            let noise = |k: usize| ((i * 37 + k * 61) % 17) as f64 / 17.0;
            let attempt = |k: usize| {
                let error = 0.05 * k as f64;
                Attempt { terms: vec![error + 0.02 * noise(k), noise(k + 5)], error }
            };
            let attempts = (0..6).map(attempt).collect();
            Judged { name: i.to_string(), set: String::new(), held_back: false, attempts, points: Vec::new() }
        };
        let cases: Vec<Judged> = (0..40).map(case).collect();
        let weights = fitted(cases.iter());
        assert!(weights[0] == 1.0 && weights[1] < 0.05, "{weights:?}");
        let mean = cases.iter().map(|case| chosen(case, &weights)).sum::<f64>() / 40.0;
        assert!(mean < 0.01, "{mean}");
    }
}
