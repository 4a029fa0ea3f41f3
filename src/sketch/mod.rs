//! A drawing and the flat mesh made of it.
//!
//! Three ways in, [`from_outline`], [`from_svg`] and [`from_picture`], end in one: a clean [`outline`] with holes that
//! is triangulated to a wanted number of vertices. SVG and pictures are read as they are seen. Inside, y points up; answers are given in the coordinates of the
//! upload, which for SVG and pictures have y down.

mod arrangement;
mod exchange;
mod eyes;
pub mod foreign;
pub mod gzip;
pub mod outline;
mod picture;
mod reading;
mod refusal;
mod ring;
mod simplification;
mod svg;
mod triangulation;
mod untangling;

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use crate::geometry::doubled_area;
use crate::mesh::TriangleMesh;
use crate::mesh::connectivity::largest_component;
use outline::{Drawing, Figure};
use reading::Reading;
pub use reading::canvas::Canvas;
use reading::checkerboard::without_checkerboard;
pub use refusal::{Fault, Refusal, Warning, WarningCode};

/// Vertices of a sketch where the request names no number.
pub const DEFAULT_TARGET_VERTICES: usize = 800;

/// The numbers of vertices that can be asked for.
pub const TARGET_VERTICES: std::ops::RangeInclusive<usize> = 50..=20_000;

/// Longest contour of what is seen that is looked at, in points before simplification per point allowed after it.
const RAW_POINTS_PER_POINT: usize = 20;

/// What an upload may cost.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Config {
    /// Points of an outline and its holes together, also of one found in a picture or an SVG: 20,000 by default. No
    /// sketch has more vertices, and a comb of so many points takes two seconds, one of 40,000 more than five.
    pub max_points: usize,
    /// Bytes of a drawing that is text: an SVG or an outline in JSON.
    pub max_document_bytes: usize,
    /// Pixels of a picture along one side.
    pub max_picture_side: u32,
    /// Pixels of a picture.
    pub max_picture_pixels: u64,
}

impl Default for Config {
    fn default() -> Self {
        Self { max_points: 20_000, max_document_bytes: 16 << 20, max_picture_side: 8192, max_picture_pixels: 64 << 20 }
    }
}

/// Which way y points in the coordinates a sketch was uploaded in.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum YAxis {
    /// JSON outlines, and the user units of an SVG whose root is shown upside down, as CAD programs write it.
    Up,
    /// Other SVG user units, and pixels.
    Down,
}

impl YAxis {
    /// A point seen with y up from one with y as in the upload, or the reverse: it is its own inverse.
    fn flipped(self, [x, y]: [f64; 2]) -> [f64; 2] {
        match self {
            Self::Up => [x, y],
            Self::Down => [x, -y],
        }
    }
}

/// A line as its points, from end to end.
pub type Line = Vec<[f64; 2]>;

/// A triangulated figure in the plane: z = 0, y up, triangles counter-clockwise, one component.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(into = "exchange::Parts", try_from = "exchange::Parts")]
pub struct Sketch {
    mesh: TriangleMesh,
    y_axis: YAxis,
    /// Lines within the figure, y up.
    strokes: Vec<Line>,
}

/// A sketch made of an upload, and what was mended or left out on the way.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Imported {
    pub sketch: Sketch,
    pub warnings: Vec<Warning>,
    /// All figures of the drawing, largest first.
    pub figures: Vec<SeenFigure>,
}

/// A figure of a drawing: where it is, and how large, in the coordinates of the upload.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct SeenFigure {
    /// Lowest and highest corner of the box it lies in.
    #[serde(rename = "box")]
    #[schema(value_type = Vec<Vec<f64>>, min_items = 2, max_items = 2)]
    pub bounds: [[f64; 2]; 2],
    pub area: f64,
}

/// What is to be made of a drawing.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Choice {
    /// Vertices of the sketch, about.
    pub vertices: usize,
    /// Which of its figures, the largest being number 0.
    pub figure: usize,
}

impl Sketch {
    /// The sketch that a stored mesh is.
    ///
    /// # Errors
    /// A vertex off the plane or of no triangle, a clockwise triangle, several components, no triangle.
    pub fn new(mesh: TriangleMesh, y_axis: YAxis) -> Result<Self, Refusal> {
        if mesh.triangles().is_empty() {
            return Err(Refusal::plain("the sketch has no triangles"));
        }
        if let Some(vertex) = mesh.positions().iter().position(|p| p[2] != 0.0) {
            return Err(Refusal::plain(format!("vertex {vertex} does not lie in the plane z = 0")));
        }
        let flat = |v: u32| {
            let [x, y, _] = mesh.positions()[v as usize];
            [x, y]
        };
        if let Some(triangle) = mesh.triangles().iter().position(|t| doubled_area(t.map(flat)) <= 0.0) {
            return Err(Refusal::plain(format!("triangle {triangle} is not counter-clockwise")));
        }
        if largest_component(&mesh).vertices.len() < mesh.positions().len() {
            return Err(Refusal::plain("the sketch is not one connected figure"));
        }
        Ok(Self { mesh, y_axis, strokes: Vec::new() })
    }

