//! What shapes are described by, to be looked at: eigenfunctions, signatures, segmentations, the shape rebuilt of its first
//! eigenfunctions.

use axum::http::HeaderMap;
use axum::response::Response;
use serde::{Deserialize, Serialize};
use utoipa::{IntoParams, ToSchema};

use super::App;
use super::pictures::{GLB, PNG, width};
use super::problem::{Fault, Problem};
use super::query::{Id, Query};
use super::representation::{JSON, NPY, SAFETENSORS, Wanted};
use super::spectra::{Asked, Found};
use crate::descriptors::functions::{Kind as Function, Sampling};
use crate::export::{Unwritten, functions};
use crate::numerics::Unwatched;
use crate::pipeline::segmented;
use crate::regions::MAX_REGIONS;
use crate::spectral::{Boundary, rebuilt};
use crate::store::Kind;

/// Bytes of functions in one answer.
const LARGEST_ANSWER: usize = 1 << 30;

/// Times or energies at most.
const MOST_COMPONENTS: usize = 1000;

/// Pixels across, where nobody asks for others.
const WIDTH: u32 = 600;

/// Which functions of a shape, and how they are to come.
#[derive(Clone, Copy, Debug, Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
#[into_params(parameter_in = Query)]
pub struct FunctionsQuery {
    #[param(inline)]
    kind: Function,
    /// Eigenpairs they are made of; 20 where it is not given.
    #[param(minimum = 1, maximum = 1000000)]
    k: Option<usize>,
    /// `neumann` where it is not given.
    boundary: Option<Boundary>,
    /// Times or energies; 100 where it is not given.
    #[param(minimum = 1, maximum = 1000)]
    count: Option<usize>,
    /// Width of an energy's band in spacings; 6 where it is not given.
    #[param(minimum = 1e-6, maximum = 1000000)]
    variance: Option<f64>,
    /// Which of them is shown as colours, counted from 0; the first where it is not given.
    #[param(maximum = 1000000)]
    column: Option<usize>,
    /// Pixels of a picture; 600 where it is not given.
    #[param(minimum = 100, maximum = 4000)]
    width: Option<u32>,
}

/// Answers functions of a mesh at the vertices of the user's file: eigenfunctions, heat or wave kernel signatures, global
/// point signatures, at area 1.
///
/// `application/x-npy` and `application/vnd.safetensors` hold all, a row per vertex, not a number outside the largest component; `model/gltf-binary` and `image/png` show one as colours. Where the spectrum is not known yet it is queued: ask again.
#[utoipa::path(
    get, path = "/v1/meshes/{id}/functions", operation_id = "read_mesh_functions", tag = "meshes", params(("id" = String, Path), FunctionsQuery),
    responses(
        (status = 200, description = "the functions", content(("application/x-npy"), ("application/vnd.safetensors"), ("model/gltf-binary"), ("image/png"))),
        (status = 202, description = "the spectrum is queued", body = super::spectra::PendingSpectrum, headers(("Location" = String), ("Retry-After" = u32))),
        (status = 304, description = "unchanged"),
    ),
)]
pub async fn of_mesh(
    app: App,
    Id(id): Id,
    Query(query): Query<FunctionsQuery>,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    answered(&app, Kind::Mesh, id, query, headers).await
}

/// Answers functions of a sketch, as those of a mesh.
#[utoipa::path(
    get, path = "/v1/sketches/{id}/functions", operation_id = "read_sketch_functions", tag = "sketches", params(("id" = String, Path), FunctionsQuery),
    responses(
        (status = 200, description = "the functions", content(("application/x-npy"), ("application/vnd.safetensors"), ("model/gltf-binary"), ("image/png"))),
        (status = 202, description = "the spectrum is queued", body = super::spectra::PendingSpectrum, headers(("Location" = String), ("Retry-After" = u32))),
        (status = 304, description = "unchanged"),
    ),
)]
pub async fn of_sketch(
    app: App,
    Id(id): Id,
    Query(query): Query<FunctionsQuery>,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    answered(&app, Kind::Sketch, id, query, headers).await
}

