//! Poses: asked for, looked at, read, ended.

use std::convert::Infallible;
use std::sync::Arc;

use axum::Json;
use axum::http::{HeaderMap, StatusCode};
use axum::response::Response;
use bytes::Bytes;
use serde::Deserialize;
use serde::de::IgnoredAny;
use utoipa::IntoParams;

use super::body::JsonBody;
use super::idempotency::{Answer, IdempotencyKey, fingerprint};
use super::job_document::PoseDocument;
use super::page::{Listing, PageQuery};
use super::pictures::{GLB, PNG, width};
use super::preference::Wait;
use super::problem::{Fault, Problem};
use super::query::{Id, Query};
use super::representation::{JSON, OCTETS, SAFETENSORS, Wanted};
use super::{App, memory, resource, shapes};
use crate::export::pose;
use crate::intake::json;
use crate::jobs::{Posing, Task};
use crate::mesh::formats::Format;
use crate::picture::WIDTH;
use crate::pipeline::Settings;
use crate::posing::outcome::{HandleWeights, PoseResult};
use crate::posing::request::{MAX_PLACES, PoseRequest};
use crate::posing::{basis as of_handles, faults};
use crate::store::{self, Job, Kind, MEMORY, NewJob};

const OBJ: &str = Format::Obj.media_type();

/// What a pose is asked for with beside its request.
#[derive(Debug, Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
#[into_params(parameter_in = Query)]
pub struct PoseQuery {
    /// A name to list the pose under.
    #[param(max_length = 200)]
    name: Option<String>,
}

/// Asks for a pose: a matched mesh takes the deformation of its sketch.
///
/// The sketch is moved by `handles` (points, bones, cages), to a place for each in every one of the `frames`; or the mesh takes the pose that `sketch` is drawn in. `Prefer: wait=N` (at most 60) answers a short one in the same response.
#[utoipa::path(
    post, path = "/v1/poses", operation_id = "create_pose", tag = "poses",
    params(
        PoseQuery,
        ("Prefer" = Option<String>, Header, description = "`wait=N`: seconds to wait for the end of the pose"),
        ("Idempotency-Key" = Option<String>, Header, pattern = "^[!-~]{1,255}$", description = "the same key never makes a second pose"),
    ),
    request_body = PoseRequest,
    responses(
        (status = 202, description = "queued", body = PoseDocument, headers(("Location" = String), ("Retry-After" = u32))),
        (status = 200, description = "finished within the wait", body = PoseDocument, headers(("Preference-Applied" = String))),
    ),
)]
pub async fn create(
    app: App,
    Query(query): Query<PoseQuery>,
    key: IdempotencyKey,
    wait: Wait,
    body: JsonBody,
) -> Result<Response, Problem> {
    let name = shapes::name(query.name, None)?;
    let body = Arc::new(body);
    let (printed, named) = (body.clone(), name.clone().unwrap_or_default());
    let print = app.off_runtime(move || fingerprint("POST /v1/poses", &[&printed.bytes, named.as_bytes()])).await?;
    let request = submitted(&app, body, name, key.dedupe(&print));
    resource::asked::<Posing>(&app, &key, &print, &wait, request).await
}

/// Queues the pose that `body` asks for.
async fn submitted(
    app: &App,
    body: Arc<JsonBody>,
    name: Option<String>,
    dedupe: Option<String>,
) -> Result<Answer, Problem> {
    let (memory, read) = (body.bytes.len().saturating_mul(json::MEMORY_OF_TREE), body.clone());
    let request = app.with_memory(memory, move || json::parsed::<PoseRequest>(&read.bytes)).await??;
    let task = task(app, request).await?;
    let payload = serde_json::to_string(&task).map_err(Problem::internal)?;
    let job = NewJob { name: name.as_deref(), dedupe: dedupe.as_deref(), taken_for: MEMORY, ..task.job(&payload) };
    resource::queued::<Posing>(app, app.queued(&job, None).await?).await
}