    /// The sketch with lines within the figure, y up.
    pub fn with_strokes(self, strokes: Vec<Line>) -> Self {
        Self { strokes, ..self }
    }

    /// The mesh: z = 0, y up.
    pub fn mesh(&self) -> &TriangleMesh {
        &self.mesh
    }

    pub fn y_axis(&self) -> YAxis {
        self.y_axis
    }

    /// The lines drawn within the figure, y up: an eye, an ear, a leg before a leg; those of spots have one point.
    pub fn strokes(&self) -> &[Line] {
        &self.strokes
    }

    /// Those lines in the coordinates of the upload.
    pub fn drawn_strokes(&self) -> Vec<Line> {
        self.strokes.iter().map(|line| line.iter().map(|&point| self.y_axis.flipped(point)).collect()).collect()
    }

    /// The vertices nearest to drawn eyes: one or two dots within the figure, away from all other lines.
    pub fn eyes(&self) -> Vec<u32> {
        eyes::eyes(self)
    }

    /// A vertex in the coordinates of the upload.
    ///
    /// # Panics
    /// When the sketch has no such vertex.
    pub fn point(&self, vertex: usize) -> [f64; 2] {
        let [x, y, _] = self.mesh.positions()[vertex];
        self.y_axis.flipped([x, y])
    }

    /// All vertices in the coordinates of the upload.
    pub fn points(&self) -> Vec<[f64; 2]> {
        (0..self.mesh.positions().len()).map(|v| self.point(v)).collect()
    }

    /// A point of the upload in the coordinates of the mesh.
    pub fn to_internal(&self, point: [f64; 2]) -> [f64; 2] {
        self.y_axis.flipped(point)
    }

    /// A point of the plane of the mesh in the coordinates of the upload.
    pub fn to_upload(&self, point: [f64; 2]) -> [f64; 2] {
        self.y_axis.flipped(point)
    }

    /// The same for sketches of the same vertices, triangles, direction of y and lines within.
    pub fn content_hash(&self) -> blake3::Hash {
        let mut hasher = blake3::Hasher::new();
        hasher.update(b"sketch 1").update(&[self.y_axis as u8]);
        hasher.update(&(self.mesh.positions().len() as u64).to_le_bytes());
        self.mesh.positions().iter().flatten().for_each(|x| {
            hasher.update(&x.to_le_bytes());
        });
        self.mesh.triangles().iter().flatten().for_each(|v| {
            hasher.update(&v.to_le_bytes());
        });
        for line in &self.strokes {
            hasher.update(&(line.len() as u64).to_le_bytes());
            line.iter().flatten().for_each(|x| {
                hasher.update(&x.to_le_bytes());
            });
        }
        hasher.finalize()
    }
}

/// The sketch of an outline with holes, y up, with about `target_vertices` vertices.
///
/// # Errors
/// A number of vertices out of [`TARGET_VERTICES`], and all that [`Figure::new`] names.
pub fn from_outline(drawing: &Drawing, target_vertices: usize, config: &Config) -> Result<Imported, Refusal> {
    check_target(target_vertices)?;
    let (figure, mut warnings) = Figure::new(drawing, config)?;
    let (sketch, given_up) = of_figure(&figure, target_vertices, YAxis::Up)?;
    warnings.extend(given_up);
    let low = [0, 1].map(|i| drawing.outline.iter().map(|p| p[i]).fold(f64::INFINITY, f64::min));
    let high = [0, 1].map(|i| drawing.outline.iter().map(|p| p[i]).fold(f64::NEG_INFINITY, f64::max));
    let figures = vec![SeenFigure { bounds: [low, high], area: sketch.mesh.area() }];
    Ok(Imported { sketch, warnings, figures })
}

/// The sketch of a figure that an SVG document shows, in user units of its `viewBox`.
///
/// # Errors
/// A number of vertices out of [`TARGET_VERTICES`]; a document that cannot be read, is too large, or shows no figure, or
/// none of this number.
pub fn from_svg(bytes: &[u8], wanted: Choice, config: &Config) -> Result<Imported, Refusal> {
    check_target(wanted.vertices)?;
    let (canvas, ignored) = svg::canvas(bytes, config)?;
    let warnings = ignored.warning().into_iter().collect();
    seen(canvas, warnings, wanted, config).map_err(|refusal| ignored.told_with(refusal))
}