async fn answered(
    app: &App,
    kind: Kind,
    id: String,
    query: FunctionsQuery,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    let wanted = Wanted::negotiated(headers, &[NPY, SAFETENSORS, GLB, PNG])?;
    let sampling = sampling(&query)?;
    let wide = width(query.width, WIDTH)?;
    let asked = Asked::of(app, kind, id, query.k, query.boundary)?;
    let (spectrum, figure, mesh) = match asked.found(app).await? {
        Found::Spectrum(found) => *found,
        Found::Pending(pending) => return Ok(pending),
    };
    let spectrum = spectrum.at_unit_area(asked.k);
    let columns = query.kind.columns(&spectrum, sampling);
    let all = ![GLB, PNG].contains(&wanted.media_type());
    let column = query.column.unwrap_or(0);
    if !all && column >= columns {
        let detail = format!("there are {columns} of these functions, counted from 0");
        return Err(Problem::not_there("there is no such function", Fault::in_query("column", detail)));
    }
    let shown = if all { 0..columns } else { column..column + 1 };
    let size = figure.of_file().len().saturating_mul(shown.len() * size_of::<f64>());
    if size > LARGEST_ANSWER {
        let detail =
            format!("{} functions of {} vertices are too many for one answer", columns, figure.of_file().len());
        return Err(Problem::refused("the answer would be too large", vec![Fault::in_query("count", detail)]));
    }
    let write = move |media_type| {
        let values = query.kind.at_vertices(&spectrum, sampling, shown);
        match media_type {
            NPY => Ok(functions::npy(&values, &figure)),
            SAFETENSORS => functions::safetensors(&values, &figure),
            GLB => functions::glb(&values, &figure, &mesh),
            _ => functions::png(&values, &figure, &mesh, wide),
        }
    };
    wanted.answer(app, write).await
}

fn sampling(query: &FunctionsQuery) -> Result<Sampling, Problem> {
    let (count, variance) = (query.count.unwrap_or(100), query.variance.unwrap_or(6.0));
    let mut faults = Vec::new();
    if !(1..=MOST_COMPONENTS).contains(&count) {
        faults.push(Fault::in_query("count", format!("must be 1 to {MOST_COMPONENTS}, is {count}")));
    }
    if !(1e-6..=1e6).contains(&variance) {
        faults.push(Fault::in_query("variance", format!("must be 1e-6 to 1e6, is {variance:?}")));
    }
    if faults.is_empty() {
        Ok(Sampling { count, variance })
    } else {
        Err(Problem::refused("there are no such functions", faults))
    }
}

/// How a shape is segmented.
#[derive(Clone, Copy, Debug, Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
#[into_params(parameter_in = Query)]
pub struct SegmentsQuery {
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
    get, path = "/v1/meshes/{id}/segmentation", operation_id = "read_mesh_segmentation", tag = "meshes", params(("id" = String, Path), SegmentsQuery),
    responses(
        (status = 200, description = "the regions", content((Segmentation = "application/json"), ("model/gltf-binary"), ("image/png"))),
        (status = 202, description = "the spectrum is queued", body = super::spectra::PendingSpectrum, headers(("Location" = String), ("Retry-After" = u32))),
        (status = 304, description = "unchanged"),
    ),
)]
pub async fn segments_of_mesh(
    app: App,
    Id(id): Id,
    Query(query): Query<SegmentsQuery>,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    segments(&app, Kind::Mesh, id, query, headers).await
}

/// Answers the consensus segmentation of a sketch, as that of a mesh.
#[utoipa::path(
    get, path = "/v1/sketches/{id}/segmentation", operation_id = "read_sketch_segmentation", tag = "sketches", params(("id" = String, Path), SegmentsQuery),
    responses(
        (status = 200, description = "the regions", content((Segmentation = "application/json"), ("model/gltf-binary"), ("image/png"))),
        (status = 202, description = "the spectrum is queued", body = super::spectra::PendingSpectrum, headers(("Location" = String), ("Retry-After" = u32))),
        (status = 304, description = "unchanged"),
    ),
)]
pub async fn segments_of_sketch(
    app: App,
    Id(id): Id,
    Query(query): Query<SegmentsQuery>,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    segments(&app, Kind::Sketch, id, query, headers).await
}

