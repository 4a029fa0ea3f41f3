//! Functions, labels and colours taken from one shape of a match to the other.

use std::convert::Infallible;
use std::sync::Arc;

use axum::http::{HeaderMap, StatusCode};
use axum::response::Response;
use bytes::Bytes;
use serde::{Deserialize, Serialize};
use utoipa::{IntoParams, ToSchema};

use super::body::JsonBody;
use super::held::Held;
use super::media_types::{GLB, JSON, NPY};
use super::problem::{Fault, Problem};
use super::query::{Id, Query};
use super::representation::Wanted;
use super::{App, memory, resource, shapes};
use crate::export::{Unwritten, transfer};
use crate::intake::{json, sketch as drawings};
use crate::jobs::Caches;
use crate::mesh::file_mesh::FileMesh;
use crate::numerics::Unwatched;
use crate::pipeline::outcome::MatchResult;
use crate::pipeline::{Bases, Settings};
use crate::sketch::{self, Canvas, Sketch};
use crate::store::{self, ShapeKind, SourceFile};
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
    let result = outcome(&app, resource::result::<Settings>(&app, &id).await?).await?;
    let vertices = shapes::stored(&app, ShapeKind::Mesh, &result.mesh).await?.vertices;
    let found = faults(&request, &result, vertices);
    if !found.is_empty() {
        return Err(unfit(found.into_iter().map(Fault::from).collect()));
    }
    if wanted.media_type() == NPY && !matches!(request.given, Given::Function { .. }) {
        let fault = Fault::in_header("accept", "only a function is an array: application/json or model/gltf-binary");
        return Err(Problem::of_fault(StatusCode::NOT_ACCEPTABLE, fault));
    }
    let drawing =
        if request.given == (Given::Drawing {}) { Some(Drawing::of(&app, &result.sketch).await?) } else { None };
    let (rows, drawn) = (result.c.rows, drawing.as_ref().map_or(0, |drawing| drawing.memory));
    let besides = |mesh: &store::Shape| memory::of_spectrum(mesh.vertices, rows).saturating_add(drawn);
    let matched = Matched::of(&app, result, besides).await?;
    let spectra = matched.spectra(&app);
    let media_type = wanted.media_type();
    let work = move || {
        let (result, (sketch, mesh)) = (&matched.result, &*matched.shapes);
        let canvas = drawing.map(|drawing| drawing.canvas()).transpose()?;
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
        match (media_type, request.from) {
            (GLB, Shape::Sketch) => transfer::glb(&moved, mesh),
            (GLB, Shape::Mesh) => transfer::glb(&moved, &FileMesh::from(sketch.mesh().clone())),
            (NPY, _) => Ok(transfer::npy(&moved)),
            _ => serde_json::to_vec(&moved).map(Bytes::from).map_err(Unwritten::from),
        }
        .map_err(Problem::internal)
    };
    let body = app.at_length(work).await??;
    wanted.answer_once(&app, move |_| Ok::<_, Infallible>(body)).await
}

fn unfit(faults: Vec<Fault>) -> Problem {
    Problem::refused("this cannot be taken over", faults)
}

/// What a match found, read.
pub(super) async fn outcome(app: &App, result: Bytes) -> Result<MatchResult, Problem> {
    app.off_runtime(move || serde_json::from_slice(&result).map_err(Problem::internal)).await?
}

/// What a match found, and its shapes.
pub(super) struct Matched {
    pub result: MatchResult,
    pub shapes: Held<(Sketch, FileMesh)>,
}

impl Matched {
    /// With room for so many bytes besides the shapes, as the mesh tells.
    pub async fn of(
        app: &App,
        result: MatchResult,
        besides: impl FnOnce(&store::Shape) -> usize,
    ) -> Result<Matched, Problem> {
        let shapes = shapes::both(app, (&result.sketch, &result.mesh), besides).await?;
        Ok(Matched { result, shapes })
    }

    /// The spectra that it is looked at by.
    pub fn spectra(&self, app: &App) -> Caches {
        Caches::of_match(app.store.clone(), &self.result.mesh, &self.result.sketch)
    }

    /// The points back as JSON.
    fn inverse(&self, by: By, spectra: &Caches) -> Result<Bytes, Problem> {
        let (result, (sketch, mesh)) = (&self.result, &*self.shapes);
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

/// The drawing of a sketch, and the bytes of memory that it takes to see it, about.
struct Drawing {
    bytes: Bytes,
    kind: drawings::Drawing,
    memory: usize,
}

impl Drawing {
    /// # Errors
    /// 422 where there is none, or the sketch was deleted.
    async fn of(app: &App, sketch: &str) -> Result<Drawing, Problem> {
        if app.store.shape(ShapeKind::Sketch, sketch).await?.is_none() {
            return Err(unfit(vec![Fault::at_pointer("/given/type", "the sketch of the match was deleted")]));
        }
        let SourceFile { bytes, media_type } =
            app.store.file(ShapeKind::Sketch, sketch).await?.ok_or_else(colourless)?;
        let kind = drawings::kind(&bytes, Some(&media_type))?;
        let memory = drawings::memory(&bytes, kind, &sketch::Config::default())?;
        Ok(Drawing { bytes, kind, memory })
    }

    /// What is seen of it.
    ///
    /// # Errors
    /// 422 where it has no colours.
    fn canvas(&self) -> Result<Canvas, Problem> {
        drawings::canvas(&self.bytes, self.kind, &sketch::Config::default()).ok_or_else(colourless)
    }
}

fn colourless() -> Problem {
    unfit(vec![Fault::at_pointer("/given/type", "the sketch was uploaded as an outline, which has no colours")])
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
        let result = outcome(&app, source.clone()).await?;
        let rows = result.c.rows;
        let matched = Matched::of(&app, result, |mesh| memory::of_spectrum(mesh.vertices, rows)).await?;
        let spectra = matched.spectra(&app);
        let body = app.at_length(move || matched.inverse(by, &spectra)).await??;
        Ok(move |_| Ok::<_, Infallible>(body))
    };
    wanted.answer_made_of(&app, (source.clone(), format!("inverse {by:?}")), fetched).await
}
