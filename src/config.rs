//! How the service is told to serve, by the command line and the environment: every owner's configuration, gathered.

use std::fmt;
use std::net::{SocketAddr, ToSocketAddrs};
use std::num::NonZeroU32;
use std::path::PathBuf;
use std::time::Duration;

use anyhow::ensure;
use bytesize::ByteSize;
use clap::Args;
use rustix::fs::Mode;
use rustix::process::umask;

use sketchmatch::access::WatchedFile;
use sketchmatch::http::admission::Admission;
use sketchmatch::http::limits::TenantLimits;
use sketchmatch::http::origin::Origin;
use sketchmatch::store::{BlobUrl, DatabaseUrl, Store};
use sketchmatch::webhooks::Host;
use sketchmatch::{http, store, worker};

/// Where everything is kept: the same for every node.
#[derive(Debug, Args)]
pub struct StoreOptions {
    /// Directory of the database and the blobs, as far as they are not elsewhere.
    #[arg(long, env = "SKETCHMATCH_DATA_DIR", default_value = "data")]
    pub data_dir: PathBuf,
    /// PostgreSQL database that many nodes share, postgres://user:password@host/database [default: SQLite in the data
    /// directory, for one process].
    #[arg(long, env = "SKETCHMATCH_DATABASE_URL", hide_env_values = true)]
    pub database_url: Option<DatabaseUrl>,
    /// Place of the blobs, s3://bucket/prefix or file:///folder [default: the data directory]. For S3, AWS_ACCESS_KEY_ID,
    /// AWS_SECRET_ACCESS_KEY, AWS_REGION, AWS_ENDPOINT_URL and the like are read from the environment.
    #[arg(long, env = "SKETCHMATCH_BLOB_URL")]
    pub blob_url: Option<BlobUrl>,
}

impl StoreOptions {
    pub fn config(&self) -> store::Config {
        let StoreOptions { data_dir, database_url, blob_url } = self;
        store::Config { data_dir: data_dir.clone(), database_url: database_url.clone(), blob_url: blob_url.clone() }
    }

    /// The same, for who opens it: what this process writes from now on is readable by its owner alone, files 600, folders 700.
    pub fn to_open(&self) -> store::Config {
        umask(Mode::RWXG | Mode::RWXO);
        self.config()
    }
}

/// How a node computes.
#[derive(Debug, Args)]
pub struct WorkerOptions {
    /// Matches computed at one time; 0 where other nodes do [default: the number of processors].
    #[arg(long, env = "SKETCHMATCH_WORKERS")]
    pub workers: Option<u16>,
    /// Longest time a match or a spectrum may be computed, in seconds; it fails then.
    #[arg(long, env = "SKETCHMATCH_MAX_JOB_SECONDS", default_value_t = worker::Config::default().longest_job.as_secs(),
        value_parser = clap::value_parser!(u64).range(1..))]
    pub max_job_seconds: u64,
    /// Keep one cache of spectra and prepared meshes for all tenants, who can tell by its haste what others have computed.
    #[arg(long, env = "SKETCHMATCH_SHARED_CACHES")]
    pub shared_caches: bool,
    /// How long results are kept after the end of their jobs, such as 30d [default: for ever].
    #[arg(long, env = "SKETCHMATCH_KEEP_RESULTS", value_parser = humantime::parse_duration)]
    pub keep_results: Option<Duration>,
    /// How long matches, poses and other jobs are kept after their end, with their results [default: for ever].
    #[arg(long, env = "SKETCHMATCH_KEEP_JOBS", value_parser = humantime::parse_duration)]
    pub keep_jobs: Option<Duration>,
    /// How long uploads are kept that nobody uploads again or asks a job of [default: for ever].
    #[arg(long, env = "SKETCHMATCH_KEEP_UPLOADS", value_parser = humantime::parse_duration)]
    pub keep_uploads: Option<Duration>,
    /// How long answers under an Idempotency-Key are kept, up to a day.
    #[arg(long, env = "SKETCHMATCH_KEEP_ANSWERS", default_value = "24h", value_parser = humantime::parse_duration)]
    pub keep_answers: Duration,
    /// Host that may be told of the ends of jobs, with its port where that is not 443; may be repeated.
    #[arg(long = "webhook-host", env = "SKETCHMATCH_WEBHOOK_HOST", value_delimiter = ',')]
    pub webhook_hosts: Vec<Host>,
    /// Memory that jobs running on this node may take together, as estimated; one that takes more runs alone.
    #[arg(long, env = "SKETCHMATCH_MAX_JOBS_MEMORY", default_value_t = ByteSize(worker::Config::default().memory))]
    pub max_jobs_memory: ByteSize,
}

