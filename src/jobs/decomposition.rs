//! The spectrum of a shape, computed and kept.

use serde::{Deserialize, Serialize};

use super::{Bench, Failure, Progress, Task, memory};
use crate::mesh::figure::Figure;
use crate::mesh::file_mesh::FileMesh;
use crate::pipeline::Spectra;
use crate::spectral::Boundary;
use crate::store::ShapeKind;

/// Which spectrum: that of a stored shape's largest component.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Decomposition {
    /// Id of the shape.
    pub shape: String,
    pub kind: ShapeKind,
    /// Number of eigenpairs.
    pub k: usize,
    pub boundary: Boundary,
}

/// What came of a decomposition; the whole spectrum is then in the cache.
#[derive(Debug, Serialize)]
pub struct Eigenvalues {
    boundary: Boundary,
    /// The first k, ascending, in units of 1/length².
    eigenvalues: Vec<f64>,
    k: usize,
}

impl Task for Decomposition {
    const NAME: &'static str = "spectrum";
    /// Matches are not to find the queue full of spectra.
    const ONE_PLACE_IN: usize = 2;
    /// A spectrum may take long, and a match that comes need not wait for one to end.
    const THREADS_LEFT: usize = 1;
    type Outcome = Eigenvalues;

    fn shapes(&self) -> [Option<&str>; 2] {
        match self.kind {
            ShapeKind::Mesh => [Some(&self.shape), None],
            ShapeKind::Sketch => [None, Some(&self.shape)],
        }
    }

    fn bytes_per_vertex(&self) -> usize {
        memory::of_spectrum(self.k)
    }

    fn run(self, _: &str, bench: &Bench, progress: &Progress) -> Result<Eigenvalues, Failure> {
        let Decomposition { shape, kind, k, boundary } = self;
        let mesh = match kind {
            ShapeKind::Mesh => bench.answer(bench.store.mesh(&shape), progress)?,
            ShapeKind::Sketch => {
                let sketch = bench.answer(bench.store.sketch(&shape), progress)?;
                sketch.map(|sketch| FileMesh::from(sketch.mesh().clone()))
            }
        };
        let mesh = mesh.ok_or_else(|| Failure::refused(format_args!("there is no {} {shape}", kind.as_str()), &[]))?;
        let figure = Figure::largest(&mesh);
        let spectrum = bench.caches.spectrum(&figure.mesh, k, boundary, progress)?;
        Ok(Eigenvalues { boundary, eigenvalues: spectrum.eigenvalues.iter().copied().take(k).collect(), k })
    }
}
