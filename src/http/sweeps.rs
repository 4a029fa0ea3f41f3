//! Many matches that differ in one value, asked for together.

use std::sync::Arc;

use axum::http::StatusCode;
use axum::response::{IntoResponse, Response};
use serde::ser::{Error, SerializeSeq};
use serde::{Deserialize, Serialize, Serializer};
use serde_json::Value;
use utoipa::ToSchema;

use super::body::JsonBody;
use super::held::Held;
use super::idempotency::{Answer, IdempotencyKey, fingerprint};
use super::job_document::MatchDocument;
use super::problem::{Fault, Problem};
use super::resource::Resource;
use super::shapes::shortened;
use super::turns::keeping;
use super::{App, matches};
use crate::intake::{Untaken, json};
use crate::jobs::Task;
use crate::pipeline::Settings;
use crate::pipeline::request::MatchRequest;
use crate::store::{Job, MEMORY, NewJob, Priority};

/// Values at most.
const MOST: usize = 64;

/// The requests may together be as long as so many of the longest that is taken: of labels for every vertex of a large mesh 64
/// fit, and what is kept of them, queued in one transaction and told in one answer stays some tens of megabytes.
const LONGEST: usize = 4;

/// Bytes of memory per byte of a request for its settings, their text in the queue and that in the answer: a digit and its comma
/// are a number of eight bytes, and may be written in four letters.
const MEMORY_OF_REQUEST: usize = 8;

/// A match request, the place in it that varies, and the values it takes there.
#[derive(Clone, Debug, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct SweepRequest {
    /// As `POST /v1/matches` takes it, the sketch by its id.
    #[schema(value_type = MatchRequest)]
    request: Value,
    /// JSON pointer to a member of the request, such as `/regulariser/gamma` of one that names the regulariser's `type`; objects
    /// on the way are made where there are none.
    #[schema(pattern = "^(/[^/]+)+$")]
    pointer: String,
    #[schema(min_items = 1, max_items = 64)]
    values: Vec<Value>,
}

/// The matches that were queued, in the order of the values.
#[derive(Serialize, ToSchema)]
pub struct Sweep {
    #[serde(serialize_with = "one_after_another")]
    #[schema(value_type = Vec<MatchDocument>)]
    matches: Vec<(Job, String)>,
}

/// Writes what is told of matches, whose requests are as in the queue: the tree of one at a time.
fn one_after_another<S: Serializer>(matches: &[(Job, String)], out: S) -> Result<S::Ok, S::Error> {
    let mut list = out.serialize_seq(Some(matches.len()))?;
    for (job, payload) in matches {
        let request = serde_json::from_str(payload).map_err(S::Error::custom)?;
        list.serialize_element(&Settings::document(job.clone(), Some(request)))?;
    }
    list.end()
}

/// Asks for a match for each of several values of one member of the request.
///
/// Every request is checked before any is queued, and all are or none. They are matches like others, each named after its value, to be followed and read by themselves; their priority is `batch`. The requests may together be as long as four of the longest that are taken.
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
    Ok(key.once(&app.store, &print, submitted(&app, (&key, &print), body)).await?.into_response())
}

async fn submitted(app: &App, (key, print): (&IdempotencyKey, &str), body: Arc<JsonBody>) -> Result<Answer, Problem> {
    let sweep = read(app, body).await?;
    let mut asked = Vec::new();
    for i in 0..sweep.values.len() {
        let of = sweep.clone();
        let (request, name) = app.off_runtime(move || of.request(i)).await??;
        let (settings, payload, _) =
            matches::payload(app, request, None).await.map_err(|problem| of_value(i, problem))?;
        asked.push((settings, payload, name, key.dedupe(&format!("{print} {i}"))));
    }
    let jobs = asked.iter().map(|(settings, payload, name, dedupe)| NewJob {
        name: Some(name),
        dedupe: dedupe.as_deref(),
        taken_for: MEMORY,
        priority: Priority::Batch,
        ..settings.job(payload)
    });
    let jobs = app.queued_together(Settings::NAME, &jobs.collect::<Vec<_>>()).await?;
    let matches = jobs.into_iter().zip(asked).map(|(job, (_, payload, ..))| (job, payload)).collect();
    app.off_runtime(keeping(sweep, move || Answer::json(StatusCode::ACCEPTED, None, &Sweep { matches }))).await?
}

/// The sweep, with room for it and for all that is made of it.
///
/// # Errors
/// Whatever is wrong with it as a whole.
async fn read(app: &App, body: Arc<JsonBody>) -> Result<Arc<Held<SweepRequest>>, Problem> {
    let most = LONGEST.saturating_mul(app.config.max_request_bytes);
    let room = app.room_for(memory(body.bytes.len(), most)).await?;
    let places = app.most_together(Settings::NAME);
    let checked = move || {
        let sweep = json::parsed::<SweepRequest>(&body.bytes)?;
        sweep.check(most, places)?;
        Ok(Arc::new(Held::new(sweep, room)))
    };
    app.off_runtime(checked).await?
}