impl WorkerOptions {
    /// The store with the caches as they are to be.
    pub fn cached(&self, store: Store) -> Store {
        if self.shared_caches { store.with_shared_caches() } else { store }
    }

    pub fn config(&self) -> worker::Config {
        let default = worker::Config::default();
        let longest_job = Duration::from_secs(self.max_job_seconds);
        let retention = store::Retention {
            results: self.keep_results,
            jobs: self.keep_jobs,
            uploads: self.keep_uploads,
            answers: Some(self.keep_answers),
        };
        let (workers, memory) = (self.workers.map_or(default.workers, usize::from), self.max_jobs_memory.as_u64());
        let webhook_hosts = self.webhook_hosts.clone().into();
        worker::Config { workers, longest_job, memory, retention, webhook_hosts, ..default }
    }
}

/// What one tenant may take; 0 is as much as there is.
#[derive(Debug, Args)]
pub struct TenantOptions {
    /// Requests a tenant may send in a second [default: 100 where keys are asked for, else any number].
    #[arg(long, env = "SKETCHMATCH_TENANT_REQUESTS_PER_SECOND")]
    pub tenant_requests_per_second: Option<u32>,
    /// Requests of a tenant that may be under way, streams of events among them [default: 200 where keys are asked for, else
    /// any number].
    #[arg(long, env = "SKETCHMATCH_TENANT_OPEN_REQUESTS")]
    pub tenant_open_requests: Option<u64>,
    /// Jobs of a tenant that may wait [default: 200 where keys are asked for, else any number].
    #[arg(long, env = "SKETCHMATCH_TENANT_QUEUED_JOBS")]
    pub tenant_queued_jobs: Option<u64>,
    /// Uploads and results of a tenant that are kept.
    #[arg(long, env = "SKETCHMATCH_TENANT_STORED_BYTES", default_value = "0")]
    pub tenant_stored_bytes: ByteSize,
    /// Seconds of processor time that the jobs of a tenant may take in an hour.
    #[arg(long, env = "SKETCHMATCH_TENANT_CPU_SECONDS", default_value_t = 0)]
    pub tenant_cpu_seconds: u64,
}

impl TenantOptions {
    /// The limits where keys are asked for, or where all are one tenant.
    pub fn limits(&self, admission: &Admission) -> TenantLimits {
        let among_many = matches!(admission, Admission::Keyholders(_));
        let (requests, open, jobs) =
            if among_many { (REQUESTS_PER_SECOND, OPEN_REQUESTS, QUEUED_JOBS) } else { (0, 0, 0) };
        let some = |number: u64| (number > 0).then_some(number);
        TenantLimits {
            requests_per_second: NonZeroU32::new(self.tenant_requests_per_second.unwrap_or(requests)),
            open_requests: some(self.tenant_open_requests.unwrap_or(open)),
            queued_jobs: some(self.tenant_queued_jobs.unwrap_or(jobs)),
            stored_bytes: some(self.tenant_stored_bytes.as_u64()),
            cpu_per_hour: some(self.tenant_cpu_seconds).map(Duration::from_secs),
        }
    }
}

/// What a tenant among many may take where nothing is said: more than a page with a fast hand asks for, a quarter of the
/// connections there are where a process may have 1,024 files open, and a fifth of the queue.
const REQUESTS_PER_SECOND: u32 = 100;
const OPEN_REQUESTS: u64 = 200;
const QUEUED_JOBS: u64 = 200;

