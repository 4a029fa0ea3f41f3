//! A mesh that is known already: its spectrum and its preparation are at hand, and matches with it take no time for them.

use std::sync::Arc;

use sketchmatch::alignment::prepared::PreparedMesh;
use sketchmatch::mesh::TriangleMesh;
use sketchmatch::mesh::file_mesh::FileMesh;
use sketchmatch::numerics::{Cancelled, Unwatched, Watch};
use sketchmatch::pipeline::outcome::MatchResult;
use sketchmatch::pipeline::{self, Computing, Preparations, Settings, Spectra, Stage, Surroundings, Watcher};
use sketchmatch::sketch::Sketch;
use sketchmatch::spectral::laplacian::Lumping;
use sketchmatch::spectral::{self, Boundary, SpectralError, Spectrum};

const SEEN: &str = "a body of the bench has a spectrum";

/// Exactly k pairs, factorisation included.
pub fn eigenpairs(mesh: &TriangleMesh, k: usize) -> Spectrum {
    spectral::spectrum_with(mesh, Lumping::Mixed, k, Boundary::Neumann, &Unwatched).expect(SEEN)
}

/// Matches with a mesh that is known.
pub struct Match {
    known: Known,
    settings: Settings,
    file: FileMesh,
}

impl Match {
    pub fn of(mesh: &TriangleMesh, preset: &str) -> Match {
        let request = serde_json::json!({"mesh": "m", "sketch": "s", "preset": preset});
        let request = serde_json::from_value(request).expect("a request");
        let settings = Settings::resolve(&request).expect("a preset is in range");
        Match { known: Known::of(mesh, preset == "automatic"), settings, file: mesh.clone().into() }
    }

    pub fn run(&self, sketch: &Sketch) -> MatchResult {
        let Match { known, settings, file } = self;
        let surroundings =
            Surroundings { spectra: known, preparations: known, watcher: &Nobody, clock: &|| 0.0, preview: None };
        pipeline::run(sketch, file, settings, &surroundings).expect("the body can be matched")
    }
}

/// A mesh whose spectrum and preparation are at hand; a sketch's are computed.
struct Known {
    vertices: usize,
    spectrum: Arc<Spectrum>,
    prepared: Option<Arc<PreparedMesh>>,
}

impl Known {
    fn of(mesh: &TriangleMesh, prepared: bool) -> Known {
        let prepare = || Arc::new(PreparedMesh::new(mesh, &Unwatched).expect("nobody cancels"));
        let spectrum = Arc::new(eigenpairs(mesh, 20));
        Known { vertices: mesh.positions().len(), spectrum, prepared: prepared.then(prepare) }
    }
}

impl Spectra for Known {
    fn spectrum(
        &self,
        mesh: &TriangleMesh,
        k: usize,
        boundary: Boundary,
        watch: &dyn Watch,
    ) -> Result<Arc<Spectrum>, SpectralError> {
        if mesh.positions().len() == self.vertices {
            return Ok(self.spectrum.clone());
        }
        Computing.spectrum(mesh, k, boundary, watch)
    }
}

impl Preparations for Known {
    fn prepared(&self, mesh: &TriangleMesh, watch: &dyn Watch) -> Result<Arc<PreparedMesh>, Cancelled> {
        self.prepared.clone().map_or_else(|| Computing.prepared(mesh, watch), Ok)
    }
}

struct Nobody;

impl Watcher for Nobody {
    fn proceed(&self, _stage: Stage, _fraction: f64) -> Result<(), Cancelled> {
        Ok(())
    }
}
