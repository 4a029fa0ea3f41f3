//! Sketches: uploaded, looked at, listed.

use std::path::Path;
use std::sync::Arc;

use axum::Json;
use axum::extract::State;
use axum::http::StatusCode;
use axum::response::Response;
use serde::{Deserialize, Serialize};
use utoipa::{IntoParams, ToSchema};

use super::App;
use super::body::{JsonBody, Upload, is_json, unsupported};
use super::idempotency::IdempotencyKey;
use super::json::{self, without_mark};
use super::page::{Listing, PageQuery};
use super::problem::{Fault, Problem};
use super::query::{Id, Query};
use super::shapes::{self, Renaming, ShapeDocument};
use super::svg_reader;
use crate::sketch::outline::OutlineRequest;
use crate::sketch::{
    Choice, Config, DEFAULT_TARGET_VERTICES, Imported, Refusal, SeenFigure, Sketch, TARGET_VERTICES, Warning,
    from_outline, from_picture, from_svg, picture_memory,
};
use crate::store::{Kind, Source};

#[derive(Debug, Serialize, Deserialize, ToSchema)]
pub struct SketchMeasures {
    vertices: usize,
    triangles: usize,
    /// In squared units of the upload.
    area: f64,
    /// What was mended, and what is to be known.
    #[serde(deserialize_with = "shapes::known_warnings")]
    pub(super) warnings: Vec<Warning>,
    /// The figures that the drawing shows, largest first; the first is taken where the upload asks for no other.
    #[serde(default)]
    figures: Vec<SeenFigure>,
}

#[derive(Debug, Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
#[into_params(parameter_in = Query)]
pub struct UploadQuery {
    /// Vertices wanted; 800 where neither this nor the body says.
    #[param(minimum = 50, maximum = 20000)]
    target_vertices: Option<usize>,
    /// Which figure of the drawing to take, by its place among `figures`; 0, the largest, where it is not said.
    #[serde(default)]
    #[param(minimum = 0, default = 0)]
    figure: usize,
    /// A name to list the sketch under.
    #[param(max_length = 200)]
    name: Option<String>,
}

/// Bytes of memory per byte of a drawing that is text: an SVG of many short elements takes most.
const MEMORY_OF_TEXT: usize = 32;

/// The kinds of drawing that are understood.
#[derive(Clone, Copy)]
pub enum Drawn {
    Outline,
    Svg,
    Png,
    Jpeg,
}

impl Drawn {
    /// The content type of a drawing of this kind.
    pub const fn media_type(self) -> &'static str {
        match self {
            Drawn::Outline => "application/json",
            Drawn::Svg => "image/svg+xml",
            Drawn::Png => "image/png",
            Drawn::Jpeg => "image/jpeg",
        }
    }
}

