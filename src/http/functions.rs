//! What shapes are described by, to be looked at: eigenfunctions and signatures.

use axum::http::HeaderMap;
use axum::response::Response;
use serde::Deserialize;
use utoipa::IntoParams;

use super::App;
use super::media_types::{GLB, NPY, OCTETS, PNG, SAFETENSORS};
use super::memory::LARGEST_ANSWER;
use super::pictures::width;
use super::problem::{Fault, Problem};
use super::query::{Id, Query};
use super::representation::Wanted;
use super::spectra::{Decomposed, Found, SpectrumOfShape};
use crate::descriptors::functions::{Family, Sampling};
use crate::export::functions;
use crate::pipeline::settings::{MAX_SIGNATURE, SIGNATURE, VARIANCE};
use crate::spectral::Boundary;
use crate::store::ShapeKind;

/// Pixels across, where nobody asks for others.
pub(super) const WIDTH: u32 = 600;

/// Which functions of a shape, and how they are to come.
#[derive(Clone, Copy, Debug, Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
#[into_params(parameter_in = Query)]
pub struct FunctionsQuery {
    #[param(inline)]
    kind: Family,
    /// Eigenpairs they are made of; 20 where it is not given.
    #[param(minimum = 1, maximum = 1000000)]
    k: Option<usize>,
    /// `neumann` where it is not given.
    boundary: Option<Boundary>,
    /// Times or energies of a kernel; 100 where it is not given.
    #[param(minimum = 1, maximum = 1000)]
    count: Option<usize>,
    /// Width of an energy's band of the wave kernel in spacings; 6 where it is not given.
    #[param(minimum = 1e-6, maximum = 1000000)]
    variance: Option<f64>,
    /// Which of them is shown where they come as colours, counted from 0; the first where it is not given.
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
        (status = 200, description = "the functions", content(("application/x-npy"), ("application/vnd.safetensors"), ("model/gltf-binary"), ("image/png"), ("application/octet-stream"))),
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
    answered(&app, ShapeKind::Mesh, id, query, headers).await
}

/// Answers functions of a sketch, as those of a mesh.
#[utoipa::path(
    get, path = "/v1/sketches/{id}/functions", operation_id = "read_sketch_functions", tag = "sketches", params(("id" = String, Path), FunctionsQuery),
    responses(
        (status = 200, description = "the functions", content(("application/x-npy"), ("application/vnd.safetensors"), ("model/gltf-binary"), ("image/png"), ("application/octet-stream"))),
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
    answered(&app, ShapeKind::Sketch, id, query, headers).await
}

async fn answered(
    app: &App,
    kind: ShapeKind,
    id: String,
    query: FunctionsQuery,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    let wanted = Wanted::negotiated(headers, &[NPY, SAFETENSORS, GLB, PNG, OCTETS])?;
    let sampling = sampling(&query)?;
    let wide = width(query.width, WIDTH)?;
    let asked = SpectrumOfShape::of(app, kind, id, query.k, query.boundary)?;
    let found = match asked.found(app, query.kind.most_columns(asked.k, sampling)).await? {
        Found::Spectrum(found) => found,
        Found::Pending(pending) => return Ok(pending),
    };
    let at_unit_area = move |found: Decomposed| Decomposed { spectrum: found.spectrum.at_unit_area(asked.k), ..found };
    let found = app.off_runtime(move || found.map(at_unit_area)).await?;
    let (columns, vertices) = (query.kind.columns(&found.spectrum, sampling), found.figure.of_file().len());
    let all = ![GLB, PNG].contains(&wanted.media_type());
    let column = query.column.unwrap_or(0);
    if !all && column >= columns {
        let detail = format!("there are {columns} of these functions, counted from 0");
        return Err(Problem::not_there("there is no such function", Fault::in_query("column", detail)));
    }
    let shown = if all { 0..columns } else { column..column + 1 };
    let size = vertices.saturating_mul(shown.len() * size_of::<f64>());
    if size > LARGEST_ANSWER {
        let detail = format!("{columns} functions of {vertices} vertices are too many for one answer");
        return Err(Problem::refused("the answer would be too large", vec![Fault::in_query("count", detail)]));
    }
    let write = move |media_type| {
        let Decomposed { spectrum, figure, mesh } = &*found;
        let values = query.kind.at_vertices(spectrum, sampling, shown);
        match media_type {
            NPY | OCTETS => Ok(functions::npy(&values, figure)),
            SAFETENSORS => functions::safetensors(&values, figure),
            GLB => functions::glb(&values, figure, mesh),
            _ => functions::png(&values, figure, mesh, wide),
        }
    };
    wanted.answer(app, write).await
}

fn sampling(query: &FunctionsQuery) -> Result<Sampling, Problem> {
    let (count, variance) = (query.count.unwrap_or(SIGNATURE), query.variance.unwrap_or(VARIANCE));
    let mut faults = Vec::new();
    let is_kernel = matches!(query.kind, Family::HeatKernel | Family::WaveKernel);
    if query.count.is_some() && !is_kernel {
        faults.push(Fault::in_query("count", "only functions of a kernel are as many as are asked for"));
    }
    if query.variance.is_some() && query.kind != Family::WaveKernel {
        faults.push(Fault::in_query("variance", "only bands of the wave kernel have a width"));
    }
    if !(1..=MAX_SIGNATURE).contains(&count) {
        faults.push(Fault::in_query("count", format!("must be 1 to {MAX_SIGNATURE}, is {count}")));
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