/// What is to be done for a request.
///
/// # Errors
/// 422 with every fault found.
async fn task(app: &App, request: PoseRequest) -> Result<Posing, Problem> {
    let matched = match of_match(app, &request.matching).await? {
        Ok(matched) => matched,
        Err(detail) => return Err(unfit(vec![Fault::at_pointer("/match", detail)])),
    };
    let (mesh, sketch) = (matched.mesh.unwrap_or_default(), matched.sketch.unwrap_or_default());
    let mut found = Vec::new();
    if let Some(other) = request.sketch.as_ref().filter(|other| **other != sketch) {
        let detail = format!(
            "the match is of {sketch}, not of {other}: for the pose of another drawing match it with the mesh, and name that match"
        );
        found.push(Fault::at_pointer("/sketch", detail));
    }
    let vertices = app.store.shape(Kind::Mesh, &mesh).await?.map(|shape| shape.vertices);
    let frames = request.frames.as_ref().map_or(1, Vec::len);
    if let Some(vertices) = vertices {
        if frames.saturating_mul(vertices) > MAX_PLACES {
            let most = MAX_PLACES / vertices.max(1);
            let detail =
                format!("{frames} frames of {vertices} vertices are too many for one answer: up to {most} fit");
            found.push(Fault::at_pointer("/frames", detail));
        }
        let excess = memory::excess_of_pose(vertices, app.config.max_job_memory);
        found.extend(excess.map(|detail| Fault::at_pointer("/match", detail)));
    }
    let Some(flat) = app.store.sketch(&sketch).await? else {
        return Err(unfit(vec![Fault::at_pointer("/match", "the sketch of the match was deleted")]));
    };
    if vertices.is_none() {
        return Err(unfit(vec![Fault::at_pointer("/match", "the mesh of the match was deleted")]));
    }
    let (request, on_sketch) = app
        .off_runtime(move || {
            let faults = faults(&request, &flat);
            (request, faults)
        })
        .await?;
    found.extend(on_sketch.into_iter().map(Fault::from));
    if found.is_empty() { Ok(Posing { request, mesh, sketch }) } else { Err(unfit(found)) }
}

/// The match of this id that succeeded; or why there is none to pose by.
async fn of_match(app: &App, id: &str) -> Result<Result<Job, String>, Problem> {
    let Some(job) = app.store.job(id).await?.filter(|job| job.kind == Settings::NAME) else {
        return Ok(Err("there is no match of this id".to_owned()));
    };
    Ok(if job.state == store::State::Succeeded { Ok(job) } else { Err(resource::resultless::<Settings>(&job)) })
}

/// 422: the mesh cannot be posed as asked.
fn unfit(faults: Vec<Fault>) -> Problem {
    Problem::refused("the mesh cannot be posed as asked", faults)
}

/// Lists the poses, newest first.
#[utoipa::path(
    get, path = "/v1/poses", operation_id = "list_poses", tag = "poses", params(PageQuery),
    responses((status = 200, description = "a page", body = Listing<PoseDocument>)),
)]
pub async fn list(app: App, Query(query): Query<PageQuery>) -> Result<Response, Problem> {
    resource::listed::<Posing>(&app, &query).await
}

/// Tells how far a pose is.
#[utoipa::path(
    get, path = "/v1/poses/{id}", operation_id = "read_pose", tag = "poses", params(("id" = String, Path)),
    responses((status = 200, description = "the pose", body = PoseDocument)),
)]
pub async fn read(app: App, Id(id): Id) -> Result<Json<PoseDocument>, Problem> {
    let job = resource::found::<Posing>(&app, &id).await?;
    Ok(Json(resource::described::<Posing>(&app, job).await?))
}

/// Cancels a pose that is queued or running, deletes one that is finished.
#[utoipa::path(
    delete, path = "/v1/poses/{id}", operation_id = "end_pose", tag = "poses", params(("id" = String, Path)),
    responses(
        (status = 200, description = "cancelled", body = PoseDocument),
        (status = 204, description = "deleted"),
    ),
)]
pub async fn end(app: App, Id(id): Id) -> Result<Response, Problem> {
    resource::ended::<Posing>(&app, &id).await
}

