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
mod timestamp;
mod transfers;
mod unread;

use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

use axum::Router;
use axum::extract::{DefaultBodyLimit, FromRequestParts, MatchedPath, Request};
use axum::http::request::Parts;
use axum::http::{HeaderName, Method, StatusCode};
use axum::middleware::{Next, from_fn, from_fn_with_state, map_request, map_response};
use axum::response::{IntoResponse, Response};
use axum::routing::get;
use metrics_exporter_prometheus::PrometheusHandle;
use tokio::net::TcpListener;
use tokio::sync::{OnceCell, OwnedSemaphorePermit, Semaphore};
use tokio_util::sync::CancellationToken;
use tower_http::catch_panic::CatchPanicLayer;
use tower_http::compression::CompressionLayer;
use tower_http::timeout::TimeoutLayer;
use utoipa_swagger_ui::SwaggerUi;

use crate::access::{Grant, Signer};
use crate::jobs;
use crate::store::{Job, JobChanges, NewJob, Places, Store, StoreError, Submitted, Unkept};
use crate::webhooks;
use admission::{Admission, Door};
use connections::Limits;
use examples::Examples;
pub use front_page::FrontPage;
use host::Hosts;
use limits::Pace;
use observation::Trace;
use open_requests::OpenRequests;
use origin::Origin;
pub use preference::LONGEST_WAIT;
use problem::Problem;
use single_flight::SingleFlight;

/// How long a change of a job made by another process may go unnoticed.
const POLL: Duration = Duration::from_secs(15);

/// The name of the secret that signs addresses.
const LINKS: &str = "links";

/// Connections at one time to the address of the measures: those who watch are few.
const MEASURE_CONNECTIONS: usize = 64;

/// What the service allows.
#[derive(Clone, Debug)]
pub struct Config {
    /// Who is let in.
    pub admission: Admission,
    /// What one tenant may take.
    pub tenant_limits: limits::Limits,
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
            tenant_limits: limits::Limits::default(),
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

/// In which line work waits for its turn.
#[derive(Clone, Copy)]
enum Line {
    /// It takes moments.
    Short,
    /// It may take tens of seconds.
    Long,
}

/// The work, with what it takes until it has ended, also where nobody waits for it any more.
fn keeping<T>(
    taken: impl Send + 'static,
    work: impl FnOnce() -> T + Send + 'static,
) -> impl FnOnce() -> T + Send + 'static {
    move || {
        let _taken = taken;
        work()
    }
}

/// What was taken into the queue.
///
/// # Errors
/// 503 where it is full; 404 where a shape was deleted meanwhile.
fn taken<T>(submitted: Submitted<T>) -> Result<T, Problem> {
    match submitted {
        Submitted::Taken(taken) => Ok(taken),
        Submitted::Full => Err(Problem::busy("the queue is full", 10)),
        Submitted::Gone => Err(Problem::not_found("shape of this id any more")),
    }
}

