//! Functions, labels and colours taken from one shape of a match to the other.

use std::convert::Infallible;
use std::sync::Arc;

use axum::http::{HeaderMap, StatusCode};
use axum::response::Response;
use bytes::Bytes;
use serde::{Deserialize, Serialize};
use utoipa::{IntoParams, ToSchema};

use super::body::JsonBody;
use super::pictures::GLB;
use super::problem::{Fault, Problem};
use super::query::{Id, Query};
use super::representation::{JSON, NPY, Wanted};
use super::{App, keeping, memory, resource, shapes};
use crate::export::transfer;
use crate::intake::{json, sketch as drawings};
use crate::jobs::Caches;
use crate::mesh::file_mesh::FileMesh;
use crate::numerics::Unwatched;
use crate::pipeline::outcome::MatchResult;
use crate::pipeline::{Bases, Settings};
use crate::sketch::{self, Canvas, Sketch};
use crate::store::Kind;
use crate::transfer::request::{By, Given, Moved, Shape, TransferRequest};
use crate::transfer::{by_map, by_points, faults, sketch_vertices, sketch_vertices_by_map};

/// Takes a function, labels or colours given at the vertices of one shape to the other, by the points of a match or by its
/// functional map.
///
/// Nothing is kept: sent again, it is computed again. By `Accept`, `model/gltf-binary` answers the other shape with what came of it as colours of its vertices, and `application/x-npy` a function.
#[utoipa::path(
    post, path = "/v1/matches/{id}/transfers", operation_id = "transfer", tag = "matches", params(("id" = String, Path)),
    request_body = TransferRequest,
    responses(
        (status = 200, description = "what has come of it, at the vertices of the other shape", content(
            (Moved = "application/json"), ("model/gltf-binary"), ("application/x-npy"),
        )),
        (status = 409, description = "not finished, or finished without a result"),
    ),
)]
pub async fn create(app: App, Id(id): Id, headers: HeaderMap, body: JsonBody) -> Result<Response, Problem> {
    let wanted = Wanted::negotiated(headers, &[JSON, GLB, NPY])?;
    let body = Arc::new(body);
    let (taken, read) = (body.bytes.len().saturating_mul(json::MEMORY_OF_TREE), body.clone());
    let request = app.with_memory(taken, move || json::parsed::<TransferRequest>(&read.bytes)).await??;
    let matched = Matched::of(&app, &id).await?;
    let found = faults(&request, &matched.result, matched.mesh.positions().len());
    if !found.is_empty() {
        return Err(unfit(found.into_iter().map(Fault::from).collect()));
    }
    if wanted.media_type() == NPY && !matches!(request.given, Given::Function { .. }) {
        let fault = Fault::in_header("accept", "only a function is an array: application/json or model/gltf-binary");
        return Err(Problem::of_fault(StatusCode::NOT_ACCEPTABLE, fault));
    }
    let canvas =
        if request.given == (Given::Drawing {}) { Some(canvas(&app, &matched.result.sketch).await?) } else { None };
    let taken = memory::of_spectrum(matched.mesh.positions().len(), matched.result.c.rows);
    let spectra = Caches::new(app.store.clone());
    let work = move || {
        let Matched { result, sketch, mesh } = &matched;
        let values = request.given.values(|| {
            let colour = |canvas: &Canvas| result.correspondences.iter().map(|p| canvas.colour_at(p.point)).collect();
            canvas.as_ref().map(colour).unwrap_or_default()
        });
        let moved = match request.by {
            By::Points => by_points(&request, &values, result, mesh),
            By::Map => {
                let bases = Bases::of(sketch, mesh, result, &spectra, &Unwatched).map_err(Problem::internal)?;
                by_map(request.from, &values, &bases, sketch)
            }
        };
        let to = match request.from {
            Shape::Sketch => mesh.clone(),
            Shape::Mesh => FileMesh::from(sketch.mesh().clone()),
        };
        Ok::<_, Problem>((moved, to))
    };
    let memory = app.room_for(taken).await?;
    let (moved, to) = app.at_length(keeping(memory, work)).await??;
    let write = move |media_type| match media_type {
        GLB => transfer::glb(&moved, &to),
        NPY => Ok(transfer::npy(&moved)),
        _ => Ok(serde_json::to_vec(&moved)?.into()),
    };
    wanted.answer_once(&app, write).await
}

