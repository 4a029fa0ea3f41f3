//! The exact minimiser of the ℓ2 problem.

use faer::linalg::solvers::Solve;
use faer::{Mat, MatRef, Side};

use super::MapError;
use super::problem::Problem;
use crate::numerics::{Watch, least_squares};

/// The C (l × k) of ‖C A − B‖²_F + γ ‖W ⊙ C‖²_F → min, for W (l × k).
///
/// The rows of C are independent: (A Aᵀ + γ diag(wᵢ²)) cᵢ = A bᵢ, l Cholesky factorisations. A row whose matrix is
/// singular to rounding gets the solution of least norm.
///
/// # Errors
/// [`MapError::Decomposition`] if such a row's eigenvalues do not converge, or the watcher, asked at every row, cancels.
pub(super) fn minimiser(
    problem: &Problem,
    gamma: f64,
    weights: MatRef<'_, f64>,
    watch: &dyn Watch,
) -> Result<Mat<f64>, MapError> {
    let mut c = Mat::zeros(problem.rows(), problem.columns());
    for i in 0..problem.rows() {
        watch.proceed(i as f64 / problem.rows() as f64)?;
        let mut system = problem.gram().to_owned();
        for j in 0..problem.columns() {
            system[(j, j)] += gamma * weights[(i, j)].powi(2);
        }
        let row = solution(system.as_ref(), problem.cross().subrows(i, 1))?;
        c.row_mut(i).copy_from(row.row(0));
    }
    Ok(c)
}

/// The x (1 × k) of x S = b for S (k × k) symmetric positive semidefinite, the one of least norm where S is singular.
fn solution(system: MatRef<'_, f64>, b: MatRef<'_, f64>) -> Result<Mat<f64>, MapError> {
    let cut_off = system.nrows() as f64 * f64::EPSILON * system.norm_max();
    match system.llt(Side::Lower) {
        Ok(llt) if llt.L().diagonal().column_vector().iter().all(|&pivot| pivot * pivot > cut_off) => {
            Ok(llt.solve(b.transpose()).transpose().to_owned())
        }
        _ => Ok(least_squares::minimum_norm(system, b)?),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::functional_map::problem;
    use crate::numerics::Unwatched;
    use crate::numerics::random;

    fn example(q: usize) -> Problem {
        Problem::new(random::normal(5, q, 1).as_ref(), random::normal(7, q, 2).as_ref()).unwrap()
    }

    #[test]
    fn the_minimiser_has_no_gradient() {
        let (problem, gamma) = (example(40), 3.0);
        let weights = Mat::from_fn(7, 5, |i, j| i.abs_diff(j) as f64);
        let c = minimiser(&problem, gamma, weights.as_ref(), &Unwatched).unwrap();
        let penalty = Mat::from_fn(7, 5, |i, j| 2.0 * gamma * weights[(i, j)].powi(2) * c[(i, j)]);
        assert!((problem.gradient(c.as_ref()) + penalty).norm_max() < 1e-9);
    }

    #[test]
    fn without_a_penalty_it_is_least_squares() {
        // Three constraints leave A Aᵀ (5 × 5) singular.
        for (q, tolerance) in [(40, 1e-12), (3, 1e-7)] {
            let problem = example(q);
            let c = minimiser(&problem, 0.0, Mat::ones(7, 5).as_ref(), &Unwatched).unwrap();
            assert!((c - problem::least_squares(&problem).unwrap()).norm_max() < tolerance);
        }
    }
}
