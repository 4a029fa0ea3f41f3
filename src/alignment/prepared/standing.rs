//! Which way is up on a mesh: along one of the axes of its file, so that it stands on what lies apart from its plane of
//! symmetry, as feet do, with its middle above them and not near the ground.

use std::convert::Infallible;

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::symmetry::{Symmetry, plane};
use crate::geometry::axes::{Axes, centred};
use crate::geometry::frame::Frame;
use crate::geometry::{dot, doubled_area};
use crate::mesh::TriangleMesh;
use crate::spectral::laplacian::{Lumping, mass};

/// What lies lower than this above the lowest vertex is on the ground, and what is further than this from the plane of
/// symmetry lies apart from it, in units of √area.
const GROUND: f64 = 0.035;
const APART: f64 = 0.04;
/// A middle higher above the ground than this, in units of √area, is no better: legs lift it, a body that lies has it low.
const HIGH: f64 = 0.4;
/// What a direction within the plane of symmetry is worth beside standing on feet, one that files have as up (y or z,
/// not turned round), and that which the convention of the format says.
const WITHIN: f64 = 0.5;
const USUAL: f64 = 0.5;
const AGREED: f64 = 1.0;
/// The difference of two directions' worths that makes one e times as likely as the other.
const DOUBT: f64 = 0.12;

/// The direction that is up on a mesh.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct Up {
    /// An axis of the mesh's file, of length 1.
    #[schema(value_type = Vec<f64>, min_items = 3, max_items = 3)]
    pub direction: [f64; 3],
    /// How sure that is, from 1/6 to 1.
    pub confidence: f64,
}

impl Up {
    /// Whether it is surer than not.
    pub fn is_sure(&self) -> bool {
        self.confidence > 0.5
    }
}

/// The up of a body, in one part or several, whose every vertex has a triangle, `agreed` being what the format of its file says.
pub fn up(mesh: &TriangleMesh, agreed: Option<[f64; 3]>) -> Up {
    let area = mesh.area();
    let masses: Vec<f64> = mass(mesh, Lumping::Barycentric).iter().map(|a| a / area).collect();
    let centred = centred(mesh.positions(), &masses, area.sqrt());
    let axes = Axes::principal(&centred, &masses);
    let positions: Vec<[f64; 3]> = centred.into_iter().map(|p| axes.along(p)).collect();
    let Ok(symmetry) = plane(&positions, &masses, || Ok::<_, Infallible>(()));
    found(&Body { positions: &positions, masses: &masses, axes: &axes, symmetry: &symmetry }, agreed)
}

/// A mesh at area 1 about its middle, along its principal axes.
pub struct Body<'a> {
    pub positions: &'a [[f64; 3]],
    pub masses: &'a [f64],
    pub axes: &'a Axes,
    pub symmetry: &'a Symmetry,
}

/// As [`up`].
pub fn found(body: &Body<'_>, agreed: Option<[f64; 3]>) -> Up {
    let directions = (0..3).flat_map(|axis| {
        [1.0, -1.0].map(|sign| std::array::from_fn::<f64, 3, _>(|i| if i == axis { sign } else { 0.0 }))
    });
    let worth = |direction: [f64; 3]| {
        let usual = if direction[1] + direction[2] > 0.0 { USUAL } else { 0.0 };
        let agreed = if agreed == Some(direction) { AGREED } else { 0.0 };
        body.standing(body.axes.along(direction)) + usual + agreed
    };
    let worths: Vec<([f64; 3], f64)> = directions.map(|direction| (direction, worth(direction))).collect();
    let first = worths.iter().copied().reduce(|a, b| if b.1 > a.1 { b } else { a });
    let (direction, most) = first.unwrap_or(([0.0, 0.0, 1.0], 0.0));
    let total: f64 = worths.iter().map(|(_, worth)| ((worth - most) / DOUBT).exp()).sum();
    Up { direction, confidence: 1.0 / total }
}

