//! The Laplace–Beltrami operator of a triangle mesh: cotangent stiffness and lumped mass.

use sprs::CsMat;

use crate::geometry::{cross, dot, doubled_area_of_sides, length, subtract};
use crate::mesh::TriangleMesh;

/// How the area of a triangle is shared among its vertices.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Lumping {
    /// The Voronoi area of each vertex, and fixed shares in an obtuse triangle [MDSB03, fig. 4].
    Mixed,
    /// A third of the area to each.
    Barycentric,
}

/// The stiffness S, n × n, symmetric positive semidefinite with zero row sums, both triangles stored: S_ij =
/// −(cot α_ij + cot β_ij) / 2 for an edge ij, α and β the angles opposite it (eq. 2.8, S = D − W).
///
/// A vertex of no triangle has an empty row but for a zero on the diagonal.
pub fn stiffness(mesh: &TriangleMesh) -> CsMat<f64> {
    assembled(mesh.positions().len(), mesh.triangles(), |t| cotangents(mesh, mesh.triangles()[t]))
}

/// The diagonal of the mass A: n areas that sum to the mesh's, each positive where the vertex has a triangle with an area
/// (eq. 2.9 with the squared edge length).
pub fn mass(mesh: &TriangleMesh, lumping: Lumping) -> Vec<f64> {
    let shares = |t: usize| match lumping {
        Lumping::Mixed => {
            let triangle = mesh.triangles()[t];
            mixed_shares(triangle_area(mesh, triangle), squared_sides(mesh, triangle), cotangents(mesh, triangle))
        }
        Lumping::Barycentric => [triangle_area(mesh, mesh.triangles()[t]) / 3.0; 3],
    };
    summed(mesh.positions().len(), mesh.triangles(), shares)
}

/// Triangles told by the lengths of their sides. Two may share more than one edge, and the ends of an edge may be one
/// vertex.
pub(super) struct Triangles {
    pub corners: Vec<[u32; 3]>,
    /// The first from the first corner to the second.
    pub lengths: Vec<[f64; 3]>,
}

impl Triangles {
    /// The stiffness and the diagonal of the mass, as [`stiffness`] and [`mass`], on `n` vertices.
    pub fn operator(&self, n: usize, lumping: Lumping) -> (CsMat<f64>, Vec<f64>) {
        let shares = |t: usize| {
            let area = doubled_area_of_sides(self.lengths[t]) / 2.0;
            match lumping {
                Lumping::Mixed => mixed_shares(area, self.lengths[t].map(|l| l * l), self.cotangents(t)),
                Lumping::Barycentric => [area / 3.0; 3],
            }
        };
        (assembled(n, &self.corners, |t| self.cotangents(t)), summed(n, &self.corners, shares))
    }

    /// The cotangents of the angles at the corners.
    fn cotangents(&self, t: usize) -> [f64; 3] {
        // Side i begins at corner i: the angle at a corner is opposite the side that begins at the next one.
        let [c, a, b] = self.lengths[t];
        let area = doubled_area_of_sides([a, b, c]);
        [[a, b, c], [b, c, a], [c, a, b]].map(|[a, b, c]| (b * b + c * c - a * a) / (2.0 * area))
    }
}

/// The stiffness of triangles with these cotangents at their corners, by their numbers.
fn assembled(n: usize, triangles: &[[u32; 3]], cotangents: impl Fn(usize) -> [f64; 3]) -> CsMat<f64> {
    // Where the entries of each row begin: two in every triangle beside the diagonal.
    let mut ends = vec![0; n + 1];
    triangles.as_flattened().iter().for_each(|&v| ends[v as usize + 1] += 2);
    for v in 0..n {
        ends[v + 1] += ends[v];
    }
    let mut filled = ends.clone();
    let mut entries = vec![(0, 0.0); ends[n]];
    let mut diagonal = vec![0.0; n];
    for (t, triangle) in triangles.iter().enumerate() {
        let cotangents = cotangents(t);
        for corner in 0..3 {
            // The angle at `corner` is opposite the edge ij.
            let edge = [triangle[(corner + 1) % 3] as usize, triangle[(corner + 2) % 3] as usize];
            let weight = 0.5 * cotangents[corner];
            for [i, j] in [edge, [edge[1], edge[0]]] {
                entries[filled[i]] = (j, -weight);
                filled[i] += 1;
                diagonal[i] += weight;
            }
        }
    }
    let (mut indptr, mut indices, mut data) = (vec![0], Vec::new(), Vec::new());
    let mut row = Vec::new();
    for i in 0..n {
        row.clear();
        row.extend_from_slice(&entries[ends[i]..ends[i + 1]]);
        row.push((i, diagonal[i]));
        row.sort_by_key(|&(column, _)| column);
        for same in row.chunk_by(|a, b| a.0 == b.0) {
            indices.push(same[0].0);
            data.push(same.iter().map(|&(_, value)| value).sum());
        }
        indptr.push(indices.len());
    }
    CsMat::new((n, n), indptr, indices, data)
}

/// Per vertex the sum of the shares that the corners of triangles have, by their numbers.
fn summed(n: usize, triangles: &[[u32; 3]], shares: impl Fn(usize) -> [f64; 3]) -> Vec<f64> {
    let mut sums = vec![0.0; n];
    for (t, triangle) in triangles.iter().enumerate() {
        for (vertex, share) in triangle.iter().zip(shares(t)) {
            sums[*vertex as usize] += share;
        }
    }
    sums
}

fn triangle_area(mesh: &TriangleMesh, triangle: [u32; 3]) -> f64 {
    crate::geometry::triangle_area(corners(mesh, triangle))
}

fn corners(mesh: &TriangleMesh, triangle: [u32; 3]) -> [[f64; 3]; 3] {
    triangle.map(|v| mesh.positions()[v as usize])
}

/// The cotangents of the three angles: (u · v) / |u × v| of the edges that leave each corner.
fn cotangents(mesh: &TriangleMesh, triangle: [u32; 3]) -> [f64; 3] {
    let p = corners(mesh, triangle);
    std::array::from_fn(|c| {
        let (u, v) = (subtract(p[(c + 1) % 3], p[c]), subtract(p[(c + 2) % 3], p[c]));
        dot(u, v) / length(cross(u, v))
    })
}

/// The squared lengths of the sides, the first from the first corner to the second.
fn squared_sides(mesh: &TriangleMesh, triangle: [u32; 3]) -> [f64; 3] {
    let [a, b, c] = corners(mesh, triangle);
    [[a, b], [b, c], [c, a]].map(|[from, to]| {
        let side = subtract(to, from);
        dot(side, side)
    })
}

/// What the corners of a triangle have of its area; squared sides as [`squared_sides`] has them.
fn mixed_shares(area: f64, squared: [f64; 3], cotangents: [f64; 3]) -> [f64; 3] {
    if let Some(obtuse) = cotangents.iter().position(|&c| c < 0.0) {
        return std::array::from_fn(|c| if c == obtuse { area / 2.0 } else { area / 4.0 });
    }
    std::array::from_fn(|c| {
        let (next, last) = ((c + 1) % 3, (c + 2) % 3);
        (squared[c] * cotangents[last] + squared[last] * cotangents[next]) / 8.0
    })
}
