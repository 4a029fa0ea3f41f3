//! Routes, their bodies, problem details, OpenAPI.
//!
//! A handler extracts, makes one or two calls and wraps the answer. What it hands to the store and takes from there is
//! all it knows of the worker.

pub mod admission;
mod asking;
mod body;
mod connections;
mod evaluations;
mod events;
mod examples;
mod front_page;
mod functions;
mod geometry;
mod health;
mod held;
mod host;
mod idempotency;
mod inline_sketch;
mod inside;
mod job_document;
pub mod limits;
mod links;
mod matches;
mod media_types;
mod memory;
mod meshes;
mod observation;
mod open_requests;
pub mod openapi;
pub mod origin;
mod page;
mod paths;
mod pictures;
mod portraits;
mod pose_results;
mod poses;
mod preference;
mod problem;
mod query;
mod queueing;
mod rebuilt;
mod regularisers;
mod representation;
mod resource;
mod results;
mod security_headers;
mod segmentation;
mod shapes;
mod single_flight;
mod sketches;
mod spectra;
mod sweeps;
#[cfg(test)]
mod testing;
mod timestamp;
mod transfers;
mod turns;
mod unread;

use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

use axum::Router;
use axum::extract::{DefaultBodyLimit, FromRequestParts, MatchedPath, Request};
use axum::http::request::Parts;
use axum::http::{Method, StatusCode};
use axum::middleware::{Next, from_fn, from_fn_with_state, map_request, map_response};
use axum::response::{IntoResponse, Response};
use axum::routing::get;
use metrics_exporter_prometheus::PrometheusHandle;
use tokio::net::TcpListener;
use tokio::sync::{OnceCell, Semaphore};
use tokio_util::sync::CancellationToken;
use tower_http::catch_panic::CatchPanicLayer;
use tower_http::compression::CompressionLayer;
use tower_http::timeout::TimeoutLayer;
use utoipa_swagger_ui::SwaggerUi;

use crate::access::{Grant, Signer};
use crate::store::{JobChanges, Store};
use crate::webhooks;
use admission::{Admission, Door};
use connections::ConnectionLimits;
use examples::Examples;
pub use front_page::FrontPage;
use host::OwnNames;
use limits::{Pace, TenantLimits};
use observation::Trace;
use open_requests::OpenRequests;
use origin::Origin;
pub use preference::LONGEST_WAIT;
use problem::Problem;
use single_flight::SingleFlight;
use turns::grains;

/// How long a change of a job made by another process may go unnoticed.
const POLL: Duration = Duration::from_secs(15);

/// Connections at one time to the address of the measures: those who watch are few.
const MEASURE_CONNECTIONS: usize = 64;

/// What the service allows.
#[derive(Clone, Debug)]
pub struct Config {
    /// Who is let in.
    pub admission: Admission,
    /// What one tenant may take.
    pub tenant_limits: TenantLimits,
    /// Origins that scripts of other sites may call from.
    pub cors_origins: Vec<Origin>,
    /// Names to answer to beside local ones, on a loopback address; where there are some, on others too.
    pub allowed_hosts: Vec<String>,
    /// Connections at one time, as far as the process may have files open.
    pub max_connections: usize,
    /// How long a client may be silent: before and within the headers of a request, within its body, and before it reads
    /// an answer.
    pub idle_timeout: Duration,
    /// How long a request may take, its body included, until it is answered.
    pub request_deadline: Duration,
    /// Bytes of a mesh or sketch file.
    pub max_upload_bytes: usize,
    /// Bytes of a JSON request.
    pub max_request_bytes: usize,
    /// Bytes of all bodies that are in memory at one time.
    pub max_uploads_bytes: usize,
    /// Bytes of memory that everything read at one time may take: what is made of bodies, as estimated beforehand.
    pub max_reading_bytes: usize,
    /// Triangles of a mesh that are matched.
    pub max_triangles: usize,
    /// Eigenpairs of a spectrum.
    pub max_eigenpairs: usize,
    /// Bytes of memory a job may take.
    pub max_job_memory: usize,
    /// Jobs that may wait.
    pub max_queue: usize,
    /// Whom clients may have told of the ends of jobs.
    pub webhook_hosts: webhooks::Hosts,
    /// The program whose processes read SVGs, see [`svg_reader`](crate::intake::svg_reader); where there is none they are read in this one.
    pub svg_reader: Option<PathBuf>,
    /// What is answered at `/`.
    pub front_page: FrontPage,
}

