//! Shapes in regions, as a match without an alignment finds them.

use axum::http::HeaderMap;
use axum::response::Response;
use serde::{Deserialize, Serialize};
use utoipa::{IntoParams, ToSchema};

use super::App;
use super::functions::WIDTH;
use super::media_types::{GLB, JSON, PNG};
use super::pictures::width;
use super::problem::{Fault, Problem};
use super::query::{Id, Query};
use super::representation::Wanted;
use super::spectra::{Decomposed, Found, SpectrumOfShape};
use crate::export::{Unwritten, functions};
use crate::numerics::Unwatched;
use crate::pipeline::segmented;
use crate::pipeline::settings::REGIONS;
use crate::regions::MAX_REGIONS;
use crate::spectral::Boundary;
use crate::store::ShapeKind;

/// How a shape is segmented.
#[derive(Clone, Copy, Debug, Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
#[into_params(parameter_in = Query)]
pub struct SegmentationQuery {
    /// Regions at most; 7 where it is not given.
    #[param(minimum = 1, maximum = 64)]
    regions: Option<usize>,
    /// Eigenpairs; 20 where it is not given.
    #[param(minimum = 1, maximum = 1000000)]
    k: Option<usize>,
    boundary: Option<Boundary>,
    /// Pixels of a picture; 600 where it is not given.
    #[param(minimum = 100, maximum = 4000)]
    width: Option<u32>,
}

/// A shape in regions.
#[derive(Debug, Serialize, ToSchema)]
pub struct Segmentation {
    /// How many regions were found.
    regions: usize,
    /// For every vertex of the user's file its region, from 0 by descending area; −1 is in none.
    labels: Vec<i32>,
}

/// Answers the consensus segmentation of a mesh, as a match without an alignment finds it.
///
/// JSON holds the labels; `model/gltf-binary` and `image/png` show them as colours. Where the spectrum is not known yet it is queued: ask again.
#[utoipa::path(
    get, path = "/v1/meshes/{id}/segmentation", operation_id = "read_mesh_segmentation", tag = "meshes", params(("id" = String, Path), SegmentationQuery),
    responses(
        (status = 200, description = "the regions", content((Segmentation = "application/json"), ("model/gltf-binary"), ("image/png"))),
        (status = 202, description = "the spectrum is queued", body = super::spectra::PendingSpectrum, headers(("Location" = String), ("Retry-After" = u32))),
        (status = 304, description = "unchanged"),
    ),
)]
pub async fn of_mesh(
    app: App,
    Id(id): Id,
    Query(query): Query<SegmentationQuery>,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    answered(&app, ShapeKind::Mesh, id, query, headers).await
}

/// Answers the consensus segmentation of a sketch, as that of a mesh.
#[utoipa::path(
    get, path = "/v1/sketches/{id}/segmentation", operation_id = "read_sketch_segmentation", tag = "sketches", params(("id" = String, Path), SegmentationQuery),
    responses(
        (status = 200, description = "the regions", content((Segmentation = "application/json"), ("model/gltf-binary"), ("image/png"))),
        (status = 202, description = "the spectrum is queued", body = super::spectra::PendingSpectrum, headers(("Location" = String), ("Retry-After" = u32))),
        (status = 304, description = "unchanged"),
    ),
)]
pub async fn of_sketch(
    app: App,
    Id(id): Id,
    Query(query): Query<SegmentationQuery>,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    answered(&app, ShapeKind::Sketch, id, query, headers).await
}

async fn answered(
    app: &App,
    kind: ShapeKind,
    id: String,
    query: SegmentationQuery,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    let wanted = Wanted::negotiated(headers, &[JSON, GLB, PNG])?;
    let count = query.regions.unwrap_or(REGIONS);
    if !(1..=MAX_REGIONS).contains(&count) {
        let fault = Fault::in_query("regions", format!("must be 1 to {MAX_REGIONS}, is {count}"));
        return Err(Problem::refused("there is no such segmentation", vec![fault]));
    }
    let wide = width(query.width, WIDTH)?;
    let asked = SpectrumOfShape::of(app, kind, id, query.k, query.boundary)?;
    let found = match asked.found(app, 1).await? {
        Found::Spectrum(found) => found,
        Found::Pending(pending) => return Ok(pending),
    };
    let write = move |media_type| {
        let Decomposed { spectrum, figure, mesh } = &**found;
        // Nobody watches, and so nobody cancels.
        let regions =
            segmented(&spectrum.at_unit_area(asked.k), count, &Unwatched).map_err(|error| error.to_string())?;
        let labels = functions::labels(&regions, figure);
        let written = match media_type {
            GLB => functions::labelled_glb(&labels, mesh),
            PNG => functions::labelled_png(&labels, mesh, wide),
            _ => serde_json::to_vec(&Segmentation { regions: regions.count(), labels })
                .map(Into::into)
                .map_err(Unwritten::from),
        };
        written.map_err(|error| error.to_string())
    };
    wanted.at_length().answer(app, write).await
}
