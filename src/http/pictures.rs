//! Pictures of matches.

use axum::extract::State;
use axum::http::HeaderMap;
use axum::response::Response;
use bytes::Bytes;
use serde::Deserialize;
use serde::de::IgnoredAny;
use utoipa::{IntoParams, ToSchema};

use super::App;
use super::problem::{Fault, Problem};
use super::query::{Id, Query};
use super::representation::{OCTETS, Wanted};
use super::results::stored;
use super::shapes;
use crate::alignment::frame::Frame;
use crate::mesh::cross;
use crate::mesh::file_mesh::FileMesh;
use crate::picture::{self, Matched, Unfit, WIDTH, WIDTHS, heat_map};
use crate::pipeline::outcome::ViewReport;
use crate::sketch::Sketch;

pub(super) const PNG: &str = "image/png";
pub(super) const SVG: &str = "image/svg+xml";
pub(super) const GLB: &str = "model/gltf-binary";

/// How the picture of a match is to be.
#[derive(Clone, Copy, Debug, Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
#[into_params(parameter_in = Query)]
pub struct PictureQuery {
    /// The form of the picture, whatever the `Accept` header says: an `<img>` cannot choose it.
    #[param(inline)]
    format: Option<PictureFormat>,
    /// Its width in pixels; 1600 where it is not given.
    #[param(minimum = 100, maximum = 4000)]
    width: Option<u32>,
    /// Which of the `alternatives` of the result is shown instead of the answer, counted from 0.
    #[param(maximum = 1000)]
    alternative: Option<usize>,
}

/// How the picture of a matrix is to be.
#[derive(Clone, Copy, Debug, Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
#[into_params(parameter_in = Query)]
pub struct MatrixQuery {
    /// The form of the picture, whatever the `Accept` header says.
    #[param(inline)]
    format: Option<PictureFormat>,
}

/// Which answer is shown.
#[derive(Clone, Copy, Debug, Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
#[into_params(parameter_in = Query)]
pub struct AnswerQuery {
    /// Which of the `alternatives` of the result is shown instead of the answer, counted from 0.
    #[param(maximum = 1000)]
    alternative: Option<usize>,
}

#[derive(Clone, Copy, Debug, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub(super) enum PictureFormat {
    Png,
    Svg,
}

/// The form of a picture that is asked for: PNG where nothing tells.
pub(super) fn wanted(format: Option<PictureFormat>, headers: HeaderMap) -> Result<Wanted, Problem> {
    match format {
        Some(PictureFormat::Png) => Ok(Wanted::named(headers, PNG)),
        Some(PictureFormat::Svg) => Ok(Wanted::named(headers, SVG)),
        None => Wanted::negotiated(headers, &[PNG, SVG, OCTETS]),
    }
}

/// The width asked for, else `usual`.
pub(super) fn width(asked: Option<u32>, usual: u32) -> Result<u32, Problem> {
    match asked {
        Some(width) if !WIDTHS.contains(&width) => {
            let (least, most) = WIDTHS.into_inner();
            let fault = Fault::in_query("width", format!("a picture is {least} to {most} pixels wide"));
            Err(Problem::refused("there is no such picture", vec![fault]))
        }
        asked => Ok(asked.unwrap_or(usual)),
    }
}

/// What a picture of a match is a file of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Form {
    Png,
    Svg,
    /// The mesh alone, in space.
    Glb,
}

/// How a picture of a match is to be.
#[derive(Clone, Copy, Debug)]
pub struct Look {
    pub form: Form,
    /// In pixels; of no meaning in space.
    pub width: u32,
    /// Which alternative is shown instead of the answer.
    pub alternative: Option<usize>,
}

impl From<Form> for Look {
    /// The answer in this form, of the usual width.
    fn from(form: Form) -> Look {
        Look { form, width: WIDTH, alternative: None }
    }
}

