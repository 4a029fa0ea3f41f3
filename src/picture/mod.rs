//! What people look at: a match as coloured figures, the functional map as a heat map, the mesh in the sketch's colours.
//!
//! Every place of the sketch has a colour, and the mesh has it where that place is answered; what nobody's answer is near
//! is light grey, and what is matched without confidence grey. The same input gives the same bytes.

mod colour;
mod drawing;
mod figure;
#[cfg(test)]
mod fixtures;
mod gallery;
mod glb;
pub mod heat_map;
mod lettering;
pub mod paint;
mod palette;
pub mod plot;
mod png;
mod portrait;
mod raster;
pub mod reading;
mod scene;
mod surface;
mod svg;
mod view;

use std::ops::RangeInclusive;

use image::ImageError;

use crate::geometry::frame::Frame;
use crate::mesh::TriangleMesh;
use crate::mesh::file_mesh::FileMesh;
use crate::mesh::formats::Appearance;
use crate::mesh::refusal::Refusal;
use crate::sketch::Sketch;
use colour::Colour;
use paint::Paint;
use scene::Scene;

/// The widths of pictures in pixels, and that of the picture of a match where nobody asks for another. It is up to two
/// fifths as high, as its figures and a margin need.
pub const WIDTHS: RangeInclusive<u32> = 100..=4000;
pub const WIDTH: u32 = 1600;

/// A sketch, a mesh, and the point of the mesh for every vertex of the sketch. It can only be built fitting.
#[derive(Clone, Debug)]
pub struct Matched<'a> {
    sketch: &'a Sketch,
    mesh: &'a TriangleMesh,
    /// A vertex of the mesh and a confidence for every vertex of the sketch.
    vertices: Vec<u32>,
    confidence: Vec<f64>,
    view: Option<Frame>,
}

/// The points are not those of the two shapes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the points of the match are not those of its sketch and its mesh")]
pub struct Unfit;

impl<'a> Matched<'a> {
    /// The match of the sketch with the mesh: `points` are a vertex of the mesh and a confidence in `[0, 1]` for every
    /// vertex of the sketch, in its order. `view` is what the sketch was matched in, orthonormal; where there is none, the
    /// matched vertices tell one.
    ///
    /// # Errors
    /// [`Unfit`] where the sketch has another number of vertices or the mesh no such vertex.
    pub fn new(
        sketch: &'a Sketch,
        mesh: &'a TriangleMesh,
        points: impl IntoIterator<Item = (u32, f64)>,
        view: Option<Frame>,
    ) -> Result<Matched<'a>, Unfit> {
        let (vertices, confidence): (Vec<u32>, Vec<f64>) = points.into_iter().unzip();
        let fits = vertices.len() == sketch.mesh().positions().len()
            && vertices.iter().all(|&v| (v as usize) < mesh.positions().len());
        if fits { Ok(Matched { sketch, mesh, vertices, confidence, view }) } else { Err(Unfit) }
    }
}

/// The match as a PNG picture, `width` pixels wide and up to two fifths as high: the sketch, the mesh in the view the sketch
/// was matched in, and the mesh from 60° beside it, in the colours of the sketch's places.
///
/// # Errors
/// What the PNG encoder reports.
pub fn png(pair: &Matched<'_>, width: u32) -> Result<Vec<u8>, ImageError> {
    let Scene { height, figures } = scene::scene(pair, width);
    png::encoded(width, height, png::pixels(width, height, &figures))
}

/// The same picture as SVG. Triangles that are in sight are polygons, outlines are strokes; a figure with more than
/// 20,000 triangles in sight is an embedded PNG, so that the document stays within a few megabytes.
///
/// # Errors
/// What the PNG encoder reports.
pub fn svg(pair: &Matched<'_>, width: u32) -> Result<String, ImageError> {
    let Scene { height, figures } = scene::scene(pair, width);
    let mut content = String::new();
    for figure in &figures {
        content.push_str(&svg::figure(figure)?);
    }
    Ok(svg::document(width, height, "the sketch and the mesh in matching colours", &content))
}

/// A mesh alone as a PNG picture, `width` pixels wide and up to as high: grey, y up, from its front right and a little above.
///
/// # Errors
/// What the PNG encoder reports.
pub fn mesh_png(mesh: &TriangleMesh, width: u32) -> Result<Vec<u8>, ImageError> {
    let (height, figure) = portrait::portrait(mesh, width);
    png::encoded(width, height, png::pixels(width, height, &[figure]))
}

/// The same picture as SVG, as [`svg`].
///
/// # Errors
/// What the PNG encoder reports.
pub fn mesh_svg(mesh: &TriangleMesh, width: u32) -> Result<String, ImageError> {
    let (height, figure) = portrait::portrait(mesh, width);
    Ok(svg::document(width, height, "the mesh", &svg::figure(&figure)?))
}

