//! Geodesic errors of an answer whose truth is known at some points, § 4.2.

use std::collections::{BTreeMap, HashMap};
use std::sync::{Arc, Mutex, PoisonError};

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::measures::{Measures, mean, thresholds, unbounded};
use super::truth::Truth;
use crate::mesh::file_mesh::FileMesh;
use crate::mesh::geodesics::Marching;
use crate::numerics::Unwatched;

/// Errors of an answer at the points of a truth.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct PairsEvaluation {
    /// The length that an error of 1 stands for, in units of the mesh's file.
    pub unit: f64,
    /// The variant with the least mean error.
    pub best: String,
    /// Every point held to that variant.
    pub coherent: Measures,
    /// Every point held to its nearest variant.
    pub pointwise: Measures,
    pub variants: BTreeMap<String, Measures>,
    /// The errors up to which the curves count.
    pub thresholds: Vec<f64>,
    /// In the order of the truth.
    pub points: Vec<PointError>,
}

/// The errors at one point; null where it cannot be reached or its truth is not known.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct PointError {
    #[schema(value_type = Vec<f64>, min_items = 2, max_items = 2)]
    pub point: [f64; 2],
    /// The answer: that of the nearest vertex of the sketch.
    pub mesh_vertex: u32,
    #[schema(value_type = Option<f64>)]
    #[serde(deserialize_with = "unbounded")]
    pub coherent: f64,
    #[schema(value_type = Option<f64>)]
    #[serde(deserialize_with = "unbounded")]
    pub pointwise: f64,
}

/// The errors of p answers to a truth; not a number where it is not known, infinite where it cannot be reached.
#[derive(Clone, Debug, PartialEq)]
pub struct Errors {
    /// The length of an error of 1.
    pub unit: f64,
    /// For every variant.
    pub variants: BTreeMap<String, Vec<f64>>,
}

impl Errors {
    /// The variant with the least mean error, the first of equals.
    pub fn best(&self) -> &str {
        // Where nothing is known of a variant its mean is not a number, which comes last.
        let least = self.variants.iter().min_by(|(_, a), (_, b)| mean(a).total_cmp(&mean(b)));
        least.map_or("", |(name, _)| name)
    }

    /// Every point held to the best variant.
    pub fn coherent(&self) -> &[f64] {
        self.variants.get(self.best()).map_or(&[], Vec::as_slice)
    }

    /// Every point held to its nearest variant.
    pub fn pointwise(&self) -> Vec<f64> {
        let points = self.coherent().len();
        (0..points).map(|p| self.variants.values().map(|errors| errors[p]).fold(f64::NAN, f64::min)).collect()
    }
}

impl Truth {
    /// The errors of p answers, vertices of the file in the order of the points: geodesic distances on the mesh in units of
    /// √area, of √(area / 2) where one side is seen.
    ///
    /// # Panics
    /// Where there are [faults](Truth::faults), or answers that the mesh does not have.
    pub fn errors(&self, mesh: &FileMesh, answers: &[u32]) -> Errors {
        Judge::new(self, mesh).errors(answers)
    }

    /// What p answers, as [`Truth::errors`] takes them, are worth.
    pub fn evaluation(&self, mesh: &FileMesh, answers: &[u32]) -> PairsEvaluation {
        Judge::new(self, mesh).evaluation(answers)
    }
}

/// Judges many answers to one truth: distances from a vertex that was answered before are not measured again.
pub struct Judge<'a> {
    truth: &'a Truth,
    mesh: &'a FileMesh,
    marching: Marching,
    /// The length of an error of 1.
    unit: f64,
    /// The vertices of the file that the truth names, ascending.
    ends: Vec<u32>,
    /// From a vertex of the file to each of the ends.
    known: Mutex<HashMap<u32, Arc<[f64]>>>,
}