/// Permits for this many bytes.
fn grains(bytes: usize) -> u32 {
    u32::try_from(bytes.div_ceil(body::MEMORY_GRAIN)).unwrap_or(u32::MAX)
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

    /// What signs addresses and knows its signatures again.
    ///
    /// # Errors
    /// What the store said.
    async fn signer(&self) -> Result<&Signer, StoreError> {
        let signer = async { self.store.secret(LINKS).await.map(Signer::new) };
        self.signer.get_or_try_init(|| signer).await
    }

    /// What `work` returns, done on a thread of its own: as many at a time as there are processors, or two. Work that has
    /// begun keeps its turn to its end, also where the client hangs up meanwhile.
    async fn off_runtime<T: Send + 'static>(&self, work: impl FnOnce() -> T + Send + 'static) -> Result<T, Problem> {
        let turn = self.turns.clone().acquire_owned().await.map_err(Problem::internal)?;
        tokio::task::spawn_blocking(keeping(turn, work)).await.map_err(Problem::internal)
    }

    /// The same for work that may take tens of seconds: of the turns it leaves one to short work, which so goes on however much
    /// there is of it.
    async fn at_length<T: Send + 'static>(&self, work: impl FnOnce() -> T + Send + 'static) -> Result<T, Problem> {
        let long = self.long_turns.clone().acquire_owned().await.map_err(Problem::internal)?;
        self.off_runtime(keeping(long, work)).await
    }

    /// The same for work that waits in one line or the other.
    async fn in_line<T: Send + 'static>(
        &self,
        line: Line,
        work: impl FnOnce() -> T + Send + 'static,
    ) -> Result<T, Problem> {
        match line {
            Line::Short => self.off_runtime(work).await,
            Line::Long => self.at_length(work).await,
        }
    }

    /// A hold on about this many bytes of the memory for what is read, once they are free; what takes more than there are goes
    /// alone. Who has one asks for no other: two who did would wait for each other.
    async fn room_for(&self, bytes: usize) -> Result<OwnedSemaphorePermit, Problem> {
        let grains = grains(bytes.min(self.config.max_reading_bytes));
        self.reading.clone().acquire_many_owned(grains).await.map_err(Problem::internal)
    }

    /// What short work returns that takes about this many bytes of memory.
    async fn with_memory<T: Send + 'static>(
        &self,
        bytes: usize,
        work: impl FnOnce() -> T + Send + 'static,
    ) -> Result<T, Problem> {
        let memory = self.room_for(bytes).await?;
        self.off_runtime(keeping(memory, work)).await
    }

    /// Bytes of memory that are set aside for what is being read now.
    fn reading_bytes(&self) -> usize {
        let all = grains(self.config.max_reading_bytes) as usize;
        (all - self.reading.available_permits()) * body::MEMORY_GRAIN
    }

    /// A hold on memory for a body of `length` bytes, given back when dropped.
    ///
    /// # Errors
    /// 503 while other bodies take it up.
    fn memory_for(&self, length: usize) -> Result<OwnedSemaphorePermit, Problem> {
        let hold = self.memory.clone().try_acquire_many_owned(grains(length));
        hold.map_err(|_| Problem::busy("too many uploads are under way", 1))
    }

    /// Makes a hold on memory one for `length` bytes.
    ///
    /// # Errors
    /// 503 while other bodies take it up.
    fn enlarge(&self, hold: &mut OwnedSemaphorePermit, length: usize) -> Result<(), Problem> {
        let more = length.saturating_sub(hold.num_permits() * body::MEMORY_GRAIN);
        hold.merge(self.memory_for(more)?);
        Ok(())
    }

    /// Puts a job into the queue, of whose places its kind may take so many, together with the shape that came within its
    /// request, where one did.
    ///
    /// # Errors
    /// 429 where the tenant has as many jobs as it may; 503 where the queue is full; 404 where a shape the job needs was deleted meanwhile.
    async fn queued(&self, job: &NewJob<'_>, shape: Option<Unkept>) -> Result<Job, Problem> {
        let (job, places) = (&self.traced(job), self.places(job.kind));
        let _turn = self.may_take(shape.as_ref().map_or(0, Unkept::bytes), 1).await?;
        let submitted = match shape {
            Some(shape) => self.store.submit_with(shape, job, places).await?,
            None => self.store.submit(job, places).await?,
        };
        Ok(*taken(submitted)?)
    }

    /// Puts jobs of one kind into the queue together: all or none.
    ///
    /// # Errors
    /// As of [`queued`](Self::queued).
    async fn queued_together(&self, kind: &str, jobs: &[NewJob<'_>]) -> Result<Vec<Job>, Problem> {
        let jobs: Vec<NewJob> = jobs.iter().map(|job| self.traced(job)).collect();
        let _turn = self.may_take(0, jobs.len() as u64).await?;
        taken(self.store.submit_all(&jobs, self.places(kind)).await?)
    }

    /// The job as part of the trace that the request is part of.
    fn traced<'a>(&'a self, job: &NewJob<'a>) -> NewJob<'a> {
        NewJob { trace: self.trace.as_ref().map(|Trace(trace)| &**trace), ..*job }
    }

    /// The places of the queue, and those of them that jobs of a kind may take.
    fn places(&self, kind: &str) -> Places {
        let queue = self.config.max_queue;
        Places { queue, of_kind: jobs::kind(kind).map_or(queue, |kind| kind.places(queue)) }
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
fn router(app: App, hosts: Hosts) -> Router {
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
        .layer(from_fn_with_state(Arc::new(hosts), host::checked))
        .layer(from_fn(observation::observed))
}

const PREFERENCE_APPLIED: HeaderName = HeaderName::from_static("preference-applied");

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
    let hosts = Hosts::of(listener.local_addr()?.ip(), &app.config.allowed_hosts);
    let limits = Limits { connections: app.config.max_connections, idle: app.config.idle_timeout };
    let shutdown = app.shutdown.clone();
    if let Admission::Keyholders(Some(file)) = &app.config.admission {
        tokio::spawn(file.clone().watch(shutdown.clone()));
    }
    connections::serve(listener, router(app, hosts), limits, shutdown).await;
    Ok(())
}

/// Answers on `listener` what those want to know who watch, the measures and how it is, to whoever reaches it, until `app` is told
/// to stop.
///
/// # Errors
/// What the listener said.
pub async fn serve_measures(listener: TcpListener, app: App) -> std::io::Result<()> {
    let hosts = Hosts::of(listener.local_addr()?.ip(), &app.config.allowed_hosts);
    let limits = Limits { connections: MEASURE_CONNECTIONS, idle: app.config.idle_timeout };
    let (shutdown, deadline) = (app.shutdown.clone(), app.config.request_deadline);
    let routes = Router::new()
        .route("/metrics", get(health::measures))
        .route("/healthz", get(health::alive))
        .route("/readyz", get(health::ready))
        .with_state(Service(app))
        .layer(TimeoutLayer::with_status_code(StatusCode::SERVICE_UNAVAILABLE, deadline))
        .layer(map_response(problem::dressed))
        .layer(from_fn_with_state(Arc::new(hosts), host::checked));
    connections::serve(listener, routes, limits, shutdown).await;
    Ok(())
}

#[cfg(test)]
mod tests {
    use std::pin::pin;
    use std::sync::mpsc::channel;

    use axum::http::HeaderMap;
    use metrics_exporter_prometheus::PrometheusBuilder;
    use serde_json::json;
    use tokio::time::timeout;

    use super::*;
    use crate::mesh::solids::sheet;
    use crate::store::Source;
    use crate::store::testing::fresh;

    /// Within which all is done that nothing keeps waiting.
    const SOON: Duration = Duration::from_secs(20);

    #[tokio::test]
    async fn work_keeps_its_turn_and_its_memory_when_nobody_waits_any_more() {
        let (_directory, store) = fresh().await;
        let measures = PrometheusBuilder::new().build_recorder().handle();
        let app = App::new(store, Config::default(), measures, CancellationToken::new());
        let turns = app.turns.available_permits();
        let (began, begun) = channel();
        let (end, ended) = channel();
        let working = app.clone();
        let asking = tokio::spawn(async move {
            let work = move || {
                began.send(()).unwrap();
                ended.recv().unwrap();
            };
            working.with_memory(1 << 20, work).await
        });
        tokio::task::spawn_blocking(move || begun.recv().unwrap()).await.unwrap();
        asking.abort();
        assert!(asking.await.unwrap_err().is_cancelled());
        assert_eq!((app.turns.available_permits(), app.reading_bytes()), (turns - 1, 1 << 20));
        end.send(()).unwrap();
        let all_turns = app.turns.acquire_many(u32::try_from(turns).unwrap()).await;
        assert!(all_turns.is_ok() && app.reading.available_permits() == grains(app.config.max_reading_bytes) as usize);
    }

    #[tokio::test]
    async fn short_work_goes_on_however_much_long_work_there_is() {
        let (_directory, store) = fresh().await;
        let source = Source { bytes: "v".into(), media_type: "model/obj".to_owned(), parameters: String::new() };
        let mesh = store.insert_mesh(sheet(6, 3).into(), source, None, json!({})).await.unwrap().0.id;
        let measures = PrometheusBuilder::new().build_recorder().handle();
        let app = App::new(store, Config::default(), measures, CancellationToken::new());
        let id = || query::Id(mesh.clone());
        let (ends, ended) = channel::<()>();
        let ended = Arc::new(std::sync::Mutex::new(ended));
        let long: Vec<_> = (0..=app.turns.available_permits())
            .map(|_| {
                let (app, ended) = (app.clone(), ended.clone());
                // It lasts until nobody can say any more that it is over.
                tokio::spawn(async move { app.at_length(move || ended.lock().unwrap().recv().is_err()).await })
            })
            .collect();
        while app.long_turns.available_permits() > 0 {
            tokio::task::yield_now().await;
        }
        let picture = portraits::of_mesh(app.clone(), id(), query::Query(Default::default()), HeaderMap::new());
        let mut picture = pin!(picture);
        assert!(timeout(Duration::from_millis(200), &mut picture).await.is_err());
        let triangles = timeout(SOON, geometry::of_mesh(app.clone(), id(), HeaderMap::new())).await.unwrap();
        assert_eq!(triangles.ok().unwrap().status(), StatusCode::OK);
        drop(ends);
        assert_eq!(timeout(SOON, picture).await.unwrap().ok().unwrap().status(), StatusCode::OK);
        for work in long {
            assert!(work.await.unwrap().ok().unwrap());
        }
    }
}