fn unfit(faults: Vec<Fault>) -> Problem {
    Problem::refused("this cannot be taken over", faults)
}

/// A match and its shapes.
pub(super) struct Matched {
    pub result: MatchResult,
    pub sketch: Sketch,
    pub mesh: FileMesh,
}

impl Matched {
    pub async fn of(app: &App, id: &str) -> Result<Matched, Problem> {
        let result = resource::result::<Settings>(app, id).await?;
        let read = move || serde_json::from_slice::<MatchResult>(&result).map_err(Problem::internal);
        let result = app.off_runtime(read).await??;
        let (sketch, mesh) = (shapes::sketch(app, &result.sketch).await?, shapes::mesh(app, &result.mesh).await?);
        Ok(Matched { result, sketch, mesh })
    }

    /// The points back as JSON.
    fn inverse(&self, by: By, spectra: &Caches) -> Result<Bytes, Problem> {
        let Matched { result, sketch, mesh } = self;
        let sketch_vertices = match by {
            By::Points => sketch_vertices(result, mesh, false),
            By::Map => {
                let bases = Bases::of(sketch, mesh, result, spectra, &Unwatched).map_err(Problem::internal)?;
                sketch_vertices_by_map(&bases, &Unwatched).map_err(Problem::internal)?
            }
        };
        serde_json::to_vec(&Inverse { sketch_vertices }).map(Bytes::from).map_err(Problem::internal)
    }
}

/// What is seen of the drawing of a sketch.
///
/// # Errors
/// 422 where it has no colours.
async fn canvas(app: &App, sketch: &str) -> Result<Canvas, Problem> {
    let colourless =
        || unfit(vec![Fault::at_pointer("/given/type", "the sketch was uploaded as an outline, which has no colours")]);
    let file = app.store.file(Kind::Sketch, sketch).await?.ok_or_else(colourless)?;
    let limits = sketch::Config::default();
    let kind = drawings::kind(&file.bytes, Some(&file.media_type))?;
    let taken = drawings::memory(&file.bytes, kind, &limits)?;
    app.with_memory(taken, move || drawings::canvas(&file.bytes, kind, &limits)).await?.ok_or_else(colourless)
}

/// What the points back are found by.
#[derive(Clone, Copy, Debug, Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
#[into_params(parameter_in = Query)]
pub struct InverseQuery {
    /// `points` where it is not given.
    #[param(inline)]
    by: Option<By>,
}

/// The points from the mesh back to the sketch.
#[derive(Debug, Serialize, Deserialize, ToSchema)]
pub struct Inverse {
    /// For every vertex of the user's mesh file a vertex of the sketch; null where nothing corresponds.
    sketch_vertices: Vec<Option<usize>>,
}

/// Answers the points of a match from the mesh back to the sketch.
///
/// By `points` a vertex has the vertex of the sketch whose answer is nearest along the surface, up to 0.12 √area; by `map` that whose image under C is nearest in the basis of the mesh.
#[utoipa::path(
    get, path = "/v1/matches/{id}/inverse", operation_id = "read_inverse", tag = "matches", params(("id" = String, Path), InverseQuery),
    responses(
        (status = 200, description = "a vertex of the sketch for every vertex of the mesh", body = Inverse),
        (status = 304, description = "unchanged"),
        (status = 409, description = "not finished, or finished without a result"),
    ),
)]
pub async fn inverse(
    app: App,
    Id(id): Id,
    Query(query): Query<InverseQuery>,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    let by = query.by.unwrap_or_default();
    let wanted = Wanted::negotiated(headers, &[JSON])?;
    let source = resource::result::<Settings>(&app, &id).await?;
    let fetched = async {
        let matched = Matched::of(&app, &id).await?;
        let memory = memory::of_spectrum(matched.mesh.positions().len(), matched.result.c.rows);
        let spectra = Caches::new(app.store.clone());
        let memory = app.room_for(memory).await?;
        let body = app.at_length(keeping(memory, move || matched.inverse(by, &spectra))).await??;
        Ok(move |_| Ok::<_, Infallible>(body))
    };
    wanted.answer_made_of(&app, (source, format!("inverse {by:?}")), fetched).await
}
