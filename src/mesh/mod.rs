//! A valid triangle mesh.

pub mod connectivity;
mod cut;
mod decimation;
pub(crate) mod disjoint_sets;
pub(crate) mod edges;
pub mod farthest_points;
pub mod figure;
pub mod file_mesh;
pub mod flat;
pub mod followers;
pub mod formats;
pub mod geodesics;
mod joining;
mod mending;
pub mod normals;
pub mod parts;
mod polygon;
pub mod refusal;
#[cfg(test)]
pub(crate) mod solids;
pub mod sound;
mod soundness;
pub mod validation;
mod warnings;
mod winding;

use edges::Edges;
use refusal::{Faults, Place, Refusal};

use crate::geometry::triangle_area;

/// Vertices or triangles that are hashed together.
const HASHED: usize = 2048;

/// A triangle mesh that can only be built valid.
///
/// Guaranteed: at least one triangle with an area; coordinates finite and at most 1e50; indices in range; every triangle
/// has three distinct vertices; no triangle occurs twice; every edge has one or two triangles, wound consistently; the
/// triangles around a vertex form one fan (edges and vertices are manifold). Allowed: boundary, several components,
/// vertices of no triangle, triangles as thin as may be.
///
/// Flat shapes (sketches) are meshes with z = 0.
#[derive(Clone, Debug, PartialEq)]
pub struct TriangleMesh {
    positions: Vec<[f64; 3]>,
    triangles: Vec<[u32; 3]>,
}

impl TriangleMesh {
    /// The mesh of these vertices and triangles, n × 3 coordinates and m × 3 indices, in O(m log m). Refused with every
    /// reason where something the type guarantees does not hold; places are vertices and triangles.
    pub fn new(positions: Vec<[f64; 3]>, triangles: Vec<[u32; 3]>) -> Result<TriangleMesh, Refusal> {
        let mut faults = Faults::default();
        if triangles.is_empty() {
            faults.push(Place::file(), "there are no triangles");
        }
        soundness::coordinates(&positions, &mut faults);
        for (t, triangle) in triangles.iter().enumerate() {
            soundness::corners(*triangle, positions.len(), &Place::face(t), &mut faults);
        }
        faults.into_result()?;

        let mut faults = Faults::default();
        soundness::areas(&positions, &triangles, &mut faults);
        for (t, first) in soundness::firsts(&triangles).into_iter().enumerate().filter(|(t, first)| t != first) {
            faults.push(Place::face(t), format!("it has the same vertices as triangle {first}"));
        }
        let edges = Edges::of(&triangles);
        soundness::crowded_edges(&edges, &mut faults);
        soundness::winding(&triangles, &edges, &mut faults);
        soundness::fans(positions.len(), &triangles, &edges, &mut faults);
        faults.into_result()?;
        Ok(TriangleMesh { positions, triangles })
    }

    /// The mesh moved, turned and scaled, so that its vertices are at these positions: what is guaranteed of it stays.
    pub(crate) fn similar(&self, positions: Vec<[f64; 3]>) -> TriangleMesh {
        TriangleMesh { positions, triangles: self.triangles.clone() }
    }

    /// n × 3, in units of the file.
    pub fn positions(&self) -> &[[f64; 3]] {
        &self.positions
    }

    /// m × 3, every row the vertices of a triangle in its winding.
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    /// Sum of the triangles' areas, in squared units of the file.
    pub fn area(&self) -> f64 {
        self.triangles.iter().map(|&t| triangle_area(t.map(|v| self.positions[v as usize]))).sum()
    }

    /// The [`content_hash`] of its vertices and triangles.
    pub fn content_hash(&self) -> blake3::Hash {
        content_hash(&self.positions, &self.triangles)
    }
}

