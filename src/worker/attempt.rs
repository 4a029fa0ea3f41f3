use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::time::Duration;

use bytes::Bytes;
use rayon::ThreadPool;
use tokio::runtime::Handle;
use tokio::sync::oneshot;
use tokio::time::{Instant, MissedTickBehavior, interval_at};
use tokio_util::sync::CancellationToken;

use super::failure::Failure;
use super::measures::{self, Ended};
use super::preparations::CachedPreparations;
use super::progress::Progress;
use super::spectra::CachedSpectra;
use crate::store::{Beat, Lease, Store, StoreError};

/// How often progress is reported, and cancelling noticed; a fraction of the lease.
const BEAT: Duration = Duration::from_millis(500);

/// What every attempt works with.
pub(super) struct Bench {
    pub store: Store,
    pub spectra: CachedSpectra,
    pub preparations: CachedPreparations,
    pub runtime: Handle,
    /// Cancelled when running jobs are to be given back.
    pub stop: CancellationToken,
    pool: ThreadPool,
    body: Box<Body>,
}

/// What a job does, on a thread of the pool.
type Body = dyn Fn(&Bench, &Lease, &Progress) -> Outcome + Send + Sync;

/// The result's bytes.
pub(super) type Outcome = Result<Bytes, Failure>;

impl Bench {
    /// A bench whose computations wait for the store by the calling runtime.
    pub fn new(store: Store, pool: ThreadPool, body: Box<Body>) -> Bench {
        let spectra = CachedSpectra::new(store.clone());
        let preparations = CachedPreparations::new(store.clone());
        Bench { store, spectra, preparations, runtime: Handle::current(), stop: CancellationToken::new(), pool, body }
    }
}

/// Carries out a leased job and reports how it ended. Returns when the thread is free again, or at once when the
/// bench stops.
pub(super) async fn attempt(bench: &Arc<Bench>, lease: Lease) {
    let measured = measures::Attempt::begin(lease.job.kind);
    let ended = carry_out(bench, &lease).await;
    measured.end(ended);
}

async fn carry_out(bench: &Arc<Bench>, lease: &Lease) -> Ended {
    let progress = Arc::new(Progress::default());
    let mut ended = start(bench, lease.clone(), progress.clone());
    let mut timer = interval_at(Instant::now() + BEAT, BEAT);
    timer.set_missed_tick_behavior(MissedTickBehavior::Delay);
    let mut taken_away = None;
    loop {
        tokio::select! {
            biased;
            outcome = &mut ended => {
                let outcome = outcome.unwrap_or_else(|_| Err(Failure::internal("the thread is gone", true)));
                return match taken_away {
                    Some(ended) => ended,
                    None => report(&bench.store, lease, outcome).await.unwrap_or_else(unreported),
                };
            }
            () = bench.stop.cancelled() => {
                progress.stop();
                return match taken_away {
                    Some(ended) => ended,
                    None => released(&bench.store, lease).await.unwrap_or_else(unreported),
                };
            }
            _ = timer.tick(), if taken_away.is_none() => {
                taken_away = beaten(&bench.store, lease, &progress).await;
                if taken_away.is_some() {
                    progress.stop();
                }
            }
        }
    }
}

/// Reports progress; how the attempt ended for us if the job is ours no more.
async fn beaten(store: &Store, lease: &Lease, progress: &Progress) -> Option<Ended> {
    let (stage, fraction) = progress.at();
    match store.beat(lease, stage, fraction).await {
        Ok(Beat::Held) => None,
        Ok(Beat::Cancelled) => Some(Ended::Cancelled),
        Ok(Beat::Lost) => Some(Ended::Lost),
        Err(error) => {
            tracing::error!(%error, "a job's progress cannot be reported");
            None
        }
    }
}

/// Starts the computation on the pool; the receiver gets its outcome, a panic included.
fn start(bench: &Arc<Bench>, lease: Lease, progress: Arc<Progress>) -> oneshot::Receiver<Outcome> {
    let (sender, receiver) = oneshot::channel();
    let bench_there = bench.clone();
    bench.pool.spawn(move || {
        let run = AssertUnwindSafe(|| (bench_there.body)(&bench_there, &lease, &progress));
        let outcome = catch_unwind(run).unwrap_or_else(|panic| Err(Failure::internal(message(panic), false)));
        // Nobody listens any more when the bench has stopped.
        let _ = sender.send(outcome);
    });
    receiver
}

async fn report(store: &Store, lease: &Lease, outcome: Outcome) -> Result<Ended, StoreError> {
    let failure = match outcome {
        Ok(result) => match store.succeed(lease, result).await {
            Ok(published) => return Ok(if published { Ended::Succeeded } else { Ended::Lost }),
            Err(error) => Failure::from(error),
        },
        Err(failure) => failure,
    };
    match failure {
        Failure::Stopped => released(store, lease).await,
        Failure::Problem { problem, retry } => {
            Ok(if store.fail(lease, &problem, retry).await? { Ended::Failed } else { Ended::Lost })
        }
    }
}

async fn released(store: &Store, lease: &Lease) -> Result<Ended, StoreError> {
    Ok(if store.release(lease).await? { Ended::Released } else { Ended::Lost })
}

/// What is not reported now is found out when the lease runs out.
fn unreported(error: StoreError) -> Ended {
    tracing::error!(%error, "a job cannot be reported on");
    Ended::Lost
}

fn message(panic: Box<dyn Any + Send>) -> String {
    let text = panic.downcast_ref::<String>().map(String::as_str).or_else(|| panic.downcast_ref::<&str>().copied());
    format!("panic: {}", text.unwrap_or("no message"))
}
