//! Matches: asked for, looked at, ended.

use axum::Json;
use axum::response::Response;

use super::asking::{Asked, JobQuery, Submission};
use super::idempotency::Answer;
use super::inline_sketch::InlineSketch;
use super::job_document::MatchDocument;
use super::page::{Listing, PageQuery};
use super::problem::{Fault, Problem};
use super::query::{Id, Query};
use super::{App, Config, asking, memory, resource};
use crate::alignment::prepared::standing::Up;
use crate::intake::json;
use crate::intake::mesh::MeshMeasures;
use crate::jobs::Task;
use crate::pipeline::request::{GivenMap, MatchRequest, Regions};
use crate::pipeline::{self, Settings};
use crate::sketch::outline::OutlineRequest;
use crate::store::{Shape, ShapeKind, Unkept};

/// Asks for a match.
///
/// Only `mesh` and `sketch` are required; the sketch may be drawn in the request itself and is then kept like one uploaded. `Prefer: wait=N` (at most 60) answers a short match in the same response.
#[utoipa::path(
    post, path = "/v1/matches", operation_id = "create_match", tag = "matches",
    params(
        JobQuery,
        ("Prefer" = Option<String>, Header, description = "`wait=N`: seconds to wait for the end of the match"),
        ("Idempotency-Key" = Option<String>, Header, pattern = "^[!-~]{1,255}$", description = "the same key never makes a second match"),
    ),
    request_body = MatchRequest,
    responses(
        (status = 202, description = "queued", body = MatchDocument, headers(("Location" = String), ("Retry-After" = u32))),
        (status = 200, description = "finished within the wait", body = MatchDocument, headers(("Preference-Applied" = String))),
    ),
)]
pub async fn create(app: App, asked: Asked) -> Result<Response, Problem> {
    asking::answered::<Settings, _>(&app, asked, |submission| submitted(&app, submission)).await
}

/// Queues the match that is asked for.
async fn submitted(app: &App, submission: Submission) -> Result<Answer, Problem> {
    let read = submission.body.clone();
    let memory = read.bytes.len().saturating_mul(json::MEMORY_OF_TREE);
    let read = app.with_memory(memory, move || {
        json::parsed_apart::<MatchRequest, OutlineRequest>(&read.bytes, "sketch")
            .map_err(|untaken| untaken.expecting("/sketch", "an id, or an object with `outline`"))
    });
    let (request, drawing) = read.await??;
    let inline = match drawing {
        Some(drawing) => Some(InlineSketch::of(app, drawing).await?),
        None => None,
    };
    let (settings, payload, drawn) = payload(app, request, inline).await?;
    asking::queued::<Settings>(app, &submission, settings.job(&payload), drawn).await
}

/// The request with every value filled in, also in JSON, checked against the shapes it names; and the sketch within it, to
/// be kept where the match is taken.
///
/// # Errors
/// 422 with every fault found.
pub(super) async fn payload(
    app: &App,
    request: MatchRequest,
    inline: Option<InlineSketch>,
) -> Result<(Settings, String, Option<Unkept>), Problem> {
    let mut faults = Vec::new();
    let sketch = match &inline {
        Some(inline) => Some(inline.sketch.mesh().positions().len()),
        None => named(app, ShapeKind::Sketch, &request.sketch, &mut faults).await?.map(|sketch| sketch.vertices),
    };
    let mesh = named(app, ShapeKind::Mesh, &request.mesh, &mut faults).await?;
    let up = mesh.as_ref().and_then(known_up);
    let mesh = mesh.map(|mesh| (mesh.vertices, mesh.matched));
    let config = app.config.clone();
    let settings = app.off_runtime(move || settings(&request, sketch, mesh, &config, faults)).await??;
    let mut settings = settings.standing(up);
    let faults = faults_on_shapes(app, &settings, inline.as_ref()).await?;
    if !faults.is_empty() {
        return Err(unfit(faults));
    }
    let drawn = match inline {
        Some(inline) => Some(inline.unkept(app).await?),
        None => None,
    };
    if let Some(drawn) = &drawn {
        settings.sketch = drawn.id().to_owned();
    }
    let written = app.off_runtime(move || serde_json::to_string(&settings).map(|payload| (settings, payload)));
    let (settings, payload) = written.await?.map_err(Problem::internal)?;
    Ok((settings, payload, drawn))
}

/// 422: the shapes cannot be matched as asked.
fn unfit(faults: Vec<Fault>) -> Problem {
    Problem::refused("the match cannot be carried out as asked", faults)
}