#[derive(Debug, Args)]
pub struct ServeOptions {
    /// Address or name, and port, to listen on.
    #[arg(long, env = "SKETCHMATCH_LISTEN", default_value = "127.0.0.1:8080", value_parser = Listen::resolve)]
    pub listen: Listen,
    #[command(flatten)]
    pub store: StoreOptions,
    #[command(flatten)]
    pub worker: WorkerOptions,
    /// File of the keys that are let in, read again when it changes; those in the database are, too.
    #[arg(long, env = "SKETCHMATCH_API_KEYS")]
    pub api_keys: Option<PathBuf>,
    /// Ask nobody for a key, also on an address that is not loopback.
    #[arg(long, env = "SKETCHMATCH_NO_AUTH", conflicts_with = "api_keys")]
    pub no_auth: bool,
    /// Address or name, and port, to answer /metrics, /healthz and /readyz on, to whoever reaches it.
    #[arg(long, env = "SKETCHMATCH_METRICS_LISTEN", value_parser = Listen::resolve)]
    pub metrics_listen: Option<Listen>,
    #[command(flatten)]
    pub tenants: TenantOptions,
    /// Origin that scripts of other sites may call from, or `*`; may be repeated.
    #[arg(long = "cors-origin", env = "SKETCHMATCH_CORS_ORIGIN", value_delimiter = ',')]
    pub cors_origins: Vec<Origin>,
    /// Name of a host to answer to beside local ones, as a proxy on this machine passes it on; may be repeated.
    #[arg(long = "allowed-host", env = "SKETCHMATCH_ALLOWED_HOST", value_delimiter = ',')]
    pub allowed_hosts: Vec<String>,
    /// Most connections at one time; fewer where the process may not have so many files open.
    #[arg(long, env = "SKETCHMATCH_MAX_CONNECTIONS", default_value_t = http::Config::default().max_connections)]
    pub max_connections: usize,
    /// How long a client may be silent before or within a request, and before it reads an answer.
    #[arg(long, env = "SKETCHMATCH_IDLE_TIMEOUT", default_value = "30s", value_parser = humantime::parse_duration)]
    pub idle_timeout: Duration,
    /// How long a request may take, its body included, until it is answered; more than the longest wait of 60 s.
    #[arg(long, env = "SKETCHMATCH_REQUEST_DEADLINE", default_value = "10m", value_parser = deadline)]
    pub request_deadline: Duration,
    /// Largest mesh or sketch file.
    #[arg(long, env = "SKETCHMATCH_MAX_UPLOAD_BYTES", default_value_t = size(http::Config::default().max_upload_bytes))]
    pub max_upload_bytes: ByteSize,
    /// Largest JSON request and SVG.
    #[arg(long, env = "SKETCHMATCH_MAX_REQUEST_BYTES", default_value_t = size(http::Config::default().max_request_bytes))]
    pub max_request_bytes: ByteSize,
    /// All uploads that are in memory at one time.
    #[arg(long, env = "SKETCHMATCH_MAX_UPLOADS_BYTES", default_value_t = size(http::Config::default().max_uploads_bytes))]
    pub max_uploads_bytes: ByteSize,
    /// Memory that reading takes at one time: pictures decoded, trees of documents, meshes, what answers are made of.
    #[arg(long, env = "SKETCHMATCH_MAX_READING_BYTES", default_value_t = size(http::Config::default().max_reading_bytes))]
    pub max_reading_bytes: ByteSize,
    /// Triangles of a mesh that are matched; of up to four times as many the surface is made coarser.
    #[arg(long, env = "SKETCHMATCH_MAX_TRIANGLES", default_value_t = http::Config::default().max_triangles)]
    pub max_triangles: usize,
    /// Most eigenpairs of a spectrum that can be asked for.
    #[arg(long, env = "SKETCHMATCH_MAX_EIGENPAIRS", default_value_t = http::Config::default().max_eigenpairs)]
    pub max_eigenpairs: usize,
    /// Memory one job may take, as estimated from its shapes before it is queued.
    #[arg(long, env = "SKETCHMATCH_MAX_JOB_MEMORY", default_value_t = size(http::Config::default().max_job_memory))]
    pub max_job_memory: ByteSize,
    /// Most jobs that wait.
    #[arg(long, env = "SKETCHMATCH_MAX_QUEUE", default_value_t = http::Config::default().max_queue)]
    pub max_queue: usize,
}

