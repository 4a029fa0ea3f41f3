//! What kinds of jobs have in common that have an address: how they are found, listed, read and ended.

use axum::Json;
use axum::http::StatusCode;
use axum::response::{IntoResponse, Response};
use bytes::Bytes;
use serde::Serialize;
use serde_json::Value;

use super::App;
use super::page::{PageQuery, cursor_fault};
use super::problem::Problem;
use crate::jobs::Task;
use crate::store::{Job, State};

/// Seconds after which to look at an unfinished job again.
pub const LOOK_AGAIN: u32 = 1;

/// A kind of job that has an address.
pub trait Resource: Task {
    /// The noun in messages.
    const NOUN: &'static str;
    /// Where they are listed.
    const PATH: &'static str;
    /// What is told of one.
    type Document: Serialize;

    /// What is told of a job; with its payload in JSON also what was asked for.
    fn document(job: Job, payload: Option<Value>) -> Self::Document;
}

/// The address of a job.
pub fn address<T: Resource>(id: &str) -> String {
    format!("{}/{id}", T::PATH)
}

/// The job of this id.
///
/// # Errors
/// 404 where there is none of this kind.
pub async fn found<T: Resource>(app: &App, id: &str) -> Result<Job, Problem> {
    let job = app.store.job(id).await?.filter(|job| job.kind == T::NAME);
    job.ok_or_else(|| missing::<T>(id))
}

fn missing<T: Resource>(id: &str) -> Problem {
    Problem::not_found(format_args!("{} {id}", T::NOUN))
}

/// What is told of a job by itself: also what was asked for.
pub async fn described<T: Resource>(app: &App, job: Job) -> Result<T::Document, Problem> {
    let payload = app.store.payload(&job.id).await?;
    let payload = payload.map(|payload| serde_json::from_str(&payload)).transpose().map_err(Problem::internal)?;
    Ok(T::document(job, payload))
}

/// A page of the jobs of a kind, newest first.
pub async fn listed<T: Resource>(app: &App, query: &PageQuery) -> Result<Response, Problem> {
    let jobs = app.store.jobs(T::NAME, &query.page()?).await.map_err(cursor_fault)?;
    query.listing(T::PATH, jobs, Job::cursor, |job| Ok(T::document(job, None)))
}

/// Cancels a job that is queued or running, deletes one that is finished.
pub async fn ended<T: Resource>(app: &App, id: &str) -> Result<Response, Problem> {
    let job = found::<T>(app, id).await?;
    if !job.state.finished() {
        return Ok(cancelled::<T>(app, id).await?.into_response());
    }
    app.store.delete(id).await?;
    Ok(StatusCode::NO_CONTENT.into_response())
}

/// Cancels a job that is queued or running; one that is finished stays as it is.
pub async fn cancelled<T: Resource>(app: &App, id: &str) -> Result<Json<T::Document>, Problem> {
    found::<T>(app, id).await?;
    let job = app.store.cancel(id).await?.ok_or_else(|| missing::<T>(id))?;
    Ok(Json(described::<T>(app, job).await?))
}

/// The result of a job as it was written.
///
/// # Errors
/// 404 where there is no such job, 409 where it has no result, 410 where the result's time was over.
pub async fn result<T: Resource>(app: &App, id: &str) -> Result<Bytes, Problem> {
    let job = found::<T>(app, id).await?;
    if job.state != State::Succeeded {
        let problem = Problem::new(StatusCode::CONFLICT, resultless::<T>(&job));
        return Err(if job.state.finished() { problem } else { problem.retry_after(LOOK_AGAIN) });
    }
    let gone = || format!("the result of {} {id} was kept for its time and is deleted: ask for it again", T::NOUN);
    app.store.result(id).await?.ok_or_else(|| Problem::new(StatusCode::GONE, gone()))
}

/// What the result of a job that runs looks like at first sight, once that is known.
///
/// # Errors
/// 404 where there is no such job.
pub async fn preview<T: Resource>(app: &App, id: &str) -> Result<Option<Bytes>, Problem> {
    found::<T>(app, id).await?;
    Ok(app.store.previewed(id).await?)
}

/// Why a job has no result, in words.
pub fn resultless<T: Resource>(job: &Job) -> String {
    let (noun, reason) = (T::NOUN, job.error.as_ref().and_then(|error| error.get("detail")?.as_str()));
    match (job.state, reason) {
        (State::Cancelled, _) => format!("the {noun} was cancelled"),
        (_, Some(reason)) => format!("the {noun} failed: {reason}"),
        (state, None) if state.finished() => format!("the {noun} failed"),
        _ => format!("the {noun} is not finished"),
    }
}
