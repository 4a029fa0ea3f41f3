//! What the worker measures of its jobs.

use std::time::Instant;

use metrics::{counter, describe_counter, describe_gauge, describe_histogram, gauge, histogram};

use crate::access::Tenant;
use crate::jobs::{KINDS, Kind};
use crate::store::{Job, Priority};

/// How an attempt at a job came to its end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Ended {
    Succeeded,
    /// With a problem.
    Failed,
    /// With a problem, to be tried again.
    Retried,
    /// Given back because the process lacks what it takes.
    Postponed,
    /// By a client.
    Cancelled,
    /// Given back because the worker stops.
    Released,
    /// The lease ran out meanwhile, or nobody could be told.
    Lost,
}

impl Ended {
    const ALL: [Ended; 7] = [
        Ended::Succeeded,
        Ended::Failed,
        Ended::Retried,
        Ended::Postponed,
        Ended::Cancelled,
        Ended::Released,
        Ended::Lost,
    ];

    /// The name in measures and log lines.
    pub fn name(self) -> &'static str {
        match self {
            Ended::Succeeded => "succeeded",
            Ended::Failed => "failed",
            Ended::Retried => "retried",
            Ended::Postponed => "postponed",
            Ended::Cancelled => "cancelled",
            Ended::Released => "released",
            Ended::Lost => "lost",
        }
    }
}

const RUNNING: &str = "sketchmatch_jobs_running";
const ENDED: &str = "sketchmatch_jobs_total";
const SECONDS: &str = "sketchmatch_job_seconds";
const WAITED: &str = "sketchmatch_job_wait_seconds";

/// Says what is measured here and sets it to nothing, so that what has not happened yet is 0 and not unknown.
pub(super) fn describe() {
    describe_gauge!(RUNNING, "Jobs that are being computed.");
    describe_counter!(ENDED, "Attempts at jobs that came to an end, by kind and outcome.");
    describe_histogram!(SECONDS, "Seconds from the begin of an attempt at a job to its end, by kind.");
    describe_histogram!(
        WAITED,
        "Seconds from when a job was asked for to the begin of an attempt at it, by priority and by whether its tenant has a name."
    );
    gauge!(RUNNING).set(0);
    for priority in [Priority::Interactive, Priority::Batch] {
        for tenant in ["default", "named"] {
            let _ = histogram!(WAITED, "priority" => priority.as_str(), "tenant" => tenant);
        }
    }
    for Kind { name, .. } in &KINDS {
        let _ = histogram!(SECONDS, "kind" => *name);
        for outcome in Ended::ALL {
            counter!(ENDED, "kind" => *name, "outcome" => outcome.name()).absolute(0);
        }
    }
}

/// An attempt under way: one of [`RUNNING`].
pub(super) struct Attempt {
    kind: String,
    begun: Instant,
}

impl Attempt {
    pub fn begin(job: &Job) -> Attempt {
        gauge!(RUNNING).increment(1);
        let tenant = if job.tenant == Tenant::default() { "default" } else { "named" };
        let waited_ms = job.started_ms.map_or(0, |started| started - job.created_ms);
        histogram!(WAITED, "priority" => job.priority.as_str(), "tenant" => tenant).record(waited_ms as f64 / 1e3);
        Attempt { kind: job.kind.clone(), begun: Instant::now() }
    }

    /// Counts the attempt and its time, and returns the seconds it took.
    pub fn end(self, ended: Ended) -> f64 {
        let (kind, seconds) = (self.kind.clone(), self.begun.elapsed().as_secs_f64());
        counter!(ENDED, "kind" => kind.clone(), "outcome" => ended.name()).increment(1);
        histogram!(SECONDS, "kind" => kind).record(seconds);
        seconds
    }
}

impl Drop for Attempt {
    fn drop(&mut self) {
        gauge!(RUNNING).decrement(1);
    }
}

#[cfg(test)]
mod tests {
    use metrics_exporter_prometheus::PrometheusBuilder;

    use super::*;
    use crate::store::testing::{ALL, fresh};
    use crate::store::{NewJob, Places};

    #[tokio::test]
    async fn attempts_are_measured_by_name() {
        let (_place, store) = fresh().await;
        let mut leases = Vec::new();
        for (kind, priority) in [("match", Priority::Interactive), ("spectrum", Priority::Batch)] {
            let job = NewJob { priority, ..NewJob::of(kind, "{}") };
            store.submit(&job, Places { queue: 9, of_kind: 9 }).await.unwrap();
            leases.push(store.claim(&[kind], ALL).await.unwrap().unwrap());
        }
        let recorder = PrometheusBuilder::new().build_recorder();
        let text = metrics::with_local_recorder(&recorder, || {
            describe();
            let _running = Attempt::begin(&leases[0].job);
            Attempt::begin(&leases[1].job).end(Ended::Cancelled);
            recorder.handle().render()
        });
        for line in [
            "# HELP sketchmatch_jobs_running Jobs that are being computed.",
            "sketchmatch_jobs_running 1",
            "sketchmatch_jobs_total{kind=\"spectrum\",outcome=\"cancelled\"} 1",
            "sketchmatch_jobs_total{kind=\"match\",outcome=\"failed\"} 0",
            "sketchmatch_job_seconds_count{kind=\"spectrum\"} 1",
            "sketchmatch_job_seconds_count{kind=\"match\"} 0",
            "sketchmatch_job_wait_seconds_count{priority=\"batch\",tenant=\"default\"} 1",
            "sketchmatch_job_wait_seconds_count{priority=\"batch\",tenant=\"named\"} 0",
        ] {
            assert!(text.lines().any(|found| found == line), "{line}: {text}");
        }
    }
}
