//! Geometric matrix completion [KBB+15], eq. 2.15: C = A Bᵀ of low rank, smooth along both shapes and sparse.

use faer::{Mat, MatRef, Scale};

use super::{About, Formula, Found, MAX_ITERATIONS, Search, TOLERANCE, Term, step};
use crate::functional_map::MapError;
use crate::functional_map::parameter::{Declared, integer, number, parameters};
use crate::functional_map::problem::{Problem, Seen};
use crate::numerics::conjugate_gradient::{self, Smooth};
use crate::numerics::{DecompositionError, Stopping};

/// Below this |x| is rounded off, so that the sum of magnitudes has a gradient: values of Ψ C Φᵀ are of the size of k.
const ROUNDED: f64 = 1e-2;

const MU_1: Declared<f64> = number("weight μ₁ of smoothness along the sketch", 0.1, 0.0, 1e9);
const MU_2: Declared<f64> = number("weight μ₂ of smoothness along the mesh", 0.1, 0.0, 1e9);
const MU_3: Declared<f64> = number("weight μ₃ of the sum of magnitudes of Ψ C Φᵀ over both shapes", 0.1, 0.0, 1e9);
const MU_4: Declared<f64> = number("weight μ₄ of the size of the factors, that is of the nuclear norm", 1.0, 0.0, 1e9);
const RANK: Declared<usize> = integer("columns of the factors: the largest rank of C", 20, 1, 500);

parameters! {
    /// The terms of eq. 2.15 beside the data.
    pub struct MatrixCompletion {
        mu_1: f64 = MU_1,
        mu_2: f64 = MU_2,
        mu_3: f64 = MU_3,
        mu_4: f64 = MU_4,
        rank: usize = RANK,
        max_iterations: usize = MAX_ITERATIONS,
        tolerance: f64 = TOLERANCE,
    }
}

pub(super) static ABOUT: About = About {
    r#type: "matrix_completion",
    title: "Geometric matrix completion",
    formula: Formula {
        text: "‖C A − B‖²_F + μ₁ tr(C Λ_M Cᵀ) + μ₂ tr(Cᵀ Λ_N C) + μ₃ ‖Ψ C Φᵀ‖₁ + μ₄/2 (‖U‖²_F + ‖V‖²_F), C = U Vᵀ",
        latex: r"\|CA - B\|_F^2 + \mu_1 \operatorname{tr}(C \Lambda_M C^T) + \mu_2 \operatorname{tr}(C^T \Lambda_N C) + \mu_3 \|\Psi C \Phi^T\|_1 + \tfrac{\mu_4}{2} (\|U\|_F^2 + \|V\|_F^2), \; C = U V^T",
    },
    equation: "2.15",
    solver: "nonlinear conjugate gradients on both factors from those of C⁰; eigenvalues in units of the largest, the sum of \
             magnitudes rounded off and taken over samples of both shapes",
    parameters: MatrixCompletion::PARAMETERS,
};

impl Term for MatrixCompletion {
    /// Not convex in the factors; where the rank is not less than that of the solution it has no other minima than that of the
    /// problem in C with the nuclear norm.
    fn minimiser(&self, search: Search<'_>) -> Found {
        let Search { problem, start, watch, .. } = search;
        let (rows, columns) = start.shape();
        let factors = factors(start.as_ref(), self.rank.min(rows).min(columns))?;
        let size = start.norm_l2().max(1.0);
        let energy = Energy { terms: self, problem, seen: problem.seen(), rows };
        let h = Smooth {
            objective: |uv: MatRef<'_, f64>| Ok(energy.value(uv)),
            gradient: |uv: MatRef<'_, f64>| Ok(energy.gradient(uv)),
            step: step(problem.lipschitz()? * size),
        };
        let stopping = Stopping { max_iterations: self.max_iterations, tolerance: self.tolerance };
        let (uv, report) = conjugate_gradient::minimise(&h, factors, stopping, watch)?;
        Ok((product(uv.as_ref(), rows), report))
    }
}