/// The sketch of a figure that a PNG or JPEG picture shows, in pixels: the centre of the first is (0.5, 0.5).
///
/// # Errors
/// A number of vertices out of [`TARGET_VERTICES`]; a picture that cannot be read, is too large, or shows no figure, or
/// none of this number.
pub fn from_picture(bytes: &[u8], wanted: Choice, config: &Config) -> Result<Imported, Refusal> {
    check_target(wanted.vertices)?;
    seen(picture::canvas(bytes, config)?, Vec::new(), wanted, config)
}

/// The sketch of a figure that is seen on a canvas.
fn seen(canvas: Canvas, mut warnings: Vec<Warning>, wanted: Choice, config: &Config) -> Result<Imported, Refusal> {
    let canvas = match without_checkerboard(&canvas) {
        Some(transparent) => {
            let detail = "squares of two greys were taken for a ground that is transparent";
            warnings.push(Warning::new(WarningCode::Background, detail));
            transparent
        }
        None => canvas,
    };
    let canvas = canvas.with_room();
    let reading = Reading::of(&canvas)?;
    let figures = reading.figures(&canvas);
    if wanted.figure >= figures.len() {
        let detail =
            format!("figure {} was asked for; the drawing shows {}, counted from 0", wanted.figure, figures.len());
        return Err(Refusal { faults: vec![Fault::of_figure(detail)] });
    }
    let y_axis = if canvas.pixel[1] < 0.0 { YAxis::Up } else { YAxis::Down };
    let (drawing, strokes) = reading.drawing(&canvas, wanted.figure, RAW_POINTS_PER_POINT * config.max_points)?;
    let figure = drawn_figure(&drawing, y_axis, config)?;
    warnings.extend(reading.warnings(&canvas, wanted.figure));
    let (sketch, given_up) = of_figure(&figure, wanted.vertices, y_axis)?;
    warnings.extend(given_up);
    let up = |line: Line| line.into_iter().map(|point| y_axis.flipped(point)).collect();
    let strokes = strokes.into_iter().map(up).collect();
    Ok(Imported { sketch: sketch.with_strokes(strokes), warnings, figures })
}

/// What a viewer sees of an SVG document.
///
/// # Errors
/// A document that cannot be read or is too large.
pub fn canvas_of_svg(bytes: &[u8], config: &Config) -> Result<Canvas, Refusal> {
    svg::canvas(bytes, config).map(|(canvas, _)| canvas)
}

/// What a viewer sees of a PNG or JPEG picture.
///
/// # Errors
/// A picture that cannot be read or is too large.
pub fn canvas_of_picture(bytes: &[u8], config: &Config) -> Result<Canvas, Refusal> {
    picture::canvas(bytes, config)
}

/// Bytes of memory that reading a picture takes at its peak, about, by its header; none where that is refused.
pub fn picture_memory(bytes: &[u8], config: &Config) -> usize {
    picture::memory(bytes, config)
}

/// The figure of a drawing as it was uploaded. What is wrong with it has a place but no pointer: nobody wrote its points.
fn drawn_figure(drawing: &Drawing, y_axis: YAxis, config: &Config) -> Result<Figure, Refusal> {
    let up = |ring: &Vec<[f64; 2]>| ring.iter().map(|&point| y_axis.flipped(point)).collect();
    let drawing = Drawing { outline: up(&drawing.outline), holes: drawing.holes.iter().map(up).collect() };
    let placed = |fault: Fault| Fault { pointer: None, point: fault.point.map(|p| y_axis.flipped(p)), ..fault };
    match Figure::new(&drawing, config) {
        Ok((figure, _)) => Ok(figure),
        Err(refusal) => Err(Refusal { faults: refusal.faults.into_iter().map(placed).collect() }),
    }
}

fn check_target(target_vertices: usize) -> Result<(), Refusal> {
    if TARGET_VERTICES.contains(&target_vertices) {
        return Ok(());
    }
    let (least, most) = (TARGET_VERTICES.start(), TARGET_VERTICES.end());
    let detail = format!("{target_vertices} vertices; from {least} to {most} can be asked for");
    Err(Refusal { faults: vec![Fault::of("/target_vertices", detail)] })
}

fn of_figure(figure: &Figure, target_vertices: usize, y_axis: YAxis) -> Result<(Sketch, Vec<Warning>), Refusal> {
    let (flat, warnings) = triangulation::triangulated(&figure.rings, target_vertices)?;
    let positions =
        flat.points.iter().map(|&point| figure.frame.drawing_point(point)).map(|[x, y]| [x, y, 0.0]).collect();
    let mesh = TriangleMesh::new(positions, flat.triangles)
        .map_err(|error| Refusal::plain(format!("the figure is too thin to be triangulated: {error}")))?;
    Ok((Sketch::new(mesh, y_axis)?, warnings))
}

#[cfg(test)]
mod tests;
