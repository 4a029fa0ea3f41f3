//! Geodesic distances on a triangle mesh by fast marching.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use super::TriangleMesh;
use crate::geometry::{length, subtract};
use crate::numerics::{Cancelled, Pace, Watch};

/// Share by which a distance has to fall to be corrected.
const CORRECTION: f64 = 1e-9;
/// Corrections per vertex after which the front is stopped. Well-shaped meshes need none, meshes of needles about five.
const PATIENCE: usize = 64;

/// A mesh prepared for fast marching from any number of sources [KS98].
///
/// The front passes a triangle as the circle around a point source unfolded into the triangle's plane [NK02], which is
/// exact on flat ground. At an obtuse corner it may come to the tip before it comes to an end of the base; such a tip
/// is corrected when the end is known, and the correction handed on.
pub struct Marching {
    corners: Vec<Corner>,
    /// Vertex after vertex, the corners it carries the front to.
    carried: Vec<u32>,
    /// For every vertex where its corners begin in `carried`, and where the last one's end.
    begins: Vec<u32>,
}

impl Marching {
    /// The mesh laid out corner by corner; O(n).
    pub fn new(mesh: &TriangleMesh) -> Self {
        let corners: Vec<Corner> = mesh.triangles().iter().flat_map(|&triangle| Corner::of(mesh, triangle)).collect();
        let mut begins = vec![0; mesh.positions().len() + 1];
        for vertex in corners.iter().flat_map(|corner| corner.base) {
            begins[vertex as usize + 1] += 1;
        }
        for vertex in 0..mesh.positions().len() {
            begins[vertex + 1] += begins[vertex];
        }
        let (mut carried, mut ends) = (vec![0; 2 * corners.len()], begins.clone());
        for (i, corner) in (0..).zip(&corners) {
            for vertex in corner.base {
                let end = &mut ends[vertex as usize];
                carried[*end as usize] = i;
                *end += 1;
            }
        }
        Self { corners, carried, begins }
    }

    /// The corners `vertex` carries the front to.
    fn carried(&self, vertex: u32) -> &[u32] {
        let [begin, end] = [0, 1].map(|next| self.begins[vertex as usize + next] as usize);
        &self.carried[begin..end]
    }

    /// The geodesic distance of every vertex from the nearest source, infinite where no source reaches; O(n log n).
    ///
    /// # Errors
    /// [`Cancelled`] by the watcher, asked as the front passes.
    ///
    /// # Panics
    /// Where a source is not a vertex of the mesh.
    pub fn distances(&self, sources: &[u32], watch: &dyn Watch) -> Result<Vec<f64>, Cancelled> {
        self.distances_within(sources, f64::INFINITY, watch)
    }

    /// As [`Marching::distances`] up to `reach`, and beyond it anything that is larger than `reach`.
    ///
    /// # Errors
    /// As [`Marching::distances`].
    ///
    /// # Panics
    /// As [`Marching::distances`].
    pub fn distances_within(&self, sources: &[u32], reach: f64, watch: &dyn Watch) -> Result<Vec<f64>, Cancelled> {
        self.marched(sources, reach, watch, |_, _| ())
    }

    /// For every vertex the place in `sources` of the nearest one, where that is less than `reach` away; of sources that
    /// are one vertex the first. O(n log n), all cells in one march.
    ///
    /// A front that meets another across a triangle is taken for one, so that borders are true to a triangle.
    ///
    /// # Errors
    /// As [`Marching::distances`].
    ///
    /// # Panics
    /// As [`Marching::distances`].
    pub fn cells_within(
        &self,
        sources: &[u32],
        reach: f64,
        watch: &dyn Watch,
    ) -> Result<Vec<Option<usize>>, Cancelled> {
        let mut cells = vec![None; self.begins.len() - 1];
        for (place, &vertex) in sources.iter().enumerate().rev() {
            cells[vertex as usize] = Some(place);
        }
        let distances = self.marched(sources, reach, watch, |tip, from| cells[tip as usize] = cells[from as usize])?;
        Ok(cells.iter().zip(distances).map(|(&cell, distance)| cell.filter(|_| distance < reach)).collect())
    }