/// What a name or address and a port stand for: the first address that can be listened on is.
#[derive(Clone, Debug)]
pub struct Listen {
    text: String,
    addresses: Vec<SocketAddr>,
}

impl Listen {
    pub fn resolve(text: &str) -> Result<Listen, String> {
        let addresses = text.to_socket_addrs().map_err(|error| format!("{error}; an example is localhost:8080"))?;
        Ok(Listen { text: text.to_owned(), addresses: addresses.collect() })
    }

    pub fn addresses(&self) -> &[SocketAddr] {
        &self.addresses
    }
}

impl fmt::Display for Listen {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str(&self.text)
    }
}

fn size(bytes: usize) -> ByteSize {
    ByteSize(bytes as u64)
}

/// As many bytes as can be addressed, where it is more.
fn bytes(size: ByteSize) -> usize {
    usize::try_from(size.as_u64()).unwrap_or(usize::MAX)
}

/// A deadline that leaves room for the longest wait a client is granted.
fn deadline(text: &str) -> Result<Duration, String> {
    let deadline = humantime::parse_duration(text).map_err(|error| error.to_string())?;
    if deadline > http::LONGEST_WAIT { Ok(deadline) } else { Err("more than the longest wait of 60 s".to_owned()) }
}

impl ServeOptions {
    /// Whom to let in. Keys are asked for where a file of them is named or there ever was one in the database.
    ///
    /// # Errors
    /// A file of keys that cannot be read; no keys on an address that is not loopback, without `--no-auth`.
    pub async fn admission(&self, store: &Store) -> anyhow::Result<Admission> {
        let (listen, has_keys) = (&self.listen, store.has_keys().await?);
        if self.no_auth {
            if has_keys {
                tracing::warn!("--no-auth: the keys in the database are not asked for");
            }
            return Ok(Admission::Anybody);
        }
        let file = self.api_keys.as_deref().map(WatchedFile::open).transpose()?;
        if file.is_some() || has_keys {
            return Ok(Admission::Keyholders(file));
        }
        ensure!(
            listen.addresses().iter().all(|address| address.ip().is_loopback()),
            "{listen} is not a loopback address, so that anybody who reaches it could use the server: name a file of keys by \
             --api-keys, make one by `sketchmatch keys add`, or say --no-auth to ask nobody for a key"
        );
        Ok(Admission::Anybody)
    }