/// The view a match is looked at from: that which the sketch was matched in, rolled so that the mesh stands in the picture as
/// the sketch does.
pub fn matched_view(pair: &Matched<'_>) -> Frame {
    view::matched(pair)
}

/// The match as [`png`] with both shapes deformed, in the colours and the views they have at rest: `drawing` are the places
/// of the sketch's vertices with y up, `places` those of the mesh's.
///
/// # Errors
/// [`PoseUnseen`].
pub fn posed_png(
    pair: &Matched<'_>,
    drawing: &[[f64; 2]],
    places: Vec<[f64; 3]>,
    width: u32,
) -> Result<Vec<u8>, PoseUnseen> {
    let drawing = drawing.iter().map(|&[x, y]| [x, y, 0.0]).collect();
    let drawing = TriangleMesh::new(drawing, pair.sketch.mesh().triangles().to_vec())?;
    let mesh = TriangleMesh::new(places, pair.mesh.triangles().to_vec())?;
    let Scene { height, figures } =
        scene::of_shapes(scene::colours(pair), &drawing, &mesh, &view::matched(pair), width);
    Ok(png::encoded(width, height, png::pixels(width, height, &figures))?)
}

/// Why a pose cannot be drawn.
#[derive(Debug, thiserror::Error)]
pub enum PoseUnseen {
    #[error("what became of the shape is none: {0}")]
    Shape(#[from] Refusal),
    #[error(transparent)]
    Encoder(#[from] ImageError),
}

/// The mesh of the file that is matched in the colours of the sketch, as glTF 2.0 binary, lit by whoever shows it. Vertices
/// and triangles are in the file's order and coordinates; a mesh that single precision would spoil is moved to the origin and scaled to extent 1.
///
/// # Errors
/// What the encoder reports.
pub fn glb(pair: &Matched<'_>, file: &FileMesh) -> Result<Vec<u8>, gltf::Error> {
    glb::file(file, &scene::colours(pair).1, &[])
}

/// The mesh of the file in these colours of its vertices, as [`glb`].
///
/// # Errors
/// What the encoder reports: the file would be larger than 4 GiB.
pub fn painted_glb(mesh: &FileMesh, paint: &Paint<'_>) -> Result<Vec<u8>, gltf::Error> {
    glb::file(mesh, &paint.on(mesh), &[])
}

/// The mesh as [`mesh_png`] in these colours; a flat one is seen from above.
///
/// # Errors
/// What the PNG encoder reports.
pub fn painted_png(mesh: &FileMesh, paint: &Paint<'_>, width: u32) -> Result<Vec<u8>, ImageError> {
    let (height, figure) = portrait::painted(mesh.sound(), paint.on(mesh), width);
    png::encoded(width, height, png::pixels(width, height, &[figure]))
}

/// Meshes as by [`painted_png`], each `width` pixels wide, in rows of `columns`.
///
/// # Errors
/// What the PNG encoder reports.
pub fn gallery_png(painted: &[(&FileMesh, Paint<'_>)], columns: usize, width: u32) -> Result<Vec<u8>, ImageError> {
    let portrait = |(mesh, paint): &(&FileMesh, Paint<'_>)| portrait::painted(mesh.sound(), paint.on(mesh), width);
    let (width, height, figures) = gallery::arranged(painted.iter().map(portrait).collect(), columns, width);
    png::encoded(width, height, png::pixels(width, height, &figures))
}

/// The mesh alone, in white, as [`glb`].
///
/// # Errors
/// What the encoder reports: the file would be larger than 4 GiB.
pub fn mesh_glb(mesh: &FileMesh) -> Result<Vec<u8>, gltf::Error> {
    posed_glb(mesh, &[])
}

/// The mesh as [`mesh_glb`] in poses: each the places of the file's vertices. One is the mesh itself in that pose; several
/// are morph targets of the mesh at rest, with an animation from one to the next.
///
/// # Errors
/// What the encoder reports: the file would be larger than 4 GiB.
pub fn posed_glb(mesh: &FileMesh, poses: &[Vec<[f64; 3]>]) -> Result<Vec<u8>, gltf::Error> {
    glb::file(mesh, &vec![Colour::WHITE; mesh.sound().positions().len()], poses)
}

/// The mesh as [`posed_glb`] in the appearance its own file gave it; nothing where the file's vertices are others.
///
/// # Errors
/// What the encoder reports: the file would be larger than 4 GiB.
pub fn posed_glb_in(
    mesh: &FileMesh,
    appearance: Appearance,
    poses: &[Vec<[f64; 3]>],
) -> Result<Option<Vec<u8>>, gltf::Error> {
    glb::in_appearance(mesh, appearance, poses)
}

#[cfg(test)]
mod tests;
