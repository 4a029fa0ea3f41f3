//! Whether the server lives, whether it takes work, and its measures.

use axum::Json;
use axum::extract::State;
use axum::http::header;
use axum::response::IntoResponse;
use serde::Serialize;
use utoipa::ToSchema;

use super::App;
use super::problem::Problem;

#[derive(Serialize, ToSchema)]
pub struct Health {
    /// `ok`
    status: &'static str,
}

const OK: Json<Health> = Json(Health { status: "ok" });

/// Tells that the process lives.
#[utoipa::path(get, path = "/healthz", tag = "service", responses((status = 200, description = "it lives", body = Health)))]
pub async fn alive() -> Json<Health> {
    OK
}

/// Tells whether requests are taken: the store answers and nobody has told the server to stop.
#[utoipa::path(
    get, path = "/readyz", tag = "service",
    responses((status = 200, description = "it takes requests", body = Health), (status = 503, description = "it does not")),
)]
pub async fn ready(State(app): State<App>) -> Result<Json<Health>, Problem> {
    if app.shutdown.is_cancelled() {
        return Err(Problem::busy("the server is stopping", 5));
    }
    app.store.healthy().await.map_err(|error| {
        tracing::error!(%error, "the store does not answer");
        Problem::busy("the store does not answer", 5)
    })?;
    Ok(OK)
}

/// Answers the measures of the process in the text format of Prometheus.
#[utoipa::path(
    get, path = "/metrics", tag = "service",
    responses((status = 200, description = "the measures", content_type = "text/plain", body = String)),
)]
pub async fn measures(State(app): State<App>) -> Result<impl IntoResponse, Problem> {
    metrics::gauge!("jobs_queued").set(app.store.queued().await? as f64);
    metrics::gauge!("reading_bytes").set(app.reading_bytes() as f64);
    app.metrics.run_upkeep();
    Ok(([(header::CONTENT_TYPE, "text/plain; version=0.0.4; charset=utf-8")], app.metrics.render()))
}