/// U √Σ over V √Σ of the singular value decomposition of C⁰, the first `rank` columns: (l + k) × rank.
fn factors(c: MatRef<'_, f64>, rank: usize) -> Result<Mat<f64>, MapError> {
    let svd = c.thin_svd().map_err(|_| DecompositionError::SingularValues { rows: c.nrows(), columns: c.ncols() })?;
    let (u, v, sigma) = (svd.U(), svd.V(), svd.S().column_vector());
    Ok(Mat::from_fn(c.nrows() + c.ncols(), rank, |i, j| {
        let entry = if i < c.nrows() { u[(i, j)] } else { v[(i - c.nrows(), j)] };
        entry * sigma[j].max(0.0).sqrt()
    }))
}

/// C = U Vᵀ of U (l × r) over V (k × r).
fn product(uv: MatRef<'_, f64>, rows: usize) -> Mat<f64> {
    let (u, v) = uv.split_at_row(rows);
    u * v.transpose()
}

struct Energy<'a> {
    terms: &'a MatrixCompletion,
    problem: &'a Problem,
    seen: &'a Seen,
    /// l.
    rows: usize,
}

impl Energy<'_> {
    fn value(&self, uv: MatRef<'_, f64>) -> f64 {
        let c = product(uv, self.rows);
        let smoothness: f64 =
            (0..c.ncols()).map(|j| (0..c.nrows()).map(|i| self.roughness(i, j) * c[(i, j)].powi(2)).sum::<f64>()).sum();
        let [phi, psi] = &self.seen.samples;
        let kernel = psi * &c * phi.transpose();
        let rounded = |x: f64| x.hypot(ROUNDED) - ROUNDED;
        let magnitudes: f64 = kernel.col_iter().map(|column| column.iter().map(|&x| rounded(x)).sum::<f64>()).sum();
        let size = 0.5 * self.terms.mu_4 * uv.squared_norm_l2();
        self.problem.variable(c.as_ref()) + smoothness + self.of_sample() * magnitudes + size
    }

    fn gradient(&self, uv: MatRef<'_, f64>) -> Mat<f64> {
        let c = product(uv, self.rows);
        let [phi, psi] = &self.seen.samples;
        let kernel = psi * &c * phi.transpose();
        let signs = Mat::from_fn(kernel.nrows(), kernel.ncols(), |i, j| kernel[(i, j)] / kernel[(i, j)].hypot(ROUNDED));
        let of_magnitudes = Scale(self.of_sample()) * (psi.transpose() * signs * phi);
        let data = self.problem.gradient(c.as_ref());
        let of_c = Mat::from_fn(c.nrows(), c.ncols(), |i, j| {
            data[(i, j)] + 2.0 * self.roughness(i, j) * c[(i, j)] + of_magnitudes[(i, j)]
        });
        let (u, v) = uv.split_at_row(self.rows);
        let (of_u, of_v) = (&of_c * v, of_c.transpose() * u);
        Mat::from_fn(uv.nrows(), uv.ncols(), |i, j| {
            let of_c = if i < self.rows { of_u[(i, j)] } else { of_v[(i - self.rows, j)] };
            of_c + self.terms.mu_4 * uv[(i, j)]
        })
    }

    /// μ₁ λ_j + μ₂ μ_i, eigenvalues in units of the largest of both.
    fn roughness(&self, i: usize, j: usize) -> f64 {
        let [sketch, mesh] = &self.seen.eigenvalues;
        let at = |eigenvalues: &[f64], i: usize| eigenvalues.get(i).copied().unwrap_or(0.0);
        self.terms.mu_1 * at(sketch, j) + self.terms.mu_2 * at(mesh, i)
    }

    /// μ₃ times the share of both shapes that a pair of samples stands for.
    fn of_sample(&self) -> f64 {
        let [phi, psi] = &self.seen.samples;
        self.terms.mu_3 / (phi.nrows() * psi.nrows()).max(1) as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::functional_map::problem::{Commutator, least_squares};
    use crate::functional_map::regulariser::Nuclear;
    use crate::numerics::{Unwatched, inner_product, random};

    const L: usize = 9;
    const K: usize = 7;

    fn problem() -> Problem {
        let a = random::ill_conditioned(K, 60, 5.0, 1);
        let b = random::normal(L, K, 2) * &a + 0.1 * random::normal(L, 60, 3);
        let mut problem = Problem::new(a.as_ref(), b.as_ref()).unwrap();
        let eigenvalues = [K, L].map(|n| (0..n).map(|i| i as f64 / L as f64).collect());
        problem.see(Seen { eigenvalues, samples: [random::normal(12, K, 4), random::normal(15, L, 5)] });
        problem
    }

    /// The minimiser from C⁰ of the data alone.
    fn found(term: &dyn Term, problem: &Problem, data: &Problem) -> Mat<f64> {
        let (weights, start) = (Mat::zeros(L, K), least_squares(data).unwrap());
        term.minimiser(Search { problem, weights: &weights, start, watch: &Unwatched }).unwrap().0
    }

    fn minimiser(terms: MatrixCompletion, problem: &Problem) -> Mat<f64> {
        found(&terms, problem, problem)
    }

    fn terms(mu: [f64; 4]) -> MatrixCompletion {
        let [mu_1, mu_2, mu_3, mu_4] = mu;
        MatrixCompletion { mu_1, mu_2, mu_3, mu_4, rank: K, max_iterations: 2_000, tolerance: 1e-8 }
    }

    #[test]
    fn with_the_factors_alone_it_is_the_nuclear_norm() {
        for gamma in [0.1, 5.0] {
            let problem = problem();
            let nuclear = Nuclear { gamma, max_iterations: 20_000, tolerance: 1e-10 };
            let wanted = self::found(&nuclear, &problem, &problem);
            let found = minimiser(terms([0.0, 0.0, 0.0, gamma]), &problem);
            assert!((found - &wanted).norm_l2() < 1e-4 * wanted.norm_l2(), "γ = {gamma}");
        }
    }

    #[test]
    fn smoothness_is_that_of_the_laplacians() {
        let problem = problem();
        let found = minimiser(terms([3.0, 2.0, 0.0, 1.0]), &problem);
        // tr(C Λ Cᵀ) = ‖C √Λ‖² and tr(Cᵀ Λ C) = ‖√Λ C‖², as commutators with one side at rest.
        let mut wanted = problem.clone();
        let root = |n: usize| Mat::from_fn(n, n, |i, j| if i == j { (i as f64 / L as f64).sqrt() } else { 0.0 });
        wanted.commute(Commutator { x: root(K), y: Mat::zeros(L, L), weight: 3.0 }).unwrap();
        wanted.commute(Commutator { x: Mat::zeros(K, K), y: root(L), weight: 2.0 }).unwrap();
        let nuclear = Nuclear { gamma: 1.0, max_iterations: 20_000, tolerance: 1e-10 };
        let wanted = self::found(&nuclear, &wanted, &problem);
        assert!((found - &wanted).norm_l2() < 1e-4 * wanted.norm_l2());
    }

    #[test]
    fn the_gradient_is_the_slope_of_the_value() {
        let (problem, terms) = (problem(), terms([0.3, 0.2, 5.0, 0.4]));
        let energy = Energy { terms: &terms, problem: &problem, seen: problem.seen(), rows: L };
        let (uv, direction, step) = (random::normal(L + K, 3, 6), random::normal(L + K, 3, 7), 1e-6);
        let difference =
            energy.value((&uv + step * &direction).as_ref()) - energy.value((&uv - step * &direction).as_ref());
        let slope = inner_product(energy.gradient(uv.as_ref()).as_ref(), direction.as_ref());
        assert!((difference / (2.0 * step) - slope).abs() < 1e-5 * slope.abs());
    }

    #[test]
    fn magnitudes_make_the_kernel_sparser() {
        let problem = problem();
        let [phi, psi] = &problem.seen().samples;
        let magnitudes = |c: Mat<f64>| {
            let kernel = psi * c * phi.transpose();
            kernel.col_iter().map(|column| column.iter().map(|x| x.abs()).sum::<f64>()).sum::<f64>()
        };
        let [without, with] = [0.0, 200.0].map(|mu_3| magnitudes(minimiser(terms([0.0, 0.0, mu_3, 0.1]), &problem)));
        assert!(with < 0.7 * without, "{with} {without}");
    }

    #[test]
    fn the_rank_is_at_most_that_asked_for() {
        let problem = problem();
        let c = minimiser(MatrixCompletion { rank: 2, max_iterations: 500, ..terms([0.1; 4]) }, &problem);
        let singular = c.singular_values().unwrap();
        assert!(singular[1] > 1e-3 && singular[2] < 1e-9, "{singular:?}");
    }
}
