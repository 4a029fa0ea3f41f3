//! Point descriptors made of eigenpairs.
//!
//! Heat and wave kernel signatures are filters of the spectrum: component t of a point x is Σ_i f_t(λ_i) φ_i(x)². A set
//! of filters is a k × count matrix; the n × count matrix of all points is never formed.

pub mod functions;
pub mod global_point_signature;
pub mod heat_kernel;
pub mod projection;
pub mod wave_kernel;

/// The first eigenvalue of a spectrum that is not the zero of the constant function; none where there is no such.
///
/// A computed zero is told from a small eigenvalue by its size against the largest.
pub fn first_positive(eigenvalues: &[f64]) -> Option<f64> {
    let largest = *eigenvalues.last()?;
    eigenvalues.iter().copied().find(|&l| l > 1e-9 * largest)
}

/// `count` numbers from `first` to `last`, evenly spaced in their logarithms.
fn log_spaced(first: f64, last: f64, count: usize) -> Vec<f64> {
    let step = if count > 1 { (last.ln() - first.ln()) / (count - 1) as f64 } else { 0.0 };
    (0..count).map(|i| first * (step * i as f64).exp()).collect()
}
