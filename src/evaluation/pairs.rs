//! Geodesic errors of an answer whose truth is known at some points, § 4.2.

use std::collections::{BTreeMap, HashMap};
use std::sync::{Arc, Mutex, PoisonError};

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::Fault;
use super::measures::{Measures, mean, thresholds, unbounded};
use crate::mesh::file_mesh::FileMesh;
use crate::mesh::geodesics::Marching;
use crate::numerics::Unwatched;

/// The vertex of a point whose truth is not known.
const UNKNOWN: i64 = -1;
/// Points of a truth at most.
const MAX_POINTS: usize = 10_000;
/// Ways to read it at most.
const MAX_VARIANTS: usize = 16;
/// Vertices that the fronts of all answers pass at most: some tens of seconds' work.
const MAX_PASSED: usize = 50_000_000;

/// The true correspondence of p points of a sketch. What else a file says is passed over.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct Truth {
    /// Whether the view is from the side, so that half of the mesh is seen: errors are in units of √(area / 2) then, else
    /// of √area.
    pub side: bool,
    /// p points in the coordinates of the sketch.
    #[schema(schema_with = points_schema)]
    pub points: Vec<[f64; 2]>,
    /// For each way the drawing can be read the p vertices of the user's file, −1 where one is not known. A silhouette cannot
    /// tell front from back nor left from right: `front`, `front_mirrored`, `back` and `back_mirrored`.
    #[schema(schema_with = variants_schema)]
    pub variants: BTreeMap<String, Vec<i64>>,
}

fn points_schema() -> utoipa::openapi::schema::ArrayBuilder {
    use utoipa::openapi::schema::{ArrayBuilder, ObjectBuilder, Type};
    let coordinate = ObjectBuilder::new().schema_type(Type::Number);
    let point = ArrayBuilder::new().items(coordinate).min_items(Some(2)).max_items(Some(2));
    ArrayBuilder::new().items(point).min_items(Some(1)).max_items(Some(MAX_POINTS))
}

