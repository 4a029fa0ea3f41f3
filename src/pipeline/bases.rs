//! The bases that the functional map of a match leads between.

use std::sync::Arc;

use faer::Mat;

use super::outcome::MatchResult;
use super::{MatchError, Spectra, figure};
use crate::mesh::figure::Figure;
use crate::mesh::file_mesh::FileMesh;
use crate::numerics::Watch;
use crate::sketch::Sketch;
use crate::spectral::{Boundary, Spectrum};

/// Where a request says how many eigenfunctions the bases of the sketch and of the mesh have.
pub(super) const ASKED_BY: [&str; 2] = ["/basis/k", "/basis/k_mesh"];

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
        let both = both(spectra, (sketch, &figure), [columns, rows], boundary, ASKED_BY, watch)?;
        let [phi, psi] = at_unit_area(&both, [columns, rows]);
        Ok(Bases { phi, psi, figure, c: result.c.to_mat() })
    }
}

/// The first k and l eigenpairs of a sketch and of a figure, or more, in the units of their files.
///
/// # Errors
/// [`MatchError`], with the place in the request that asked for so many.
pub(super) fn both(
    spectra: &dyn Spectra,
    (sketch, figure): (&Sketch, &Figure),
    [k, l]: [usize; 2],
    boundary: Boundary,
    [of_k, of_l]: [&str; 2],
    watch: &dyn Watch,
) -> Result<[Arc<Spectrum>; 2], MatchError> {
    let phi = spectra.spectrum(sketch.mesh(), k, boundary, watch);
    let phi = phi.map_err(|error| MatchError::of_spectrum("sketch", of_k, error))?;
    let psi = spectra.spectrum(&figure.mesh, l, boundary, watch);
    let psi = psi.map_err(|error| MatchError::of_spectrum("mesh", of_l, error))?;
    Ok([phi, psi])
}

/// The first pairs of both spectra, as many as told, with both shapes at area 1.
pub(super) fn at_unit_area([sketch, mesh]: &[Arc<Spectrum>; 2], [k, l]: [usize; 2]) -> [Spectrum; 2] {
    [sketch.at_unit_area(k), mesh.at_unit_area(l)]
}
