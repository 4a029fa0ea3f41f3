//! The true correspondence between a view of a creature and its mesh.

use std::collections::BTreeMap;

use super::body::Body;
use super::silhouette::Silhouette;
use super::view::{FRAME, Projection, View};
use crate::evaluation::truth::Truth;
use crate::geometry::{dot, doubled_area, subtract};
use crate::mesh::TriangleMesh;

/// Distance between the points along both axes, in drawing units.
const SPACING: f64 = 10.0;
/// Points along a side of the frame.
const COLUMNS: usize = (FRAME / SPACING) as usize;

/// What the true vertices of a point are called: where its viewing ray enters the mesh and where it leaves it, each also on
/// the other side of the body.
const VARIANTS: [&str; 4] = ["front", "front_mirrored", "back", "back_mirrored"];

/// The nearness at which a viewing ray enters and leaves the mesh, the larger first.
type Hits = (f64, f64);

/// The points of a square grid inside the silhouette, and for each the mesh vertex nearest to where its viewing ray
/// enters the mesh, where it leaves it, and to their counterparts on the other side of the body.
pub(super) fn truth(body: &Body, mesh: &TriangleMesh, silhouette: &Silhouette, view: View) -> Truth {
    let frame = Projection::around(mesh, view);
    let mut points = Vec::new();
    let mut vertices = Vec::new();
    for (cell, hits) in hits(mesh, &frame).into_iter().enumerate() {
        let point = [abscissa(cell % COLUMNS), abscissa(cell / COLUMNS)];
        let Some((first, last)) = hits.filter(|_| silhouette.contains(point)) else { continue };
        let (front, back) = (frame.lifted(point, first), frame.lifted(point, last));
        points.push(point);
        vertices.push([front, body.opposite(front), back, body.opposite(back)].map(|p| nearest_vertex(mesh, p)));
    }
    let variant = |(i, name): (usize, &&str)| (name.to_string(), vertices.iter().map(|v| i64::from(v[i])).collect());
    let variants: BTreeMap<String, Vec<i64>> = VARIANTS.iter().enumerate().map(variant).collect();
    Truth { side: view == View::Side, points, variants }
}

/// For every point of the grid, row by row, where its viewing ray enters and leaves the mesh.
fn hits(mesh: &TriangleMesh, frame: &Projection) -> Vec<Option<Hits>> {
    let mut hits: Vec<Option<Hits>> = vec![None; COLUMNS * COLUMNS];
    for triangle in mesh.triangles() {
        let corners = triangle.map(|v| frame.projected(mesh.positions()[v as usize]));
        let flat = corners.map(|(p, _)| p);
        let (columns, rows) = (covered(flat.map(|p| p[0])), covered(flat.map(|p| p[1])));
        for (row, column) in rows.flat_map(|row| columns.clone().map(move |column| (row, column))) {
            let Some(weights) = barycentric(flat, [abscissa(column), abscissa(row)]) else { continue };
            let nearness = dot(weights, corners.map(|(_, nearness)| nearness));
            let hit = &mut hits[row * COLUMNS + column];
            let (first, last) = hit.unwrap_or((nearness, nearness));
            *hit = Some((first.max(nearness), last.min(nearness)));
        }
    }
    hits
}

fn abscissa(index: usize) -> f64 {
    SPACING * (index as f64 + 0.5)
}

/// The indices of the grid points within the range of three coordinates.
fn covered(x: [f64; 3]) -> std::ops::Range<usize> {
    let [low, high] = [x.into_iter().fold(f64::INFINITY, f64::min), x.into_iter().fold(0.0, f64::max)];
    let index = |x: f64| (x / SPACING - 0.5).ceil().max(0.0) as usize;
    index(low)..(index(high) + 1).min(COLUMNS)
}

/// The barycentric coordinates of a point in a triangle; `None` outside or where the triangle is seen edge-on.
fn barycentric([a, b, c]: [[f64; 2]; 3], p: [f64; 2]) -> Option<[f64; 3]> {
    let whole = doubled_area([a, b, c]);
    let weights = [[p, b, c], [a, p, c], [a, b, p]].map(|t| doubled_area(t) / whole);
    (whole != 0.0 && weights.iter().all(|&w| w >= 0.0)).then_some(weights)
}

/// The first of the vertices nearest to a point.
fn nearest_vertex(mesh: &TriangleMesh, point: [f64; 3]) -> u32 {
    let squared = |p: &[f64; 3]| dot(subtract(*p, point), subtract(*p, point));
    let nearest = (0u32..).zip(mesh.positions()).min_by(|(_, a), (_, b)| squared(a).total_cmp(&squared(b)));
    nearest.map_or(0, |(vertex, _)| vertex)
}
