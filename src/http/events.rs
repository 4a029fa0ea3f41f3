//! The course of a job as server-sent events.

use std::convert::Infallible;

use axum::http::{HeaderMap, StatusCode};
use axum::response::sse::{Event, KeepAlive, Sse};
use axum::response::{IntoResponse, Response};
use futures::stream::{self, Stream};

use super::App;
use super::job_document::{MatchDocument, PoseDocument};
use super::problem::{Fault, Problem};
use super::query::Id;
use super::resource::{self, Resource};
use crate::jobs::Posing;
use crate::pipeline::Settings;
use crate::store::{Job, JobChanges};

/// Streams the changes of a match until it is finished.
///
/// One event `status` per change, its data the match, its id the revision. `Last-Event-ID` leaves out what was seen;
/// where nothing can follow, the answer is 204, which tells an `EventSource` not to come again.
#[utoipa::path(
    get, path = "/v1/matches/{id}/events", operation_id = "follow_match", tag = "matches",
    params(("id" = String, Path), ("Last-Event-ID" = Option<i64>, Header, description = "the id of the last event seen")),
    responses(
        (
            status = 200, content_type = "text/event-stream", body = MatchDocument,
            description = "events with `event` (`status`), `id` (the revision) and `data` (the match as JSON)",
        ),
        (status = 204, description = "the last event was seen"),
    ),
)]
pub async fn of_match(app: App, Id(id): Id, headers: HeaderMap) -> Result<Response, Problem> {
    followed::<Settings>(app, id, &headers).await
}

/// Streams the changes of a pose until it is finished, as those of a match.
#[utoipa::path(
    get, path = "/v1/poses/{id}/events", operation_id = "follow_pose", tag = "poses",
    params(("id" = String, Path), ("Last-Event-ID" = Option<i64>, Header, description = "the id of the last event seen")),
    responses(
        (
            status = 200, content_type = "text/event-stream", body = PoseDocument,
            description = "events with `event` (`status`), `id` (the revision) and `data` (the pose as JSON)",
        ),
        (status = 204, description = "the last event was seen"),
    ),
)]
pub async fn of_pose(app: App, Id(id): Id, headers: HeaderMap) -> Result<Response, Problem> {
    followed::<Posing>(app, id, &headers).await
}

async fn followed<T: Resource + 'static>(app: App, id: String, headers: &HeaderMap) -> Result<Response, Problem> {
    let seen = last_event_id(headers)?;
    let job = resource::found::<T>(&app, &id).await?;
    if job.state.finished() && job.revision <= seen {
        return Ok(StatusCode::NO_CONTENT.into_response());
    }
    let changes = app.store.job_changes(&id);
    // What is ahead of the job was never sent: it is told from its beginning.
    let seen = if seen > job.revision { -1 } else { seen };
    let events = events::<T>(Course { app, id, seen, changes, ended: false });
    Ok(Sse::new(events).keep_alive(KeepAlive::default()).into_response())
}

/// The revision the client saw last, −1 where it saw none.
fn last_event_id(headers: &HeaderMap) -> Result<i64, Problem> {
    let Some(value) = headers.get("last-event-id") else { return Ok(-1) };
    let revision = value.to_str().ok().and_then(|value| value.parse().ok());
    revision.ok_or_else(|| Problem::malformed(Fault::in_header("last-event-id", "an event id here is an integer")))
}

/// Where one client is in the course of a job.
struct Course {
    app: App,
    id: String,
    seen: i64,
    changes: JobChanges,
    ended: bool,
}

fn events<T: Resource>(course: Course) -> impl Stream<Item = Result<Event, Infallible>> {
    stream::unfold(course, |mut course| async move {
        let job = course.next().await?;
        course.seen = job.revision;
        course.ended = job.state.finished();
        let event = Event::default().event("status").id(job.revision.to_string());
        let event = event.json_data(T::document(job, None)).ok()?;
        Some((Ok(event), course))
    })
}

impl Course {
    /// The job at its next revision; nothing after its end, its deletion or the end of the server.
    async fn next(&mut self) -> Option<Job> {
        while !self.ended {
            let job = self.app.store.job(&self.id).await.ok()??;
            if job.revision > self.seen {
                return Some(job);
            }
            if job.state.finished() || !self.app.change(&mut self.changes).await {
                return None;
            }
        }
        None
    }
}
