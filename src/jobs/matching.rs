//! A sketch matched to a mesh.

use std::collections::BTreeMap;
use std::time::Instant;

use metrics::{describe_histogram, histogram};

use super::{Bench, Failure, Progress, Task, memory};
use crate::pipeline::outcome::MatchResult;
use crate::pipeline::settings::upsampled;
use crate::pipeline::{self, Settings, Stage, Surroundings, TOTAL};

const STAGE_SECONDS: &str = "sketchmatch_stage_seconds";

/// The settings of a match say all there is to do.
impl Task for Settings {
    const NAME: &'static str = "match";
    type Outcome = MatchResult;

    fn shapes(&self) -> [Option<&str>; 2] {
        [Some(&self.mesh), Some(&self.sketch)]
    }

    fn bytes_per_vertex(&self) -> usize {
        let (k, l) = upsampled(self);
        memory::of_spectrum(k.max(l))
    }

    fn bytes_besides(&self) -> usize {
        memory::of_map(self)
    }

    /// The correspondence of the sketch and the mesh.
    fn run(self, id: &str, bench: &Bench, progress: &Progress) -> Result<MatchResult, Failure> {
        let sketch = bench.answer(bench.store.sketch(&self.sketch), progress)?;
        let sketch = sketch.ok_or_else(|| Failure::refused(format_args!("there is no sketch {}", self.sketch), &[]))?;
        let mesh = bench.answer(bench.store.mesh(&self.mesh), progress)?;
        let mesh = mesh.ok_or_else(|| Failure::refused(format_args!("there is no mesh {}", self.mesh), &[]))?;
        let begun = Instant::now();
        let clock = || begun.elapsed().as_secs_f64() * 1e3;
        let caches = &bench.caches;
        let preview = |result: MatchResult| {
            let result = MatchResult { id: Some(id.to_owned()), ..result };
            // Numbers and strings are always written.
            progress.preview(serde_json::to_vec(&result).unwrap_or_default().into());
        };
        let surroundings = Surroundings {
            spectra: caches,
            preparations: caches,
            watcher: progress,
            clock: &clock,
            preview: Some(&preview),
        };
        let result = pipeline::run(&sketch, &mesh, &self, &surroundings)?;
        measure(&result.timings_ms);
        Ok(MatchResult { id: Some(id.to_owned()), ..result })
    }
}

/// Says what is measured here and sets it to nothing, so that what has not happened yet is 0 and not unknown.
pub fn describe() {
    describe_histogram!(STAGE_SECONDS, "Seconds a match spent in a stage.");
    for stage in Stage::ALL {
        let _ = histogram!(STAGE_SECONDS, "stage" => stage.name());
    }
}

/// Takes the times of a match's stages, in milliseconds, into [`STAGE_SECONDS`].
fn measure(milliseconds: &BTreeMap<String, f64>) {
    for (stage, taken) in milliseconds.iter().filter(|(stage, _)| *stage != TOTAL) {
        histogram!(STAGE_SECONDS, "stage" => stage.clone()).record(taken / 1e3);
    }
}

#[cfg(test)]
mod tests {
    use metrics_exporter_prometheus::PrometheusBuilder;

    use super::*;

    #[test]
    fn stages_are_measured_by_name() {
        let recorder = PrometheusBuilder::new().build_recorder();
        let text = metrics::with_local_recorder(&recorder, || {
            describe();
            measure(&BTreeMap::from([("map".to_owned(), 250.0), (TOTAL.to_owned(), 300.0)]));
            recorder.handle().render()
        });
        for line in [
            "sketchmatch_stage_seconds_sum{stage=\"map\"} 0.25",
            "sketchmatch_stage_seconds_count{stage=\"regions\"} 0",
        ] {
            assert!(text.lines().any(|found| found == line), "{line}: {text}");
        }
        assert!(!text.contains("total\"}"), "{text}");
    }
}