/// Takes a sketch: an outline as JSON (y up), an SVG, a PNG or a JPEG.
///
/// The drawing is the raw body, under its content type (`application/json`, `image/svg+xml`, `image/png`, `image/jpeg`) or
/// `application/octet-stream`, or the part `file` of a form. The same drawing, read the same way, is one sketch however
/// often it comes; a name that comes with it is the sketch's from then on.
#[utoipa::path(
    post, path = "/v1/sketches", operation_id = "upload_sketch", tag = "sketches",
    params(UploadQuery, ("Idempotency-Key" = Option<String>, Header, pattern = "^[!-~]{1,255}$", description = "the same key gets the same answer")),
    request_body(description = "the drawing", content(
        (OutlineRequest = "application/json"), ("application/octet-stream"), ("multipart/form-data"),
    )),
    responses(
        (status = 201, description = "taken", body = ShapeDocument<SketchMeasures>, headers(("Location" = String))),
        (status = 200, description = "this very drawing is known already", body = ShapeDocument<SketchMeasures>, headers(("Location" = String))),
    ),
)]
pub async fn upload(
    State(app): State<App>,
    Query(query): Query<UploadQuery>,
    key: IdempotencyKey,
    upload: Upload,
) -> Result<Response, Problem> {
    let upload = Arc::new(upload);
    let asked = (upload.clone(), format!("{query:?}"));
    let answer = async {
        let name = shapes::name(query.name, upload.file_name.clone())?;
        let target = target(query.target_vertices)?;
        let config = Config { max_document_bytes: app.config.max_request_bytes, ..Config::default() };
        let (looked_at, within) = (upload.clone(), config.clone());
        let known = app.off_runtime(move || {
            let drawn = drawn(&looked_at.bytes, looked_at.media_type.as_deref())?;
            Ok::<_, Problem>((drawn, memory(&looked_at.bytes, drawn, &within)?))
        });
        let (drawn, memory) = known.await??;
        let (svg_reader, file, figure) = (app.config.svg_reader.clone(), upload.bytes.clone(), query.figure);
        // The turn and the memory are of the work, which goes on where the client hangs up; so is the upload.
        let taken = app.with_memory(memory, move || {
            imported(&upload.bytes, drawn, (target, figure), &config, svg_reader.as_deref())
        });
        let Imported { sketch, warnings, figures } = taken.await??;
        let source =
            Source { bytes: file, media_type: drawn.media_type().to_owned(), parameters: asked_of(target, figure) };
        let body = serde_json::to_value(measured(&sketch, warnings, figures)).map_err(Problem::internal)?;
        shapes::uploaded::<SketchMeasures>(app.store.insert_sketch(sketch, source, name.as_deref(), body).await?)
    };
    shapes::once(&app, Kind::Sketch, &key, asked, answer).await
}

/// What is asked of the reading, in words: nothing where nothing is.
fn asked_of(target: Option<usize>, figure: usize) -> String {
    let vertices = target.map(|vertices| format!("target_vertices={vertices}"));
    let figure = (figure > 0).then(|| format!("figure={figure}"));
    [vertices, figure].into_iter().flatten().collect::<Vec<_>>().join("&")
}

/// The number of vertices the query asks for.
fn target(asked: Option<usize>) -> Result<Option<usize>, Problem> {
    if asked.is_none_or(|vertices| TARGET_VERTICES.contains(&vertices)) {
        return Ok(asked);
    }
    let (least, most) = TARGET_VERTICES.into_inner();
    let fault = Fault::in_query("target_vertices", format!("from {least} to {most} vertices can be asked for"));
    Err(Problem::refused("the sketch cannot be made as asked", vec![fault]))
}

/// The kind of drawing by its content type, else by its first bytes.
///
/// # Errors
/// 415 for what is no drawing.
pub fn drawn(bytes: &[u8], media_type: Option<&str>) -> Result<Drawn, Problem> {
    match media_type {
        Some(media_type) if is_json(media_type) => Ok(Drawn::Outline),
        Some("image/svg+xml") => Ok(Drawn::Svg),
        Some("image/png") => Ok(Drawn::Png),
        Some("image/jpeg" | "image/jpg") => Ok(Drawn::Jpeg),
        _ => sniffed(bytes).ok_or_else(|| {
            unsupported(
                "a sketch is application/json, image/svg+xml, image/png or image/jpeg; these bytes are none of them",
            )
        }),
    }
}

/// The kind of drawing by its first bytes.
fn sniffed(bytes: &[u8]) -> Option<Drawn> {
    match without_mark(bytes).trim_ascii_start() {
        [b'{', ..] => Some(Drawn::Outline),
        [b'<', ..] => Some(Drawn::Svg),
        [0x89, b'P', b'N', b'G', ..] => Some(Drawn::Png),
        [0xff, 0xd8, 0xff, ..] => Some(Drawn::Jpeg),
        _ => None,
    }
}

/// Bytes of memory that a drawing takes while it is read, about.
///
/// # Errors
/// 413 for text beyond its limit.
fn memory(bytes: &[u8], drawn: Drawn, config: &Config) -> Result<usize, Problem> {
    match drawn {
        Drawn::Png | Drawn::Jpeg => Ok(picture_memory(bytes, config)),
        Drawn::Outline | Drawn::Svg if bytes.len() > config.max_document_bytes => {
            Err(Problem::too_large(config.max_document_bytes))
        }
        Drawn::Outline | Drawn::Svg => Ok(bytes.len().saturating_mul(MEMORY_OF_TEXT)),
    }
}

