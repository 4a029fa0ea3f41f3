//! How a job is asked for: once under its key, and waited for as long as the client prefers.

use std::future::Future;
use std::sync::Arc;
use std::time::Duration;

use axum::extract::{FromRequest, FromRequestParts, Request};
use axum::http::{HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Response};
use serde::Deserialize;
use tokio::time::{Instant, timeout_at};
use utoipa::IntoParams;

use super::body::JsonBody;
use super::idempotency::{Answer, IdempotencyKey, fingerprint};
use super::preference::{PREFERENCE_APPLIED, Wait};
use super::problem::{Fault, Problem};
use super::query::Query;
use super::resource::{LOOK_AGAIN, Resource, address, described};
use super::{App, Service, shapes};
use crate::store::{Job, MEMORY, NewJob, Priority, Unkept};

/// What a job is asked for with beside its request.
#[derive(Debug, Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
#[into_params(parameter_in = Query)]
pub struct JobQuery {
    /// A name to list it under.
    #[param(max_length = 200)]
    name: Option<String>,
    /// `batch` comes after what somebody waits for, `interactive`.
    #[serde(default)]
    #[param(inline)]
    priority: Priority,
    /// Address that is told when the job ends, `https://` at one of the hosts this server may call; docs/service.md has how.
    #[param(max_length = 2000)]
    webhook: Option<String>,
}

/// A request for a job, as it came.
pub struct Asked {
    query: JobQuery,
    key: IdempotencyKey,
    wait: Wait,
    body: JsonBody,
}

impl FromRequest<Service> for Asked {
    type Rejection = Problem;

    async fn from_request(request: Request, service: &Service) -> Result<Asked, Problem> {
        let (mut parts, body) = request.into_parts();
        let Query(query) = Query::from_request_parts(&mut parts, service).await?;
        let key = IdempotencyKey::from_request_parts(&mut parts, service).await?;
        let Ok(wait) = Wait::from_request_parts(&mut parts, service).await;
        let body = JsonBody::from_request(Request::from_parts(parts, body), service).await?;
        Ok(Asked { query, key, wait, body })
    }
}

/// What is to be put into the queue: the request, unread, and the names of its job.
pub struct Submission {
    pub body: Arc<JsonBody>,
    name: Option<String>,
    dedupe: Option<String>,
    priority: Priority,
    webhook: Option<String>,
}

/// The answer to a request for a job that `submitted` puts into the queue: carried out once under its key, and waited for
/// as long as the client prefers.
pub async fn answered<T: Resource, F>(
    app: &App,
    asked: Asked,
    submitted: impl FnOnce(Submission) -> F,
) -> Result<Response, Problem>
where
    F: Future<Output = Result<Answer, Problem>>,
{
    let Asked { query, key, wait, body } = asked;
    let name = shapes::name(query.name.clone())?;
    let JobQuery { priority, webhook, .. } = query;
    if let Some(Err(reason)) = webhook.as_deref().map(|address| app.config.webhook_hosts.address(address)) {
        let fault = Fault::in_query("webhook", reason);
        return Err(Problem::refused("nobody can be told of the end of the job as asked", vec![fault]));
    }
    let body = Arc::new(body);
    let (printed, named, call) = (body.clone(), name.clone().unwrap_or_default(), format!("POST {}", T::PATH));
    let told = webhook.clone();
    let print = move || {
        let parts = [&printed.bytes, named.as_bytes()].into_iter().chain(told.as_deref().map(str::as_bytes));
        // No address is that.
        let turn = (priority == Priority::Batch).then_some(b"batch".as_slice());
        fingerprint(&call, &parts.chain(turn).collect::<Vec<_>>())
    };
    let print = app.off_runtime(print).await?;
    let submission = Submission { body, name, dedupe: key.dedupe(&print), priority, webhook };
    let answer = key.once(&app.store, &print, submitted(submission)).await?;
    let location = answer.location.clone().unwrap_or_default();
    let Some(patience) = wait.duration() else { return Ok(accepted(answer)) };
    let id = location.trim_start_matches(T::PATH).trim_start_matches('/');
    let mut response = match waited_for(app, id, patience).await? {
        Some(job) if job.state.finished() => {
            Answer::json(StatusCode::OK, Some(location), &described::<T>(app, job).await?)?.into_response()
        }
        Some(job) => accepted(Answer::json(StatusCode::ACCEPTED, Some(location), &described::<T>(app, job).await?)?),
        None => accepted(answer),
    };
    let applied = wait.0.and_then(|seconds| HeaderValue::try_from(format!("wait={seconds}")).ok());
    response.headers_mut().extend(applied.map(|applied| (PREFERENCE_APPLIED, applied)));
    Ok(response)
}

/// 202 with the time to look again.
fn accepted(answer: Answer) -> Response {
    let mut response = answer.into_response();
    response.headers_mut().insert(header::RETRY_AFTER, HeaderValue::from(LOOK_AGAIN));
    response
}

/// The job once it is finished, or as it is when `patience` is at its end or the server stops; nothing where it was deleted.
async fn waited_for(app: &App, id: &str, patience: Duration) -> Result<Option<Job>, Problem> {
    let deadline = Instant::now() + patience;
    let mut changes = app.store.job_changes(id);
    let mut waits = true;
    loop {
        let job = app.store.job(id).await?;
        let unfinished = job.as_ref().is_some_and(|job| !job.state.finished());
        if !(waits && unfinished) {
            return Ok(job);
        }
        waits = timeout_at(deadline, app.change(&mut changes)).await == Ok(true);
    }
}

/// Puts the job of a submission into the queue, with the sketch that was drawn within the request; 202 with what is told
/// of it.
pub async fn queued<T: Resource>(
    app: &App,
    submission: &Submission,
    job: NewJob<'_>,
    drawn: Option<Unkept>,
) -> Result<Answer, Problem> {
    let (name, dedupe) = (submission.name.as_deref(), submission.dedupe.as_deref());
    let (priority, webhook) = (submission.priority, submission.webhook.as_deref());
    let job = NewJob { name, dedupe, priority, webhook, taken_for: MEMORY, ..job };
    let job = app.queued(&job, drawn).await?;
    Answer::json(StatusCode::ACCEPTED, Some(address::<T>(&job.id)), &described::<T>(app, job).await?)
}
