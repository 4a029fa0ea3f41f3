//! Pictures of matches.

use std::future::ready;

use axum::http::HeaderMap;
use axum::response::Response;
use bytes::Bytes;
use serde::Deserialize;
use serde::de::IgnoredAny;
use utoipa::{IntoParams, ToSchema};

use super::media_types::{GLB, OCTETS, PNG, SVG};
use super::problem::{Fault, Problem};
use super::query::{Id, Query};
use super::representation::Wanted;
use super::{App, resource, shapes};
use crate::export::functional_map;
use crate::export::picture::{self, Form, Look};
use crate::picture::{WIDTH, WIDTHS};
use crate::pipeline::Settings;

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
    pub(super) alternative: Option<usize>,
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
    app: App,
    Id(id): Id,
    Query(query): Query<PictureQuery>,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    let wanted = wanted(query.format, headers)?;
    let form = if wanted.media_type() == SVG { Form::Svg } else { Form::Png };
    let look = Look { form, width: width(query.width, WIDTH)?, alternative: query.alternative };
    drawn(&app, wanted, look, resource::result::<Settings>(&app, &id).await?).await
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
    app: App,
    Id(id): Id,
    Query(query): Query<MatrixQuery>,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    let wanted = wanted(query.format, headers)?;
    let result = resource::result::<Settings>(&app, &id).await?;
    let made_of = (result.clone(), "matrix".to_owned());
    let draw = move |media_type| match media_type {
        SVG => functional_map::svg(&result),
        _ => functional_map::png(&result),
    };
    wanted.answer_made_of(&app, made_of, ready(Ok(draw))).await
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
    app: App,
    Id(id): Id,
    Query(query): Query<AnswerQuery>,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    let wanted = Wanted::negotiated(headers, &[GLB, OCTETS])?;
    let look = Look { alternative: query.alternative, ..Look::from(Form::Glb) };
    drawn(&app, wanted, look, resource::result::<Settings>(&app, &id).await?).await
}

/// Which shapes a result is of, and how many alternatives it has.
#[derive(Deserialize)]
struct Contents {
    sketch: String,
    mesh: String,
    alternatives: Vec<IgnoredAny>,
}

/// 404: a result of so many alternatives has no such one.
pub(super) fn no_alternative(count: usize) -> Problem {
    let fault = Fault::in_query("alternative", format!("the result has {count} alternatives"));
    Problem::not_there("there is no such answer", fault)
}

/// Answers a result and its shapes as a picture, or as the coloured mesh.
pub(super) async fn drawn(app: &App, wanted: Wanted, look: Look, result: Bytes) -> Result<Response, Problem> {
    let read = result.clone();
    let contents = app.off_runtime(move || serde_json::from_slice(&read)).await?.map_err(Problem::internal)?;
    let Contents { sketch, mesh, alternatives } = contents;
    if look.alternative.is_some_and(|alternative| alternative >= alternatives.len()) {
        return Err(no_alternative(alternatives.len()));
    }
    let fetched = async {
        let (shapes, read) = (shapes::both(app, (&sketch, &mesh), |_| 0).await?, result.clone());
        Ok(move |_| picture::file(look, &read, &shapes.0, &shapes.1).map(Bytes::from))
    };
    wanted.answer_made_of(app, (result.clone(), format!("{look:?}")), fetched).await
}
