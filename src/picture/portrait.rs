//! The picture of a mesh alone.

use super::colour::Colour;
use super::drawing;
use super::figure::{Figure, Placement, Window};
use super::scene::Bounds;
use crate::geometry::cross;
use crate::geometry::frame::Frame;
use crate::geometry::unit;
use crate::mesh::TriangleMesh;
use crate::mesh::normals::vertex_normals;

/// The view of a mesh of which nothing is known: y up, from its front right and a little above.
const TOWARD_CAMERA: [f64; 3] = [0.5, 0.35, 0.8];
const UP: [f64; 3] = [0.0, 1.0, 0.0];

/// The grey of the mesh, in full light.
const PAPER: f64 = 0.9;

/// Room round the mesh, as a share of the picture's width.
const MARGIN: f64 = 0.05;

/// The height of the picture of a mesh that is `width` pixels wide, at most as high, and the mesh in it.
pub fn portrait(mesh: &TriangleMesh, width: u32) -> (u32, Figure) {
    seen(mesh, &vec![Colour::grey(PAPER); mesh.positions().len()], &looked_at(), width)
}

/// The same in colours of its vertices; a flat mesh, of z = 0, is seen from above and not in a slanting light.
pub fn painted(mesh: &TriangleMesh, colours: Vec<Colour>, width: u32) -> (u32, Figure) {
    if mesh.positions().iter().all(|p| p[2] == 0.0) {
        let upright = Frame { right: [1.0, 0.0, 0.0], up: UP, toward_camera: [0.0, 0.0, 1.0] };
        let (height, placement) = placed(mesh, &upright, width);
        return (height, drawing::flat(mesh, colours, &placement));
    }
    seen(mesh, &colours, &looked_at(), width)
}

fn looked_at() -> Frame {
    let toward_camera = unit(TOWARD_CAMERA);
    let right = unit(cross(UP, toward_camera));
    Frame { right, up: cross(toward_camera, right), toward_camera }
}

fn seen(mesh: &TriangleMesh, colours: &[Colour], frame: &Frame, width: u32) -> (u32, Figure) {
    let (height, placement) = placed(mesh, frame, width);
    (height, drawing::seen(mesh, &vertex_normals(mesh), colours, frame, &placement))
}

/// How high the picture is, and where the mesh goes in it.
fn placed(mesh: &TriangleMesh, frame: &Frame, width: u32) -> (u32, Placement) {
    let bounds = Bounds::of(mesh, |p| frame.project(p));
    let [across, upwards] = bounds.extent();
    let (margin, room) = (MARGIN * f64::from(width), (1.0 - 2.0 * MARGIN) * f64::from(width));
    let scale = room / across.max(upwards);
    let scale = if scale.is_finite() { scale } else { 1.0 };
    let height = ((scale * upwards + 2.0 * margin).ceil() as u32).clamp(1, width);
    let window = Window { left: 0, top: 0, width, height };
    (height, Placement { window, scale, middle: bounds.middle() })
}