/// The sketch in a drawing of this kind, with so many vertices and of the figure of this number; an SVG is read by a
/// process of the program `svg_reader` where there is one.
///
/// # Errors
/// 400 for broken JSON, 422 with every fault of a drawing that cannot be matched.
pub fn imported(
    bytes: &[u8],
    drawn: Drawn,
    (target, figure): (Option<usize>, usize),
    config: &Config,
    svg_reader: Option<&Path>,
) -> Result<Imported, Problem> {
    let wanted = Choice { vertices: target.unwrap_or(DEFAULT_TARGET_VERTICES), figure };
    let imported = match drawn {
        Drawn::Outline => {
            let (drawing, vertices) = json::typed::<OutlineRequest>(bytes)?.into_parts();
            from_outline(&drawing, target.unwrap_or(vertices), config)
        }
        Drawn::Svg => match svg_reader {
            Some(program) => svg_reader::read(program, bytes, wanted, config).map_err(Problem::internal)?,
            None => from_svg(bytes, wanted, config),
        },
        Drawn::Png | Drawn::Jpeg => from_picture(bytes, wanted, config),
    };
    imported.map_err(refused)
}

pub(super) fn measured(sketch: &Sketch, warnings: Vec<Warning>, figures: Vec<SeenFigure>) -> SketchMeasures {
    let mesh = sketch.mesh();
    let (vertices, triangles) = (mesh.positions().len(), mesh.triangles().len());
    SketchMeasures { vertices, triangles, area: mesh.area(), warnings, figures }
}

/// The problem of a drawing that is not taken.
pub(super) fn refused(refusal: Refusal) -> Problem {
    let faults = refusal.faults.into_iter().map(|fault| Fault {
        place: fault.point.map(|[x, y]| format!("point ({x}, {y})")),
        pointer: fault.pointer,
        detail: fault.detail,
    });
    Problem::refused("the drawing is not a sketch that can be matched", faults.collect())
}

/// Lists the sketches, newest first.
#[utoipa::path(
    get, path = "/v1/sketches", operation_id = "list_sketches", tag = "sketches", params(PageQuery),
    responses((status = 200, description = "a page", body = Listing<ShapeDocument<SketchMeasures>>)),
)]
pub async fn list(State(app): State<App>, Query(query): Query<PageQuery>) -> Result<Response, Problem> {
    shapes::listed::<SketchMeasures>(&app, Kind::Sketch, &query).await
}

/// Answers what is known of a sketch.
#[utoipa::path(
    get, path = "/v1/sketches/{id}", operation_id = "read_sketch", tag = "sketches", params(("id" = String, Path)),
    responses((status = 200, description = "the sketch", body = ShapeDocument<SketchMeasures>)),
)]
pub async fn read(State(app): State<App>, Id(id): Id) -> Result<Json<ShapeDocument<SketchMeasures>>, Problem> {
    Ok(Json(shapes::known(&app, Kind::Sketch, &id).await?))
}

/// Renames a sketch.
#[utoipa::path(
    patch, path = "/v1/sketches/{id}", operation_id = "rename_sketch", tag = "sketches", params(("id" = String, Path)), request_body = Renaming,
    responses((status = 200, description = "the sketch, renamed", body = ShapeDocument<SketchMeasures>)),
)]
pub async fn rename(
    State(app): State<App>,
    Id(id): Id,
    body: JsonBody,
) -> Result<Json<ShapeDocument<SketchMeasures>>, Problem> {
    Ok(Json(shapes::renamed(&app, Kind::Sketch, &id, body).await?))
}

/// Deletes a sketch, its file and its triangles. Matches it was part of stay.
#[utoipa::path(
    delete, path = "/v1/sketches/{id}", operation_id = "delete_sketch", tag = "sketches", params(("id" = String, Path)),
    responses(
        (status = 204, description = "deleted"),
        (status = 409, description = "a match or spectrum that is not finished needs it"),
    ),
)]
pub async fn delete(State(app): State<App>, Id(id): Id) -> Result<StatusCode, Problem> {
    shapes::deleted(&app, Kind::Sketch, &id).await
}
