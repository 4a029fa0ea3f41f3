use bytes::Bytes;
use serde_json::json;

use super::bench::Bench;
use super::failure::Failure;
use super::progress::Progress;
use crate::mesh::figure::Figure;
use crate::mesh::file_mesh::FileMesh;
use crate::pipeline::Spectra;
use crate::store::{Kind, Lease, SpectrumTask};

/// The eigenvalues of a stored shape's largest component, as JSON; the whole spectrum is then in the cache.
pub(super) fn run(bench: &Bench, lease: &Lease, progress: &Progress) -> Result<Bytes, Failure> {
    let task: SpectrumTask = serde_json::from_str(&lease.payload).map_err(|error| Failure::internal(error, false))?;
    let SpectrumTask { shape, kind, k, boundary } = task;
    let mesh = match kind {
        Kind::Mesh => bench.runtime.block_on(bench.store.mesh(&shape))?,
        Kind::Sketch => {
            bench.runtime.block_on(bench.store.sketch(&shape))?.map(|sketch| FileMesh::from(sketch.mesh().clone()))
        }
    };
    let mesh = mesh.ok_or_else(|| Failure::refused(format_args!("there is no {} {shape}", kind.as_str()), &[]))?;
    let figure = Figure::largest(&mesh);
    let spectrum = bench.spectra.spectrum(&figure.mesh, k, boundary, progress)?;
    let eigenvalues = &spectrum.eigenvalues[..k.min(spectrum.len())];
    Ok(json!({ "eigenvalues": eigenvalues, "k": k, "boundary": boundary }).to_string().into())
}