async fn segments(
    app: &App,
    kind: Kind,
    id: String,
    query: SegmentsQuery,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    let wanted = Wanted::negotiated(headers, &[JSON, GLB, PNG])?;
    let count = query.regions.unwrap_or(7);
    if !(1..=MAX_REGIONS).contains(&count) {
        let fault = Fault::in_query("regions", format!("must be 1 to {MAX_REGIONS}, is {count}"));
        return Err(Problem::refused("there is no such segmentation", vec![fault]));
    }
    let wide = width(query.width, WIDTH)?;
    let asked = Asked::of(app, kind, id, query.k, query.boundary)?;
    let (spectrum, figure, mesh) = match asked.found(app).await? {
        Found::Spectrum(found) => *found,
        Found::Pending(pending) => return Ok(pending),
    };
    let write = move |media_type| {
        // Nobody watches, and so nobody cancels.
        let regions =
            segmented(&spectrum.at_unit_area(asked.k), count, &Unwatched).map_err(|error| error.to_string())?;
        let labels = functions::labels(&regions, &figure);
        let written = match media_type {
            GLB => functions::labelled_glb(&labels, &mesh),
            PNG => functions::labelled_png(&labels, &mesh, wide),
            _ => serde_json::to_vec(&Segmentation { regions: regions.count(), labels })
                .map(Into::into)
                .map_err(Unwritten::from),
        };
        written.map_err(|error| error.to_string())
    };
    wanted.answer(app, write).await
}

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
        (status = 200, description = "the rebuilt shape", content(("model/gltf-binary"), ("application/x-npy"))),
        (status = 202, description = "the spectrum is queued", body = super::spectra::PendingSpectrum, headers(("Location" = String), ("Retry-After" = u32))),
        (status = 304, description = "unchanged"),
    ),
)]
pub async fn rebuilt_mesh(
    app: App,
    Id(id): Id,
    Query(query): Query<RebuiltQuery>,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    places(&app, Kind::Mesh, id, query, headers).await
}

/// Answers a sketch rebuilt of its first k eigenfunctions, as a mesh.
#[utoipa::path(
    get, path = "/v1/sketches/{id}/rebuilt", operation_id = "rebuild_sketch", tag = "sketches", params(("id" = String, Path), RebuiltQuery),
    responses(
        (status = 200, description = "the rebuilt shape", content(("model/gltf-binary"), ("application/x-npy"))),
        (status = 202, description = "the spectrum is queued", body = super::spectra::PendingSpectrum, headers(("Location" = String), ("Retry-After" = u32))),
        (status = 304, description = "unchanged"),
    ),
)]
pub async fn rebuilt_sketch(
    app: App,
    Id(id): Id,
    Query(query): Query<RebuiltQuery>,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    places(&app, Kind::Sketch, id, query, headers).await
}

async fn places(
    app: &App,
    kind: Kind,
    id: String,
    query: RebuiltQuery,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    let wanted = Wanted::negotiated(headers, &[GLB, NPY])?;
    let asked = Asked::of(app, kind, id, query.k, query.boundary)?;
    let (spectrum, figure, mesh) = match asked.found(app).await? {
        Found::Spectrum(found) => *found,
        Found::Pending(pending) => return Ok(pending),
    };
    let write = move |media_type| {
        let places = rebuilt::rebuilt(&spectrum.at_unit_area(asked.k), figure.mesh.positions());
        let places = functions::placed(&places, &figure, &mesh);
        match media_type {
            NPY => Ok(functions::places_npy(&places)),
            _ => functions::places_glb(places, &mesh),
        }
    };
    wanted.answer(app, write).await
}
