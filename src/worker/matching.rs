use bytes::Bytes;

use super::attempt::Bench;
use super::failure::Failure;
use super::progress::Progress;
use crate::pipeline;
use crate::pipeline::settings::Settings;
use crate::store::Job;

/// The correspondence of a sketch and a mesh as JSON.
pub(super) fn run(bench: &Bench, job: &Job, progress: &Progress) -> Result<Bytes, Failure> {
    let settings: Settings =
        serde_json::from_value(job.payload.clone()).map_err(|error| Failure::internal(error, false))?;
    let sketch = bench.runtime.block_on(bench.store.sketch(&settings.sketch))?;
    let sketch = sketch.ok_or_else(|| Failure::refused(format_args!("there is no sketch {}", settings.sketch), &[]))?;
    let mesh = bench.runtime.block_on(bench.store.mesh(&settings.mesh))?;
    let mesh = mesh.ok_or_else(|| Failure::refused(format_args!("there is no mesh {}", settings.mesh), &[]))?;
    let mut result = pipeline::run(&sketch, &mesh, &settings, &bench.spectra, progress)?;
    result.id = Some(job.id.clone());
    Ok(serde_json::to_vec(&result).map_err(|error| Failure::internal(error, false))?.into())
}
