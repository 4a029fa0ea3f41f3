//! Shapes drawn as figures: a flat mesh, and a mesh as it is seen.

use super::colour::Colour;
use super::figure::{Figure, Placement};
use super::raster::Raster;
use crate::geometry::dot;
use crate::geometry::frame::Frame;
use crate::mesh::TriangleMesh;
use crate::mesh::edges::{Edges, triangle_of};

/// The light, as right, up and towards the camera, of about length 1.
const LIGHT: [f64; 3] = [-0.36, 0.48, 0.8];
/// The light that comes from everywhere; the rest, up to 1, comes from the lamp.
const AMBIENT: f64 = 0.5;

/// How far before the surface a line on it lies, in pixels, so that the surface does not hide it.
const BEFORE: f64 = 3.0;

/// A flat mesh in colours of its vertices, with its boundary.
pub fn flat(mesh: &TriangleMesh, colours: Vec<Colour>, placement: &Placement) -> Figure {
    let pixel = |&[x, y, _]: &[f64; 3]| {
        let [x, y] = placement.pixel([x, y]);
        [x, y, 0.0]
    };
    let points: Vec<[f64; 3]> = mesh.positions().iter().map(pixel).collect();
    let boundary = Edges::of(mesh.triangles());
    let boundary = boundary.iter().filter(|edge| edge.half_edges().len() == 1);
    let lines = boundary.map(|edge| edge.ends().map(|v| in_plane(points[v as usize]))).collect();
    Figure { window: placement.window, points, triangles: mesh.triangles().to_vec(), colours, lines }
}

/// A mesh seen through a frame in colours of its vertices, lit from the viewer's upper left on whichever side is
/// seen, with the outlines that are in sight.
pub fn seen(
    mesh: &TriangleMesh,
    normals: &[[f64; 3]],
    colours: &[Colour],
    frame: &Frame,
    placement: &Placement,
) -> Figure {
    let pixel = |&p: &[f64; 3]| {
        let [x, y] = placement.pixel(frame.project(p));
        [x, y, frame.depth(p) * placement.scale]
    };
    let mut points: Vec<[f64; 3]> = mesh.positions().iter().map(pixel).collect();
    // Counted from the nearest point, depths are of the size of pixels, whatever the coordinates of the mesh.
    let used = mesh.triangles().as_flattened().iter().map(|&v| points[v as usize][2]);
    let nearest = used.fold(f64::NEG_INFINITY, f64::max);
    points.iter_mut().for_each(|p| p[2] -= nearest);
    let lit = |(colour, normal): (&Colour, &[f64; 3])| colour.lit(light(frame, *normal));
    let mut figure = Figure {
        window: placement.window,
        points,
        triangles: mesh.triangles().to_vec(),
        colours: colours.iter().zip(normals).map(lit).collect(),
        lines: Vec::new(),
    };
    let raster = Raster::of(&figure);
    figure.lines = outlines(&figure).filter(|line| in_sight(&raster, line)).map(|line| line.map(in_plane)).collect();
    figure
}

/// The light on a surface of this normal, turned to the viewer.
fn light(frame: &Frame, normal: [f64; 3]) -> f64 {
    let seen = [dot(frame.right, normal), dot(frame.up, normal), dot(frame.toward_camera, normal)];
    let side = if seen[2] < 0.0 { -1.0 } else { 1.0 };
    AMBIENT + (1.0 - AMBIENT) * (side * dot(seen, LIGHT)).clamp(0.0, 1.0)
}

/// The edges at which the surface ends or turns away from the viewer.
fn outlines(figure: &Figure) -> impl Iterator<Item = [[f64; 3]; 2]> {
    let edges = Edges::of(&figure.triangles);
    let turns: Vec<[u32; 2]> = edges
        .iter()
        .filter(|edge| {
            let mut sides = edge.half_edges().map(|h| figure.doubled_area(triangle_of(h)) > 0.0);
            let first = sides.next();
            sides.len() == 0 || sides.any(|side| Some(side) != first)
        })
        .map(|edge| edge.ends())
        .collect();
    turns.into_iter().map(|ends| ends.map(|v| figure.points[v as usize]))
}

/// Whether the middle of a line is before the surface or beside it.
fn in_sight(raster: &Raster, [a, b]: &[[f64; 3]; 2]) -> bool {
    let [x, y, z] = [0, 1, 2].map(|i| 0.5 * (a[i] + b[i]));
    raster.farthest_around([x, y]) <= z + BEFORE
}

fn in_plane([x, y, _]: [f64; 3]) -> [f64; 2] {
    [x, y]
}
