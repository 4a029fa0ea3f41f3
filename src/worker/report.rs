//! What the store is told of an attempt.

use std::time::Duration;

use bytes::Bytes;
use tokio::time::{Instant, sleep};

use super::measures::Ended;
use super::workshop::Workshop;
use crate::jobs::{Failure, Outcome, Progress};
use crate::store::{Heartbeat, Lease, State, Store, StoreError};

/// How long an outcome is kept for a store that lacks what it takes to hear of it.
const PATIENCE: Duration = Duration::from_secs(300);

/// Rest before the store is told again; it doubles every time, up to a fraction of the lease.
const FIRST_REST: Duration = Duration::from_millis(250);

const LONGEST_REST: Duration = Duration::from_secs(8);

/// Reports progress; how the attempt ended for us if the job is ours no more.
pub(super) async fn beaten(store: &Store, lease: &Lease, progress: &Progress) -> Option<Ended> {
    let (stage, fraction) = progress.at();
    ended_by(store.heartbeat(lease, stage, fraction).await)
}

/// Keeps what the outcome looks like at first sight; how the attempt ended for us if the job is ours no more.
pub(super) async fn previewed(store: &Store, lease: &Lease, progress: &Progress, preview: Bytes) -> Option<Ended> {
    let (_, fraction) = progress.at();
    ended_by(store.preview(lease, &preview, fraction).await)
}

fn ended_by(heartbeat: Result<Heartbeat, StoreError>) -> Option<Ended> {
    match heartbeat {
        Ok(Heartbeat::Held) => None,
        Ok(Heartbeat::Cancelled) => Some(Ended::Cancelled),
        Ok(Heartbeat::Lost) => Some(Ended::Lost),
        Err(error) => {
            tracing::error!(%error, "a job's progress cannot be reported");
            None
        }
    }
}

/// Tells the store the outcome, again and again while it lacks what it takes: what was computed is not to be lost to a
/// want that passes.
pub(super) async fn until_told(workshop: &Workshop, lease: &Lease, progress: &Progress, outcome: &Outcome) -> Ended {
    let (begun, mut rest) = (Instant::now(), FIRST_REST);
    loop {
        let error = match told(workshop.store(), lease, outcome).await {
            Ok(ended) => return ended,
            Err(error) => error,
        };
        if error.lack().is_none() || begun.elapsed() > PATIENCE {
            tracing::error!(%error, "a job cannot be reported on");
            return postponed(workshop.store(), lease).await.unwrap_or_else(unreported);
        }
        tracing::warn!(%error, "a job cannot be reported on yet");
        if workshop.stop.run_until_cancelled(sleep(rest)).await.is_none() {
            return released(workshop, lease).await;
        }
        if let Some(ended) = beaten(workshop.store(), lease, progress).await {
            return ended;
        }
        rest = LONGEST_REST.min(2 * rest);
    }
}

async fn told(store: &Store, lease: &Lease, outcome: &Outcome) -> Result<Ended, StoreError> {
    let ours = |ours: bool, ended: Ended| if ours { ended } else { Ended::Lost };
    match outcome {
        Ok(result) => Ok(ours(store.succeed(lease, result.clone()).await?, Ended::Succeeded)),
        Err(Failure::Stopped) => Ok(ours(store.release(lease).await?, Ended::Released)),
        Err(Failure::Lacking) => postponed(store, lease).await,
        Err(Failure::Problem { problem, retry: false }) => Ok(ours(store.fail(lease, problem).await?, Ended::Failed)),
        Err(Failure::Problem { problem, retry: true }) => Ok(match store.retry(lease, problem).await? {
            Some(State::Queued) => Ended::Retried,
            Some(_) => Ended::Failed,
            None => Ended::Lost,
        }),
    }
}

async fn postponed(store: &Store, lease: &Lease) -> Result<Ended, StoreError> {
    Ok(if store.postpone(lease).await? { Ended::Postponed } else { Ended::Lost })
}

/// Gives the job back to the queue.
pub(super) async fn released(workshop: &Workshop, lease: &Lease) -> Ended {
    match workshop.store().release(lease).await {
        Ok(true) => Ended::Released,
        Ok(false) => Ended::Lost,
        Err(error) => unreported(error),
    }
}

/// What is not reported now is found out when the lease runs out.
fn unreported(error: StoreError) -> Ended {
    tracing::error!(%error, "a job cannot be given back");
    Ended::Lost
}
