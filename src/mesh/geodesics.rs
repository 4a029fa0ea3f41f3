//! Geodesic distances on a triangle mesh by fast marching.

mod corner;

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use super::TriangleMesh;
use corner::Corner;

/// The geodesic distance of every vertex from the nearest source, infinite where no source reaches: one march of
/// [`Marching`].
///
/// # Panics
/// Where a source is not a vertex of the mesh.
pub fn distances(mesh: &TriangleMesh, sources: &[u32]) -> Vec<f64> {
    Marching::new(mesh).distances(sources)
}

/// A mesh prepared for fast marching from any number of sources [KS98].
///
/// The front passes a triangle as the circle around a point source unfolded into the triangle's plane [NK02], which is
/// exact on flat ground. Obtuse corners are split by unfolding the triangles opposite to them, so that the front comes
/// to a corner after the two vertices it comes from.
pub struct Marching {
    corners: Vec<Corner>,
    /// For every vertex, the corners it carries the front to.
    carried: Vec<Vec<u32>>,
}

impl Marching {
    /// The mesh laid out corner by corner; O(n).
    pub fn new(mesh: &TriangleMesh) -> Self {
        let corners = corner::all(mesh);
        let mut carried = vec![Vec::new(); mesh.positions().len()];
        for (i, corner) in (0u32..).zip(&corners) {
            for vertex in corner.base {
                carried[vertex as usize].push(i);
            }
        }
        Self { corners, carried }
    }

    /// The geodesic distance of every vertex from the nearest source, infinite where no source reaches; O(n log n).
    ///
    /// # Panics
    /// Where a source is not a vertex of the mesh.
    pub fn distances(&self, sources: &[u32]) -> Vec<f64> {
        // What the front has passed is final; what it has not is a bound from above.
        let mut passed = vec![f64::INFINITY; self.carried.len()];
        let mut bounds = passed.clone();
        let mut front = BinaryHeap::new();
        for &vertex in sources {
            bounds[vertex as usize] = 0.0;
            front.push(Arrival { distance: 0.0, vertex });
        }
        while let Some(Arrival { distance, vertex }) = front.pop() {
            if passed[vertex as usize].is_finite() {
                continue;
            }
            passed[vertex as usize] = distance;
            for &corner in &self.carried[vertex as usize] {
                let corner = &self.corners[corner as usize];
                let distance = corner.distance(corner.base.map(|v| passed[v as usize]));
                if passed[corner.tip as usize].is_infinite() && distance < bounds[corner.tip as usize] {
                    bounds[corner.tip as usize] = distance;
                    front.push(Arrival { distance, vertex: corner.tip });
                }
            }
        }
        passed
    }
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
