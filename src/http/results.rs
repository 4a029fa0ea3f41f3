//! The results of matches.

use axum::http::HeaderMap;
use axum::response::Response;

use super::pictures::{self, GLB};
use super::problem::Problem;
use super::query::Id;
use super::representation::{JSON, NPY, Wanted};
use super::{App, resource};
use crate::export::picture::Form;
use crate::export::{correspondences, functional_map};
use crate::pipeline::Settings;
use crate::pipeline::outcome::MatchResult;

const CSV: &str = "text/csv";

/// Answers the result of a match.
///
/// JSON holds all of it. By `Accept`, `text/csv` answers the correspondences as a table, `application/x-npy` C, and
/// `model/gltf-binary` the mesh in the colours of the sketch.
#[utoipa::path(
    get, path = "/v1/matches/{id}/result", operation_id = "read_result", tag = "matches", params(("id" = String, Path)),
    responses(
        (status = 200, description = "the result", body = MatchResult),
        (status = 304, description = "unchanged"),
        (status = 409, description = "not finished, or finished without a result"),
    ),
)]
pub async fn read(app: App, Id(id): Id, headers: HeaderMap) -> Result<Response, Problem> {
    let wanted = Wanted::negotiated(headers, &[JSON, CSV, NPY, GLB])?;
    let result = resource::result::<Settings>(&app, &id).await?;
    if wanted.media_type() == GLB {
        return pictures::drawn(&app, wanted, Form::Glb.into(), result).await;
    }
    let write = move |media_type| match media_type {
        CSV => correspondences::csv(&result),
        NPY => functional_map::npy(&result),
        _ => Ok(result),
    };
    wanted.answer(&app, write).await
}
