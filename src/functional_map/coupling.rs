//! Bases of both shapes that go together, by joint approximate diagonalisation [KBBG+13]: rotations of the eigenfunctions in which
//! the Laplacians are nearly diagonal and corresponding functions have nearly equal coefficients.

use faer::{Mat, MatRef, Scale};

use crate::numerics::{Cancelled, Watch, inner_product};

/// Rounds at most, and the change of the energy, relative to its size, at which they end.
const ROUNDS: usize = 500;
const SETTLED: f64 = 1e-12;
/// Steps tried in a round, each half of the one before, and the share of the decrease their slope promises that they have to bring.
const TRIES: usize = 40;
const SUFFICIENT: f64 = 1e-4;

/// P (k × k) and Q (k × k), orthogonal: the bases Φ P and Ψ Q go together.
pub struct Coupling {
    pub p: Mat<f64>,
    pub q: Mat<f64>,
}

/// A minimum of off(Pᵀ Λ_M P) + off(Qᵀ Λ_N Q) − 2 w ⟨P, (B Aᵀ)ᵀ Q⟩ from P = Q = 1, off being the sum of squares beside the diagonal: what of
/// the last term is not constant in ‖Pᵀ A − Qᵀ B‖²_F. Eigenvalues (k) are in units of the largest of both, `cross` = B Aᵀ (k × k) in that
/// of its norm.
///
/// By descent along the gradient on the orthogonal group with steps of Barzilai and Borwein [BB88], each taken back to the group by
/// QR and halved until it descends.
///
/// # Errors
/// [`Cancelled`] by the watcher, asked every round.
pub fn coupled(
    [sketch, mesh]: [&[f64]; 2],
    cross: MatRef<'_, f64>,
    weight: f64,
    watch: &dyn Watch,
) -> Result<Coupling, Cancelled> {
    let k = sketch.len();
    let norm = cross.norm_l2().max(f64::MIN_POSITIVE);
    let energy = Energy { eigenvalues: [sketch, mesh], cross: Scale(weight / norm) * cross };
    let mut at = [Mat::<f64>::identity(k, k), Mat::<f64>::identity(k, k)];
    let mut value = energy.value(&at);
    let mut slope = energy.slope(&at);
    let mut step = 0.1;
    for round in 0..ROUNDS {
        watch.proceed(round as f64 / ROUNDS as f64)?;
        let steepness = product(&slope, &slope);
        let mut found = None;
        for _ in 0..TRIES {
            let next = [0, 1].map(|i| orthogonal((&at[i] - Scale(step) * &slope[i]).as_ref()));
            let next_value = energy.value(&next);
            if next_value <= value - SUFFICIENT * step * steepness {
                found = Some((next, next_value));
                break;
            }
            step *= 0.5;
        }
        let Some((next, next_value)) = found else { break };
        let next_slope = energy.slope(&next);
        let moved = [0, 1].map(|i| &next[i] - &at[i]);
        let turned = [0, 1].map(|i| &next_slope[i] - &slope[i]);
        let curvature = product(&moved, &turned).abs();
        let length = product(&moved, &moved);
        step = if curvature > f64::MIN_POSITIVE { (length / curvature).clamp(1e-6, 1e3) } else { step };
        let settled = value - next_value <= SETTLED * value.abs().max(1.0);
        (at, value, slope) = (next, next_value, next_slope);
        if settled {
            break;
        }
    }
    let [p, q] = at;
    Ok(Coupling { p, q })
}

struct Energy<'a> {
    eigenvalues: [&'a [f64]; 2],
    /// w B Aᵀ.
    cross: Mat<f64>,
}

impl Energy<'_> {
    /// Without what is constant: Σ of both − Σ_i (p_iᵀ Λ p_i)², and the coupling.
    fn value(&self, at: &[Mat<f64>; 2]) -> f64 {
        let diagonal = |i: usize| self.diagonal(i, &at[i]).iter().map(|d| d * d).sum::<f64>();
        let together = inner_product((&self.cross * &at[0]).as_ref(), at[1].as_ref());
        -diagonal(0) - diagonal(1) - 2.0 * together
    }

    /// p_iᵀ Λ p_i.
    fn diagonal(&self, shape: usize, x: &Mat<f64>) -> Vec<f64> {
        let of = |i: usize| x.col(i).iter().zip(self.eigenvalues[shape]).map(|(x, l)| l * x * x).sum();
        (0..x.ncols()).map(of).collect()
    }

    /// The gradient along the group: G − X sym(Xᵀ G), halves of both sides.
    fn slope(&self, at: &[Mat<f64>; 2]) -> [Mat<f64>; 2] {
        let coupling = [self.cross.transpose() * &at[1], &self.cross * &at[0]];
        [0, 1].map(|shape| {
            let (x, d) = (&at[shape], self.diagonal(shape, &at[shape]));
            let k = x.ncols();
            let along = Mat::from_fn(k, k, |i, j| {
                -4.0 * self.eigenvalues[shape][i] * x[(i, j)] * d[j] - 2.0 * coupling[shape][(i, j)]
            });
            let inner = x.transpose() * &along;
            let symmetric = Scale(0.5) * (&inner + inner.transpose());
            along - x * symmetric
        })
    }
}

