//! Pictures of matches.

use axum::extract::State;
use axum::http::HeaderMap;
use axum::response::Response;
use bytes::Bytes;
use serde::Deserialize;
use utoipa::{IntoParams, ToSchema};

use super::App;
use super::problem::Problem;
use super::query::{Id, Query};
use super::representation::Wanted;
use super::results::stored;
use super::shapes;
use crate::alignment::frame::Frame;
use crate::mesh::cross;
use crate::mesh::file_mesh::FileMesh;
use crate::picture::{self, Matched, Unfit, heat_map};
use crate::pipeline::outcome::ViewReport;
use crate::sketch::Sketch;

const PNG: &str = "image/png";
const SVG: &str = "image/svg+xml";
pub(super) const GLB: &str = "model/gltf-binary";

#[derive(Clone, Copy, Debug, Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
#[into_params(parameter_in = Query)]
pub struct PictureQuery {
    /// The form of the picture, whatever the `Accept` header says: an `<img>` cannot choose it.
    #[param(inline)]
    format: Option<PictureFormat>,
}

#[derive(Clone, Copy, Debug, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
enum PictureFormat {
    Png,
    Svg,
}

impl PictureQuery {
    /// The form that is asked for: PNG where nothing tells.
    fn wanted(self, headers: HeaderMap) -> Result<Wanted, Problem> {
        match self.format {
            Some(PictureFormat::Png) => Ok(Wanted::named(headers, PNG)),
            Some(PictureFormat::Svg) => Ok(Wanted::named(headers, SVG)),
            None => Wanted::negotiated(headers, &[PNG, SVG]),
        }
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

/// Why a picture was not drawn.
#[derive(Debug, thiserror::Error)]
pub enum Undrawn {
    #[error("the result cannot be read: {0}")]
    Result(#[from] serde_json::Error),
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

/// A file with a picture of the result, as the service wrote it, of a match of these two shapes.
///
/// # Errors
/// A result that cannot be read or is of other shapes; what an encoder reports.
pub fn file(form: Form, result: &[u8], sketch: &Sketch, mesh: &FileMesh) -> Result<Vec<u8>, Undrawn> {
    let Seen { correspondences, alignment } = serde_json::from_slice(result)?;
    let view = alignment.map(|Alignment { view: ViewReport { toward_camera, up } }| Frame {
        right: cross(up, toward_camera),
        up,
        toward_camera,
    });
    let points = correspondences.into_iter();
    let points = points.map(|Point { mesh_vertex, confidence }| {
        // Where there is no such vertex this is one past the last, and refused.
        let vertex = mesh.sound_vertices(mesh_vertex).next().unwrap_or(mesh.sound().positions().len() as u32);
        (vertex, confidence.unwrap_or(0.0))
    });
    let pair = Matched::new(sketch, mesh.sound(), points, view)?;
    Ok(match form {
        Form::Png => picture::png(&pair)?,
        Form::Svg => picture::svg(&pair)?.into_bytes(),
        Form::Glb => picture::glb(&pair, mesh)?,
    })
}

/// Answers a picture of a match: the sketch, the mesh in the view it was matched in, and the mesh from 60° beside it.
///
/// What corresponds has one colour; what nothing corresponds to is light grey, and what is matched without confidence
/// grey. The picture is 1600 pixels wide and up to 640 high.
#[utoipa::path(
    get, path = "/v1/matches/{id}/picture", tag = "matches", params(("id" = String, Path), PictureQuery),
    responses(
        (status = 200, description = "the picture", content((String = "image/png"), (String = "image/svg+xml"))),
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
    let wanted = query.wanted(headers)?;
    drawn(&app, wanted, stored(&app, &id).await?).await
}

/// Answers the functional map of a match as a heat map: a row per eigenfunction of the mesh and a column per one of the
/// sketch, red above 0 and blue below.
#[utoipa::path(
    get, path = "/v1/matches/{id}/matrix", tag = "matches", params(("id" = String, Path), PictureQuery),
    responses(
        (status = 200, description = "the heat map", content((String = "image/png"), (String = "image/svg+xml"))),
        (status = 304, description = "unchanged"),
        (status = 409, description = "not finished, or finished without a result"),
    ),
)]
pub async fn of_matrix(
    State(app): State<App>,
    Id(id): Id,
    Query(query): Query<PictureQuery>,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    let wanted = query.wanted(headers)?;
    let result = stored(&app, &id).await?;
    wanted.answer(&app, move |media_type| matrix(media_type, &result)).await
}

/// Answers the mesh of a match in the colours of the sketch, as glTF 2.0 binary.
///
/// Vertices and triangles are those of `GET /v1/meshes/{id}/mesh`, in single precision.
#[utoipa::path(
    get, path = "/v1/matches/{id}/mesh.glb", tag = "matches", params(("id" = String, Path)),
    responses(
        (status = 200, description = "the mesh", content((String = "model/gltf-binary"))),
        (status = 304, description = "unchanged"),
        (status = 409, description = "not finished, or finished without a result"),
    ),
)]
pub async fn of_mesh(State(app): State<App>, Id(id): Id, headers: HeaderMap) -> Result<Response, Problem> {
    let wanted = Wanted::negotiated(headers, &[GLB])?;
    drawn(&app, wanted, stored(&app, &id).await?).await
}

/// Which shapes a result is of.
#[derive(Deserialize)]
struct Shapes {
    sketch: String,
    mesh: String,
}

/// Answers a result and its shapes as a picture, or as the coloured mesh.
pub(super) async fn drawn(app: &App, wanted: Wanted, result: Bytes) -> Result<Response, Problem> {
    let named = result.clone();
    let named = app.off_runtime(move || serde_json::from_slice::<Shapes>(&named)).await?;
    let Shapes { sketch, mesh } = named.map_err(Problem::internal)?;
    let (sketch, mesh) = (shapes::sketch(app, &sketch).await?, shapes::mesh(app, &mesh).await?);
    let draw = move |media_type| {
        let form = match media_type {
            SVG => Form::Svg,
            GLB => Form::Glb,
            _ => Form::Png,
        };
        file(form, &result, &sketch, &mesh).map(Bytes::from)
    };
    wanted.answer(app, draw).await
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
