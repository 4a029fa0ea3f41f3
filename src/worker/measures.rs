//! What the worker measures of its jobs.

use std::collections::BTreeMap;
use std::time::Instant;

use metrics::{counter, gauge, histogram};

use crate::pipeline::TOTAL;
use crate::store::JobKind;

/// How an attempt at a job came to its end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Ended {
    Succeeded,
    /// With a problem; the job may be tried again.
    Failed,
    /// By a client.
    Cancelled,
    /// Given back because the worker stops.
    Released,
    /// The lease ran out meanwhile, or nobody could be told.
    Lost,
}

impl Ended {
    fn name(self) -> &'static str {
        match self {
            Ended::Succeeded => "succeeded",
            Ended::Failed => "failed",
            Ended::Cancelled => "cancelled",
            Ended::Released => "released",
            Ended::Lost => "lost",
        }
    }
}

/// An attempt under way: one of `jobs_running`.
pub(super) struct Attempt {
    kind: JobKind,
    begun: Instant,
}

impl Attempt {
    pub fn begin(kind: JobKind) -> Attempt {
        gauge!("jobs_running").increment(1);
        Attempt { kind, begun: Instant::now() }
    }

    /// Counts the attempt in `jobs_total` and its time in `job_seconds`.
    pub fn end(self, ended: Ended) {
        let kind = self.kind.as_str();
        counter!("jobs_total", "kind" => kind, "outcome" => ended.name()).increment(1);
        histogram!("job_seconds", "kind" => kind).record(self.begun.elapsed().as_secs_f64());
    }
}

impl Drop for Attempt {
    fn drop(&mut self) {
        gauge!("jobs_running").decrement(1);
    }
}

/// Takes the times of a match's stages, in milliseconds, into `stage_seconds`.
pub(super) fn stages(milliseconds: &BTreeMap<String, f64>) {
    for (stage, taken) in milliseconds.iter().filter(|(stage, _)| *stage != TOTAL) {
        histogram!("stage_seconds", "stage" => stage.clone()).record(taken / 1e3);
    }
}

#[cfg(test)]
mod tests {
    use metrics_exporter_prometheus::PrometheusBuilder;

    use super::*;

    #[test]
    fn attempts_and_stages_are_measured_by_name() {
        let recorder = PrometheusBuilder::new().build_recorder();
        let text = metrics::with_local_recorder(&recorder, || {
            let _running = Attempt::begin(JobKind::Match);
            Attempt::begin(JobKind::Spectrum).end(Ended::Cancelled);
            stages(&BTreeMap::from([("map".to_owned(), 250.0), (TOTAL.to_owned(), 300.0)]));
            recorder.handle().render()
        });
        for line in [
            "jobs_running 1",
            "jobs_total{kind=\"spectrum\",outcome=\"cancelled\"} 1",
            "job_seconds_count{kind=\"spectrum\"} 1",
            "stage_seconds_sum{stage=\"map\"} 0.25",
        ] {
            assert!(text.lines().any(|found| found == line), "{line}: {text}");
        }
        assert!(!text.contains("total\"}"), "{text}");
    }
}