    /// The distances up to `reach`; whenever one falls, `hand_on` is told the vertex and that through which the shorter
    /// way along edges leads.
    fn marched(
        &self,
        sources: &[u32],
        reach: f64,
        watch: &dyn Watch,
        mut hand_on: impl FnMut(u32, u32),
    ) -> Result<Vec<f64>, Cancelled> {
        let mut distances = vec![f64::INFINITY; self.begins.len() - 1];
        let mut pace = Pace::new(watch, distances.len());
        let mut front = BinaryHeap::new();
        for &vertex in sources {
            distances[vertex as usize] = 0.0;
            front.push(Arrival { distance: 0.0, vertex });
        }
        let mut patience = PATIENCE * distances.len();
        while let Some(Arrival { distance, vertex }) =
            front.pop().filter(|arrival| patience > 0 && arrival.distance <= reach)
        {
            if distance > distances[vertex as usize] {
                continue;
            }
            patience -= 1;
            pace.step()?;
            for &corner in self.carried(vertex) {
                let corner = &self.corners[corner as usize];
                let ends = corner.base.map(|v| distances[v as usize]);
                let distance = corner.distance(ends);
                let known = &mut distances[corner.tip as usize];
                if distance < *known * (1.0 - CORRECTION) {
                    *known = distance;
                    let nearer = usize::from(ends[1] + corner.sides[1] < ends[0] + corner.sides[0]);
                    hand_on(corner.tip, corner.base[nearer]);
                    front.push(Arrival { distance, vertex: corner.tip });
                }
            }
        }
        Ok(distances)
    }
}

/// A vertex, the tip, and two others that carry the front to it, in a plane where `base[0]` is the origin and `base[1]`
/// lies on the x-axis, `width` away.
struct Corner {
    tip: u32,
    base: [u32; 2],
    width: f64,
    /// Lengths of the edges from the tip to the ends of the base.
    sides: [f64; 2],
    at: [f64; 2],
}

impl Corner {
    /// The three corners of a triangle.
    fn of(mesh: &TriangleMesh, triangle: [u32; 3]) -> [Self; 3] {
        let [p, q, r] = triangle.map(|v| mesh.positions()[v as usize]);
        let lengths = [[p, q], [q, r], [r, p]].map(|[a, b]| length(subtract(b, a)));
        [0, 1, 2].map(|turn| {
            let [tip, left, right] = [0, 1, 2].map(|corner| triangle[(turn + corner) % 3]);
            let [to_left, width, to_right] = [0, 1, 2].map(|side| lengths[(turn + side) % 3]);
            let sides = [to_left, to_right];
            Self { tip, base: [left, right], width, sides, at: apex(sides, width) }
        })
    }

    /// The distance of the tip, given those of the base: infinite for an end the front has not passed.
    fn distance(&self, ends: [f64; 2]) -> f64 {
        let along_edges = (ends[0] + self.sides[0]).min(ends[1] + self.sides[1]);
        if ends.iter().all(|d| d.is_finite()) { self.across(ends).min(along_edges) } else { along_edges }
    }

    /// The distance of the tip from the point below the base that is as far from its ends as they are from the source;
    /// infinite where there is no such point or the straight line from it misses the base.
    fn across(&self, ends: [f64; 2]) -> f64 {
        let [x, depth] = apex(ends, self.width);
        let (reach, rise) = (self.at[0] - x, self.at[1] + depth);
        let crossing = x + reach * depth / rise;
        // Without such a point the depth is not a number, and neither is the crossing.
        if (0.0..=self.width).contains(&crossing) { (reach * reach + rise * rise).sqrt() } else { f64::INFINITY }
    }
}

/// Where on the x-axis, and how far off it, a point is that is `a` and `b` away from the ends of a base on that axis;
/// NaN off it where the lengths make no triangle.
fn apex([a, b]: [f64; 2], width: f64) -> [f64; 2] {
    let x = (a * a - b * b + width * width) / (2.0 * width);
    [x, (a * a - x * x).sqrt()]
}

/// A vertex the front may come to. The nearest is the greatest, so that a heap hands it out first; between equals the
/// lower index is.
struct Arrival {
    distance: f64,
    vertex: u32,
}

impl Ord for Arrival {
    fn cmp(&self, other: &Self) -> Ordering {
        other.distance.total_cmp(&self.distance).then(other.vertex.cmp(&self.vertex))
    }
}

impl PartialOrd for Arrival {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Arrival {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Arrival {}

#[cfg(test)]
mod tests;
