//! Claims a job, runs it on the bounded pool, reports.
//!
//! A job is claimed only when a thread is free for it. The computation runs on that thread and knows nothing of the
//! queue; a task beside it reports its progress, extends the lease and passes on that somebody cancelled it.

mod admission;
mod attempt;
mod measures;
mod pool;
mod report;
mod shares;
mod webhooks;
mod workshop;

use std::num::NonZero;
use std::sync::Arc;
use std::thread;
use std::time::Duration;

use rayon::ThreadPoolBuildError;
use tokio::sync::Semaphore;
use tokio::time::{sleep, timeout};
use tokio_util::sync::CancellationToken;
use tokio_util::task::TaskTracker;

use crate::jobs::{self, Bench, Failure, GRACE, Outcome, Progress};
use crate::store::{self, Gone, LEASE, Lease, Retention, Store};
use crate::webhooks::{Caller, Hosts};
use admission::Admission;
use shares::Shares;
use workshop::Workshop;

/// How often the queue is looked at when nobody tells of a change: jobs that have rested enough do not.
const POLL: Duration = Duration::from_secs(1);

/// How often blobs that nothing names are looked for, and how old they have to be: nobody who writes one takes as long to
/// name it.
const SWEEP: Duration = Duration::from_secs(3600);

/// How often what was kept for its time is looked for: what is temporary goes within this of its end.
const LET_GO: Duration = Duration::from_secs(60);

/// How the worker behaves.
#[derive(Clone, Debug)]
pub struct Config {
    /// Jobs computed at the same time, each on a thread of its own; with none the queue is looked after all the same.
    pub workers: usize,
    /// How long running jobs may go on after the stop, before they are given back to the queue.
    pub grace: Duration,
    /// How long a job may take, after which it fails.
    pub longest_job: Duration,
    /// How long things are kept.
    pub retention: Retention,
    /// Bytes of memory that running jobs may take together, as estimated; one that takes more by itself runs alone.
    pub memory: u64,
    /// Whom this node may tell of the ends of jobs.
    pub webhook_hosts: Hosts,
}

impl Default for Config {
    fn default() -> Config {
        let workers = thread::available_parallelism().map_or(1, NonZero::get);
        Config {
            workers,
            grace: GRACE,
            longest_job: Duration::from_secs(3600),
            memory: 8 << 30,
            retention: Retention::default(),
            webhook_hosts: Hosts::default(),
        }
    }
}

/// Works on the queue until `shutdown`, then finishes what is running or, after `config.grace`, gives it back.
///
/// # Errors
/// The system refused the threads.
pub async fn run(store: Store, config: Config, shutdown: CancellationToken) -> Result<(), ThreadPoolBuildError> {
    let pool = pool::of(config.workers.max(1))?;
    measures::describe();
    jobs::describe();
    store::describe();
    webhooks::describe();
    work(&Arc::new(Workshop::new(store, pool, config.longest_job, Box::new(compute))), &config, &shutdown).await;
    Ok(())
}

/// A kind that is unknown here is known to another version of the program, and never claimed.
fn compute(lease: &Lease, bench: &Bench, progress: &Progress) -> Outcome {
    let unknown = || Failure::internal(format_args!("no job is of the kind {}", lease.job.kind), true);
    jobs::kind(&lease.job.kind).ok_or_else(unknown)?.run(lease, bench, progress)
}

async fn work(workshop: &Arc<Workshop>, config: &Config, shutdown: &CancellationToken) {
    let attempts = TaskTracker::new();
    tokio::join!(
        claim_until(shutdown, workshop, &attempts, config),
        reap_until(shutdown, workshop.store()),
        sweep_until(shutdown, workshop.store()),
        let_go_until(shutdown, workshop.store(), &config.retention),
        call_until(shutdown, workshop.store(), &config.webhook_hosts)
    );
    attempts.close();
    if timeout(config.grace, attempts.wait()).await.is_err() {
        workshop.stop.cancel();
        attempts.wait().await;
    }
}

