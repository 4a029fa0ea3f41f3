//! Heat kernel signature: how much heat stays at a point until a time t [SOG09], eq. 2.17.

use faer::Mat;

use super::{first_positive, log_spaced};

/// `count` times, log-spaced from 4 ln 10 / λ_max to 4 ln 10 / λ_2 of the spectrum; none where it has no positive
/// eigenvalue.
pub fn times(eigenvalues: &[f64], count: usize) -> Vec<f64> {
    let (Some(first), Some(&last)) = (first_positive(eigenvalues), eigenvalues.last()) else { return Vec::new() };
    let decades = 4.0 * std::f64::consts::LN_10;
    log_spaced(decades / last, decades / first, count)
}

/// `count` times, log-spaced over a range given in units of 1/λ.
pub fn times_between([first, last]: [f64; 2], count: usize) -> Vec<f64> {
    log_spaced(first, last, count)
}

/// The filters e^(−λ_i t), k × times.
pub fn filters(eigenvalues: &[f64], times: &[f64]) -> Mat<f64> {
    Mat::from_fn(eigenvalues.len(), times.len(), |i, t| (-eigenvalues[i] * times[t]).exp())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_span_the_spectrum() {
        let times = times(&[0.0, 2.0, 5.0, 32.0], 5);
        let decades = 4.0 * 10f64.ln();
        assert!((times[0] - decades / 32.0).abs() < 1e-12 && (times[4] - decades / 2.0).abs() < 1e-12);
        // A range of 16 in four steps doubles at every step.
        assert!(times.windows(2).all(|pair| (pair[1] / pair[0] - 2.0).abs() < 1e-12));
    }

    #[test]
    fn heat_decays_with_time_and_frequency() {
        let filters = filters(&[0.0, 1.0, 3.0], &[0.5, 2.0]);
        assert_eq!((filters[(0, 0)], filters[(0, 1)]), (1.0, 1.0));
        assert!((filters[(2, 1)] - (-6f64).exp()).abs() < 1e-15);
    }
}