/// Hash of the canonical bytes of vertices and triangles, all little-endian: their numbers as u64, the coordinates as f64,
/// the triangles as u32.
pub fn content_hash(positions: &[[f64; 3]], triangles: &[[u32; 3]]) -> blake3::Hash {
    let mut hasher = blake3::Hasher::new();
    hasher.update(&(positions.len() as u64).to_le_bytes());
    hasher.update(&(triangles.len() as u64).to_le_bytes());
    // Many at a time: of long pieces several parts are hashed side by side, short ones are hashed one after another.
    let mut bytes = Vec::with_capacity(HASHED * size_of::<[f64; 3]>());
    for positions in positions.chunks(HASHED) {
        bytes.clear();
        bytes.extend(positions.as_flattened().iter().flat_map(|x| x.to_le_bytes()));
        hasher.update(&bytes);
    }
    for triangles in triangles.chunks(HASHED) {
        bytes.clear();
        bytes.extend(triangles.as_flattened().iter().flat_map(|v| v.to_le_bytes()));
        hasher.update(&bytes);
    }
    hasher.finalize()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tetrahedron() -> (Vec<[f64; 3]>, Vec<[u32; 3]>) {
        let positions = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        (positions, vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
    }

    fn refusal(change: impl Fn(&mut Vec<[f64; 3]>, &mut Vec<[u32; 3]>)) -> String {
        let (mut positions, mut triangles) = tetrahedron();
        change(&mut positions, &mut triangles);
        TriangleMesh::new(positions, triangles).unwrap_err().to_string()
    }

    #[test]
    fn accepts_closed_open_and_unreferenced() {
        let (mut positions, mut triangles) = tetrahedron();
        triangles.pop();
        positions.push([1e40, 0.0, 0.0]);
        let mesh = TriangleMesh::new(positions, triangles).unwrap();
        assert!((mesh.area() - 1.5).abs() < 1e-15);
    }

    #[test]
    fn refuses_every_breach_by_name() {
        assert!(refusal(|_, triangles| triangles.clear()).contains("no triangles"));
        assert!(refusal(|positions, _| positions[3][1] = f64::NAN).contains("vertex 3: a coordinate is not a finite"));
        assert!(refusal(|positions, _| positions[3][1] = 1e300).contains("vertex 3: a coordinate is larger"));
        assert!(refusal(|_, triangles| triangles[1] = [0, 1, 4]).contains("face 1: vertex 4 is out of range"));
        assert!(refusal(|_, triangles| triangles[1] = [0, 1, 1]).contains("face 1: vertex 1 is a corner of it twice"));
        assert!(refusal(|positions, _| positions.iter_mut().for_each(|p| *p = [p[0], 0.0, 0.0])).contains("an area"));
        assert!(refusal(|_, triangles| triangles.push([2, 0, 3])).contains("face 4: it has the same vertices"));
        assert!(refusal(|_, triangles| triangles[3] = [1, 3, 2]).contains("edge 1–3: the two triangles"));
        let third = |positions: &mut Vec<_>, triangles: &mut Vec<_>| {
            positions.push([1.0, 1.0, 1.0]);
            triangles.push([0, 1, 4]);
        };
        assert!(refusal(third).contains("edge 0–1: 3 triangles meet"));
        let tip = |positions: &mut Vec<_>, triangles: &mut Vec<_>| {
            positions.extend([[0.0, 0.0, 2.0], [0.0, 1.0, 2.0]]);
            triangles.push([3, 4, 5]);
        };
        assert!(refusal(tip).contains("vertex 3: 2 separate fans"));
    }

    #[test]
    fn tells_all_breaches_at_once() {
        let (mut positions, triangles) = tetrahedron();
        positions[0][0] = f64::INFINITY;
        positions[2][2] = f64::NAN;
        let Err(Refusal::Invalid(faults)) = TriangleMesh::new(positions, triangles) else { panic!("accepted") };
        assert_eq!(faults.listed.iter().map(|f| f.place.clone()).collect::<Vec<_>>(), [0, 2].map(Place::vertex));
    }

    #[test]
    fn measures_across_the_whole_range_of_sizes() {
        for scale in [1e-49, 1e-20, 1.0, 1e20, 1e49] {
            let (positions, triangles) = tetrahedron();
            let mesh = TriangleMesh::new(positions.iter().map(|p| p.map(|x| x * scale)).collect(), triangles).unwrap();
            let expected = (1.5 + 0.75f64.sqrt()) * scale * scale;
            assert!((mesh.area() / expected - 1.0).abs() < 1e-12);
        }
        assert!(refusal(|positions, _| positions.iter_mut().flatten().for_each(|x| *x *= 1e-200)).contains("an area"));
    }

    #[test]
    fn hashes_the_canonical_bytes() {
        let (positions, triangles) = tetrahedron();
        let mut bytes: Vec<u8> = [4u64, 4].iter().flat_map(|n| n.to_le_bytes()).collect();
        bytes.extend(positions.iter().flatten().flat_map(|x| x.to_le_bytes()));
        bytes.extend(triangles.iter().flatten().flat_map(|v| v.to_le_bytes()));
        let mesh = TriangleMesh::new(positions, triangles).unwrap();
        assert_eq!(mesh.content_hash(), blake3::hash(&bytes));
    }
}
