//! The picture of a match: three figures side by side.

use super::colour::Colour;
use super::drawing;
use super::figure::{Figure, Placement, Window};
use super::{Matched, palette, surface, view};
use crate::geometry::frame::Frame;
use crate::mesh::TriangleMesh;
use crate::mesh::normals::vertex_normals;
use crate::raster::silhouette::silhouette;

/// Room round the figures and between them at least, and the height of the picture at most, as shares of its width.
const MARGIN: f64 = 0.025;
const TALLEST: f64 = 0.4;

/// A bounding box in the plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    low: [f64; 2],
    high: [f64; 2],
}

impl Bounds {
    /// Of the mesh's vertices that have a triangle, projected.
    pub fn of(mesh: &TriangleMesh, project: impl Fn([f64; 3]) -> [f64; 2]) -> Bounds {
        let start = Bounds { low: [f64::INFINITY; 2], high: [f64::NEG_INFINITY; 2] };
        let used = mesh.triangles().as_flattened().iter();
        used.map(|&v| project(mesh.positions()[v as usize])).fold(start, |Bounds { low, high }, p| Bounds {
            low: [low[0].min(p[0]), low[1].min(p[1])],
            high: [high[0].max(p[0]), high[1].max(p[1])],
        })
    }

    pub fn extent(&self) -> [f64; 2] {
        [self.high[0] - self.low[0], self.high[1] - self.low[1]]
    }

    pub fn middle(&self) -> [f64; 2] {
        [0, 1].map(|axis| 0.5 * (self.low[axis] + self.high[axis]))
    }
}

/// A colour for every vertex of the sketch, as far as its point is believed, and for every vertex of the mesh.
pub fn colours(pair: &Matched<'_>) -> (Vec<Colour>, Vec<Colour>) {
    let places = palette::colours(pair.sketch.mesh());
    let believed = places.into_iter().zip(&pair.confidence);
    let sketch: Vec<Colour> = believed.map(|(colour, &confidence)| palette::believed(colour, confidence)).collect();
    let answers = pair.vertices.iter().copied().zip(sketch.iter().copied());
    let mesh = surface::colours(pair.mesh, answers);
    (sketch, mesh)
}

/// Three figures side by side.
pub struct Scene {
    /// Of the picture, in pixels.
    pub height: u32,
    pub figures: [Figure; 3],
}

/// From left to right the sketch, the mesh in the view it was matched in, and the mesh from 60° beside it. The two views
/// of the mesh have one scale, and the sketch covers as much of the picture as the first of them.
pub fn scene(pair: &Matched<'_>, width: u32) -> Scene {
    of_shapes(colours(pair), pair.sketch.mesh(), pair.mesh, &view::matched(pair), width)
}

/// The same of any flat mesh and any mesh, in the colours of their vertices and from the view the sketch was matched in.
pub fn of_shapes(
    (sketch_colours, mesh_colours): (Vec<Colour>, Vec<Colour>),
    sketch: &TriangleMesh,
    mesh: &TriangleMesh,
    matched: &Frame,
    width: u32,
) -> Scene {
    let turned = view::turned(matched);
    let boxes = [
        Bounds::of(sketch, |[x, y, _]| [x, y]),
        Bounds::of(mesh, |p| matched.project(p)),
        Bounds::of(mesh, |p| turned.project(p)),
    ];
    let upright = Frame { right: [1.0, 0.0, 0.0], up: [0.0, 1.0, 0.0], toward_camera: [0.0, 0.0, 1.0] };
    let enlarged = covered(mesh, matched) / covered(sketch, &upright);
    let (height, [drawn, seen, beside]) = placed(width, boxes, [enlarged, 1.0, 1.0]);
    let normals = vertex_normals(mesh);
    let figures = [
        drawing::flat(sketch, sketch_colours, &drawn),
        drawing::seen(mesh, &normals, &mesh_colours, matched, &seen),
        drawing::seen(mesh, &normals, &mesh_colours, &turned, &beside),
    ];
    Scene { height, figures }
}

