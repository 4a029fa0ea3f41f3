//! Compressive sampling matching pursuit: a sparse signal from few measurements.

/// Linear measurements y = Φ x of a signal.
pub struct Sampling<F, A> {
    /// Length of a signal.
    pub signal: usize,
    /// x ↦ Φ x.
    pub forward: F,
    /// r ↦ Φᵀ r.
    pub adjoint: A,
}

/// Pursuit ends at the latest after this many rounds; it needs few where it succeeds at all \[NT08, §2.4\].
const MAX_ROUNDS: usize = 50;
/// Residual, relative to the measurements, or to the right-hand side of the inner least squares, that is rounding.
const ROUNDING: f64 = 1e-14;

/// The entries of an s-sparse approximation a of the signal x measured as y = Φ x: indices ascending, at most
/// `sparsity` = s of them.
///
/// Algorithm 1 of the thesis \[NT08\]. It stops when the residual ‖y − Φ a‖ no longer falls, and returns the best a. Of
/// entries equally large the first counts as larger.
pub fn sparse_approximation<F, A>(phi: &Sampling<F, A>, y: &[f64], sparsity: usize) -> Vec<(usize, f64)>
where
    F: Fn(&[f64]) -> Vec<f64>,
    A: Fn(&[f64]) -> Vec<f64>,
{
    let mut a = vec![0.0; phi.signal];
    let mut residual = y.to_vec();
    let negligible = ROUNDING * norm(y);
    for _ in 0..MAX_ROUNDS {
        if norm(&residual) <= negligible {
            break;
        }
        let proxy = (phi.adjoint)(&residual);
        let mut merged = largest(&proxy, sparsity.saturating_mul(2));
        merged.extend(support(&a));
        merged.sort_unstable();
        merged.dedup();
        let b = restricted_least_squares(phi, y, &merged);
        let mut pruned = vec![0.0; phi.signal];
        for i in largest(&b, sparsity) {
            pruned[i] = b[i];
        }
        let remaining = difference(y, &(phi.forward)(&pruned));
        if norm(&remaining) >= norm(&residual) {
            break;
        }
        (a, residual) = (pruned, remaining);
    }
    support(&a).into_iter().map(|i| (i, a[i])).collect()
}

/// The b with entries in `support` alone that minimises ‖Φ b − y‖, by conjugate gradients on the normal equations
/// [NT08].
fn restricted_least_squares<F, A>(phi: &Sampling<F, A>, y: &[f64], support: &[usize]) -> Vec<f64>
where
    F: Fn(&[f64]) -> Vec<f64>,
    A: Fn(&[f64]) -> Vec<f64>,
{
    let normal_residual = |residual: &[f64]| -> Vec<f64> {
        let full = (phi.adjoint)(residual);
        let mut restricted = vec![0.0; phi.signal];
        support.iter().for_each(|&i| restricted[i] = full[i]);
        restricted
    };
    let mut b = vec![0.0; phi.signal];
    let mut residual = y.to_vec();
    let mut g = normal_residual(&residual);
    let mut d = g.clone();
    let negligible = ROUNDING * norm(&g);
    // In exact arithmetic as many steps as unknowns suffice; twice as many make up for rounding.
    for _ in 0..2 * support.len() {
        let image = (phi.forward)(&d);
        let (descent, curvature) = (dot(&g, &g), dot(&image, &image));
        if descent.sqrt() <= negligible || curvature == 0.0 {
            break;
        }
        let alpha = descent / curvature;
        b.iter_mut().zip(&d).for_each(|(b, d)| *b += alpha * d);
        residual.iter_mut().zip(&image).for_each(|(r, i)| *r -= alpha * i);
        g = normal_residual(&residual);
        let beta = dot(&g, &g) / descent;
        d.iter_mut().zip(&g).for_each(|(d, g)| *d = g + beta * *d);
    }
    b
}

/// Indices of the `count` entries of largest magnitude, zeros left out.
fn largest(x: &[f64], count: usize) -> Vec<usize> {
    let mut order = support(x);
    order.sort_by(|&i, &j| x[j].abs().total_cmp(&x[i].abs()));
    order.truncate(count);
    order
}

fn support(x: &[f64]) -> Vec<usize> {
    (0..x.len()).filter(|&i| x[i] != 0.0).collect()
}

fn difference(x: &[f64], y: &[f64]) -> Vec<f64> {
    x.iter().zip(y).map(|(x, y)| x - y).collect()
}

fn dot(x: &[f64], y: &[f64]) -> f64 {
    x.iter().zip(y).map(|(x, y)| x * y).sum()
}

fn norm(x: &[f64]) -> f64 {
    dot(x, x).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numerics::random;
    use faer::{Col, Mat};

    fn sampled(phi: &Mat<f64>, y: &[f64], sparsity: usize) -> Vec<(usize, f64)> {
        let column = |x: &[f64]| Col::from_fn(x.len(), |i| x[i]);
        let sampling = Sampling {
            signal: phi.ncols(),
            forward: |x: &[f64]| (phi * column(x)).iter().copied().collect(),
            adjoint: |r: &[f64]| (phi.transpose() * column(r)).iter().copied().collect(),
        };
        sparse_approximation(&sampling, y, sparsity)
    }

    #[test]
    fn a_sparse_signal_is_recovered_from_random_measurements() {
        let truth = [(3, 2.0), (17, -1.0), (50, 0.5), (99, 3.0), (180, -0.7)];
        for seed in 0..5 {
            let phi = random::normal(80, 200, seed) / faer::Scale(80f64.sqrt());
            let y: Vec<f64> = (0..80).map(|i| truth.iter().map(|&(j, x)| phi[(i, j)] * x).sum()).collect();
            let found = sampled(&phi, &y, 5);
            assert_eq!(found.len(), 5);
            for ((j, x), (index, value)) in truth.into_iter().zip(found) {
                assert_eq!(j, index);
                assert!((x - value).abs() < 1e-10);
            }
        }
    }

    #[test]
    fn noisy_measurements_give_a_signal_about_as_far_off() {
        let phi = random::normal(80, 200, 7) / faer::Scale(80f64.sqrt());
        let noise = random::normal(80, 1, 8);
        let y: Vec<f64> = (0..80).map(|i| phi[(i, 11)] - 2.0 * phi[(i, 42)] + 0.01 * noise[(i, 0)]).collect();
        let found = sampled(&phi, &y, 2);
        assert_eq!((found[0].0, found[1].0), (11, 42));
        assert!((found[0].1 - 1.0).abs() < 0.05 && (found[1].1 + 2.0).abs() < 0.05);
    }

    #[test]
    fn of_a_signal_fully_measured_the_largest_entries_are_left() {
        let y = [0.1, -3.0, 0.0, 2.0, -2.0, 0.5];
        let identity = Sampling { signal: 6, forward: <[f64]>::to_vec, adjoint: <[f64]>::to_vec };
        assert_eq!(sparse_approximation(&identity, &y, 1), [(1, -3.0)]);
        assert_eq!(sparse_approximation(&identity, &y, 2), [(1, -3.0), (3, 2.0)]);
        assert_eq!(sparse_approximation(&identity, &y, 100).len(), 5);
        assert_eq!(sparse_approximation(&identity, &y, 0), []);
        assert_eq!(sparse_approximation(&identity, &[0.0; 6], 3), []);
    }
}
