//! A convex quadratic over a box, by a primal-dual interior point method with Mehrotra's predictor [NW06, alg. 16.4].

use faer::Mat;
use sprs::CsMat;

use super::cholesky::{Analysis, FactorisationError, SparseCholesky};
use super::{Cancelled, Watch};

/// Mean complementarity, as a share of that at the start, at which the minimiser is reached.
const CONVERGED: f64 = 1e-15;
/// Steps at most; sixteen are usual.
const MAX_STEPS: usize = 80;
/// How far a step goes towards the bound it meets first.
const SHY: f64 = 0.995;

/// Why there is no minimiser.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum QuadraticError {
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    #[error(transparent)]
    Factorisation(#[from] FactorisationError),
}

/// The minimisers of ½ xᵀQx + cᵀx over 0 ≤ x ≤ 1 for one n × n matrix Q, positive semidefinite with both triangles and
/// the whole diagonal stored, and several vectors c: its pattern is analysed once.
pub struct BoundedQuadratic {
    q: CsMat<f64>,
    analysis: Analysis,
}

impl BoundedQuadratic {
    /// # Errors
    /// [`FactorisationError::OutOfMemory`].
    pub fn new(q: CsMat<f64>) -> Result<BoundedQuadratic, FactorisationError> {
        Ok(BoundedQuadratic { analysis: Analysis::new(&q)?, q })
    }

    /// The minimiser x for the linear term c, both of length n, strictly between the bounds.
    ///
    /// # Errors
    /// [`QuadraticError`].
    pub fn minimiser(&self, c: &[f64], watch: &dyn Watch) -> Result<Vec<f64>, QuadraticError> {
        let n = c.len();
        let size = self.q.data().iter().chain(c).fold(f64::MIN_POSITIVE, |size, x| size.max(x.abs()));
        // x ≥ 0 has the multiplier z, x ≤ 1 the multiplier v.
        let (mut x, mut z, mut v) = (vec![0.5; n], vec![size; n], vec![size; n]);
        let start = complementarity(&x, &z, &v);
        for step in 0..MAX_STEPS {
            watch.proceed(step as f64 / MAX_STEPS as f64)?;
            let mu = complementarity(&x, &z, &v);
            if mu <= CONVERGED * start {
                break;
            }
            let dual: Vec<f64> = self.times(&x).iter().enumerate().map(|(i, qx)| qx + c[i] - z[i] + v[i]).collect();
            let factor = self.factor(&x, &z, &v)?;
            let newton = |low: &dyn Fn(usize) -> f64, high: &dyn Fn(usize) -> f64| {
                // Of the bounds: z Δx + x Δz = low, −v Δx + (1 − x) Δv = high.
                let mut right = Mat::from_fn(n, 1, |i, _| low(i) / x[i] - high(i) / (1.0 - x[i]) - dual[i]);
                factor.solve(right.as_mut());
                let dx: Vec<f64> = (0..n).map(|i| right[(i, 0)]).collect();
                let dz = (0..n).map(|i| (low(i) - z[i] * dx[i]) / x[i]).collect();
                let dv = (0..n).map(|i| (high(i) + v[i] * dx[i]) / (1.0 - x[i])).collect();
                Direction { dx, dz, dv }
            };
            // The predictor asks for no complementarity at all; how far it gets says how much to ask for.
            let predicted = newton(&|i| -x[i] * z[i], &|i| -(1.0 - x[i]) * v[i]);
            let reached = predicted.step(&x, &z, &v, predicted.longest(&x, &z, &v));
            let target = mu * (complementarity(&reached.0, &reached.1, &reached.2) / mu).powi(3);
            let Direction { dx, dz, dv } = &predicted;
            let corrected =
                newton(&|i| target - x[i] * z[i] - dx[i] * dz[i], &|i| target - (1.0 - x[i]) * v[i] + dx[i] * dv[i]);
            let length = (SHY * corrected.longest(&x, &z, &v)).min(1.0);
            (x, z, v) = corrected.step(&x, &z, &v, length);
        }
        Ok(x)
    }

    fn times(&self, x: &[f64]) -> Vec<f64> {
        self.q.outer_iterator().map(|row| row.iter().map(|(j, q)| q * x[j]).sum()).collect()
    }

    /// Of Q + diag(z / x + v / (1 − x)).
    fn factor(&self, x: &[f64], z: &[f64], v: &[f64]) -> Result<SparseCholesky, FactorisationError> {
        let mut matrix = self.q.clone();
        for (i, diagonal) in matrix.diag_iter_mut().enumerate() {
            if let Some(diagonal) = diagonal {
                *diagonal += z[i] / x[i] + v[i] / (1.0 - x[i]);
            }
        }
        SparseCholesky::analysed(self.analysis.clone(), &matrix)
    }
}

