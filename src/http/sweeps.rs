//! Many matches that differ in one value, asked for together.

use std::sync::Arc;

use axum::http::StatusCode;
use axum::response::{IntoResponse, Response};
use serde::{Deserialize, Serialize};
use serde_json::Value;
use utoipa::ToSchema;

use super::body::JsonBody;
use super::idempotency::{Answer, IdempotencyKey, fingerprint};
use super::job_document::MatchDocument;
use super::problem::{Fault, Problem};
use super::{App, matches, resource, shapes};
use crate::intake::json;
use crate::jobs::Task;
use crate::pipeline::Settings;
use crate::pipeline::request::MatchRequest;
use crate::store::{MEMORY, NewJob, Priority};

/// Values at most.
const MOST: usize = 64;

/// A match request, the place in it that varies, and the values it takes there.
#[derive(Clone, Debug, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct SweepRequest {
    /// As `POST /v1/matches` takes it, the sketch by its id.
    #[schema(value_type = MatchRequest)]
    request: Value,
    /// JSON pointer to a member of the request, such as `/regulariser/gamma`; objects on the way are made where there are
    /// none.
    #[schema(pattern = "^(/[^/]+)+$")]
    pointer: String,
    #[schema(min_items = 1, max_items = 64)]
    values: Vec<Value>,
}

/// The matches that were queued, in the order of the values.
#[derive(Serialize, ToSchema)]
pub struct Sweep {
    matches: Vec<MatchDocument>,
}

/// Asks for a match for each of several values of one member of the request.
///
/// Every request is checked before any is queued. They are matches like others, each named after its value, to be followed and read by themselves; their priority is `batch`.
#[utoipa::path(
    post, path = "/v1/sweeps", operation_id = "create_sweep", tag = "matches",
    params(("Idempotency-Key" = Option<String>, Header, pattern = "^[!-~]{1,255}$", description = "the same key never makes the matches twice")),
    request_body = SweepRequest,
    responses((status = 202, description = "queued", body = Sweep)),
)]
pub async fn create(app: App, key: IdempotencyKey, body: JsonBody) -> Result<Response, Problem> {
    let body = Arc::new(body);
    let printed = body.clone();
    let print = app.off_runtime(move || fingerprint("POST /v1/sweeps", &[&printed.bytes])).await?;
    Ok(key.once(&app.store, &print, submitted(&app, body)).await?.into_response())
}

async fn submitted(app: &App, body: Arc<JsonBody>) -> Result<Answer, Problem> {
    let memory = body.bytes.len().saturating_mul(json::MEMORY_OF_TREE);
    let sweep = app.with_memory(memory, move || json::parsed::<SweepRequest>(&body.bytes)).await??;
    if !(1..=MOST).contains(&sweep.values.len()) {
        let fault = Fault::at_pointer("/values", format!("must be 1 to {MOST}, are {}", sweep.values.len()));
        return Err(unfit(vec![fault]));
    }
    let mut ready = Vec::new();
    for (i, value) in sweep.values.iter().enumerate() {
        let request = varied(&sweep, value)?.to_string();
        let request = json::parsed::<MatchRequest>(request.as_bytes());
        let request = request.map_err(|problem| of_value(i, problem.into()))?;
        let (settings, payload, _) =
            matches::payload(app, request, None).await.map_err(|problem| of_value(i, problem))?;
        ready.push((settings, payload, format!("{} = {value}", sweep.pointer)));
    }
    let mut matches: Vec<MatchDocument> = Vec::new();
    let mut queued = Vec::new();
    for (settings, payload, name) in &ready {
        let name = shapes::shortened(name);
        let priority = Priority::Batch;
        let job = NewJob { name: Some(&name), taken_for: MEMORY, priority, ..settings.job(payload) };
        match app.queued(&job, None).await {
            Ok(job) => {
                queued.push(job.id.clone());
                matches.push(resource::described::<Settings>(app, job).await?);
            }
            Err(problem) => {
                // All or none: those that are queued are not what was asked for.
                for id in queued {
                    app.store.cancel(&id).await?;
                }
                return Err(problem);
            }
        }
    }
    Answer::json(StatusCode::ACCEPTED, None, &Sweep { matches })
}

fn unfit(faults: Vec<Fault>) -> Problem {
    Problem::refused("the matches cannot be carried out as asked", faults)
}

/// A refusal of the request with one of the values: its faults lie in the request.
fn of_value(i: usize, problem: Problem) -> Problem {
    let detail = format!("with value {i}: {}", problem.detail);
    let within = |fault: Fault| Fault { pointer: fault.pointer.map(|pointer| format!("/request{pointer}")), ..fault };
    Problem { detail, errors: problem.errors.into_iter().map(within).collect(), ..problem }
}

/// The request with a value at the pointer.
fn varied(sweep: &SweepRequest, value: &Value) -> Result<Value, Problem> {
    let mut request = sweep.request.clone();
    let wrong = |detail: &str| unfit(vec![Fault::at_pointer("/pointer", detail)]);
    let path = sweep.pointer.strip_prefix('/').ok_or_else(|| wrong("must begin with /"))?;
    let mut place = &mut request;
    for token in path.split('/') {
        let token = token.replace("~1", "/").replace("~0", "~");
        place = match place {
            Value::Object(members) => members.entry(token).or_insert_with(|| Value::Object(serde_json::Map::new())),
            Value::Array(items) => {
                let item = token.parse::<usize>().ok().and_then(|i| items.get_mut(i));
                item.ok_or_else(|| wrong("leads to no item of a list"))?
            }
            _ => return Err(wrong("leads through what is neither an object nor a list")),
        };
    }
    *place = value.clone();
    Ok(request)
}