impl Body<'_> {
    /// How much the body looks as if it stood with this direction up.
    fn standing(&self, up: [f64; 3]) -> f64 {
        let heights: Vec<f64> = self.positions.iter().map(|&p| dot(up, p)).collect();
        let ground = heights.iter().copied().fold(f64::INFINITY, f64::min) + GROUND;
        let feet: Vec<usize> = (0..heights.len()).filter(|&v| heights[v] < ground).collect();
        let weight = |v: &usize| self.masses[*v];
        let apart = feet.iter().filter(|v| self.symmetry.height(self.positions[**v]).abs() > APART);
        let apart = apart.map(weight).sum::<f64>() / feet.iter().map(weight).sum::<f64>().max(f64::MIN_POSITIVE);
        let frame = Frame::looking_from(up);
        let prints = feet.iter().map(|&v| frame.project(self.positions[v])).collect();
        // The middle of the body is the origin.
        let high = (GROUND - ground).min(HIGH);
        apart - distance_from_origin(&hull(prints)) + high + WITHIN * (1.0 - dot(up, self.symmetry.normal).abs())
    }
}

/// The convex hull of points, counter-clockwise [And79].
fn hull(mut points: Vec<[f64; 2]>) -> Vec<[f64; 2]> {
    points.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
    let half = |points: &mut dyn Iterator<Item = [f64; 2]>| {
        let mut chain: Vec<[f64; 2]> = Vec::new();
        for p in points {
            while let [.., a, b] = chain[..]
                && doubled_area([a, b, p]) <= 0.0
            {
                chain.pop();
            }
            chain.push(p);
        }
        chain.pop();
        chain
    };
    let lower = half(&mut points.iter().copied());
    let upper = half(&mut points.iter().rev().copied());
    // Of a single place each half is empty.
    if lower.is_empty() { points.first().copied().into_iter().collect() } else { [lower, upper].concat() }
}

/// How far the origin is from a convex polygon, counter-clockwise; 0 inside.
fn distance_from_origin(corners: &[[f64; 2]]) -> f64 {
    let edges = || corners.iter().zip(corners.iter().cycle().skip(1));
    let inside = corners.len() > 2 && edges().all(|(a, b)| a[0] * b[1] - a[1] * b[0] >= 0.0);
    if inside {
        return 0.0;
    }
    let distance = |(a, b): (&[f64; 2], &[f64; 2])| {
        let edge = [b[0] - a[0], b[1] - a[1]];
        let squared = (edge[0] * edge[0] + edge[1] * edge[1]).max(f64::MIN_POSITIVE);
        let t = (-(a[0] * edge[0] + a[1] * edge[1]) / squared).clamp(0.0, 1.0);
        (a[0] + t * edge[0]).hypot(a[1] + t * edge[1])
    };
    edges().map(distance).fold(f64::INFINITY, f64::min)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::solids::{sphere, star};

    fn placed(mesh: &TriangleMesh, place: impl Fn([f64; 3]) -> [f64; 3]) -> TriangleMesh {
        let positions = mesh.positions().iter().map(|&p| place(p)).collect();
        TriangleMesh::new(positions, mesh.triangles().to_vec()).unwrap()
    }

    #[test]
    fn a_body_on_two_legs_stands_along_the_axis_it_was_made_along() {
        let body = star(0.1);
        let standing = up(&body, None);
        assert_eq!(standing.direction, [0.0, 0.0, 1.0]);
        assert!(standing.is_sure());
        // Mirrored, so that its ups and downs are as usual as they were.
        let other = up(&placed(&body, |[x, y, z]| [x, z, y]), None);
        assert_eq!(other.direction, [0.0, 1.0, 0.0]);
        assert!((other.confidence - standing.confidence).abs() < 1e-6);
    }

    #[test]
    fn where_nothing_stands_the_format_tells() {
        let ball = sphere(12, 24);
        for agreed in [[0.0, 1.0, 0.0], [0.0, 0.0, 1.0]] {
            let told = up(&ball, Some(agreed));
            assert!(told.is_sure() && told.direction == agreed);
        }
    }

    #[test]
    fn the_hull_holds_the_origin_or_is_away_from_it() {
        let square = vec![[1.0, 1.0], [-1.0, 1.0], [0.0, 0.0], [-1.0, -1.0], [1.0, -1.0]];
        assert_eq!(hull(square.clone()).len(), 4);
        assert_eq!(distance_from_origin(&hull(square.clone())), 0.0);
        let beside = square.iter().map(|[x, y]| [x + 3.0, *y]).collect();
        assert!((distance_from_origin(&hull(beside)) - 2.0).abs() < 1e-12);
        assert!((distance_from_origin(&hull(vec![[3.0, 4.0]; 3])) - 5.0).abs() < 1e-12);
    }
}
