//! Whether the server lives, whether it takes work, and its measures.

use std::future::Future;
use std::time::Duration;

use axum::Json;
use axum::extract::State;
use axum::http::header;
use axum::response::IntoResponse;
use metrics::describe_gauge;
use serde::Serialize;
use tokio::time::error::Elapsed;
use tokio::time::timeout;
use utoipa::ToSchema;

use super::problem::Problem;
use super::{App, Service};
use crate::jobs::{KINDS, Kind};
use crate::store::{Lack, StoreError};

#[derive(Serialize, ToSchema)]
pub struct Health {
    /// `ok`
    status: &'static str,
}

/// Bytes that have to be free on the disk: what a match and its caches take, about, on a mesh of 100,000 vertices.
const LEAST_FREE: u64 = 64 << 20;

/// How long a check may take: below what watchers usually wait, so that they are told what is away.
const LONGEST_CHECK: Duration = Duration::from_secs(3);

const OK: Json<Health> = Json(Health { status: "ok" });

/// Tells that the process lives.
#[utoipa::path(get, path = "/healthz", operation_id = "read_health", tag = "service", responses((status = 200, description = "it lives", body = Health)))]
pub async fn alive() -> Json<Health> {
    OK
}

/// Tells whether requests are taken: a row and a blob can be written and read, the disk has space, and nobody has told the
/// server to stop. Where not, `detail` names what is away, the database, the blobs or both.
#[utoipa::path(
    get, path = "/readyz", operation_id = "read_readiness", tag = "service",
    responses(
        (status = 200, description = "it takes requests", body = Health),
        (status = 503, description = "it does not"),
        (status = 507, description = "the disk is full"),
    ),
)]
pub(super) async fn ready(State(Service(app)): State<Service>) -> Result<Json<Health>, Problem> {
    if app.shutdown.is_cancelled() {
        return Err(Problem::busy("the server is stopping", 5));
    }
    app.readiness.asked(checked(&app)).await.map(|()| OK)
}

/// Ok where a row and a blob can be written and read and the disk has space.
///
/// # Errors
/// 507 where the disk is full, 503 naming what is away.
async fn checked(app: &App) -> Result<(), Problem> {
    // A disk that does not say is one that cannot be used, which is told below.
    if let Ok(Some(free)) = app.store.free_bytes().await
        && free < LEAST_FREE
    {
        return Err(Problem::lacking(Lack::Space, format_args!("the disk has {free} bytes left")));
    }
    let database = timeout(LONGEST_CHECK, app.store.database_healthy());
    let (database, blobs) = tokio::join!(database, timeout(LONGEST_CHECK, app.store.blobs_healthy()));
    let away = match (unusable("database", database)?, unusable("place of the blobs", blobs)?) {
        (false, false) => return Ok(()),
        (true, false) => "the database",
        (false, true) => "the place of the blobs",
        (true, true) => "the database and the place of the blobs",
    };
    Err(Problem::busy(format!("{away} cannot be used"), 5))
}

/// Whether what the server depends on cannot be used, which is told to the log.
///
/// # Errors
/// 507 where its disk is full.
fn unusable(what: &str, health: Result<Result<(), StoreError>, Elapsed>) -> Result<bool, Problem> {
    match health {
        Ok(Ok(())) => return Ok(false),
        Ok(Err(error)) if error.lack() == Some(Lack::Space) => return Err(Problem::lacking(Lack::Space, error)),
        Ok(Err(error)) => tracing::error!(%error, "the {what} cannot be used"),
        Err(_) => tracing::error!("the {what} does not answer"),
    }
    Ok(true)
}

const QUEUED: &str = "sketchmatch_jobs_queued";
const OLDEST: &str = "sketchmatch_queue_age_seconds";
const CALLS: &str = "sketchmatch_webhooks_waiting";
const FREE: &str = "sketchmatch_disk_free_bytes";
const READING: &str = "sketchmatch_reading_bytes";
const BUILD: &str = "sketchmatch_build_info";

/// Says what is measured here.
pub(super) fn describe() {
    describe_gauge!(QUEUED, "Jobs that wait, by kind.");
    describe_gauge!(OLDEST, "Seconds that the job has waited that waits longest, by kind.");
    describe_gauge!(CALLS, "Calls that are still to tell of the end of a job.");
    describe_gauge!(
        FREE,
        "Bytes that are free on the disk of the data directory; not a number where nothing is kept on one."
    );
    describe_gauge!(
        READING,
        "Bytes of memory set aside for drawings, meshes and spectra that are being read, as estimated."
    );
    describe_gauge!(BUILD, "1, with the version of the program.");
    metrics::gauge!(BUILD, "version" => env!("CARGO_PKG_VERSION")).set(1);
}

/// How long the database and the disk are asked for a measure.
const PATIENCE: Duration = Duration::from_secs(2);

/// Answers the measures of the process in the text format of Prometheus. What the data directory does not tell in time is
/// not a number: the other measures are needed most just then.
#[utoipa::path(
    get, path = "/metrics", operation_id = "read_measures", tag = "service",
    responses((status = 200, description = "the measures", content_type = "text/plain", body = String)),
)]
pub(super) async fn measures(State(Service(app)): State<Service>) -> impl IntoResponse {
    for Kind { name, .. } in &KINDS {
        let queued = async { app.store.queued(name).await.map(|jobs| jobs as f64) };
        metrics::gauge!(QUEUED, "kind" => *name).set(told(queued).await);
        let oldest = async { app.store.longest_wait(name).await.map(|wait| wait.as_secs_f64()) };
        metrics::gauge!(OLDEST, "kind" => *name).set(told(oldest).await);
    }
    let calls = async { app.store.webhooks_waiting().await.map(|calls| calls as f64) };
    metrics::gauge!(CALLS).set(told(calls).await);
    let free = async { app.store.free_bytes().await.map(|bytes| bytes.map_or(f64::NAN, |bytes| bytes as f64)) };
    metrics::gauge!(FREE).set(told(free).await);
    metrics::gauge!(READING).set(app.reading_bytes() as f64);
    app.process.collect();
    ([(header::CONTENT_TYPE, "text/plain; version=0.0.4; charset=utf-8")], app.metrics.render())
}

/// What the store tells of itself; not a number where it does not.
async fn told(measure: impl Future<Output = Result<f64, StoreError>>) -> f64 {
    match timeout(PATIENCE, measure).await {
        Ok(Ok(value)) => value,
        Ok(Err(error)) => {
            tracing::warn!(%error, "the store does not tell a measure");
            f64::NAN
        }
        Err(_) => f64::NAN,
    }
}

#[cfg(test)]
mod tests {
    use axum::body::to_bytes;
    use metrics_exporter_prometheus::PrometheusBuilder;
    use tokio_util::sync::CancellationToken;

    use super::*;
    use crate::http::Config;
    use crate::store::testing::fresh;

    #[tokio::test]
    async fn measures_are_told_without_the_database() {
        let (_directory, store) = fresh().await;
        store.close().await.unwrap();
        assert!(store.queued("match").await.is_err());
        let recorder = PrometheusBuilder::new().build_recorder();
        let app = App::new(store, Config::default(), recorder.handle(), CancellationToken::new());
        let _recording = metrics::set_default_local_recorder(&recorder);
        let answer = measures(State(Service(app))).await.into_response();
        let text = String::from_utf8(to_bytes(answer.into_body(), 1 << 20).await.unwrap().to_vec()).unwrap();
        assert!(text.contains("sketchmatch_jobs_queued{kind=\"match\"} NaN"), "{text}");
        assert!(text.contains("sketchmatch_reading_bytes 0"), "{text}");
    }
}
