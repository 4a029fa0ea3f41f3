//! How far an alignment is to be trusted, point by point.

use super::attempt::Attempt;
use crate::alignment::prepared::FlatShape;
use crate::alignment::scene::Scene;
use crate::alignment::scene::landmarks::Landmarks;
use crate::geometry::{length, subtract};
use crate::numerics::median;

/// Doubts of an answer.
pub const DOUBTS: usize = 6;

/// Their names, in their order: of the point the distortion of the nearest sample and the stretch of the deformation; of
/// all points terms of the choice, and how nearly as good another answer is.
pub const NAMES: [&str; DOUBTS] = ["distortion", "stretch", "mismatch", "uncovered", "turned_about", "ambiguity"];

/// A logistic regression on standardised logarithms.
#[derive(Clone, Debug, PartialEq)]
pub struct Regression {
    pub means: [f64; DOUBTS],
    pub deviations: [f64; DOUBTS],
    pub weights: [f64; DOUBTS],
    pub bias: f64,
}

/// As `sketchmatch weigh --fit` fits it to silhouettes of animals and persons and to drawings.
const FITTED: Regression = Regression {
    means: [-2.857, -1.684, -0.929, -3.064, -6.223, -4.363],
    deviations: [0.568, 0.775, 0.484, 1.020, 1.522, 1.996],
    weights: [-0.308, -0.404, -0.269, -0.089, -0.052, -0.336],
    bias: 1.548,
};
/// Logarithms are taken of no less.
const LEAST: f64 = 1e-3;

/// Answers whose points lie so far apart on average, left and right alike, are different, in units of √area.
const DIFFERENT: f64 = 0.15;
/// The difference of scores that makes one of two answers e times as likely as the other.
const MARGIN: f64 = 0.03;
/// Answers that miss landmarks by more are none.
const ASTRAY: f64 = 0.1;

/// For every vertex of the sketch the estimated chance that its answer is less than 0.1 from the truth, in units of
/// √area, of √(area / 2) for the drawings from the side among those it is estimated from.
pub fn trust(doubts: &[[f64; DOUBTS]]) -> Vec<f64> {
    doubts.iter().map(|doubts| FITTED.chance(doubts)).collect()
}

impl Regression {
    /// The chance that an answer of which this is doubted is right.
    pub fn chance(&self, doubts: &[f64; DOUBTS]) -> f64 {
        let logarithms = logarithms(doubts);
        let term = |i: usize| (logarithms[i] - self.means[i]) / self.deviations[i] * self.weights[i];
        1.0 / (1.0 + (-self.bias - (0..DOUBTS).map(term).sum::<f64>()).exp())
    }
}

/// The logarithms of doubts, which the regression is on.
pub fn logarithms(doubts: &[f64; DOUBTS]) -> [f64; DOUBTS] {
    doubts.map(|doubt| doubt.max(LEAST).ln())
}

/// For every vertex of the sketch what speaks against its answer in the attempt, each the less the better; `others` are the
/// attempts that it was chosen from.
pub fn doubts(scene: &Scene<'_>, attempt: &Attempt, others: &[Attempt], landmarks: &Landmarks) -> Vec<[f64; DOUBTS]> {
    let shape = scene.shape;
    let Attempt { laying, distortion, terms, .. } = attempt;
    let stretches = stretches(shape, &laying.positions);
    let ambiguity = ambiguity(scene, attempt, others, landmarks);
    let of_vertex = |v: usize| {
        let bent = distortion.of_samples[nearest_sample(shape, v)];
        [bent, stretches[v], terms.mismatch, terms.uncovered, terms.turned_about, ambiguity]
    };
    (0..shape.positions.len()).map(of_vertex).collect()
}

/// How likely the best of the different answers is beside this one, from 0 to 1.
fn ambiguity(scene: &Scene<'_>, attempt: &Attempt, others: &[Attempt], landmarks: &Landmarks) -> f64 {
    let folded = |map: &[u32], sample: u32| {
        let position = scene.mesh.positions[map[sample as usize] as usize];
        let symmetry = &scene.mesh.symmetry;
        if symmetry.height(position) < 0.0 { symmetry.reflect(position) } else { position }
    };
    let apart = |other: &Attempt| {
        let samples = &scene.shape.samples;
        let distance = |&s: &u32| length(subtract(folded(&attempt.map, s), folded(&other.map, s)));
        samples.iter().map(distance).sum::<f64>() / samples.len().max(1) as f64
    };
    let is_possible = |other: &&Attempt| landmarks.astray(scene.mesh, &other.map) <= ASTRAY;
    let rival = others.iter().filter(is_possible).filter(|other| apart(other) > DIFFERENT);
    let margin = rival.map(|other| other.score() - attempt.score()).fold(f64::INFINITY, f64::min);
    (-margin.max(0.0) / MARGIN).exp()
}

/// The sample nearest to a vertex within the figure.
fn nearest_sample(shape: &FlatShape, vertex: usize) -> usize {
    let nearer =
        |best: usize, s: usize| if shape.distances[s][vertex] < shape.distances[best][vertex] { s } else { best };
    (0..shape.samples.len()).fold(0, nearer)
}

/// For every vertex the mean over its triangles of the larger |log| of the two principal stretches, the usual stretch
/// of the whole taken off.
fn stretches(shape: &FlatShape, flat: &[[f64; 2]]) -> Vec<f64> {
    let singular: Vec<[f64; 2]> = shape
        .triangles
        .iter()
        .map(|t| principal_stretches(t.map(|v| shape.positions[v as usize]), t.map(|v| flat[v as usize])))
        .collect();
    let usual = median(singular.iter().flatten().copied().collect()).max(LEAST);
    let (mut sum, mut count) = (vec![0.0; flat.len()], vec![0.0; flat.len()]);
    for (triangle, stretches) in shape.triangles.iter().zip(&singular) {
        let strain = stretches.map(|s| (s.max(LEAST) / usual).ln().abs());
        for &v in triangle {
            sum[v as usize] += strain[0].max(strain[1]);
            count[v as usize] += 1.0;
        }
    }
    sum.iter().zip(&count).map(|(sum, count)| sum / count).collect()
}

/// The singular values of the linear map that takes one triangle to another.
fn principal_stretches(from: [[f64; 2]; 3], to: [[f64; 2]; 3]) -> [f64; 2] {
    let sides = |t: [[f64; 2]; 3]| [t[1][0] - t[0][0], t[2][0] - t[0][0], t[1][1] - t[0][1], t[2][1] - t[0][1]];
    let ([a, b, c, d], [p, q, r, s]) = (sides(from), sides(to));
    let determinant = a * d - b * c;
    // [p q; r s] [a b; c d]⁻¹
    let m = [p * d - q * c, q * a - p * b, r * d - s * c, s * a - r * b].map(|x| x / determinant);
    let (even, odd) = ((m[0] + m[3]).hypot(m[2] - m[1]), (m[0] - m[3]).hypot(m[2] + m[1]));
    [0.5 * (even + odd), 0.5 * (even - odd).abs()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rotated_and_stretched_triangle_has_the_stretches() {
        let from = [[0.0, 0.0], [1.0, 0.2], [0.3, 0.9]];
        let (s, c) = 0.7f64.sin_cos();
        let to = from.map(|[x, y]| [3.0 * x, 0.5 * y]).map(|[x, y]| [c * x - s * y, s * x + c * y]);
        let [most, least] = principal_stretches(from, to);
        assert!((most - 3.0).abs() < 1e-12 && (least - 0.5).abs() < 1e-12);
    }
}
