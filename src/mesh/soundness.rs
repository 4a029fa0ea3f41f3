//! The conditions that make positions and triangles a [`super::TriangleMesh`], each as the list of what breaks it.

use super::disjoint_sets::DisjointSets;
use super::edges::{self, Edges};
use super::refusal::{Faults, Place};
use crate::geometry::{cross, length, subtract};

/// Largest magnitude of a coordinate. Areas, volumes and their products stay far from overflow.
pub(super) const LARGEST_COORDINATE: f64 = 1e50;
/// Smallest diagonal of the box around a mesh. Areas and their products stay far from underflow.
pub(super) const SMALLEST_DIAGONAL: f64 = 1e-50;
/// A triangle has no area where its height over its longest edge is at most this share of that edge.
const THINNEST: f64 = 1e-10;
/// A triangle has no area where its longest edge is at most this share of the mesh's diagonal.
const SHORTEST: f64 = 1e-12;

/// Vertices with a coordinate that is not finite or too large.
pub(super) fn coordinates(positions: &[[f64; 3]], faults: &mut Faults) {
    for (v, &position) in positions.iter().enumerate() {
        coordinates_of(position, Place::vertex(v), faults);
    }
}

/// What is wrong with the coordinates of a vertex at this place.
pub(super) fn coordinates_of(position: [f64; 3], place: Place, faults: &mut Faults) {
    if !is_sound(position) {
        let detail = if position.iter().all(|x| x.is_finite()) {
            format!("a coordinate is larger than {LARGEST_COORDINATE:e}: {position:?}")
        } else {
            format!("a coordinate is not a finite number: {position:?}")
        };
        faults.push(place, detail);
    }
}

/// Whether all coordinates are finite and of a magnitude that is allowed.
pub(super) fn is_sound(position: [f64; 3]) -> bool {
    // NaN compares false.
    position.iter().all(|x| x.abs() <= LARGEST_COORDINATE)
}

/// Most corners of a face.
pub(super) const MOST_CORNERS: usize = 1 << 16;

/// Whether a triangle's corners are three different vertices that exist; every reason against it otherwise.
pub(super) fn corners([a, b, c]: [u32; 3], vertices: usize, place: &Place, faults: &mut Faults) -> bool {
    let out_of_range = [a, b, c].into_iter().find(|&v| v as usize >= vertices);
    let repeated = if a == b || a == c { Some(a) } else { (b == c).then_some(b) };
    out_of_range.iter().for_each(|&v| faults.push(place.clone(), no_such_vertex(v.into(), vertices, 0)));
    repeated.iter().for_each(|v| faults.push(place.clone(), format!("vertex {v} is a corner of it twice")));
    out_of_range.is_none() && repeated.is_none()
}

/// That there is no vertex of this number from 0, told in a count from `first`. Where that is 1, a number below counts back.
pub(super) fn no_such_vertex(vertex: i64, vertices: usize, first: i64) -> String {
    if first > 0 && vertex < 0 {
        return format!("a corner counts back beyond the first vertex: there are {vertices}");
    }
    format!("vertex {} is out of range: there are {vertices}, from {first}", vertex.saturating_add(first))
}

/// That the triangles, whose vertices exist and are sound, have an area between them.
pub(super) fn areas(positions: &[[f64; 3]], triangles: &[[u32; 3]], faults: &mut Faults) {
    if !triangles.is_empty() && flat(positions, triangles).iter().all(|&flat| flat) {
        faults.push(Place::file(), NO_AREA);
    }
}

/// What is said of a mesh without area.
pub(super) const NO_AREA: &str = "no face has an area that could be matched";

/// m flags: whether a triangle of existing vertices with sound coordinates has no area beside its sides and the mesh.
pub(super) fn flat(positions: &[[f64; 3]], triangles: &[[u32; 3]]) -> Vec<bool> {
    let corners = |triangle: &[u32; 3]| triangle.map(|v| positions[v as usize]);
    let diagonal = diagonal(triangles.iter().flat_map(corners)).unwrap_or(0.0);
    triangles.iter().map(|t| diagonal < SMALLEST_DIAGONAL || is_degenerate(corners(t), diagonal)).collect()
}

