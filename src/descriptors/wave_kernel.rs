//! Wave kernel signature: how likely a quantum particle of an energy is found at a point [ASC11], eq. 2.21–2.23.

use faer::Mat;

use super::{first_positive, log_spaced};

/// Energies and the width of their bands.
#[derive(Clone, Debug, PartialEq)]
pub struct Energies {
    /// log e, evenly spaced over the logarithms of the spectrum without 0.
    pub logarithms: Vec<f64>,
    /// σ of eq. 2.22.
    pub width: f64,
}

/// `count` energies over the spectrum with bands `variance` spacings wide; none where it has no positive eigenvalue.
pub fn energies(eigenvalues: &[f64], count: usize, variance: f64) -> Energies {
    let (Some(first), Some(&last)) = (first_positive(eigenvalues), eigenvalues.last()) else {
        return Energies { logarithms: Vec::new(), width: 1.0 };
    };
    let logarithms: Vec<f64> = log_spaced(first, last, count).iter().map(|e| e.ln()).collect();
    let spacing = (last / first).ln() / count.saturating_sub(1).max(1) as f64;
    // A spectrum of a single positive value has no spacing: one band for all.
    Energies { logarithms, width: if spacing > 0.0 { variance * spacing } else { 1.0 } }
}

/// The filters exp(−(log e − log λ_i)² / 2σ²), k × energies, every column divided by its sum; the eigenvalue 0 is left
/// out.
pub fn filters(eigenvalues: &[f64], energies: &Energies) -> Mat<f64> {
    let first = first_positive(eigenvalues).unwrap_or(f64::INFINITY);
    let mut filters = Mat::from_fn(eigenvalues.len(), energies.logarithms.len(), |i, e| {
        if eigenvalues[i] < first {
            return 0.0;
        }
        let distance = (energies.logarithms[e] - eigenvalues[i].ln()) / energies.width;
        (-0.5 * distance * distance).exp()
    });
    for e in 0..filters.ncols() {
        let sum: f64 = filters.col(e).iter().sum();
        if sum > 0.0 {
            filters.col_mut(e).iter_mut().for_each(|weight| *weight /= sum);
        }
    }
    filters
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_are_averages_without_the_constant() {
        let eigenvalues = [0.0, 1.0, 2.5, 7.0, 9.0];
        let filters = filters(&eigenvalues, &energies(&eigenvalues, 20, 6.0));
        for e in 0..20 {
            assert_eq!(filters[(0, e)], 0.0);
            assert!((filters.col(e).iter().sum::<f64>() - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn a_narrow_band_picks_its_eigenvalue() {
        let eigenvalues = [0.0, 1.0, 10.0, 100.0];
        let filters = filters(&eigenvalues, &energies(&eigenvalues, 3, 0.1));
        for e in 0..3 {
            assert!(filters[(e + 1, e)] > 0.999);
        }
    }
}