impl<'a> Judge<'a> {
    /// # Panics
    /// Where the truth has [faults](Truth::faults) for the mesh.
    pub fn new(truth: &'a Truth, mesh: &'a FileMesh) -> Judge<'a> {
        let surface = mesh.sound();
        let unit = if truth.side { (surface.area() / 2.0).sqrt() } else { surface.area().sqrt() };
        let mut ends: Vec<u32> = truth.variants.values().flatten().filter_map(|&v| u32::try_from(v).ok()).collect();
        ends.sort_unstable();
        ends.dedup();
        Judge { truth, mesh, marching: Marching::new(surface), unit, ends, known: Mutex::default() }
    }

    /// Geodesic distances from a vertex of the file to each of the ends; infinite where there is no way.
    fn distances(&self, answer: u32) -> Arc<[f64]> {
        if let Some(known) = self.known.lock().unwrap_or_else(PoisonError::into_inner).get(&answer) {
            return known.clone();
        }
        let sources: Vec<u32> = self.mesh.sound_vertices(answer).collect();
        let all = self.marching.distances(&sources, &Unwatched).expect("nobody says stop");
        let to = |&end: &u32| self.mesh.sound_vertices(end).map(|v| all[v as usize]).fold(f64::INFINITY, f64::min);
        let distances: Arc<[f64]> = self.ends.iter().map(to).collect();
        self.known.lock().unwrap_or_else(PoisonError::into_inner).insert(answer, distances.clone());
        distances
    }

    /// As [`Truth::errors`].
    pub fn errors(&self, answers: &[u32]) -> Errors {
        let distances: Vec<Arc<[f64]>> = answers.iter().map(|&answer| self.distances(answer)).collect();
        let error = |(distances, right): (&Arc<[f64]>, &i64)| {
            let end = u32::try_from(*right).ok().and_then(|right| self.ends.binary_search(&right).ok());
            end.map_or(f64::NAN, |end| distances[end] / self.unit)
        };
        let of_variant = |(name, truth): (&String, &Vec<i64>)| {
            (name.clone(), distances.iter().zip(truth).map(error).collect::<Vec<f64>>())
        };
        Errors { unit: self.unit, variants: self.truth.variants.iter().map(of_variant).collect() }
    }

    /// What p answers, as [`Truth::errors`] takes them, are worth.
    pub fn evaluation(&self, answers: &[u32]) -> PairsEvaluation {
        let errors = self.errors(answers);
        let (coherent, pointwise) = (errors.coherent(), errors.pointwise());
        let rows = self.truth.points.iter().zip(answers).zip(coherent.iter().zip(&pointwise));
        PairsEvaluation {
            unit: errors.unit,
            best: errors.best().to_owned(),
            coherent: Measures::of(coherent),
            pointwise: Measures::of(&pointwise),
            variants: errors.variants.iter().map(|(name, errors)| (name.clone(), Measures::of(errors))).collect(),
            thresholds: thresholds(),
            points: rows
                .map(|((&point, &mesh_vertex), (&coherent, &pointwise))| PointError {
                    point,
                    mesh_vertex,
                    coherent,
                    pointwise,
                })
                .collect(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evaluation::truth::tests::truth;
    use crate::mesh::TriangleMesh;

    /// A strip of n unit squares along the x-axis, cut by diagonals: vertex 2i at (i, 0), vertex 2i + 1 at (i, 1).
    fn strip(n: u32) -> FileMesh {
        let positions = (0..=n).flat_map(|i| [[f64::from(i), 0.0, 0.0], [f64::from(i), 1.0, 0.0]]).collect();
        let triangles = (0..n).flat_map(|i| [[2 * i, 2 * i + 2, 2 * i + 3], [2 * i, 2 * i + 3, 2 * i + 1]]).collect();
        TriangleMesh::new(positions, triangles).unwrap().into()
    }

    #[test]
    fn errors_are_distances_by_the_root_of_the_area() {
        // Area 8: a distance of 4 is √2 on the whole and 2 on one side.
        for (side, unit) in [(false, 8f64.sqrt()), (true, 2.0)] {
            let errors = truth(side).errors(&strip(8), &[0, 4, 0]);
            let expected = [0.0, 0.0, 4.0 / unit];
            assert_eq!(errors.best(), "front");
            assert!(errors.coherent().iter().zip(expected).all(|(e, x)| (e - x).abs() < 1e-12), "{errors:?}");
            assert_eq!(errors.pointwise(), [0.0; 3]);
        }
    }

    #[test]
    fn the_true_answer_of_any_variant_has_no_error() {
        let truth = truth(false);
        for answers in truth.variants.values() {
            let answers: Vec<u32> = answers.iter().map(|&v| v as u32).collect();
            let found = truth.evaluation(&strip(8), &answers);
            assert_eq!((found.coherent.mean, found.coherent.auc), (0.0, 1.0));
        }
    }

    #[test]
    fn the_pointwise_error_is_never_above_the_coherent_one() {
        let errors = truth(true).errors(&strip(8), &[7, 12, 3]);
        assert!(errors.pointwise().iter().zip(errors.coherent()).all(|(p, c)| p <= c));
    }

    #[test]
    fn what_is_not_known_is_left_out() {
        let mut truth = truth(false);
        truth.variants.retain(|name, _| name == "front");
        truth.variants.insert("other".to_owned(), vec![-1, 16, -1]);
        assert!(truth.faults(18).is_empty());
        let found = truth.evaluation(&strip(8), &[0, 16, 8]);
        assert_eq!((found.best.as_str(), found.coherent.count, found.coherent.mean), ("other", 1, 0.0));
        assert_eq!((found.pointwise.count, found.pointwise.mean), (3, 0.0));
        assert!(found.points[0].coherent.is_nan() && found.points[0].pointwise == 0.0);
    }
}