/// The square root of the area that a mesh covers when it is seen through a frame, in units of the mesh; positive.
fn covered(mesh: &TriangleMesh, frame: &Frame) -> f64 {
    let flat: Vec<[f64; 2]> = mesh.positions().iter().map(|&p| frame.project(p)).collect();
    let mask = silhouette(&flat, mesh.triangles());
    (mask.area() as f64).sqrt() / mask.scale
}

/// Where boxes go in the picture, each enlarged by its factor and all by one more, and how high the picture is: as large
/// as they fit, with the same room before, between and behind them. The windows share the picture.
fn placed(picture_width: u32, boxes: [Bounds; 3], enlarged: [f64; 3]) -> (u32, [Placement; 3]) {
    let width = f64::from(picture_width);
    let (margin, highest) = (MARGIN * width, TALLEST * width);
    let extents: [[f64; 2]; 3] = std::array::from_fn(|i| boxes[i].extent().map(|x| x * enlarged[i]));
    let widths: f64 = extents.iter().map(|extent| extent[0]).sum();
    let tallest = extents.iter().map(|extent| extent[1]).fold(0.0, f64::max);
    let scale = ((width - 4.0 * margin) / widths).min((highest - 2.0 * margin) / tallest);
    let scale = if scale.is_finite() { scale } else { 1.0 };
    let height = ((scale * tallest + 2.0 * margin).ceil() as u32).min(highest as u32);
    let room = (width - scale * widths) / 4.0;
    // The windows meet in the middle of the room between two figures.
    let ends = [0, 1, 2].map(|i| {
        let figures: f64 = extents[..=i].iter().map(|extent| scale * extent[0]).sum();
        (figures + room * (i as f64 + 1.5)).round().clamp(0.0, width) as u32
    });
    let edges = [0, ends[0], ends[1], picture_width];
    let placements = [0, 1, 2].map(|i| {
        let window = Window { left: edges[i], top: 0, width: edges[i + 1].saturating_sub(edges[i]), height };
        // The outer windows have a whole room at one side and half of one at the other.
        let aside = [-0.25, 0.0, 0.25][i] * room;
        let scale = scale * enlarged[i];
        let [x, y] = boxes[i].middle();
        Placement { window, scale, middle: [x + aside / scale, y] }
    });
    (height, placements)
}

#[cfg(test)]
mod tests {
    use super::super::WIDTH;
    use super::super::fixtures::{cube, square_on};
    use super::*;

    /// In pixels of a picture of the usual width.
    const ROOM: f64 = MARGIN * WIDTH as f64;

    #[test]
    fn figures_lie_evenly_in_the_picture() {
        let (mesh, sketch) = (cube(), square_on(&cube()));
        let Scene { height, figures } = scene(&sketch.pair(&mesh), WIDTH);
        let mut columns = Vec::new();
        for figure in &figures {
            let left = f64::from(figure.window.left);
            let x = figure.points.iter().map(|p| left + p[0]);
            columns.extend([x.clone().fold(f64::INFINITY, f64::min), x.fold(0.0, f64::max)]);
            let y = figure.points.iter().map(|p| p[1]);
            let (top, bottom) = (y.clone().fold(f64::INFINITY, f64::min), y.fold(0.0, f64::max));
            assert!((top + bottom - f64::from(height)).abs() < 1e-6 && top > ROOM - 1e-6);
            assert!(height <= 640);
        }
        let rooms = [columns[0], columns[2] - columns[1], columns[4] - columns[3], f64::from(WIDTH) - columns[5]];
        assert!(rooms.iter().all(|room| (room - rooms[0]).abs() < 1.5 && *room > ROOM - 1.5), "{rooms:?}");
        assert!((columns[1] - columns[0] - (columns[3] - columns[2])).abs() < 4.0, "{columns:?}");
    }

    #[test]
    fn a_point_without_extent_is_placed() {
        let dot = Bounds { low: [3.0; 2], high: [3.0; 2] };
        let (height, placements) = placed(WIDTH, [dot; 3], [1.0; 3]);
        assert_eq!(height, 2 * ROOM as u32);
        assert_eq!(placements.map(|p| p.window.width).iter().sum::<u32>(), WIDTH);
        assert!(placements.iter().all(|p| p.scale == 1.0));
    }
}
