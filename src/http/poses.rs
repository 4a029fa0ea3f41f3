//! Poses: asked for, looked at, ended.

use axum::Json;
use axum::response::Response;

use super::asking::{Asked, JobQuery, Submission};
use super::idempotency::Answer;
use super::job_document::PoseDocument;
use super::page::{Listing, PageQuery};
use super::problem::{Fault, Problem};
use super::query::{Id, Query};
use super::{App, asking, memory, resource};
use crate::intake::json;
use crate::jobs::{Posing, Task};
use crate::pipeline::Settings;
use crate::posing::faults;
use crate::posing::request::{MAX_PLACES, PoseRequest};
use crate::store::{self, Job, ShapeKind};

/// Asks for a pose: a matched mesh takes the deformation of its sketch.
///
/// The sketch is moved by `handles` (points, bones, cages), to a place for each in every one of the `frames`; or the mesh takes the pose that `sketch` is drawn in. `Prefer: wait=N` (at most 60) answers a short one in the same response.
#[utoipa::path(
    post, path = "/v1/poses", operation_id = "create_pose", tag = "poses",
    params(
        JobQuery,
        ("Prefer" = Option<String>, Header, description = "`wait=N`: seconds to wait for the end of the pose"),
        ("Idempotency-Key" = Option<String>, Header, pattern = "^[!-~]{1,255}$", description = "the same key never makes a second pose"),
    ),
    request_body = PoseRequest,
    responses(
        (status = 202, description = "queued", body = PoseDocument, headers(("Location" = String), ("Retry-After" = u32))),
        (status = 200, description = "finished within the wait", body = PoseDocument, headers(("Preference-Applied" = String))),
    ),
)]
pub async fn create(app: App, asked: Asked) -> Result<Response, Problem> {
    asking::answered::<Posing, _>(&app, asked, |submission| submitted(&app, submission)).await
}

/// Queues the pose that is asked for.
async fn submitted(app: &App, submission: Submission) -> Result<Answer, Problem> {
    let read = submission.body.clone();
    let memory = read.bytes.len().saturating_mul(json::MEMORY_OF_TREE);
    let request = app.with_memory(memory, move || json::parsed::<PoseRequest>(&read.bytes)).await??;
    let task = task(app, request).await?;
    let payload = serde_json::to_string(&task).map_err(Problem::internal)?;
    asking::queued::<Posing>(app, &submission, task.job(&payload), None).await
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
    let vertices = app.store.shape(ShapeKind::Mesh, &mesh).await?.map(|shape| (shape.vertices, shape.matched));
    let frames = request.frames.as_ref().map_or(1, Vec::len);
    if let Some((vertices, matched)) = vertices {
        if frames.saturating_mul(vertices) > MAX_PLACES {
            let most = MAX_PLACES / vertices.max(1);
            let detail =
                format!("{frames} frames of {vertices} vertices are too many for one answer: up to {most} fit");
            found.push(Fault::at_pointer("/frames", detail));
        }
        let excess = memory::excess_of_pose(matched, app.config.max_job_memory);
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
