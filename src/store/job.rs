use std::fmt::Display;
use std::sync::Arc;
use std::time::Duration;

use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use sqlx::any::AnyRow;
use sqlx::{FromRow, Row};
use utoipa::ToSchema;

use super::page;
use crate::access::Tenant;

/// Where a job stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum State {
    Queued,
    Running,
    Succeeded,
    Failed,
    Cancelled,
}

impl State {
    const ALL: [State; 5] = [State::Queued, State::Running, State::Succeeded, State::Failed, State::Cancelled];

    /// The name it is stored under.
    pub const fn as_str(self) -> &'static str {
        match self {
            State::Queued => "queued",
            State::Running => "running",
            State::Succeeded => "succeeded",
            State::Failed => "failed",
            State::Cancelled => "cancelled",
        }
    }

    /// True when it will not change any more.
    pub const fn finished(self) -> bool {
        matches!(self, State::Succeeded | State::Failed | State::Cancelled)
    }

    /// The state of this name, if there is one.
    pub(super) fn named(name: &str) -> Option<State> {
        State::ALL.into_iter().find(|state| state.as_str() == name)
    }
}

/// Whose turn comes first.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum Priority {
    /// Somebody waits for it.
    #[default]
    Interactive,
    /// It comes after those that somebody waits for.
    Batch,
}

impl Priority {
    /// The name it is told by.
    pub const fn as_str(self) -> &'static str {
        match self {
            Priority::Interactive => "interactive",
            Priority::Batch => "batch",
        }
    }

    /// The number it is stored as, by which jobs are sorted.
    pub(super) const fn rank(self) -> i64 {
        match self {
            Priority::Interactive => 0,
            Priority::Batch => 1,
        }
    }
}

/// A job as it stood when it was read. Times are milliseconds since 1970 by the database's clock.
#[derive(Clone, Debug, PartialEq)]
pub struct Job {
    /// A version 7 UUID.
    pub id: String,
    /// Whose it is.
    pub tenant: Tenant,
    /// What it does, by name.
    pub kind: String,
    /// The name under which no other job is queued until this one has ended.
    pub dedupe: Option<String>,
    pub state: State,
    pub priority: Priority,
    /// What it is called by who asked for it.
    pub name: Option<String>,
    /// The trace in which it was asked for, in the form of W3C Trace Context.
    pub trace: Option<String>,
    /// The shapes it needs.
    pub mesh: Option<String>,
    pub sketch: Option<String>,
    /// Which it is of those of its tenant and kind that wait, from 1; nothing where it does not wait.
    pub place: Option<i64>,
    /// How often it was claimed, and the token that fences off those who claimed it earlier.
    pub attempt: i64,
    pub stage: Option<String>,
    /// How much of it is done, in `[0, 1]`.
    pub fraction: f64,
    /// Grows by one with every change of state or progress.
    pub revision: i64,
    /// Why it failed, as a problem of RFC 9457.
    pub error: Option<Value>,
    pub created_ms: i64,
    pub started_ms: Option<i64>,
    pub finished_ms: Option<i64>,
}

impl Job {
    /// What is read of a row: all but the payload, which may be large and is the worker's alone.
    pub(super) const COLUMNS: &str = "id, tenant, kind, dedupe, state, priority, trace, name, mesh, sketch, attempt, stage, fraction, revision, error, created_ms, started_ms, finished_ms, \
         CASE WHEN state = 'queued' THEN (SELECT count(*) FROM jobs AS ahead WHERE ahead.state = 'queued' \
         AND ahead.tenant = jobs.tenant AND ahead.kind = jobs.kind AND (ahead.priority, ahead.created_ms, ahead.id) <= (jobs.priority, jobs.created_ms, jobs.id)) END AS place";

    /// The `Page::after` of the page that begins behind this job.
    pub fn cursor(&self) -> String {
        page::cursor(self.created_ms, &self.id)
    }
}

impl<'r> FromRow<'r, AnyRow> for Job {
    fn from_row(row: &'r AnyRow) -> Result<Job, sqlx::Error> {
        let error: Option<&str> = row.try_get("error")?;
        Ok(Job {
            id: row.try_get("id")?,
            tenant: row.try_get::<&str, _>("tenant")?.parse().map_err(sqlx::Error::decode)?,
            kind: row.try_get("kind")?,
            dedupe: row.try_get("dedupe")?,
            state: State::named(row.try_get("state")?).ok_or_else(unknown_state)?,
            priority: match row.try_get::<i64, _>("priority")? {
                0 => Priority::Interactive,
                _ => Priority::Batch,
            },
            trace: row.try_get("trace")?,
            name: row.try_get("name")?,
            mesh: row.try_get("mesh")?,
            sketch: row.try_get("sketch")?,
            place: row.try_get("place")?,
            attempt: row.try_get("attempt")?,
            stage: row.try_get("stage")?,
            fraction: row.try_get("fraction")?,
            revision: row.try_get("revision")?,
            error: error.map(serde_json::from_str).transpose().map_err(sqlx::Error::decode)?,
            created_ms: row.try_get("created_ms")?,
            started_ms: row.try_get("started_ms")?,
            finished_ms: row.try_get("finished_ms")?,
        })
    }
}

