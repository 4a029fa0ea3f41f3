//! How far an alignment is to be trusted, point by point.

use crate::alignment::distances::distortion::Distortion;
use crate::alignment::laying::Laying;
use crate::alignment::prepared::sampled_distances::Place;
use crate::alignment::prepared::{FlatShape, PreparedMesh};
use crate::numerics::median;

/// A logistic regression on standardised logarithms, fitted to the errors of silhouettes of animals and persons laid on
/// meshes of others and of themselves, turned and mirrored: of the distortion of the nearest sample, the local stretch of
/// the deformation, the cost of the outlines and the local tear of the point map.
const MEANS: [f64; 4] = [-3.329, -2.159, -2.567, -4.148];
const DEVIATIONS: [f64; 4] = [0.576, 0.984, 0.502, 0.715];
const WEIGHTS: [f64; 4] = [0.242, 1.099, 1.125, 0.260];
const BIAS: f64 = -2.673;
/// Logarithms are taken of no less.
const LEAST: f64 = 1e-3;

/// For every vertex of the sketch the estimated chance that its answer in `map` is less than 0.1 √area from the truth,
/// where `laying` is how the sketch was laid on the view.
pub fn trust(
    shape: &FlatShape,
    mesh: &PreparedMesh,
    laying: &Laying,
    map: &[u32],
    distortion: &Distortion,
) -> Vec<f64> {
    let stretches = stretches(shape, &laying.positions);
    let tears = tears(shape, mesh, map, distortion.scale);
    let chance = |v: usize| {
        let features = [distortion.of_samples[nearest_sample(shape, v)], stretches[v], laying.cost, tears[v]];
        let term = |i: usize| (features[i].max(LEAST).ln() - MEANS[i]) / DEVIATIONS[i] * WEIGHTS[i];
        let score: f64 = (0..features.len()).map(term).sum();
        1.0 / (1.0 + (score + BIAS).exp())
    };
    (0..shape.positions.len()).map(chance).collect()
}

/// For every vertex the mean over its edges of how much longer or shorter they are on the mesh, in units of the sketch:
/// large where neighbours lie on different limbs or on different sides of the body.
fn tears(shape: &FlatShape, mesh: &PreparedMesh, map: &[u32], scale: f64) -> Vec<f64> {
    let (mut sum, mut count) = (vec![0.0; map.len()], vec![0.0; map.len()]);
    let places: Vec<Place> = map.iter().map(|&vertex| mesh.distances.at(vertex)).collect();
    for &(i, j, _) in &shape.elastic.edges {
        let (i, j) = (i as usize, j as usize);
        let (p, q) = (shape.positions[i], shape.positions[j]);
        let tear = (places[i].to(&places[j]) / scale - (p[0] - q[0]).hypot(p[1] - q[1])).abs();
        for v in [i, j] {
            sum[v] += tear;
            count[v] += 1.0;
        }
    }
    sum.iter().zip(&count).map(|(sum, count)| sum / f64::max(*count, 1.0)).collect()
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
