//! How far an answer is from the truth: geodesic errors as a share of the size of the mesh [KLF11].

use serde::{Deserialize, Serialize};

use crate::mesh::TriangleMesh;
use crate::mesh::geodesics::Marching;
use crate::numerics::Unwatched;

/// The true correspondence of p points of a sketch.
///
/// A silhouette cannot tell front from back nor left from right, so there are four answers to every point.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Truth {
    /// Whether the view is from the side, so that half of the mesh is seen.
    pub side: bool,
    /// p points in the coordinates of the sketch.
    pub points: Vec<[f64; 2]>,
    pub variants: Variants,
}

/// The true vertices of p points, in each way a silhouette can be read.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Variants {
    /// Where the viewing ray meets the mesh first.
    pub front: Vec<u32>,
    /// `front` on the other side of the body.
    pub front_mirrored: Vec<u32>,
    /// Where the viewing ray leaves the mesh.
    pub back: Vec<u32>,
    /// `back` on the other side of the body.
    pub back_mirrored: Vec<u32>,
}

/// The errors of the p answers to a truth, in units of √area (of √(area / 2) where the view is from the side).
#[derive(Clone, Debug, PartialEq)]
pub struct Errors {
    /// Every point held to one variant: that with the least mean error.
    pub coherent: Vec<f64>,
    /// Every point held to its nearest variant.
    pub pointwise: Vec<f64>,
}

/// The errors of answers, p vertices of the mesh in the order of the truth's points. A point that cannot be reached
/// from its truth has an infinite error.
///
/// # Panics
/// Where the truth names a vertex the mesh does not have, or there are more answers than points.
pub fn errors(mesh: &TriangleMesh, truth: &Truth, answers: &[u32]) -> Errors {
    let Variants { front, front_mirrored, back, back_mirrored } = &truth.variants;
    let scale = if truth.side { (mesh.area() / 2.0).sqrt() } else { mesh.area().sqrt() };
    let marching = Marching::new(mesh);
    let from_answers = distances_from_answers(&marching, answers, [front, front_mirrored, back, back_mirrored]);
    let variants: [Vec<f64>; 4] = from_answers.map(|row| row.into_iter().map(|d| d / scale).collect());
    let pointwise = (0..answers.len()).map(|p| variants.iter().map(|e| e[p]).fold(f64::INFINITY, f64::min)).collect();
    let [first, others @ ..] = variants;
    let coherent = others.into_iter().fold(first, |best, e| if mean(&e) < mean(&best) { e } else { best });
    Errors { coherent, pointwise }
}

/// For every variant, the geodesic distances between answers and truth.
fn distances_from_answers(marching: &Marching, answers: &[u32], variants: [&Vec<u32>; 4]) -> [Vec<f64>; 4] {
    // Several points often have one answer: one march serves them all.
    let mut order: Vec<usize> = (0..answers.len()).collect();
    order.sort_by_key(|&point| answers[point]);
    let mut errors = [(); 4].map(|()| vec![0.0; answers.len()]);
    for points in order.chunk_by(|&p, &q| answers[p] == answers[q]) {
        let distances = marching.distances(&[answers[points[0]]], &Unwatched).expect("nobody says stop");
        for &point in points {
            for (errors, variant) in errors.iter_mut().zip(variants) {
                errors[point] = distances[variant[point] as usize];
            }
        }
    }
    errors
}

/// For every point of a truth, the answer of the correspondence that is nearest in the plane; ties go to the first.
/// `at` and `to` are the places and the vertices of the correspondences; without any there is no answer.
pub fn answers(truth: &Truth, at: &[[f64; 2]], to: &[u32]) -> Vec<u32> {
    let squared = |a: [f64; 2], b: [f64; 2]| (a[0] - b[0]).powi(2) + (a[1] - b[1]).powi(2);
    let nearest = |&point: &[f64; 2]| {
        at.iter().zip(to).min_by(|(a, _), (b, _)| squared(**a, point).total_cmp(&squared(**b, point)))
    };
    truth.points.iter().filter_map(nearest).map(|(_, &vertex)| vertex).collect()
}

/// The mean error; NaN of none.
pub fn mean(errors: &[f64]) -> f64 {
    errors.iter().sum::<f64>() / errors.len() as f64
}

/// The share of errors at or below each threshold.
pub fn curve(errors: &[f64], thresholds: &[f64]) -> Vec<f64> {
    let share = |&t: &f64| errors.iter().filter(|&&e| e <= t).count() as f64 / errors.len() as f64;
    thresholds.iter().map(share).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A strip of n unit squares along the x-axis, cut by diagonals: vertex 2i at (i, 0), vertex 2i + 1 at (i, 1).
    fn strip(n: u32) -> TriangleMesh {
        let positions = (0..=n).flat_map(|i| [[f64::from(i), 0.0, 0.0], [f64::from(i), 1.0, 0.0]]).collect();
        let triangles = (0..n).flat_map(|i| [[2 * i, 2 * i + 2, 2 * i + 3], [2 * i, 2 * i + 3, 2 * i + 1]]).collect();
        TriangleMesh::new(positions, triangles).unwrap()
    }

    fn truth(side: bool) -> Truth {
        let variants = Variants {
            front: vec![0, 4, 8],
            front_mirrored: vec![1, 5, 9],
            back: vec![16, 4, 0],
            back_mirrored: vec![17, 5, 1],
        };
        Truth { side, points: vec![[0.0, 0.0], [1.0, 0.0], [2.0, 0.0]], variants }
    }

    #[test]
    fn errors_are_distances_by_the_root_of_the_area() {
        // Area 8: a distance of 4 is √2 on the whole and 2 on one side.
        for (side, unit) in [(false, 8f64.sqrt()), (true, 2.0)] {
            let errors = errors(&strip(8), &truth(side), &[0, 4, 0]);
            let expected = [0.0, 0.0, 4.0 / unit];
            assert!(errors.coherent.iter().zip(expected).all(|(e, x)| (e - x).abs() < 1e-12), "{errors:?}");
            assert_eq!(errors.pointwise, [0.0; 3]);
        }
    }

    #[test]
    fn the_true_answer_of_any_variant_has_no_error() {
        let truth = truth(false);
        let Variants { front, front_mirrored, back, back_mirrored } = &truth.variants;
        for variant in [front, front_mirrored, back, back_mirrored] {
            assert_eq!(errors(&strip(8), &truth, variant).coherent, [0.0; 3]);
        }
    }

    #[test]
    fn the_pointwise_error_is_never_above_the_coherent_one() {
        let errors = errors(&strip(8), &truth(true), &[7, 12, 3]);
        assert!(errors.pointwise.iter().zip(&errors.coherent).all(|(p, c)| p <= c));
    }

    #[test]
    fn a_point_is_answered_by_the_nearest_correspondence() {
        let at = [[0.1, 0.0], [0.9, 0.3], [9.0, 9.0]];
        assert_eq!(answers(&truth(false), &at, &[5, 6, 7]), [5, 6, 6]);
    }

    #[test]
    fn the_curve_counts_errors_at_and_below_the_threshold() {
        let errors = [0.0, 0.1, 0.3, f64::INFINITY];
        assert_eq!(curve(&errors, &[0.0, 0.1, 0.2, 0.5]), [0.25, 0.5, 0.5, 0.75]);
        assert_eq!(mean(&errors[..2]), 0.05);
    }
}