/// Diagonal of the box around the points; none where there are no points.
fn diagonal(points: impl Iterator<Item = [f64; 3]>) -> Option<f64> {
    let mut bounds: Option<[[f64; 3]; 2]> = None;
    for p in points {
        let [low, high] = bounds.unwrap_or([p, p]);
        bounds = Some([0, 1].map(|end| {
            [0, 1, 2].map(|axis: usize| if end == 0 { low[axis].min(p[axis]) } else { high[axis].max(p[axis]) })
        }));
    }
    bounds.map(|[low, high]| length(subtract(high, low)))
}

fn is_degenerate([a, b, c]: [[f64; 3]; 3], diagonal: f64) -> bool {
    let longest = length(subtract(b, a)).max(length(subtract(c, b))).max(length(subtract(a, c)));
    longest <= SHORTEST * diagonal || length(cross(subtract(b, a), subtract(c, a))) <= THINNEST * longest * longest
}

/// Edges with more than two triangles.
pub(super) fn crowded_edges(edges: &Edges, faults: &mut Faults) {
    for edge in edges.iter() {
        let mut half_edges = edge.half_edges();
        let count = half_edges.len();
        if let (3.., Some(first)) = (count, half_edges.next()) {
            let [a, b] = edge.ends();
            let place = Place { face: Some(edges::triangle_of(first) as u64), ..Place::edge(a, b) };
            faults.push(place, format!("{count} triangles meet at this edge: an edge has one or two"));
        }
    }
}

/// Vertices whose triangles form more than one fan. Fans are joined across crowded edges too, so that one is not told
/// of both its edge and its vertices.
pub(super) fn fans(vertices: usize, triangles: &[[u32; 3]], edges: &Edges, faults: &mut Faults) {
    // A corner is named by the half-edge that starts at it.
    let mut corners = DisjointSets::new(3 * triangles.len());
    for edge in edges.iter() {
        let corner_at = |h, end: u32| if edges::ends(triangles, h)[0] == end { h } else { edges::next(h) };
        for end in edge.ends() {
            let mut at_end = edge.half_edges().map(|h| corner_at(h, end));
            if let Some(first) = at_end.next() {
                at_end.for_each(|other| corners.join(first, other));
            }
        }
    }
    let mut fans = vec![0u32; vertices];
    for (corner, &vertex) in triangles.iter().flatten().enumerate() {
        if corners.representative(corner as u32) == corner as u32 {
            fans[vertex as usize] += 1;
        }
    }
    for (v, fans) in fans.into_iter().enumerate().filter(|(_, fans)| *fans > 1) {
        faults.push(Place::vertex(v), format!("{fans} separate fans of triangles meet at this vertex: one is allowed"));
    }
}

/// Edges whose two triangles run along them in the same direction.
pub(super) fn winding(triangles: &[[u32; 3]], edges: &Edges, faults: &mut Faults) {
    for [g, h] in edges.pairs() {
        let [a, b] = edges::ends(triangles, g);
        if edges::ends(triangles, h) == [a, b] {
            let place = Place { face: Some(edges::triangle_of(g) as u64), ..Place::edge(a, b) };
            faults.push(place, "the two triangles at this edge are wound against each other");
        }
    }
}

/// For every triangle, the first triangle with the same vertices.
pub(super) fn firsts(triangles: &[[u32; 3]]) -> Vec<usize> {
    let mut order: Vec<([u32; 3], usize)> = triangles.iter().copied().enumerate().map(|(t, v)| (v, t)).collect();
    order.iter_mut().for_each(|(vertices, _)| vertices.sort_unstable());
    order.sort_unstable();
    let mut firsts = vec![0; triangles.len()];
    for same in order.chunk_by(|a, b| a.0 == b.0) {
        same.iter().for_each(|&(_, t)| firsts[t] = same[0].1);
    }
    firsts
}