fn variants_schema() -> utoipa::openapi::schema::ObjectBuilder {
    use utoipa::openapi::schema::{ArrayBuilder, ObjectBuilder, Type};
    let vertex = ObjectBuilder::new().schema_type(Type::Integer).minimum(Some(UNKNOWN)).maximum(Some(u32::MAX));
    let vertices = ArrayBuilder::new().items(vertex).min_items(Some(1)).max_items(Some(MAX_POINTS));
    ObjectBuilder::new()
        .schema_type(Type::Object)
        .additional_properties(Some(vertices))
        .description(Some("A list for each way the drawing can be read; 1 to 16 of them."))
}

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
    /// What is wrong with it for a mesh of so many vertices.
    pub fn faults(&self, vertices: usize) -> Vec<Fault> {
        let mut faults = Vec::new();
        let p = self.points.len();
        if !(1..=MAX_POINTS).contains(&p) {
            faults.push(Fault::new("/pairs/points", format!("must be 1 to {MAX_POINTS} points, are {p}")));
        }
        if !(1..=MAX_VARIANTS).contains(&self.variants.len()) {
            let detail = format!("must be 1 to {MAX_VARIANTS}, are {}", self.variants.len());
            faults.push(Fault::new("/pairs/variants", detail));
        }
        for (name, truth) in &self.variants {
            let pointer = format!("/pairs/variants/{}", name.replace('~', "~0").replace('/', "~1"));
            if truth.len() != p {
                let detail = format!("must have a vertex for each of the {p} points, has {}", truth.len());
                faults.push(Fault::new(&pointer, detail));
            }
            let there = |vertex: i64| vertex == UNKNOWN || usize::try_from(vertex).is_ok_and(|v| v < vertices);
            if let Some((i, vertex)) = truth.iter().enumerate().find(|(_, vertex)| !there(**vertex)) {
                let detail = format!("there is no vertex {vertex}, the mesh has {vertices}");
                faults.push(Fault::new(format!("{pointer}/{i}"), detail));
            } else if truth.iter().all(|&vertex| vertex == UNKNOWN) && !truth.is_empty() {
                faults.push(Fault::new(&pointer, "no vertex is known"));
            }
        }
        let passed = vertices.saturating_mul(p);
        if faults.is_empty() && passed > MAX_PASSED {
            let most = MAX_PASSED / vertices.max(1);
            let detail =
                format!("{p} points are too many on a mesh of {vertices} vertices: up to {most} can be judged");
            faults.push(Fault::new("/pairs/points", detail));
        }
        faults
    }

    /// For every point the answer of the correspondence that is nearest in the plane; ties go to the first. `at` and `to`
    /// are the places and the vertices of the correspondences; without any there is no answer.
    pub fn answers(&self, at: &[[f64; 2]], to: &[u32]) -> Vec<u32> {
        let squared = |a: [f64; 2], b: [f64; 2]| (a[0] - b[0]).powi(2) + (a[1] - b[1]).powi(2);
        let nearest = |&point: &[f64; 2]| {
            at.iter().zip(to).min_by(|(a, _), (b, _)| squared(**a, point).total_cmp(&squared(**b, point)))
        };
        self.points.iter().filter_map(nearest).map(|(_, &vertex)| vertex).collect()
    }

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
    use crate::mesh::TriangleMesh;

    /// A strip of n unit squares along the x-axis, cut by diagonals: vertex 2i at (i, 0), vertex 2i + 1 at (i, 1).
    fn strip(n: u32) -> FileMesh {
        let positions = (0..=n).flat_map(|i| [[f64::from(i), 0.0, 0.0], [f64::from(i), 1.0, 0.0]]).collect();
        let triangles = (0..n).flat_map(|i| [[2 * i, 2 * i + 2, 2 * i + 3], [2 * i, 2 * i + 3, 2 * i + 1]]).collect();
        TriangleMesh::new(positions, triangles).unwrap().into()
    }

    fn truth(side: bool) -> Truth {
        let variants = [
            ("front", vec![0, 4, 8]),
            ("front_mirrored", vec![1, 5, 9]),
            ("back", vec![16, 4, 0]),
            ("back_mirrored", vec![17, 5, 1]),
        ];
        let variants = variants.map(|(name, truth)| (name.to_owned(), truth)).into();
        Truth { side, points: vec![[0.0, 0.0], [1.0, 0.0], [2.0, 0.0]], variants }
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

    #[test]
    fn a_point_is_answered_by_the_nearest_correspondence() {
        let at = [[0.1, 0.0], [0.9, 0.3], [9.0, 9.0]];
        assert_eq!(truth(false).answers(&at, &[5, 6, 7]), [5, 6, 6]);
    }

    #[test]
    fn what_a_truth_has_wrong_is_named() {
        let faults = |change: &dyn Fn(&mut Truth)| -> Vec<String> {
            let mut truth = truth(false);
            change(&mut truth);
            truth.faults(18).into_iter().map(|fault| fault.pointer).collect()
        };
        assert_eq!(faults(&|_| ()), [""; 0]);
        assert_eq!(faults(&|t| t.variants.clear()), ["/pairs/variants"]);
        assert_eq!(faults(&|t| t.variants.get_mut("back").unwrap()[1] = 18), ["/pairs/variants/back/1"]);
        assert_eq!(faults(&|t| t.variants.get_mut("back").unwrap()[2] = -2), ["/pairs/variants/back/2"]);
        assert_eq!(faults(&|t| t.variants.get_mut("front").unwrap().truncate(2)), ["/pairs/variants/front"]);
        assert_eq!(faults(&|t| *t.variants.get_mut("front").unwrap() = vec![-1; 3]), ["/pairs/variants/front"]);
        assert_eq!(faults(&|t| drop(t.variants.insert("a/b".to_owned(), vec![]))), ["/pairs/variants/a~1b"]);
        let many =
            Truth { points: vec![[0.0; 2]; 9_000], variants: [("a".to_owned(), vec![0; 9_000])].into(), side: true };
        assert_eq!(many.faults(6_000)[0].pointer, "/pairs/points");
    }
}
