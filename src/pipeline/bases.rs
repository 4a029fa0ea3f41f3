//! The bases that the functional map of a match leads between.

use faer::Mat;

use super::outcome::MatchResult;
use super::{MatchError, Spectra, figure};
use crate::mesh::figure::Figure;
use crate::mesh::file_mesh::FileMesh;
use crate::numerics::Watch;
use crate::sketch::Sketch;
use crate::spectral::Spectrum;

/// The eigenfunctions of both shapes that C of a match leads between, at area 1, and C.
pub struct Bases {
    /// Of the sketch, as many as C has columns.
    pub phi: Spectrum,
    /// Of the figure, as many as C has rows.
    pub psi: Spectrum,
    pub figure: Figure,
    /// l × k.
    pub c: Mat<f64>,
}

impl Bases {
    /// Those of a match of these two shapes.
    ///
    /// # Errors
    /// [`MatchError`]: what kept the match itself from being carried out would keep it again.
    pub fn of(
        sketch: &Sketch,
        mesh: &FileMesh,
        result: &MatchResult,
        spectra: &dyn Spectra,
        watch: &dyn Watch,
    ) -> Result<Bases, MatchError> {
        let figure = figure::matched(mesh, &result.request)?;
        let (rows, columns, boundary) = (result.c.rows, result.c.columns, result.request.basis.boundary);
        let phi = spectra.spectrum(sketch.mesh(), columns, boundary, watch);
        let phi = phi.map_err(|error| MatchError::of_spectrum("sketch", "/basis/k", error))?.at_unit_area(columns);
        let psi = spectra.spectrum(&figure.mesh, rows, boundary, watch);
        let psi = psi.map_err(|error| MatchError::of_spectrum("mesh", "/basis/k_mesh", error))?.at_unit_area(rows);
        Ok(Bases { phi, psi, figure, c: result.c.to_mat() })
    }
}