/// Why a picture was not drawn.
#[derive(Debug, thiserror::Error)]
pub enum Undrawn {
    #[error("the result cannot be read: {0}")]
    Result(#[from] serde_json::Error),
    #[error("the result has no such alternative")]
    NoAlternative,
    #[error(transparent)]
    Unfit(#[from] Unfit),
    #[error("the picture cannot be encoded: {0}")]
    Picture(#[from] image::ImageError),
    #[error("the mesh cannot be encoded: {0}")]
    Mesh(#[from] gltf::Error),
}

/// What a picture needs of a result.
#[derive(Deserialize)]
struct Seen {
    correspondences: Vec<Point>,
    alignment: Option<Alignment>,
    alternatives: Vec<Alternative>,
}

#[derive(Deserialize)]
struct Point {
    mesh_vertex: u32,
    /// Nothing where it is not known.
    confidence: Option<f64>,
}

#[derive(Deserialize)]
struct Alignment {
    view: ViewReport,
}

#[derive(Deserialize)]
struct Alternative {
    view: ViewReport,
    mesh_vertices: Vec<u32>,
}

impl Seen {
    /// The result as if an alternative were its answer; its points are believed as those of the answer.
    fn instead(mut self, alternative: usize) -> Option<Seen> {
        let Alternative { view, mesh_vertices } = self.alternatives.drain(..).nth(alternative)?;
        self.correspondences.iter_mut().zip(mesh_vertices).for_each(|(point, vertex)| point.mesh_vertex = vertex);
        Some(Seen { alignment: Some(Alignment { view }), ..self })
    }
}

/// A file with a picture of the result, as the service wrote it, of a match of these two shapes.
///
/// # Errors
/// A result that cannot be read, is of other shapes or has no such alternative; what an encoder reports.
pub fn file(look: Look, result: &[u8], sketch: &Sketch, mesh: &FileMesh) -> Result<Vec<u8>, Undrawn> {
    let seen: Seen = serde_json::from_slice(result)?;
    let seen = match look.alternative {
        Some(alternative) => seen.instead(alternative).ok_or(Undrawn::NoAlternative)?,
        None => seen,
    };
    let view = seen.alignment.map(|Alignment { view: ViewReport { toward_camera, up } }| Frame {
        right: cross(up, toward_camera),
        up,
        toward_camera,
    });
    let points = seen.correspondences.into_iter();
    let points = points.map(|Point { mesh_vertex, confidence }| {
        // Where there is no such vertex this is one past the last, and refused.
        let vertex = mesh.sound_vertices(mesh_vertex).next().unwrap_or(mesh.sound().positions().len() as u32);
        (vertex, confidence.unwrap_or(0.0))
    });
    let pair = Matched::new(sketch, mesh.sound(), points, view)?;
    Ok(match look.form {
        Form::Png => picture::png(&pair, look.width)?,
        Form::Svg => picture::svg(&pair, look.width)?.into_bytes(),
        Form::Glb => picture::glb(&pair, mesh)?,
    })
}

/// Answers a picture of a match: the sketch, the mesh in the view it was matched in, and the mesh from 60° beside it.
///
/// What corresponds has one colour; what nothing corresponds to is light grey, and what is matched without confidence
/// grey. The picture is up to two fifths as high as it is wide.
#[utoipa::path(
    get, path = "/v1/matches/{id}/picture", operation_id = "draw_match", tag = "matches", params(("id" = String, Path), PictureQuery),
    responses(
        (status = 200, description = "the picture", content(("image/png"), ("image/svg+xml"), ("application/octet-stream"))),
        (status = 304, description = "unchanged"),
        (status = 409, description = "not finished, or finished without a result"),
    ),
)]
pub async fn of_match(
    State(app): State<App>,
    Id(id): Id,
    Query(query): Query<PictureQuery>,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    let wanted = wanted(query.format, headers)?;
    let form = if wanted.media_type() == SVG { Form::Svg } else { Form::Png };
    let look = Look { form, width: width(query.width, WIDTH)?, alternative: query.alternative };
    drawn(&app, wanted, look, stored(&app, &id).await?).await
}

/// Answers the functional map of a match as a heat map: a row per eigenfunction of the mesh and a column per one of the
/// sketch, red above 0 and blue below.
#[utoipa::path(
    get, path = "/v1/matches/{id}/matrix", operation_id = "draw_matrix", tag = "matches", params(("id" = String, Path), MatrixQuery),
    responses(
        (status = 200, description = "the heat map", content(("image/png"), ("image/svg+xml"), ("application/octet-stream"))),
        (status = 304, description = "unchanged"),
        (status = 409, description = "not finished, or finished without a result"),
    ),
)]
pub async fn of_matrix(
    State(app): State<App>,
    Id(id): Id,
    Query(query): Query<MatrixQuery>,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    let wanted = wanted(query.format, headers)?;
    let result = stored(&app, &id).await?;
    let wanted = wanted.made_of(&app, result.clone(), "matrix".to_owned()).await?;
    wanted.answer(&app, move |media_type| matrix(media_type, &result)).await
}