/// Cancels a pose that is queued or running; one that is finished stays as it is.
#[utoipa::path(
    post, path = "/v1/poses/{id}/cancel", operation_id = "cancel_pose", tag = "poses", params(("id" = String, Path)),
    responses((status = 200, description = "the pose as it now stands", body = PoseDocument)),
)]
pub async fn cancel(app: App, Id(id): Id) -> Result<Json<PoseDocument>, Problem> {
    resource::cancelled::<Posing>(&app, &id).await
}

/// Which frame is answered.
#[derive(Clone, Copy, Debug, Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
#[into_params(parameter_in = Query)]
pub struct FrameQuery {
    /// Counted from 0; the first where it is not given. JSON and GLB hold all.
    #[param(maximum = 1000)]
    frame: Option<usize>,
}

/// Answers the result of a pose.
///
/// JSON holds all of it. By `Accept`, `model/obj` answers one frame as the file that was uploaded, if it was an OBJ, with its
/// vertices in their new places, and `model/gltf-binary` all of them: one as the mesh, several as morph targets with an
/// animation.
#[utoipa::path(
    get, path = "/v1/poses/{id}/result", operation_id = "read_pose_result", tag = "poses",
    params(("id" = String, Path), FrameQuery),
    responses(
        (status = 200, description = "the result", body = PoseResult),
        (status = 304, description = "unchanged"),
        (status = 409, description = "not finished, or finished without a result"),
    ),
)]
pub async fn result(
    app: App,
    Id(id): Id,
    Query(query): Query<FrameQuery>,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    let wanted = Wanted::negotiated(headers, &[JSON, OBJ, GLB])?;
    let result = resource::result::<Posing>(&app, &id).await?;
    let contents = Contents::of(&app, &result).await?;
    let frame = contents.frame(query.frame)?;
    if wanted.media_type() == JSON {
        return wanted.answer(&app, move |_| Ok::<_, Infallible>(result)).await;
    }
    let wanted = wanted.made_of(&app, result.clone(), format!("frame {frame}")).await?;
    if let Some(unchanged) = wanted.unchanged() {
        return Ok(unchanged);
    }
    let mesh = shapes::mesh(&app, &contents.mesh).await?;
    let file = app.store.file(Kind::Mesh, &contents.mesh).await?.filter(|file| file.media_type == OBJ);
    let write = move |media_type| match media_type {
        OBJ => pose::obj(&result, frame, &mesh, file.as_ref().map(|file| file.bytes.as_ref())),
        _ => pose::glb(&result, &mesh),
    };
    wanted.answer(&app, write).await
}

/// Numbers of the largest basis that is answered: 24 MB, which is 40 handles and 50,000 vertices.
const LARGEST_BASIS: usize = 6_000_000;

/// Answers the basis in which a pose is linear in the maps of its handles, for a page that drags them.
///
/// `basis` has a row for every vertex of the file and three numbers for every handle, of a cage for every corner. With
/// (a b c / d e f) the maps, in the coordinates of the sketch's upload, vertex v is at rest[v] + (X − places[v, 0]) axes[0] +
/// (Y − places[v, 1]) axes[1], X being the sum of its numbers times (a b c) and Y that times (d e f). All are of single
/// precision.
#[utoipa::path(
    get, path = "/v1/poses/{id}/basis", operation_id = "read_pose_basis", tag = "poses", params(("id" = String, Path)),
    responses(
        (status = 200, description = "`basis`, `rest`, `places` and `axes`", content(("application/vnd.safetensors"), ("application/octet-stream"))),
        (status = 304, description = "unchanged"),
        (status = 409, description = "not finished, or finished without a result; or of no handles; or its match was deleted"),
        (status = 413, description = "too large"),
    ),
)]
pub async fn basis(app: App, Id(id): Id, headers: HeaderMap) -> Result<Response, Problem> {
    let wanted = Wanted::negotiated(headers, &[SAFETENSORS, OCTETS])?;
    let result = resource::result::<Posing>(&app, &id).await?;
    let contents = Contents::of(&app, &result).await?;
    let wanted = wanted.made_of(&app, result, "basis".to_owned()).await?;
    if let Some(unchanged) = wanted.unchanged() {
        return Ok(unchanged);
    }
    let Some(weights) = contents.weights else {
        return Err(Problem::new(StatusCode::CONFLICT, "the pose is by no handles"));
    };
    let (sketch, mesh) = (shapes::sketch(&app, &contents.sketch).await?, shapes::mesh(&app, &contents.mesh).await?);
    let numbers = 3 * weights.values.first().map_or(0, Vec::len);
    if numbers.saturating_mul(mesh.positions().len()) > LARGEST_BASIS {
        let detail = format!("a basis has at most {LARGEST_BASIS} numbers: use fewer handles");
        return Err(Problem::new(StatusCode::PAYLOAD_TOO_LARGE, detail));
    }
    let memory = memory::of_pose(mesh.positions().len());
    let matched = resource::result::<Settings>(&app, &contents.matching).await?;
    let write = move || {
        let matched = serde_json::from_slice(&matched).map_err(Problem::internal)?;
        let basis = of_handles(&sketch, &mesh, &matched, &weights).map_err(Problem::internal)?;
        pose::basis(&basis, &mesh).map_err(Problem::internal)
    };
    let body = app.with_memory(memory, write).await??;
    wanted.answer(&app, move |_| Ok::<_, Infallible>(body)).await
}

