//! What a match was computed from and found, together.

use std::convert::Infallible;

use axum::http::{HeaderMap, StatusCode};
use axum::response::Response;
use bytes::Bytes;

use super::media_types::{OCTETS, SAFETENSORS};
use super::problem::Problem;
use super::query::Id;
use super::representation::Wanted;
use super::transfers::{Matched, outcome};
use super::{App, memory, resource};
use crate::export::inside;
use crate::numerics::Unwatched;
use crate::pipeline::{Inside, Settings, functions};
use crate::store::Shape;

/// Numbers of A and B together at most: half a gigabyte.
const LARGEST: usize = 1 << 26;

/// Answers A, B, W, C⁰, C, the points, regions and eigenvalues of a match in one file of safetensors.
///
/// `a` (k × q) and `b` (l × q) are the coefficients of the corresponding functions as the solver saw them, by `part_indicator` those of the part that was found, `w` and `initial_c` (l × k) the weights and the start, `c` the map after any refinement, `points` a vertex of the user's mesh for every vertex of the sketch, `sketch_regions` and `mesh_regions` labels, `sketch_eigenvalues` and `mesh_eigenvalues` those at area 1. With `joint_diagonalisation` all but `w` is of the eigenfunctions: `w`, and `solver.objective` of the result, are of the coupled bases, and do not go together with `c` here.
#[utoipa::path(
    get, path = "/v1/matches/{id}/inside", operation_id = "read_inside", tag = "matches", params(("id" = String, Path)),
    responses(
        (status = 200, description = "the arrays", content(("application/vnd.safetensors"), ("application/octet-stream"))),
        (status = 304, description = "unchanged"),
        (status = 409, description = "not finished, or finished without a result"),
        (status = 413, description = "too large"),
    ),
)]
pub async fn read(app: App, Id(id): Id, headers: HeaderMap) -> Result<Response, Problem> {
    let wanted = Wanted::negotiated(headers, &[SAFETENSORS, OCTETS])?;
    let source = resource::result::<Settings>(&app, &id).await?;
    let fetched = async {
        let body = made(&app, source.clone()).await?;
        Ok(move |_| Ok::<_, Infallible>(body))
    };
    wanted.answer_made_of(&app, (source.clone(), "inside".to_owned()), fetched).await
}

async fn made(app: &App, result: Bytes) -> Result<Bytes, Problem> {
    let result = outcome(app, result).await?;
    let numbers = functions(&result).saturating_mul(result.request.basis.k + result.request.basis.k_mesh);
    if numbers > LARGEST {
        let detail = format!("A and B have {numbers} numbers, {LARGEST} are the most that are answered");
        return Err(Problem::new(StatusCode::PAYLOAD_TOO_LARGE, detail));
    }
    let k = result.request.basis.k_mesh;
    // The blocks, A and B made of them, and the file.
    let besides = |mesh: &Shape| memory::of_spectrum(mesh.vertices, k) + 3 * size_of::<f64>() * numbers;
    let matched = Matched::of(app, result, besides).await?;
    let spectra = matched.spectra(app);
    let write = move || {
        let (result, (sketch, mesh)) = (&matched.result, &*matched.shapes);
        let found = Inside::of(sketch, mesh, result, &spectra, &Unwatched).map_err(Problem::internal)?;
        inside::safetensors(&found, result).map_err(Problem::internal)
    };
    app.at_length(write).await?
}
