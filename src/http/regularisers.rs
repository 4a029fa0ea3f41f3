//! The regularisers, terms and bases there are.

use axum::Json;

use super::problem::Problem;
use super::query::Id;
use crate::functional_map::catalogue::{self, Description, descriptions};

/// Lists the regularisers: formula, solver, parameters with their ranges, JSON schema.
#[utoipa::path(
    get, path = "/v1/regularisers", operation_id = "list_regularisers", tag = "regularisers",
    responses((status = 200, description = "every regulariser", body = Vec<Description>)),
)]
pub async fn list() -> Json<Vec<Description>> {
    Json(descriptions())
}

/// Describes one regulariser.
#[utoipa::path(
    get, path = "/v1/regularisers/{type}", operation_id = "read_regulariser", tag = "regularisers",
    params(("type" = String, Path, description = "the `type` of a request's regulariser")),
    responses((status = 200, description = "the regulariser", body = Description)),
)]
pub async fn read(Id(name): Id) -> Result<Json<Description>, Problem> {
    let found = descriptions().into_iter().find(|description| description.r#type == name);
    found.map(Json).ok_or_else(|| Problem::not_found(format_args!("regulariser {name}")))
}

/// Lists the terms that can be added to the energy: formula, parameters with their ranges, JSON schema.
#[utoipa::path(
    get, path = "/v1/terms", operation_id = "list_terms", tag = "regularisers",
    responses((status = 200, description = "every term", body = Vec<Description>)),
)]
pub async fn terms() -> Json<Vec<Description>> {
    Json(catalogue::terms())
}

/// Lists the bases that C can be found in: formula, parameters with their ranges, JSON schema.
#[utoipa::path(
    get, path = "/v1/bases", operation_id = "list_bases", tag = "regularisers",
    responses((status = 200, description = "every kind of basis", body = Vec<Description>)),
)]
pub async fn bases() -> Json<Vec<Description>> {
    Json(catalogue::bases())
}