/// Claims jobs as threads and memory become free. A claim that has begun is carried through: a job must not be leased to
/// nobody.
async fn claim_until(shutdown: &CancellationToken, workshop: &Arc<Workshop>, attempts: &TaskTracker, config: &Config) {
    let (slots, shares) = (Arc::new(Semaphore::new(config.workers)), Arc::new(Shares::new(config.workers)));
    let admission = Arc::new(Admission::new(config.memory));
    let mut changes = workshop.store().queue_changes();
    while let Some(Ok(slot)) = shutdown.run_until_cancelled(slots.clone().acquire_owned()).await {
        changes.seen();
        let claimed = match admission.room() {
            Some(room) => workshop.store().claim(&shares.turn(), room).await,
            None => Ok(None),
        };
        match claimed {
            Ok(Some(lease)) => {
                let (workshop, share) = (workshop.clone(), jobs::kind(&lease.job.kind).map(|kind| shares.take(kind)));
                let admitted = admission.admit(&lease);
                attempts.spawn(async move {
                    attempt::attempt(&workshop, lease).await;
                    // In this order: whoever is told of the share finds the room.
                    drop((admitted, slot, share));
                });
            }
            Ok(None) => {
                let work = async {
                    tokio::select! {
                        () = changes.changed() => {}
                        () = shares.freed.notified() => {}
                        () = sleep(POLL) => {}
                    }
                };
                shutdown.run_until_cancelled(work).await;
            }
            Err(error) => {
                tracing::error!(%error, "no job can be claimed");
                shutdown.run_until_cancelled(sleep(POLL)).await;
            }
        }
    }
}

/// Takes jobs from workers that died, well before another lease could have run out.
async fn reap_until(shutdown: &CancellationToken, store: &Store) {
    while shutdown.run_until_cancelled(sleep(LEASE / 3)).await.is_some() {
        match store.reap().await {
            Ok(0) => {}
            Ok(jobs) => tracing::warn!(jobs, "leases ran out: the jobs are queued again, or failed at their last try"),
            Err(error) => tracing::error!(%error, "leases cannot be checked"),
        }
    }
}

/// Sets aside what nodes that died left among the blobs, one node at a time.
async fn sweep_until(shutdown: &CancellationToken, store: &Store) {
    while shutdown.run_until_cancelled(sleep(SWEEP)).await.is_some() {
        let swept = async {
            let claim = store.take("sweep").await?;
            if claim.is_some() { store.sweep(SWEEP).await } else { Ok(0) }
        };
        match shutdown.run_until_cancelled(swept).await {
            Some(Err(error)) => tracing::error!(%error, "the blobs cannot be swept"),
            Some(Ok(blobs)) => tracing::debug!(blobs, "the blobs are swept"),
            None => {}
        }
    }
}

/// Tells of the ends of jobs where it may.
async fn call_until(shutdown: &CancellationToken, store: &Store, hosts: &Hosts) {
    if hosts.is_empty() {
        return;
    }
    match Caller::new(hosts.clone()) {
        Ok(caller) => webhooks::call_until(shutdown, store, caller).await,
        Err(error) => tracing::error!(%error, "nobody can be told of the ends of jobs"),
    }
}

/// Deletes what was kept for its time.
async fn let_go_until(shutdown: &CancellationToken, store: &Store, retention: &Retention) {
    while shutdown.run_until_cancelled(sleep(LET_GO)).await.is_some() {
        match shutdown.run_until_cancelled(store.let_go(retention)).await {
            Some(Ok(gone)) if gone != Gone::default() => {
                let Gone { results, jobs, uploads } = gone;
                tracing::info!(results, jobs, uploads, "what was kept for its time is deleted");
            }
            Some(Err(error)) => tracing::error!(%error, "what was kept for its time cannot be deleted"),
            _ => {}
        }
    }
}

#[cfg(test)]
mod tests;