/// Answers the mesh of a match in the colours of the sketch, as glTF 2.0 binary.
///
/// Vertices and triangles are those of `GET /v1/meshes/{id}/mesh`, in single precision.
#[utoipa::path(
    get, path = "/v1/matches/{id}/mesh.glb", operation_id = "read_match_mesh", tag = "matches", params(("id" = String, Path), AnswerQuery),
    responses(
        (status = 200, description = "the mesh", content(("model/gltf-binary"), ("application/octet-stream"))),
        (status = 304, description = "unchanged"),
        (status = 409, description = "not finished, or finished without a result"),
    ),
)]
pub async fn of_mesh(
    State(app): State<App>,
    Id(id): Id,
    Query(query): Query<AnswerQuery>,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    let wanted = Wanted::negotiated(headers, &[GLB, OCTETS])?;
    let look = Look { alternative: query.alternative, ..Look::from(Form::Glb) };
    drawn(&app, wanted, look, stored(&app, &id).await?).await
}

/// Which shapes a result is of, and how many alternatives it has.
#[derive(Deserialize)]
struct Contents {
    sketch: String,
    mesh: String,
    alternatives: Vec<IgnoredAny>,
}

/// Answers a result and its shapes as a picture, or as the coloured mesh.
pub(super) async fn drawn(app: &App, wanted: Wanted, look: Look, result: Bytes) -> Result<Response, Problem> {
    let read = result.clone();
    let contents = app.off_runtime(move || serde_json::from_slice(&read)).await?.map_err(Problem::internal)?;
    let Contents { sketch, mesh, alternatives } = contents;
    if look.alternative.is_some_and(|alternative| alternative >= alternatives.len()) {
        let fault = Fault::in_query("alternative", format!("the result has {} alternatives", alternatives.len()));
        return Err(Problem::not_there("there is no such answer", fault));
    }
    let wanted = wanted.made_of(app, result.clone(), format!("{look:?}")).await?;
    if let Some(unchanged) = wanted.unchanged() {
        return Ok(unchanged);
    }
    let (sketch, mesh) = (shapes::sketch(app, &sketch).await?, shapes::mesh(app, &mesh).await?);
    wanted.answer(app, move |_| file(look, &result, &sketch, &mesh).map(Bytes::from)).await
}

/// What a heat map needs of a result.
#[derive(Deserialize)]
struct Map {
    c: Matrix,
}

#[derive(Deserialize)]
struct Matrix {
    values: Vec<Vec<f64>>,
}

fn matrix(media_type: &str, result: &[u8]) -> Result<Bytes, Undrawn> {
    let Map { c: Matrix { values } } = serde_json::from_slice(result)?;
    Ok(match media_type {
        SVG => heat_map::svg(&values)?.into(),
        _ => heat_map::png(&values)?.into(),
    })
}