/// How the picture of a pose is to be.
#[derive(Clone, Copy, Debug, Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
#[into_params(parameter_in = Query)]
pub struct PosePictureQuery {
    /// Counted from 0; the first where it is not given.
    #[param(maximum = 1000)]
    frame: Option<usize>,
    /// Its width in pixels; 1600 where it is not given.
    #[param(minimum = 100, maximum = 4000)]
    width: Option<u32>,
}

/// Answers a picture of a pose: the sketch as it was moved, the mesh as it is seen in it, and the mesh from 60° beside, in
/// the colours of the match.
#[utoipa::path(
    get, path = "/v1/poses/{id}/picture", operation_id = "draw_pose", tag = "poses",
    params(("id" = String, Path), PosePictureQuery),
    responses(
        (status = 200, description = "the picture", content(("image/png"), ("application/octet-stream"))),
        (status = 304, description = "unchanged"),
        (status = 409, description = "not finished, or finished without a result; or its match was deleted"),
    ),
)]
pub async fn picture(
    app: App,
    Id(id): Id,
    Query(query): Query<PosePictureQuery>,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    let wanted = Wanted::negotiated(headers, &[PNG, OCTETS])?;
    let width = width(query.width, WIDTH)?;
    let result = resource::result::<Posing>(&app, &id).await?;
    let contents = Contents::of(&app, &result).await?;
    let frame = contents.frame(query.frame)?;
    let wanted = wanted.made_of(&app, result.clone(), format!("picture of {frame}, {width}")).await?;
    if let Some(unchanged) = wanted.unchanged() {
        return Ok(unchanged);
    }
    let matched = resource::result::<Settings>(&app, &contents.matching).await?;
    let (sketch, mesh) = (shapes::sketch(&app, &contents.sketch).await?, shapes::mesh(&app, &contents.mesh).await?);
    wanted.answer(&app, move |_| pose::png(&result, frame, &matched, &sketch, &mesh, width)).await
}

/// What a result is of, and how many frames it has.
#[derive(Deserialize)]
struct Contents {
    #[serde(rename = "match")]
    matching: String,
    sketch: String,
    mesh: String,
    weights: Option<HandleWeights>,
    frames: Vec<IgnoredAny>,
}

impl Contents {
    async fn of(app: &App, result: &Bytes) -> Result<Contents, Problem> {
        let read = result.clone();
        app.off_runtime(move || serde_json::from_slice(&read)).await?.map_err(Problem::internal)
    }

    /// The frame asked for, the first by default.
    ///
    /// # Errors
    /// 404 where there is no such frame.
    fn frame(&self, asked: Option<usize>) -> Result<usize, Problem> {
        let frame = asked.unwrap_or(0);
        if frame < self.frames.len() {
            return Ok(frame);
        }
        let fault = Fault::in_query("frame", format!("the result has {} frames, counted from 0", self.frames.len()));
        Err(Problem::not_there("there is no such frame", fault))
    }
}
