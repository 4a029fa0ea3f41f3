//! The result of a match as it is kept.

use axum::http::StatusCode;
use bytes::Bytes;

use super::App;
use super::matches::found;
use super::problem::Problem;
use crate::store::{Job, State};

/// The result of a match as it was written.
///
/// # Errors
/// 404 where there is no such match, 409 where it has no result.
pub async fn of_match(app: &App, id: &str) -> Result<Bytes, Problem> {
    let job = found(app, id).await?;
    if job.state != State::Succeeded {
        return Err(unavailable(&job));
    }
    app.store.result(id).await?.ok_or_else(|| Problem::not_found(format_args!("result of match {id}")))
}

/// 409: why there is no result.
fn unavailable(job: &Job) -> Problem {
    let reason = job.error.as_ref().and_then(|error| error.get("detail")?.as_str());
    match (job.state, reason) {
        (State::Cancelled, _) => Problem::new(StatusCode::CONFLICT, "the match was cancelled"),
        (_, Some(reason)) => Problem::new(StatusCode::CONFLICT, format!("the match failed: {reason}")),
        (state, None) if state.finished() => Problem::new(StatusCode::CONFLICT, "the match failed"),
        _ => Problem::new(StatusCode::CONFLICT, "the match is not finished").retry_after(1),
    }
}
