//! How much memory jobs take, for each vertex of a shape and besides.

use crate::pipeline::{self, Settings};
use crate::spectral::rung;

/// Numbers per vertex beside those that grow with the number of eigenpairs: the mesh, its operator, the blocks of the
/// eigenvalue solver, descriptors.
const FIXED: usize = 224;

/// Numbers per vertex and eigenpair: the Krylov basis, which is up to three times as long, its rotation, the result.
const PER_PAIR: usize = 6;

/// Bytes per vertex of the Cholesky factor, as fill-in is on surfaces.
const FACTOR: usize = 2048;

/// The bytes for each vertex that a spectrum of at least `k` eigenpairs takes at its peak, about.
pub fn of_spectrum(k: usize) -> usize {
    let numbers = rung(k).saturating_mul(PER_PAIR).saturating_add(FIXED);
    numbers.saturating_mul(size_of::<f64>()).saturating_add(FACTOR)
}

/// The bytes that the functional map of a match takes at its peak beside the spectra, about, however many vertices there are.
pub fn of_map(settings: &Settings) -> usize {
    pipeline::kept(settings).saturating_mul(size_of::<f64>())
}

/// The bytes for each vertex of a mesh that it takes to pose it, about: two factors, and some tens of numbers.
pub const fn of_pose() -> usize {
    FIXED * size_of::<f64>() + 2 * FACTOR
}