/// The request with every value filled in, for a sketch of these many vertices and a mesh of as many in its file and as many
/// that are computed on.
fn settings(
    request: &MatchRequest,
    sketch: Option<usize>,
    mesh: Option<(usize, usize)>,
    config: &Config,
    mut faults: Vec<Fault>,
) -> Result<Settings, Problem> {
    let settings = Settings::resolve(request);
    if let Ok(settings) = &settings
        && let (Some(sketch), Some((mesh, matched))) = (sketch, mesh)
    {
        faults.extend(pipeline::check(settings, sketch, mesh).into_iter().map(Fault::from));
        faults.extend(memory::faults(settings, sketch, matched, config.max_job_memory));
    }
    match settings {
        Ok(settings) if faults.is_empty() => Ok(settings),
        settings => {
            faults.extend(settings.err().into_iter().flatten().map(Fault::from));
            Err(unfit(faults))
        }
    }
}

/// What is wrong with landmarks, components, labels and given points, for which the shapes themselves are looked at.
async fn faults_on_shapes(
    app: &App,
    settings: &Settings,
    inline: Option<&InlineSketch>,
) -> Result<Vec<Fault>, Problem> {
    let labelled = matches!(settings.regions, Regions::Given { .. });
    let pointed = matches!(settings.given_map, Some(GivenMap::Points { .. }));
    if settings.landmarks.is_empty() && settings.components.is_none() && !labelled && !pointed {
        return Ok(Vec::new());
    }
    let sketch = match inline {
        Some(inline) => Some(inline.sketch.clone()),
        None => app.store.sketch(&settings.sketch).await?,
    };
    let mesh = app.store.mesh(&settings.mesh).await?;
    let (Some(sketch), Some(mesh)) = (sketch, mesh) else { return Ok(Vec::new()) };
    let settings = settings.clone();
    let faults = app.off_runtime(move || pipeline::faults_on_shapes(&settings, &sketch, &mesh)).await?;
    Ok(faults.into_iter().map(Fault::from).collect())
}

/// The shape of this id; where there is none, a fault.
async fn named(app: &App, kind: ShapeKind, id: &str, faults: &mut Vec<Fault>) -> Result<Option<Shape>, Problem> {
    let shape = app.store.shape(kind, id).await?;
    if shape.is_none() {
        let noun = kind.as_str();
        faults.push(Fault::at_pointer(format!("/{noun}"), format!("there is no {noun} of this id")));
    }
    Ok(shape)
}

/// What the answer to the upload of a mesh said is up on it.
fn known_up(mesh: &Shape) -> Option<Up> {
    serde_json::from_value::<MeshMeasures>(mesh.body.clone()).ok()?.up
}

/// Lists the matches, newest first.
#[utoipa::path(
    get, path = "/v1/matches", operation_id = "list_matches", tag = "matches", params(PageQuery),
    responses((status = 200, description = "a page", body = Listing<MatchDocument>)),
)]
pub async fn list(app: App, Query(query): Query<PageQuery>) -> Result<Response, Problem> {
    resource::listed::<Settings>(&app, &query).await
}

/// Tells how far a match is.
#[utoipa::path(
    get, path = "/v1/matches/{id}", operation_id = "read_match", tag = "matches", params(("id" = String, Path)),
    responses((status = 200, description = "the match", body = MatchDocument)),
)]
pub async fn read(app: App, Id(id): Id) -> Result<Json<MatchDocument>, Problem> {
    let job = resource::found::<Settings>(&app, &id).await?;
    Ok(Json(resource::described::<Settings>(&app, job).await?))
}

/// Cancels a match that is queued or running, deletes one that is finished.
#[utoipa::path(
    delete, path = "/v1/matches/{id}", operation_id = "end_match", tag = "matches", params(("id" = String, Path)),
    responses(
        (status = 200, description = "cancelled", body = MatchDocument),
        (status = 204, description = "deleted"),
    ),
)]
pub async fn end(app: App, Id(id): Id) -> Result<Response, Problem> {
    resource::ended::<Settings>(&app, &id).await
}

/// Cancels a match that is queued or running; one that is finished stays as it is.
#[utoipa::path(
    post, path = "/v1/matches/{id}/cancel", operation_id = "cancel_match", tag = "matches", params(("id" = String, Path)),
    responses((status = 200, description = "the match as it now stands", body = MatchDocument)),
)]
pub async fn cancel(app: App, Id(id): Id) -> Result<Json<MatchDocument>, Problem> {
    resource::cancelled::<Settings>(&app, &id).await
}