/// Bytes of memory that a sweep of this length takes, about, whose requests may have so many together: the trees of all that
/// was sent and of one request, and what is made of every request.
fn memory(length: usize, most: usize) -> usize {
    let trees = length.saturating_mul(2 * json::MEMORY_OF_TREE);
    trees.saturating_add(length.saturating_mul(MOST).min(most).saturating_mul(MEMORY_OF_REQUEST))
}

impl SweepRequest {
    /// # Errors
    /// 422 where it has no values, or too many or more than there are places for, or requests that are together longer than
    /// `most`.
    fn check(&self, most: usize, places: usize) -> Result<(), Problem> {
        let wrong = |detail: String| Err(unfit(vec![Fault::at_pointer("/values", detail)]));
        let count = self.values.len();
        if !(1..=MOST).contains(&count) {
            return wrong(format!("must be 1 to {MOST}, are {count}"));
        }
        if count > places {
            return wrong(format!(
                "are {count}, and no more than {places} matches may wait here: ask for fewer at a time"
            ));
        }
        let values: usize = self.values.iter().map(|value| value.to_string().len()).sum();
        let length = count * self.request.to_string().len() + values;
        if length > most {
            return wrong(format!(
                "the requests are {length} bytes together, {most} are taken: ask for fewer at a time"
            ));
        }
        Ok(())
    }

    /// The request with one of the values, and what the match is called.
    fn request(&self, i: usize) -> Result<(MatchRequest, String), Problem> {
        let value = &self.values[i];
        let request = varied(self, value)?.to_string();
        let request = json::parsed::<MatchRequest>(request.as_bytes());
        let name = shortened(&format!("{} = {value}", self.pointer));
        // One that is drawn in the request would be kept for each value.
        let refused = |untaken: Untaken| of_value(i, untaken.expecting("/sketch", "the id of a sketch").into());
        Ok((request.map_err(refused)?, name))
    }
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

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use axum::body::{Body, to_bytes};
    use axum::extract::{FromRequest, FromRequestParts, Request};
    use serde_json::json;

    use super::*;
    use crate::http::testing::app;
    use crate::http::{Config, Service};
    use crate::mesh::solids::sheet;
    use crate::sketch::{Sketch, YAxis};
    use crate::store::testing::{fresh, source};
    use crate::store::{Page, Retention};

    #[tokio::test]
    async fn a_sweep_whose_process_died_before_its_answer_was_kept_is_not_made_again() {
        let (_directory, store) = fresh().await;
        let flat = sheet(8, 6);
        let sketch = Sketch::new(flat.clone(), YAxis::Up).unwrap();
        let sketch = store.insert_sketch(sketch, source("s"), None, json!({})).await.unwrap().0.id;
        let mesh = store.insert_mesh(flat.into(), source("m"), None, json!({})).await.unwrap().0.id;
        let app = app(store.clone(), Config::default());
        let sweep = json!({"request": {"mesh": mesh, "sketch": sketch}, "pointer": "/basis/k", "values": [5, 6, 6]});
        let ask = async || {
            let request = Request::post("/v1/sweeps").header("content-type", "application/json");
            let request = request.header("idempotency-key", "one").body(Body::from(sweep.to_string())).unwrap();
            let (mut parts, body) = request.into_parts();
            let key = IdempotencyKey::from_request_parts(&mut parts, &()).await.ok().unwrap();
            let request = Request::from_parts(parts, body);
            let body = JsonBody::from_request(request, &Service(app.clone())).await.ok().unwrap();
            let answer = create(app.clone(), key, body).await.ok().unwrap();
            assert_eq!((answer.status(), app.reading_bytes()), (StatusCode::ACCEPTED, 0));
            to_bytes(answer.into_body(), 1 << 20).await.unwrap()
        };
        let first = ask().await;
        store.let_go(&Retention { answers: Some(Duration::ZERO), ..Retention::default() }).await.unwrap();
        assert_eq!(ask().await, first);
        assert_eq!(store.jobs(Settings::NAME, &Page { after: None, limit: 9 }).await.unwrap().len(), 3);
    }

    #[test]
    fn a_sweep_takes_memory_by_what_is_sent_and_by_what_may_be_made_of_it() {
        assert_eq!(memory(100, 1 << 20), 100 * 2 * json::MEMORY_OF_TREE + 6400 * MEMORY_OF_REQUEST);
        assert_eq!(memory(100, 400), 100 * 2 * json::MEMORY_OF_TREE + 400 * MEMORY_OF_REQUEST);
    }
}