fn unknown_state() -> sqlx::Error {
    sqlx::Error::Decode("unknown state of a job".into())
}

/// A job to be put into the queue.
#[derive(Clone, Copy, Debug)]
pub struct NewJob<'a> {
    /// What it does, by name.
    pub kind: &'a str,
    /// What is to be done, in JSON.
    pub payload: &'a str,
    /// The shapes it needs, which have to be there.
    pub mesh: Option<&'a str>,
    pub sketch: Option<&'a str>,
    /// What it is called by who asked for it.
    pub name: Option<&'a str>,
    /// A name that no other unfinished job has.
    pub dedupe: Option<&'a str>,
    /// For how long the name is taken, whatever becomes of the job.
    pub taken_for: Duration,
    /// Bytes of memory it takes, about, for each vertex of the larger of its shapes.
    pub bytes_per_vertex: usize,
    /// Bytes it takes besides, about, however large they are.
    pub bytes_besides: usize,
    pub priority: Priority,
    /// Address that is told of its end.
    pub webhook: Option<&'a str>,
    /// The trace in which it is asked for, in the form of W3C Trace Context.
    pub trace: Option<&'a str>,
}

impl<'a> NewJob<'a> {
    /// A job that needs no shape, has no name and tells nobody of its end.
    pub const fn of(kind: &'a str, payload: &'a str) -> NewJob<'a> {
        NewJob {
            kind,
            payload,
            mesh: None,
            sketch: None,
            name: None,
            dedupe: None,
            taken_for: Duration::ZERO,
            bytes_per_vertex: 0,
            bytes_besides: 0,
            priority: Priority::Interactive,
            webhook: None,
            trace: None,
        }
    }
}

/// How many jobs may wait.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Places {
    /// In the whole queue.
    pub queue: usize,
    /// Of the kind that is submitted.
    pub of_kind: usize,
}

/// What became of a job that was submitted, or of several that were submitted together.
#[derive(Clone, Debug, PartialEq)]
pub enum Submitted<T = Box<Job>> {
    /// It waits, or the job of this name that was there before stands for it.
    Taken(T),
    /// No place is free.
    Full,
    /// A shape it needs is not there.
    Gone,
}

/// What a failed job keeps as its error: a problem of RFC 9457 whose type is its status.
pub fn problem(status: u16, title: &str, detail: impl Display) -> Value {
    json!({ "type": "about:blank", "title": title, "status": status, "detail": detail.to_string() })
}

/// The right to work on a job, until the lease runs out or the job is cancelled.
#[derive(Clone, Debug)]
pub struct Lease {
    /// The job as it was claimed; its `attempt` is the fencing token.
    pub job: Job,
    /// What is to be done, in JSON.
    pub payload: Arc<str>,
    /// How many tries it has used up, this one included.
    pub(super) tries: i64,
    /// Bytes of memory it takes, about.
    pub memory: u64,
    /// Whether a process has ended before it did, which may have been its doing: nothing else is to run beside it.
    pub suspect: bool,
}

/// What a node has free for another job.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Room {
    /// Bytes of memory.
    pub memory: u64,
    /// Whether nothing else runs: then any job may, whatever it takes.
    pub alone: bool,
}

impl<'r> FromRow<'r, AnyRow> for Lease {
    fn from_row(row: &'r AnyRow) -> Result<Lease, sqlx::Error> {
        let payload: String = row.try_get("payload")?;
        let (tries, deaths): (i64, i64) = (row.try_get("tries")?, row.try_get("deaths")?);
        let memory = u64::try_from(row.try_get::<i64, _>("memory")?).map_err(sqlx::Error::decode)?;
        Ok(Lease { job: Job::from_row(row)?, payload: payload.into(), tries, memory, suspect: deaths > 0 })
    }
}

/// What a worker learns when it reports.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Heartbeat {
    /// The job is still yours, and the lease is extended.
    Held,
    /// Somebody cancelled the job: stop.
    Cancelled,
    /// The lease ran out and the job was given away, or the job is gone: stop, nothing you publish counts.
    Lost,
}