impl Default for Config {
    fn default() -> Config {
        Config {
            admission: Admission::Anybody,
            tenant_limits: TenantLimits::default(),
            cors_origins: Vec::new(),
            allowed_hosts: Vec::new(),
            max_connections: 10_000,
            idle_timeout: Duration::from_secs(30),
            request_deadline: Duration::from_secs(600),
            max_upload_bytes: 128 << 20,
            max_request_bytes: 16 << 20,
            max_uploads_bytes: 512 << 20,
            max_reading_bytes: 2 << 30,
            max_triangles: 1_000_000,
            max_eigenpairs: 500,
            max_job_memory: 8 << 30,
            max_queue: 1000,
            webhook_hosts: webhooks::Hosts::default(),
            svg_reader: None,
            front_page: FrontPage::built(),
        }
    }
}

/// What every handler has at hand, its store that of the tenant who asks. Clones share it.
#[derive(Clone)]
pub struct App {
    store: Store,
    config: Arc<Config>,
    metrics: PrometheusHandle,
    /// Cancelled when the server is to stop.
    shutdown: CancellationToken,
    /// Turns of what is done off the threads that answer requests, and those of them that long work may have.
    turns: Arc<Semaphore>,
    long_turns: Arc<Semaphore>,
    memory: Arc<Semaphore>,
    reading: Arc<Semaphore>,
    /// What the last check of the store found.
    readiness: Arc<SingleFlight<Result<(), Problem>>>,
    /// What the system knows of this process, as measures.
    process: metrics_process::Collector,
    examples: Examples,
    /// Count the requests of tenants, those that come and those under way, where there is a limit to them.
    pace: Option<Arc<Pace>>,
    open_requests: Option<Arc<OpenRequests>>,
    /// What signs addresses, once its secret was read.
    signer: Arc<OnceCell<Signer>>,
    /// The trace that the request is part of.
    trace: Option<Trace>,
}

/// What all are served with: an [`App`] comes of it with the tenant of a request.
#[derive(Clone)]
struct Service(App);

impl FromRequestParts<Service> for App {
    type Rejection = Problem;

    async fn from_request_parts(parts: &mut Parts, Service(app): &Service) -> Result<App, Problem> {
        let grant = parts.extensions.get::<Grant>();
        let Grant { tenant, .. } = grant.ok_or_else(|| Problem::internal("nobody asked whose request this is"))?;
        let trace = parts.extensions.get::<Trace>().cloned();
        Ok(App { store: app.store.of(tenant), trace, ..app.clone() })
    }
}

impl App {
    pub fn new(store: Store, config: Config, metrics: PrometheusHandle, shutdown: CancellationToken) -> App {
        let process = metrics_process::Collector::new("sketchmatch_");
        process.describe();
        health::describe();
        observation::describe();
        // Of two there is one for short work.
        let turns = std::thread::available_parallelism().map_or(1, usize::from).max(2);
        let semaphore = |bytes: usize| Arc::new(Semaphore::new(grains(bytes) as usize));
        App {
            store,
            // A form of the largest file fits at least: it is taken apart by copying.
            memory: semaphore(config.max_uploads_bytes.max(config.max_upload_bytes.saturating_mul(2))),
            reading: semaphore(config.max_reading_bytes),
            pace: config.tenant_limits.requests_per_second.map(|per_second| Arc::new(Pace::new(per_second))),
            open_requests: config.tenant_limits.open_requests.map(|most| Arc::new(OpenRequests::new(most))),
            config: Arc::new(config),
            metrics,
            shutdown,
            turns: Arc::new(Semaphore::new(turns)),
            long_turns: Arc::new(Semaphore::new(turns - 1)),
            readiness: Arc::default(),
            process,
            examples: Examples::default(),
            signer: Arc::default(),
            trace: None,
        }
    }

