use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;

use tokio::sync::oneshot;
use tokio::time::{Instant, MissedTickBehavior, interval_at};

use super::bench::{Bench, Outcome};
use super::failure::Failure;
use super::measures::{self, Ended};
use super::progress::Progress;
use super::report;
use crate::store::Lease;

/// Carries out a leased job and reports how it ended. Returns when the thread is free again, or at once when the
/// bench stops.
pub(super) async fn attempt(bench: &Arc<Bench>, lease: Lease) {
    let (job, kind, attempt) = (lease.job.id.as_str(), lease.job.kind.as_str(), lease.job.attempt);
    tracing::info!(job, kind, attempt, "a job begins");
    let measured = measures::Attempt::begin(lease.job.kind);
    let ended = carry_out(bench, &lease).await;
    let seconds = measured.end(ended);
    tracing::info!(job, kind, attempt, outcome = ended.name(), seconds, "a job ends");
}

async fn carry_out(bench: &Arc<Bench>, lease: &Lease) -> Ended {
    let progress = Arc::new(Progress::default());
    let mut changes = bench.store.job_changes(&lease.job.id);
    let mut ended = start(bench, lease.clone(), progress.clone());
    let begun = Instant::now();
    let mut timer = interval_at(begun + bench.beat, bench.beat);
    timer.set_missed_tick_behavior(MissedTickBehavior::Delay);
    let mut taken_away = None;
    loop {
        tokio::select! {
            biased;
            outcome = &mut ended => {
                let outcome = outcome.unwrap_or_else(|_| Err(Failure::internal("the thread is gone", true)));
                return match taken_away {
                    Some(ended) => ended,
                    None => report::until_told(bench, lease, &progress, &outcome).await,
                };
            }
            () = bench.stop.cancelled() => {
                progress.stop();
                return match taken_away {
                    Some(ended) => ended,
                    None => report::released(bench, lease).await,
                };
            }
            () = changes.cancelled(), if taken_away.is_none() => taken_away = Some(Ended::Cancelled),
            _ = timer.tick(), if taken_away.is_none() => {
                taken_away = if begun.elapsed() < bench.longest_job {
                    report::beaten(&bench.store, lease, &progress).await
                } else {
                    progress.stop();
                    let overdue = Err(Failure::overdue(bench.longest_job));
                    Some(report::until_told(bench, lease, &progress, &overdue).await)
                };
            }
        }
        if taken_away.is_some() {
            progress.stop();
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

fn message(panic: Box<dyn Any + Send>) -> String {
    let text = panic.downcast_ref::<String>().map(String::as_str).or_else(|| panic.downcast_ref::<&str>().copied());
    format!("panic: {}", text.unwrap_or("no message"))
}
