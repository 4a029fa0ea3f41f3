//! Sketches: which kind of drawing bytes are, the sketch that is read of them, and what is told of it.

use std::path::Path;

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::json::{self, is_json, without_mark};
use super::{Cause, Fault, Untaken, svg_reader, warnings};
use crate::sketch::outline::OutlineRequest;
use crate::sketch::{
    Canvas, Choice, Config, DEFAULT_TARGET_VERTICES, Imported, Refusal, SeenFigure, Warning, canvas_of_picture,
    canvas_of_svg, foreign, from_outline, from_picture, from_svg, gzip, picture_memory,
};

#[derive(Debug, Serialize, Deserialize, ToSchema)]
pub struct SketchMeasures {
    pub vertices: usize,
    pub triangles: usize,
    /// In squared units of the upload.
    pub area: f64,
    /// What was mended, and what is to be known.
    #[serde(deserialize_with = "warnings::known")]
    pub warnings: Vec<Warning>,
    /// The figures that the drawing shows, largest first; the first is taken where the upload asks for no other.
    #[serde(default)]
    pub figures: Vec<SeenFigure>,
}

impl SketchMeasures {
    /// What is told of a sketch.
    pub fn of(Imported { sketch, warnings, figures }: &Imported) -> SketchMeasures {
        let mesh = sketch.mesh();
        let (vertices, triangles) = (mesh.positions().len(), mesh.triangles().len());
        SketchMeasures { vertices, triangles, area: mesh.area(), warnings: warnings.clone(), figures: figures.clone() }
    }
}

/// Bytes of memory per byte of a drawing that is text: an SVG of many short elements takes most.
const MEMORY_OF_TEXT: usize = 32;

/// The kinds of drawing that are understood.
#[derive(Clone, Copy)]
pub enum Drawing {
    Outline,
    Svg,
    Png,
    Jpeg,
}

impl Drawing {
    /// The content type of a drawing of this kind.
    pub const fn media_type(self) -> &'static str {
        match self {
            Drawing::Outline => "application/json",
            Drawing::Svg => "image/svg+xml",
            Drawing::Png => "image/png",
            Drawing::Jpeg => "image/jpeg",
        }
    }
}

/// The kind of drawing by its content type; a picture or an SVG that goes by another name, or none, by its first bytes.
///
/// # Errors
/// Unsupported for what is no drawing.
pub fn kind(bytes: &[u8], media_type: Option<&str>) -> Result<Drawing, Untaken> {
    let told = match media_type {
        Some(media_type) if is_json(media_type) => return Ok(Drawing::Outline),
        Some("image/svg+xml") => Some(Drawing::Svg),
        Some("image/png") => Some(Drawing::Png),
        Some("image/jpeg" | "image/jpg") => Some(Drawing::Jpeg),
        _ => None,
    };
    match (told, sniffed(bytes)) {
        (Some(told), None | Some(Drawing::Outline)) => Ok(told),
        (_, Some(seen)) => Ok(seen),
        (None, None) => Err(unsupported(bytes)),
    }
}

/// Why bytes are no drawing.
fn unsupported(bytes: &[u8]) -> Untaken {
    let detail = "a sketch is application/json, image/svg+xml, image/png or image/jpeg; these bytes are none of them";
    let named = foreign::name(bytes).map(|foreign| foreign.to_string());
    Untaken::of(Cause::Unsupported, named.unwrap_or_else(|| detail.to_owned()))
}

/// The kind of drawing by its first bytes.
fn sniffed(bytes: &[u8]) -> Option<Drawing> {
    match without_mark(bytes).trim_ascii_start() {
        [b'{', ..] => Some(Drawing::Outline),
        [b'<', ..] => Some(Drawing::Svg),
        start if gzip::is_packed(start) => Some(Drawing::Svg),
        [0x89, b'P', b'N', b'G', ..] => Some(Drawing::Png),
        [0xff, 0xd8, 0xff, ..] => Some(Drawing::Jpeg),
        _ => None,
    }
}

/// Bytes of memory that a drawing takes while it is read, about.
///
/// # Errors
/// Too large for text beyond its limit.
pub fn memory(bytes: &[u8], kind: Drawing, config: &Config) -> Result<usize, Untaken> {
    match kind {
        Drawing::Png | Drawing::Jpeg => Ok(picture_memory(bytes, config)),
        Drawing::Outline | Drawing::Svg if bytes.len() > config.max_document_bytes => {
            let limit = config.max_document_bytes;
            Err(Untaken::of(Cause::TooLarge, format!("the body is larger than the {limit} bytes allowed here")))
        }
        Drawing::Outline | Drawing::Svg => {
            Ok(gzip::most_unpacked(bytes).min(config.max_document_bytes).saturating_mul(MEMORY_OF_TEXT))
        }
    }
}

/// The sketch in a drawing of this kind, with so many vertices and of the figure of this number; an SVG is read by a
/// process of the program `svg_reader` where there is one.
///
/// # Errors
/// Malformed for broken JSON, unacceptable with every fault of a drawing that cannot be matched.
pub fn taken(
    bytes: &[u8],
    kind: Drawing,
    (target, figure): (Option<usize>, usize),
    config: &Config,
    svg_reader: Option<&Path>,
) -> Result<Imported, Untaken> {
    let wanted = Choice { vertices: target.unwrap_or(DEFAULT_TARGET_VERTICES), figure };
    let imported = match kind {
        Drawing::Outline => {
            let request = json::typed::<OutlineRequest>(bytes)?;
            let faults = contradictions(&request, target, figure);
            if !faults.is_empty() {
                return Err(Untaken::unacceptable("the sketch cannot be made as asked", faults));
            }
            let (drawing, vertices) = request.into_parts();
            from_outline(&drawing, target.unwrap_or(vertices), config)
        }
        Drawing::Svg => match svg_reader {
            Some(program) => svg_reader::read(program, bytes, wanted, config)
                .map_err(|error| Untaken::of(Cause::Failed, error.to_string()))?,
            None => from_svg(bytes, wanted, config),
        },
        Drawing::Png | Drawing::Jpeg => from_picture(bytes, wanted, config),
    };
    imported.map_err(untaken)
}

/// What is asked of the reading of an outline that this says otherwise.
fn contradictions(request: &OutlineRequest, target: Option<usize>, figure: usize) -> Vec<Fault> {
    let mut faults = Vec::new();
    if figure > 0 {
        faults.push(Fault::at_place("figure", "an outline is one figure, number 0"));
    }
    if let (Some(asked), Some(said)) = (target, request.target_vertices)
        && asked != said
    {
        faults.push(Fault::at_place("target_vertices", format!("is {asked} here and {said} in the body")));
        faults.push(Fault::at_pointer("/target_vertices", format!("is {said} here and {asked} beside the body")));
    }
    faults
}

/// What a viewer sees of a drawing of this kind; nothing where it is no picture or cannot be read.
pub fn canvas(bytes: &[u8], kind: Drawing, config: &Config) -> Option<Canvas> {
    match kind {
        Drawing::Outline => None,
        Drawing::Svg => canvas_of_svg(bytes, config).ok(),
        Drawing::Png | Drawing::Jpeg => canvas_of_picture(bytes, config).ok(),
    }
}

/// Why a drawing is not taken.
pub fn untaken(refusal: Refusal) -> Untaken {
    let faults = refusal.faults.into_iter().map(|fault| Fault {
        place: fault.point.map(|[x, y]| format!("point ({x}, {y})")).or(fault.asked),
        pointer: fault.pointer,
        detail: fault.detail,
    });
    Untaken::unacceptable("the drawing is not a sketch that can be matched", faults.collect())
}
