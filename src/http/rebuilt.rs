//! Shapes rebuilt of their first eigenfunctions.

use axum::http::HeaderMap;
use axum::response::Response;
use serde::Deserialize;
use utoipa::IntoParams;

use super::App;
use super::media_types::{GLB, NPY, OCTETS};
use super::problem::Problem;
use super::query::{Id, Query};
use super::representation::Wanted;
use super::spectra::{Decomposed, Found, SpectrumOfShape};
use crate::export::functions;
use crate::spectral::{Boundary, rebuilt};
use crate::store::ShapeKind;

/// What a shape is rebuilt of.
#[derive(Clone, Copy, Debug, Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
#[into_params(parameter_in = Query)]
pub struct RebuiltQuery {
    /// Eigenfunctions, the first k; 20 where it is not given.
    #[param(minimum = 1, maximum = 1000000)]
    k: Option<usize>,
    boundary: Option<Boundary>,
}

/// Answers a mesh rebuilt of its first k eigenfunctions: its coordinates as far as they describe them.
///
/// `model/gltf-binary` holds the mesh with its vertices at these places, `application/x-npy` the places alone, a row per vertex. Vertices outside the largest component stay where they are. Where the spectrum is not known yet it is queued: ask again.
#[utoipa::path(
    get, path = "/v1/meshes/{id}/rebuilt", operation_id = "rebuild_mesh", tag = "meshes", params(("id" = String, Path), RebuiltQuery),
    responses(
        (status = 200, description = "the rebuilt shape", content(("model/gltf-binary"), ("application/x-npy"), ("application/octet-stream"))),
        (status = 202, description = "the spectrum is queued", body = super::spectra::PendingSpectrum, headers(("Location" = String), ("Retry-After" = u32))),
        (status = 304, description = "unchanged"),
    ),
)]
pub async fn of_mesh(
    app: App,
    Id(id): Id,
    Query(query): Query<RebuiltQuery>,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    answered(&app, ShapeKind::Mesh, id, query, headers).await
}

/// Answers a sketch rebuilt of its first k eigenfunctions, as a mesh.
#[utoipa::path(
    get, path = "/v1/sketches/{id}/rebuilt", operation_id = "rebuild_sketch", tag = "sketches", params(("id" = String, Path), RebuiltQuery),
    responses(
        (status = 200, description = "the rebuilt shape", content(("model/gltf-binary"), ("application/x-npy"), ("application/octet-stream"))),
        (status = 202, description = "the spectrum is queued", body = super::spectra::PendingSpectrum, headers(("Location" = String), ("Retry-After" = u32))),
        (status = 304, description = "unchanged"),
    ),
)]
pub async fn of_sketch(
    app: App,
    Id(id): Id,
    Query(query): Query<RebuiltQuery>,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    answered(&app, ShapeKind::Sketch, id, query, headers).await
}

async fn answered(
    app: &App,
    kind: ShapeKind,
    id: String,
    query: RebuiltQuery,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    let wanted = Wanted::negotiated(headers, &[GLB, NPY, OCTETS])?;
    let asked = SpectrumOfShape::of(app, kind, id, query.k, query.boundary)?;
    let found = match asked.found(app, 3).await? {
        Found::Spectrum(found) => found,
        Found::Pending(pending) => return Ok(pending),
    };
    let write = move |media_type| {
        let Decomposed { spectrum, figure, mesh } = &**found;
        let places = rebuilt::rebuilt(&spectrum.at_unit_area(asked.k), figure.mesh.positions());
        let places = functions::placed(&places, figure, mesh);
        match media_type {
            NPY => Ok(functions::places_npy(&places)),
            _ => functions::places_glb(places, mesh),
        }
    };
    wanted.answer(app, write).await
}
