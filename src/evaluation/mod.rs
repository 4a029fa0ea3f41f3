//! How far an answer is from the truth: geodesic errors as a share of the size of the mesh [KLF11].

use serde::{Deserialize, Serialize};

use crate::mesh::TriangleMesh;
use crate::mesh::geodesics::Marching;

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
        let distances = marching.distances(&[answers[points[0]]]);
        for &point in points {
            for (errors, variant) in errors.iter_mut().zip(variants) {
                errors[point] = distances[variant[point] as usize];
            }
        }
    }
    errors
}

/// For every point of a truth, the answer of the correspondence that is nearest in the plane; ties go to the first.
/// `at` and `to` are the places and the vertices of the correspondences.
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
