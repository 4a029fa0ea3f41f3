//! What is told of a job.

use serde::Serialize;
use serde_json::Value;
use utoipa::ToSchema;

use super::paths;
use super::resource::{Resource, address};
use super::timestamp::timestamp;
use crate::jobs::Posing;
use crate::pipeline::Settings;
use crate::store::{Job, Priority, State};

/// What is told of every job.
#[derive(Debug, Serialize, ToSchema)]
pub struct JobDocument {
    pub id: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// The mesh and the sketch that are matched.
    pub mesh: String,
    pub sketch: String,
    pub status: Status,
    pub priority: Priority,
    pub progress: Progress,
    /// Which it is of your own of its kind that wait, from 1, where it waits.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(minimum = 1)]
    pub place_in_queue: Option<i64>,
    /// RFC 3339.
    #[schema(format = DateTime)]
    pub created_at: String,
    #[schema(format = DateTime)]
    pub started_at: Option<String>,
    #[schema(format = DateTime)]
    pub finished_at: Option<String>,
    /// Problem details where it failed.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(value_type = Option<super::problem::Problem>)]
    pub error: Option<Value>,
}

#[derive(Clone, Copy, Debug, Serialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum Status {
    Queued,
    Running,
    Succeeded,
    Failed,
    Cancelled,
}

#[derive(Debug, Serialize, ToSchema)]
pub struct Progress {
    /// The stage under way, once there is one: `spectrum`, `alignment`, `regions`, `descriptors`, `map`, `points` of a match,
    /// and `preview` when `result?preview=true` is there; `posing` of a pose.
    /// `finished` with success; after a failure or a cancelling, the stage last reported.
    pub stage: Option<String>,
    /// The share of the whole that is done.
    #[schema(minimum = 0, maximum = 1)]
    pub fraction: f64,
}

impl From<State> for Status {
    fn from(state: State) -> Status {
        match state {
            State::Queued => Status::Queued,
            State::Running => Status::Running,
            State::Succeeded => Status::Succeeded,
            State::Failed => Status::Failed,
            State::Cancelled => Status::Cancelled,
        }
    }
}

impl From<Job> for JobDocument {
    fn from(job: Job) -> JobDocument {
        JobDocument {
            id: job.id,
            name: job.name,
            mesh: job.mesh.unwrap_or_default(),
            sketch: job.sketch.unwrap_or_default(),
            status: job.state.into(),
            priority: job.priority,
            progress: Progress { stage: job.stage, fraction: job.fraction },
            place_in_queue: job.place,
            created_at: timestamp(job.created_ms),
            started_at: job.started_ms.map(timestamp),
            finished_at: job.finished_ms.map(timestamp),
            error: job.error,
        }
    }
}

/// A match and how far it is.
#[derive(Debug, Serialize, ToSchema)]
pub struct MatchDocument {
    #[serde(flatten)]
    pub job: JobDocument,
    /// Every setting as used; not in lists and events.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(value_type = Option<crate::pipeline::Settings>)]
    pub request: Option<Value>,
    pub links: Links,
}

#[derive(Debug, Serialize, ToSchema)]
pub struct Links {
    #[serde(rename = "self")]
    pub itself: String,
    pub result: String,
    /// The sketch and the mesh in matching colours.
    pub picture: String,
    /// C as a heat map.
    pub matrix: String,
    /// The mesh in the colours of the sketch.
    pub mesh: String,
    pub events: String,
}

impl Resource for Settings {
    const NOUN: &'static str = "match";
    const PATH: &'static str = paths::MATCHES;
    type Document = MatchDocument;

    fn document(job: Job, request: Option<Value>) -> MatchDocument {
        let itself = address::<Settings>(&job.id);
        let links = Links {
            result: format!("{itself}/result"),
            picture: format!("{itself}/picture"),
            matrix: format!("{itself}/matrix"),
            mesh: format!("{itself}/mesh.glb"),
            events: format!("{itself}/events"),
            itself,
        };
        MatchDocument { job: job.into(), request, links }
    }
}

/// A pose and how far it is.
#[derive(Debug, Serialize, ToSchema)]
pub struct PoseDocument {
    #[serde(flatten)]
    pub job: JobDocument,
    /// What was asked for; not in lists and events.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(value_type = Option<crate::posing::request::PoseRequest>)]
    pub request: Option<Value>,
    pub links: PoseLinks,
}

#[derive(Debug, Serialize, ToSchema)]
pub struct PoseLinks {
    #[serde(rename = "self")]
    pub itself: String,
    pub result: String,
    /// The drawing and the mesh in their pose.
    pub picture: String,
    pub events: String,
}

impl Resource for Posing {
    const NOUN: &'static str = "pose";
    const PATH: &'static str = paths::POSES;
    type Document = PoseDocument;

    fn document(job: Job, payload: Option<Value>) -> PoseDocument {
        let itself = address::<Posing>(&job.id);
        let links = PoseLinks {
            result: format!("{itself}/result"),
            picture: format!("{itself}/picture"),
            events: format!("{itself}/events"),
            itself,
        };
        let request = payload.and_then(|mut payload| payload.get_mut("request").map(Value::take));
        PoseDocument { job: job.into(), request, links }
    }
}