/// The mean product of a slack and its multiplier.
fn complementarity(x: &[f64], z: &[f64], v: &[f64]) -> f64 {
    let products = x.iter().zip(z.iter().zip(v)).map(|(x, (z, v))| x * z + (1.0 - x) * v);
    products.sum::<f64>() / (2 * x.len()).max(1) as f64
}

struct Direction {
    dx: Vec<f64>,
    dz: Vec<f64>,
    dv: Vec<f64>,
}

impl Direction {
    /// How many times it can be gone, at most 1/SHY times, before a slack or a multiplier vanishes.
    fn longest(&self, x: &[f64], z: &[f64], v: &[f64]) -> f64 {
        let until = |value: f64, change: f64| if change < 0.0 { -value / change } else { f64::INFINITY };
        let each = (0..x.len()).map(|i| {
            let (dx, dz, dv) = (self.dx[i], self.dz[i], self.dv[i]);
            until(x[i], dx).min(until(1.0 - x[i], -dx)).min(until(z[i], dz)).min(until(v[i], dv))
        });
        each.fold(1.0 / SHY, f64::min)
    }

    fn step(&self, x: &[f64], z: &[f64], v: &[f64], length: f64) -> (Vec<f64>, Vec<f64>, Vec<f64>) {
        let along = |from: &[f64], change: &[f64]| from.iter().zip(change).map(|(a, d)| a + length * d).collect();
        (along(x, &self.dx), along(z, &self.dz), along(v, &self.dv))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numerics::Unwatched;

    /// A chain of springs, squared: both bounds are met by what is pulled hard enough.
    fn chain(n: usize) -> CsMat<f64> {
        let mut entries = sprs::TriMat::new((n, n));
        for i in 0..n {
            for (offset, value) in [(0, 6.0), (1, -4.0), (2, 1.0)] {
                if i + offset < n {
                    entries.add_triplet(i, i + offset, value);
                    if offset > 0 {
                        entries.add_triplet(i + offset, i, value);
                    }
                }
            }
        }
        entries.to_csr()
    }

    /// How far a step along the gradient, kept within the bounds, would move x: not at all where it is optimal.
    fn breach(quadratic: &BoundedQuadratic, c: &[f64], x: &[f64]) -> f64 {
        let gradient = quadratic.times(x);
        let moves = gradient.iter().zip(c).zip(x).map(|((g, c), &x)| (x - (x - g - c).clamp(0.0, 1.0)).abs());
        moves.fold(0.0, f64::max)
    }

    #[test]
    fn the_minimiser_meets_the_conditions_of_optimality() {
        let n = 60;
        let quadratic = BoundedQuadratic::new(chain(n)).unwrap();
        for (frequency, size) in [(0.3, 1.0), (1.1, 4.0), (0.05, 0.2)] {
            let c: Vec<f64> = (0..n).map(|i| size * (frequency * i as f64).sin()).collect();
            let x = quadratic.minimiser(&c, &Unwatched).unwrap();
            assert!(x.iter().all(|x| (0.0..=1.0).contains(x)));
            assert!(breach(&quadratic, &c, &x) < 1e-6, "{}", breach(&quadratic, &c, &x));
        }
    }

    #[test]
    fn a_minimiser_within_the_bounds_is_that_without_them() {
        let n = 40;
        let quadratic = BoundedQuadratic::new(chain(n)).unwrap();
        let inner: Vec<f64> = (0..n).map(|i| 0.5 + 0.4 * (i as f64).sin()).collect();
        let c: Vec<f64> = quadratic.times(&inner).iter().map(|q| -q).collect();
        for (x, inner) in quadratic.minimiser(&c, &Unwatched).unwrap().iter().zip(&inner) {
            assert!((x - inner).abs() < 1e-7, "{x} {inner}");
        }
    }

    #[test]
    fn whoever_waits_no_longer_ends_it() {
        struct Gone;
        impl Watch for Gone {
            fn proceed(&self, _: f64) -> Result<(), Cancelled> {
                Err(Cancelled)
            }
        }
        let quadratic = BoundedQuadratic::new(chain(5)).unwrap();
        assert_eq!(quadratic.minimiser(&[1.0; 5], &Gone), Err(QuadraticError::Cancelled(Cancelled)));
    }
}
