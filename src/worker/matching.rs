use std::time::Instant;

use bytes::Bytes;

use super::bench::Bench;
use super::failure::Failure;
use super::measures;
use super::progress::Progress;
use crate::pipeline::{self, Settings, Surroundings};
use crate::store::Lease;

/// The correspondence of a sketch and a mesh as JSON.
pub(super) fn run(bench: &Bench, lease: &Lease, progress: &Progress) -> Result<Bytes, Failure> {
    let settings: Settings = serde_json::from_str(&lease.payload).map_err(|error| Failure::internal(error, false))?;
    let sketch = bench.runtime.block_on(bench.store.sketch(&settings.sketch))?;
    let sketch = sketch.ok_or_else(|| Failure::refused(format_args!("there is no sketch {}", settings.sketch), &[]))?;
    let mesh = bench.runtime.block_on(bench.store.mesh(&settings.mesh))?;
    let mesh = mesh.ok_or_else(|| Failure::refused(format_args!("there is no mesh {}", settings.mesh), &[]))?;
    let begun = Instant::now();
    let clock = || begun.elapsed().as_secs_f64() * 1e3;
    let surroundings =
        Surroundings { spectra: &bench.spectra, preparations: &bench.preparations, watcher: progress, clock: &clock };
    let mut result = pipeline::run(&sketch, &mesh, &settings, &surroundings)?;
    measures::stages(&result.timings_ms);
    result.id = Some(lease.job.id.clone());
    Ok(serde_json::to_vec(&result).map_err(|error| Failure::internal(error, false))?.into())
}