    /// Waits for a change of a job, but not for ever: another process may have made one. False once the server is to
    /// stop.
    async fn change(&self, changes: &mut JobChanges) -> bool {
        tokio::select! {
            () = self.shutdown.cancelled() => false,
            () = tokio::time::sleep(POLL) => true,
            () = changes.changed() => true,
        }
    }
}

/// Everything a server of these names answers, over `app`.
fn router(app: App, names: OwnNames) -> Router {
    let (cors, deadline) = (origin::layer(&app.config.cors_origins), app.config.request_deadline);
    let origins: Arc<[Origin]> = app.config.cors_origins.as_slice().into();
    let door = Door(app.clone());
    let (routes, document) = openapi::routes();
    routes
        .merge(front_page::routes())
        .with_state(Service(app))
        .merge(SwaggerUi::new("/docs").external_url_unchecked("/openapi.json", document))
        .layer(DefaultBodyLimit::disable())
        .layer(from_fn_with_state(door, admission::checked))
        .layer(CatchPanicLayer::custom(Problem::of_panic))
        .layer(TimeoutLayer::with_status_code(StatusCode::SERVICE_UNAVAILABLE, deadline))
        .layer(map_response(problem::dressed))
        .layer(CompressionLayer::new())
        .layer(map_request(representation::admit_uncompressed))
        .layer(map_response(representation::tag_compressed))
        .layer(from_fn_with_state(origins, origin::checked))
        .layer(cors)
        .layer(from_fn(security_headers::added))
        .layer(from_fn(only_paths_there_are))
        .layer(from_fn_with_state(Arc::new(names), host::checked))
        .layer(from_fn(observation::observed))
}

/// Answers OPTIONS at paths that do not exist as other methods: the layer for scripts of other sites would say yes.
async fn only_paths_there_are(request: Request, next: Next) -> Response {
    if request.method() == Method::OPTIONS && request.extensions().get::<MatchedPath>().is_none() {
        return problem::dressed(StatusCode::NOT_FOUND.into_response()).await;
    }
    next.run(request).await
}

/// Answers on `listener` until `app` is told to stop, then lets open requests finish within a grace period.
///
/// # Errors
/// What the listener said.
pub async fn serve(listener: TcpListener, app: App) -> std::io::Result<()> {
    let names = OwnNames::of(listener.local_addr()?.ip(), &app.config.allowed_hosts);
    let limits = ConnectionLimits { connections: app.config.max_connections, idle: app.config.idle_timeout };
    let shutdown = app.shutdown.clone();
    if let Admission::Keyholders(Some(file)) = &app.config.admission {
        tokio::spawn(file.clone().watch(shutdown.clone()));
    }
    connections::serve(listener, router(app, names), limits, shutdown).await;
    Ok(())
}

/// Answers on `listener` what those want to know who watch, the measures and how it is, to whoever reaches it, until `app` is told
/// to stop.
///
/// # Errors
/// What the listener said.
pub async fn serve_measures(listener: TcpListener, app: App) -> std::io::Result<()> {
    let names = OwnNames::of(listener.local_addr()?.ip(), &app.config.allowed_hosts);
    let limits = ConnectionLimits { connections: MEASURE_CONNECTIONS, idle: app.config.idle_timeout };
    let (shutdown, deadline) = (app.shutdown.clone(), app.config.request_deadline);
    let routes = Router::new()
        .route("/metrics", get(health::measures))
        .route("/healthz", get(health::alive))
        .route("/readyz", get(health::ready))
        .with_state(Service(app))
        .layer(TimeoutLayer::with_status_code(StatusCode::SERVICE_UNAVAILABLE, deadline))
        .layer(map_response(problem::dressed))
        .layer(from_fn_with_state(Arc::new(names), host::checked));
    connections::serve(listener, routes, limits, shutdown).await;
    Ok(())
}