fn product(a: &[Mat<f64>; 2], b: &[Mat<f64>; 2]) -> f64 {
    (0..2).map(|i| inner_product(a[i].as_ref(), b[i].as_ref())).sum()
}

/// The orthogonal factor of a QR decomposition with a positive diagonal.
fn orthogonal(x: MatRef<'_, f64>) -> Mat<f64> {
    let qr = x.qr();
    let (q, r) = (qr.compute_Q(), qr.R());
    Mat::from_fn(q.nrows(), q.ncols(), |i, j| if r[(j, j)] < 0.0 { -q[(i, j)] } else { q[(i, j)] })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numerics::{Unwatched, random};

    /// Eigenvalues in pairs that are nearly equal.
    fn in_pairs(k: usize) -> Vec<f64> {
        (0..k).map(|i| ((i / 2) as f64 + 1e-3 * (i % 2) as f64) / k as f64).collect()
    }

    #[test]
    fn without_functions_eigenfunctions_are_the_best_there_is() {
        let eigenvalues: Vec<f64> = (0..8).map(|i| f64::from(i) / 8.0).collect();
        let Coupling { p, q } =
            coupled([&eigenvalues, &eigenvalues], Mat::zeros(8, 8).as_ref(), 1.0, &Unwatched).unwrap();
        assert!(
            (p - Mat::<f64>::identity(8, 8)).norm_max() < 1e-9 && (q - Mat::<f64>::identity(8, 8)).norm_max() < 1e-9
        );
    }

    #[test]
    fn eigenfunctions_of_a_shape_that_are_turned_in_their_pairs_are_turned_back() {
        let k = 10;
        // B = R A with R a rotation by 50° within every pair.
        let (sin, cos) = 50f64.to_radians().sin_cos();
        let r = Mat::from_fn(k, k, |i, j| match (i / 2 == j / 2, i % 2, j % 2) {
            (true, a, b) if a == b => cos,
            (true, 0, _) => -sin,
            (true, ..) => sin,
            _ => 0.0,
        });
        let a = random::normal(k, 200, 1);
        let cross = &r * &a * a.transpose();
        let eigenvalues = in_pairs(k);
        let Coupling { p, q } = coupled([&eigenvalues, &eigenvalues], cross.as_ref(), 1.0, &Unwatched).unwrap();
        let map = q.transpose() * &r * &p;
        assert!((map - Mat::<f64>::identity(k, k)).norm_max() < 0.05);
        // The Laplacian stays nearly diagonal, and both are orthogonal.
        let turned = Mat::from_fn(k, k, |i, j| (0..k).map(|x| p[(x, i)] * eigenvalues[x] * p[(x, j)]).sum::<f64>());
        let beside: f64 =
            (0..k).flat_map(|i| (0..k).map(move |j| (i, j))).filter(|(i, j)| i != j).map(|at| turned[at].powi(2)).sum();
        assert!(beside < 1e-3, "{beside}");
        assert!((p.transpose() * &p - Mat::<f64>::identity(k, k)).norm_max() < 1e-12);
    }

    #[test]
    fn the_slope_is_that_of_the_energy_along_the_group() {
        let eigenvalues = in_pairs(6);
        let energy = Energy { eigenvalues: [&eigenvalues, &eigenvalues], cross: random::normal(6, 6, 3) };
        let at = [4, 5].map(|seed| orthogonal(random::normal(6, 6, seed).as_ref()));
        // Along X exp(t K), K skew.
        let skew = [6, 7].map(|seed| {
            let m = random::normal(6, 6, seed);
            &m - m.transpose()
        });
        let moved = |t: f64| [0, 1].map(|i| &at[i] + Scale(t) * (&at[i] * &skew[i]));
        let step = 1e-6;
        let difference = (energy.value(&moved(step)) - energy.value(&moved(-step))) / (2.0 * step);
        let direction = [0, 1].map(|i| &at[i] * &skew[i]);
        let slope = product(&energy.slope(&at), &direction);
        assert!((difference - slope).abs() < 1e-5 * slope.abs().max(1.0), "{difference} {slope}");
    }
}
