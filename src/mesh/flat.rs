//! What lies near a point of a flat mesh.

use super::TriangleMesh;

/// How far from the nearest vertex a point may be and still be on the mesh, as a share of the diagonal of its box.
pub const REACH: f64 = 0.05;

/// The vertex nearest to a point, and its distance; nothing where the mesh has no vertex.
pub fn nearest(mesh: &TriangleMesh, [x, y]: [f64; 2]) -> Option<(usize, f64)> {
    let distances = mesh.positions().iter().map(|p| (p[0] - x).hypot(p[1] - y));
    distances.enumerate().min_by(|(_, a), (_, b)| a.total_cmp(b))
}

/// How far from the nearest vertex a point of the mesh may be. Where triangles are large, a point inside one may be as far
/// from its corners as an edge is long.
pub fn reach(mesh: &TriangleMesh) -> f64 {
    let positions = mesh.positions();
    let sides = mesh.triangles().iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]);
    let lengths = sides.map(|[a, b]| {
        let (a, b) = (positions[a as usize], positions[b as usize]);
        (a[0] - b[0]).hypot(a[1] - b[1])
    });
    let extent = |axis: usize| {
        let (least, most) = positions
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(least, most), p| (least.min(p[axis]), most.max(p[axis])));
        most - least
    };
    lengths.fold(REACH * extent(0).hypot(extent(1)), f64::max)
}
