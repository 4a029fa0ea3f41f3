//! The global point signature: eigenfunctions that a pose does not change much, scaled so that slow ones weigh more.

use faer::Mat;

use crate::spectral::Spectrum;

/// An eigenvalue up to this share of the largest counts as the 0 of the constant function.
const ZERO: f64 = 1e-9;

/// Row x is g(x) = (φ_1(x) / √λ_1, φ_2(x) / √λ_2, …) over the eigenvalues above 0, at most `dimensions` of them: n × d,
/// in units of 1 (φ has 1/length, λ has 1/length²).
///
/// The constant eigenfunction of a Neumann spectrum is left out, so that d is at most k − 1 there.
///
/// Source: [Rus07], as eq. 2.24 of the thesis.
pub fn signature(spectrum: &Spectrum, dimensions: usize) -> Mat<f64> {
    let constants = constants(spectrum);
    let columns = (spectrum.len() - constants).min(dimensions);
    Mat::from_fn(spectrum.vertices(), columns, |x, j| {
        let i = constants + j;
        spectrum.eigenfunctions[(x, i)] / spectrum.eigenvalues[i].sqrt()
    })
}

/// How many dimensions there are at most: the number of eigenvalues above 0.
pub fn dimensions(spectrum: &Spectrum) -> usize {
    spectrum.len() - constants(spectrum)
}

/// How many eigenvalues count as 0.
fn constants(spectrum: &Spectrum) -> usize {
    let zero = ZERO * spectrum.eigenvalues.last().copied().unwrap_or(0.0);
    spectrum.eigenvalues.partition_point(|&lambda| lambda <= zero)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn spectrum(eigenvalues: &[f64]) -> Spectrum {
        Spectrum {
            eigenvalues: eigenvalues.to_vec(),
            eigenfunctions: Mat::from_fn(2, eigenvalues.len(), |x, i| (1 + x + 10 * i) as f64),
            mass: vec![0.5, 0.5],
        }
    }

    #[test]
    fn columns_are_divided_by_the_root_of_their_eigenvalue() {
        let signature = signature(&spectrum(&[4.0, 25.0]), 9);
        assert_eq!(signature, Mat::from_fn(2, 2, |x, i| [[0.5, 2.2], [1.0, 2.4]][x][i]));
    }

    #[test]
    fn the_constant_is_left_out_whichever_side_of_zero_it_was_found_on() {
        for zero in [0.0, 3e-15, -3e-15] {
            let signature = signature(&spectrum(&[zero, 4.0, 25.0, 100.0]), 2);
            assert_eq!(signature, Mat::from_fn(2, 2, |x, i| [[5.5, 4.2], [6.0, 4.4]][x][i]));
        }
    }

    #[test]
    fn a_spectrum_of_the_constant_alone_has_no_columns() {
        assert_eq!(signature(&spectrum(&[0.0]), 5).ncols(), 0);
        assert_eq!(signature(&spectrum(&[]), 5).ncols(), 0);
    }
}
