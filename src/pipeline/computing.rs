//! Everything a match or a pose needs of shapes, computed anew each time.

use std::sync::Arc;

use super::{Preparations, Spectra};
use crate::alignment::prepared::PreparedMesh;
use crate::mesh::TriangleMesh;
use crate::numerics::{Cancelled, Watch};
use crate::spectral::{self, Boundary, SpectralError, Spectrum};

/// Keeps nothing: for the command line and for tests.
pub struct Computing;

impl Spectra for Computing {
    fn spectrum(
        &self,
        mesh: &TriangleMesh,
        k: usize,
        boundary: Boundary,
        watch: &dyn Watch,
    ) -> Result<Arc<Spectrum>, SpectralError> {
        spectral::spectrum(mesh, k, boundary, watch).map(Arc::new)
    }
}

impl Preparations for Computing {
    fn prepared(&self, mesh: &TriangleMesh, watch: &dyn Watch) -> Result<Arc<PreparedMesh>, Cancelled> {
        PreparedMesh::new(mesh, watch).map(Arc::new)
    }
}
