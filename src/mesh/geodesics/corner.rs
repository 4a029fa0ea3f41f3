//! The corners a front passes, each laid out in a plane.

use std::collections::HashMap;

use crate::mesh::{TriangleMesh, length, subtract};

/// Triangles an obtuse corner may be unfolded over before its own triangle has to do.
const UNFOLDINGS: usize = 32;

/// A vertex and its place in a plane.
type Placed = (u32, [f64; 2]);

/// A vertex, the tip, and two others that carry the front to it. In their plane `base[0]` is the origin, `base[1]`
/// lies on the positive x-axis and the tip above the axis.
pub(super) struct Corner {
    pub(super) tip: u32,
    pub(super) base: [u32; 2],
    width: f64,
    at: [f64; 2],
}

impl Corner {
    /// The corner with its tip at the origin of the plane the base is placed in.
    fn new(tip: u32, [(left, l), (right, r)]: [Placed; 2]) -> Self {
        let width = (r[0] - l[0]).hypot(r[1] - l[1]);
        let along = [(r[0] - l[0]) / width, (r[1] - l[1]) / width];
        Self { tip, base: [left, right], width, at: [-dot(along, l), l[0] * along[1] - l[1] * along[0]] }
    }

    /// The distance of the tip, given those of the base: infinite for an end the front has not passed.
    pub(super) fn distance(&self, [a, b]: [f64; 2]) -> f64 {
        let along_edges = (a + self.at[0].hypot(self.at[1])).min(b + (self.width - self.at[0]).hypot(self.at[1]));
        self.across(a, b).map_or(along_edges, |d| d.min(along_edges))
    }

    /// The distance of the tip from the point below the base that is `a` and `b` away from its ends; `None` where there
    /// is no such point or the straight line from it misses the base.
    fn across(&self, a: f64, b: f64) -> Option<f64> {
        let [x, depth] = apex(a, b, self.width)?;
        let (reach, rise) = (self.at[0] - x, self.at[1] + depth);
        let crossing = x + reach * depth / rise;
        (0.0..=self.width).contains(&crossing).then(|| reach.hypot(rise))
    }
}

/// Every corner of every triangle, the obtuse ones split in two where the mesh lets them.
pub(super) fn all(mesh: &TriangleMesh) -> Vec<Corner> {
    let strip = Strip::new(mesh);
    let mut corners = Vec::with_capacity(3 * mesh.triangles().len());
    for &[a, b, c] in mesh.triangles() {
        for [tip, left, right] in [[a, b, c], [b, c, a], [c, a, b]] {
            let [l, r, width] = [[tip, left], [tip, right], [left, right]].map(|edge| strip.length(edge));
            let x = (l * l + r * r - width * width) / (2.0 * l);
            let (left, right) = ((left, [l, 0.0]), (right, [x, (r * r - x * x).max(0.0).sqrt()]));
            match strip.splitting(left, right) {
                Some(between) => corners.extend([[left, between], [between, right]].map(|b| Corner::new(tip, b))),
                None => corners.push(Corner::new(tip, [left, right])),
            }
        }
    }
    corners
}

/// A mesh whose triangles can be unfolded into a plane one after the other.
struct Strip<'a> {
    mesh: &'a TriangleMesh,
    /// The third vertex of the triangle on the right of a directed edge. Looked up by key only, so that the order of
    /// the map reaches no result.
    beyond: HashMap<[u32; 2], u32>,
}

impl<'a> Strip<'a> {
    fn new(mesh: &'a TriangleMesh) -> Self {
        let beyond = mesh.triangles().iter().flat_map(|&[a, b, c]| [([b, a], c), ([c, b], a), ([a, c], b)]).collect();
        Self { mesh, beyond }
    }

    fn length(&self, edge: [u32; 2]) -> f64 {
        let [a, b] = edge.map(|v| self.mesh.positions()[v as usize]);
        length(subtract(b, a))
    }

    /// The vertex that splits an obtuse corner at the origin into two acute ones, found by unfolding the triangles
    /// beyond its base; `None` where the corner is not obtuse, or the mesh or the patience ends first.
    fn splitting(&self, left: Placed, right: Placed) -> Option<Placed> {
        if dot(left.1, right.1) >= 0.0 {
            return None;
        }
        let [mut l, mut r] = [left, right];
        for _ in 0..UNFOLDINGS {
            let next = self.unfolded(l, r)?;
            match [dot(next.1, left.1) > 0.0, dot(next.1, right.1) > 0.0] {
                [true, true] => return Some(next),
                [false, _] => r = next,
                [true, false] => l = next,
            }
        }
        None
    }

    /// The vertex beyond an edge, placed on its right.
    fn unfolded(&self, (left, l): Placed, (right, r): Placed) -> Option<Placed> {
        let vertex = *self.beyond.get(&[left, right])?;
        let width = (r[0] - l[0]).hypot(r[1] - l[1]);
        let along = [(r[0] - l[0]) / width, (r[1] - l[1]) / width];
        let [x, depth] = apex(self.length([left, vertex]), self.length([right, vertex]), width)?;
        Some((vertex, [l[0] + x * along[0] + depth * along[1], l[1] + x * along[1] - depth * along[0]]))
    }
}

/// The point `a` and `b` away from the ends of a base: how far along the base and how far below it; `None` where the
/// three lengths make no triangle.
fn apex(a: f64, b: f64, width: f64) -> Option<[f64; 2]> {
    let x = (a * a - b * b + width * width) / (2.0 * width);
    let squared = a * a - x * x;
    (squared >= 0.0).then(|| [x, squared.sqrt()])
}

fn dot(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}
