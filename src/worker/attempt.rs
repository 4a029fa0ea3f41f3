use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::time::Duration;

use rustix::time::{ClockId, clock_gettime};
use tokio::runtime::Handle;
use tokio::sync::oneshot;
use tokio::time::{Instant, MissedTickBehavior, interval_at};
use tracing::Instrument;

use super::measures::{self, Ended};
use super::report;
use super::workshop::Workshop;
use crate::jobs::{Failure, Outcome, Progress};
use crate::store::{Lease, Store};
use crate::traces;

/// Carries out a leased job and reports how it ended. Returns when the thread is free again, or at once when the
/// bench stops.
pub(super) async fn attempt(workshop: &Arc<Workshop>, lease: Lease) {
    let (job, kind, attempt) = (lease.job.id.as_str(), lease.job.kind.as_str(), lease.job.attempt);
    tracing::info!(job, kind, attempt, "a job begins");
    let measured = measures::Attempt::begin(&lease.job);
    let waited_ms = lease.job.started_ms.unwrap_or(lease.job.created_ms) - lease.job.created_ms;
    // For traces alone: the log has these in lines of their own.
    let span = tracing::debug_span!("job", job, kind, attempt, waited_ms);
    if let Some(trace) = &lease.job.trace {
        traces::join(&span, trace);
    }
    let ended = carry_out(workshop, &lease).instrument(span).await;
    let seconds = measured.end(ended);
    tracing::info!(job, kind, attempt, outcome = ended.name(), seconds, "a job ends");
}

async fn carry_out(workshop: &Arc<Workshop>, lease: &Lease) -> Ended {
    let progress = Arc::new(Progress::default());
    let mut changes = workshop.store().job_changes(&lease.job.id);
    let mut ended = start(workshop, lease.clone(), progress.clone());
    let begun = Instant::now();
    let mut timer = interval_at(begun + workshop.beat, workshop.beat);
    timer.set_missed_tick_behavior(MissedTickBehavior::Delay);
    let mut taken_away = None;
    loop {
        tokio::select! {
            biased;
            outcome = &mut ended => {
                let outcome = outcome.unwrap_or_else(|_| Err(Failure::internal("the thread is gone", true)));
                return match taken_away {
                    Some(ended) => ended,
                    None => report::until_told(workshop, lease, &progress, &outcome).await,
                };
            }
            () = workshop.stop.cancelled() => {
                progress.stop();
                return match taken_away {
                    Some(ended) => ended,
                    None => report::released(workshop, lease).await,
                };
            }
            () = changes.cancelled(), if taken_away.is_none() => taken_away = Some(Ended::Cancelled),
            preview = progress.previewed(), if taken_away.is_none() => {
                taken_away = report::previewed(workshop.store(), lease, &progress, preview).await;
            }
            _ = timer.tick(), if taken_away.is_none() => {
                taken_away = if begun.elapsed() < workshop.longest_job {
                    report::beaten(workshop.store(), lease, &progress).await
                } else {
                    progress.stop();
                    let overdue = Err(Failure::overdue(workshop.longest_job));
                    Some(report::until_told(workshop, lease, &progress, &overdue).await)
                };
            }
        }
        if taken_away.is_some() {
            progress.stop();
        }
    }
}

/// Starts the computation on the pool; the receiver gets its outcome, a panic included.
fn start(workshop: &Arc<Workshop>, lease: Lease, progress: Arc<Progress>) -> oneshot::Receiver<Outcome> {
    let (sender, receiver) = oneshot::channel();
    let (there, runtime, span) = (workshop.clone(), Handle::current(), tracing::debug_span!("computing"));
    workshop.pool.spawn(move || {
        let _within = span.enter();
        let begun = processor_time();
        let run = AssertUnwindSafe(|| (there.body)(&lease, &there.bench, &progress));
        let outcome = catch_unwind(run).unwrap_or_else(|panic| Err(Failure::internal(message(panic), false)));
        charge(&runtime, there.store().of(&lease.job.tenant), processor_time().saturating_sub(begun));
        // Nobody listens any more when the bench has stopped.
        let _ = sender.send(outcome);
    });
    receiver
}

/// The processor time that this thread has had.
fn processor_time() -> Duration {
    let time = clock_gettime(ClockId::ThreadCPUTime);
    Duration::try_from(time).unwrap_or_default()
}

/// Has the tenant's account show what a job took; the job does not wait for it, nor fail by it.
fn charge(runtime: &Handle, store: Store, cpu: Duration) {
    runtime.spawn(async move {
        if let Err(error) = store.charge(cpu).await {
            tracing::warn!(%error, "the processor time of a job is not counted");
        }
    });
}

fn message(panic: Box<dyn Any + Send>) -> String {
    let text = panic.downcast_ref::<String>().map(String::as_str).or_else(|| panic.downcast_ref::<&str>().copied());
    format!("panic: {}", text.unwrap_or("no message"))
}