    pub fn http(&self) -> http::Config {
        http::Config {
            cors_origins: self.cors_origins.clone(),
            allowed_hosts: self.allowed_hosts.clone(),
            max_connections: self.max_connections,
            idle_timeout: self.idle_timeout,
            request_deadline: self.request_deadline,
            max_upload_bytes: bytes(self.max_upload_bytes),
            max_request_bytes: bytes(self.max_request_bytes),
            max_uploads_bytes: bytes(self.max_uploads_bytes),
            max_reading_bytes: bytes(self.max_reading_bytes),
            max_triangles: self.max_triangles,
            max_eigenpairs: self.max_eigenpairs,
            max_job_memory: bytes(self.max_job_memory),
            max_queue: self.max_queue,
            webhook_hosts: self.worker.webhook_hosts.clone().into(),
            ..http::Config::default()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::Parser;
    use sketchmatch::access::{Key, Scopes, Tenant};

    /// A command line of nothing but these options.
    #[derive(Debug, Parser)]
    struct Line {
        #[command(flatten)]
        options: ServeOptions,
    }

    fn read(arguments: &[&str]) -> Result<ServeOptions, clap::Error> {
        Line::try_parse_from(["serve"].iter().chain(arguments)).map(|line| line.options)
    }

    fn serve(arguments: &[&str]) -> ServeOptions {
        read(arguments).unwrap()
    }

    #[test]
    fn an_origin_that_cannot_match_is_refused() {
        let refused = read(&["--cors-origin", "https://a.example/"]).unwrap_err();
        assert!(refused.to_string().contains("without a path: https://a.example"), "{refused}");
        assert_eq!(serve(&["--cors-origin", "https://a.example,*"]).cors_origins.len(), 2);
    }

    #[test]
    fn a_request_may_take_longer_than_the_longest_wait() {
        assert_eq!(serve(&["--request-deadline", "2m"]).request_deadline, Duration::from_secs(120));
        assert!(read(&["--request-deadline", "60s"]).is_err());
    }

    #[tokio::test]
    async fn only_loopback_is_served_unasked() {
        let directory = tempfile::tempdir().unwrap();
        let store = Store::open(&store::Config::local(directory.path().join("data"))).await.unwrap();
        let file = directory.path().join("keys");
        std::fs::write(&file, "a-key").unwrap();
        let file = file.to_str().unwrap();
        // Whether keys are asked for; nothing where the server does not start.
        let asks = async |arguments: &[&str]| {
            let admission = serve(arguments).admission(&store).await;
            admission.ok().map(|admission| matches!(admission, Admission::Keyholders(_)))
        };
        let public = ["--listen", "0.0.0.0:8080"];
        for arguments in [&[][..], &["--listen", "[::1]:8080"], &["--listen", "localhost:8080"]] {
            assert_eq!(asks(arguments).await, Some(false), "{arguments:?}");
        }
        assert_eq!(asks(&public).await, None);
        assert_eq!(asks(&[&public[..], &["--no-auth"]].concat()).await, Some(false));
        assert_eq!(asks(&[&public[..], &["--api-keys", file]].concat()).await, Some(true));
        assert_eq!(asks(&["--api-keys", file]).await, Some(true));
        assert_eq!(asks(&["--api-keys", "/no/such/file"]).await, None);
        assert!(read(&["--api-keys", file, "--no-auth"]).is_err());

        let (key, scopes) = (Key::random().unwrap(), Scopes::default());
        let id = store.keys().add(&key, (&Tenant::default(), &scopes), None, None).await.unwrap();
        assert_eq!((asks(&[]).await, asks(&public).await), (Some(true), Some(true)));
        store.keys().revoke(&id).await.unwrap();
        assert_eq!((asks(&[]).await, asks(&["--no-auth"]).await), (Some(true), Some(false)));
    }

    #[test]
    fn a_place_that_cannot_be_is_refused() {
        for arguments in [["--database-url", "mysql://host/database"], ["--blob-url", "data/blobs"]] {
            assert!(read(&arguments).is_err(), "{arguments:?}");
        }
        let store = serve(&["--database-url", "postgres://me:secret@host/database", "--blob-url", "s3://bucket"]);
        assert!(!format!("{store:?}").contains("secret"));
    }

    #[test]
    fn tenants_are_limited_where_there_may_be_many() {
        let limits = |arguments: &[&str], admission| serve(arguments).tenants.limits(&admission);
        assert_eq!(limits(&[], Admission::Anybody), TenantLimits::default());
        let usual = limits(&[], Admission::Keyholders(None));
        assert_eq!((usual.requests_per_second, usual.queued_jobs), (NonZeroU32::new(100), Some(200)));
        assert_eq!(usual.open_requests, Some(200));
        assert_eq!((usual.stored_bytes, usual.cpu_per_hour), (None, None));
        let free = ["--tenant-requests-per-second", "0", "--tenant-open-requests", "0", "--tenant-queued-jobs", "0"];
        assert_eq!(limits(&free, Admission::Keyholders(None)), TenantLimits::default());
        let said = limits(&["--tenant-stored-bytes", "1GiB", "--tenant-cpu-seconds", "60"], Admission::Anybody);
        assert_eq!((said.stored_bytes, said.cpu_per_hour), (Some(1 << 30), Some(Duration::from_secs(60))));
    }

    #[test]
    fn sizes_are_read_with_and_without_units() {
        let largest = |size: &str| serve(&["--max-upload-bytes", size]).http().max_upload_bytes;
        for (size, bytes) in [("1000", 1000), ("2MiB", 2 << 20), ("2 MB", 2_000_000), ("1.5 GiB", 3 << 29)] {
            assert_eq!(largest(size), bytes, "{size}");
        }
        assert_eq!(serve(&[]).http().max_job_memory, http::Config::default().max_job_memory);
        for size in ["", "-1", "many", "1 XB", "MiB"] {
            assert!(read(&["--max-upload-bytes", size]).is_err(), "{size}");
        }
    }
}
