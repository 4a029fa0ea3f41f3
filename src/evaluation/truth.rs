//! The true correspondence of points of a sketch, as files have it.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::Fault;

/// The vertex of a point whose truth is not known.
const UNKNOWN: i64 = -1;
/// Points of a truth at most.
const MAX_POINTS: usize = 10_000;
/// Ways to read it at most.
const MAX_VARIANTS: usize = 16;
/// Of so many points of a truth one may lie off the drawing: it may be of a line that was too fine to be read.
const ONE_MAY_BE_OFF: usize = 10;
/// Vertices that the fronts of all answers pass at most: some tens of seconds' work.
const MAX_PASSED: usize = 50_000_000;

/// The true correspondence of p points of a sketch. What else a file says is passed over.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct Truth {
    /// Whether the view is from the side, so that half of the mesh is seen: errors are in units of √(area / 2) then, else
    /// of √area.
    pub side: bool,
    /// p points in the coordinates that the sketch was uploaded in.
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

    /// What is wrong with it for a drawing with correspondences at these places: more than a tenth of its points farther from
    /// each than a square is wide of which there are as many in the drawing's box. Points of the drawing are nearer to the
    /// vertices of its triangulation; those of one that is turned over are not.
    pub fn misplaced(&self, at: &[[f64; 2]]) -> Option<Fault> {
        let least = at.iter().copied().reduce(|a, b| [a[0].min(b[0]), a[1].min(b[1])])?;
        let largest = at.iter().copied().reduce(|a, b| [a[0].max(b[0]), a[1].max(b[1])])?;
        let square = (largest[0] - least[0]) * (largest[1] - least[1]) / at.len() as f64;
        let off = self.points.iter().filter(|&&point| at.iter().all(|&place| squared(place, point) > square)).count();
        let p = self.points.len();
        let detail = format!(
            "{off} of the {p} points lie off the drawing, which reaches from {least:.1?} to {largest:.1?}: they are to be in the \
             coordinates that the sketch was uploaded in, y up in JSON and down in SVG and pictures"
        );
        (off * ONE_MAY_BE_OFF > p).then(|| Fault::new("/pairs/points", detail))
    }

    /// Distances that are kept at most while an answer with these many vertices is judged on a mesh of so many: from every vertex
    /// that is answered to every one that is true, where there are no [faults](Truth::faults).
    pub fn distances(&self, answers: usize, vertices: usize) -> usize {
        let points = self.points.len();
        let ends = points.saturating_mul(self.variants.len()).min(vertices);
        points.min(answers).saturating_mul(ends).min(MAX_PASSED)
    }

    /// For every point the answer of the correspondence that is nearest in the plane; ties go to the first. `at` and `to`
    /// are the places and the vertices of the correspondences; without any there is no answer.
    pub fn answers(&self, at: &[[f64; 2]], to: &[u32]) -> Vec<u32> {
        let nearest = |&point: &[f64; 2]| {
            at.iter().zip(to).min_by(|(a, _), (b, _)| squared(**a, point).total_cmp(&squared(**b, point)))
        };
        self.points.iter().filter_map(nearest).map(|(_, &vertex)| vertex).collect()
    }
}

/// The square of the distance of two points.
fn squared(a: [f64; 2], b: [f64; 2]) -> f64 {
    (a[0] - b[0]).powi(2) + (a[1] - b[1]).powi(2)
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// Three points and the four ways to read their drawing, on a strip of eight squares.
    pub fn truth(side: bool) -> Truth {
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
    fn a_point_is_answered_by_the_nearest_correspondence() {
        let at = [[0.1, 0.0], [0.9, 0.3], [9.0, 9.0]];
        assert_eq!(truth(false).answers(&at, &[5, 6, 7]), [5, 6, 6]);
    }

    #[test]
    fn points_in_other_coordinates_than_the_drawing_are_refused() {
        // A triangle that stands on its base, whose truth is known at every seventh vertex.
        let at: Vec<[f64; 2]> =
            (0..=20).flat_map(|y| (y..=40 - y).map(move |x| [f64::from(x), f64::from(y)])).collect();
        let points = |place: fn([f64; 2]) -> [f64; 2]| Truth {
            points: at.iter().step_by(7).map(|&[x, y]| place([x + 0.4, y + 0.3])).collect(),
            ..Truth::default()
        };
        assert_eq!(points(|point| point).misplaced(&at), None);
        assert_eq!(points(|point| point).misplaced(&[]), None);
        let down = points(|[x, y]| [x, 20.0 - y]).misplaced(&at).unwrap();
        assert_eq!(down.pointer, "/pairs/points");
        assert!(
            down.detail.contains("of the 63 points lie off the drawing, which reaches from [0.0, 0.0]"),
            "{}",
            down.detail
        );
        assert!(points(|[x, y]| [10.0 * x, 10.0 * y]).misplaced(&at).is_some());
    }

    #[test]
    fn distances_are_kept_of_answers_and_ends_that_there_are() {
        let truth = truth(false);
        assert_eq!(
            [truth.distances(100, 18), truth.distances(2, 18), truth.distances(100, 5)],
            [3 * 12, 2 * 12, 3 * 5]
        );
        let many = Truth { points: vec![[0.0; 2]; 1 << 20], ..truth };
        assert_eq!(many.distances(1 << 20, 1 << 20), MAX_PASSED);
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
