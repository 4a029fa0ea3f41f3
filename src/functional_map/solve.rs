//! The functional map that minimises data term and regulariser.

use faer::Mat;

use super::MapError;
use super::problem::{Problem, check};
use super::regulariser::{Regulariser, Search};
use crate::numerics::{Report, Watch};

/// A functional map and how it was found.
#[derive(Clone, Debug)]
pub struct Solution {
    /// C, l × k.
    pub c: Mat<f64>,
    /// Its history is that of the whole objective ‖C A − B‖²_F + γ ρ(C), from the start on.
    pub report: Report,
}

/// The minimiser C (l × k) of ‖C A − B‖²_F + γ ρ(C), for `weights` = W (l × k, none negative), reached from `start` = C⁰
/// (l × k, see [`least_squares`](super::problem::least_squares)).
///
/// A direct solution, that of `none` and of ℓ2 by default, reports no iteration and the objective of the start and its
/// own. An iteration carries out all of its `max_iterations` if `tolerance` is 0; otherwise it has converged as soon as
/// ‖C − prox(C − ∇f(C)/L)‖_F ≤ tolerance · max(1, ‖C‖_F), for ℓ2 by conjugate gradients ‖∇h(C)‖_F / L.
///
/// # Errors
/// [`MapError`] if a shape does not fit, an entry is not finite, a decomposition does not converge, or the watcher,
/// asked at every iteration, cancels.
pub fn solve(
    problem: &Problem,
    regulariser: &Regulariser,
    weights: &Mat<f64>,
    start: Mat<f64>,
    watch: &dyn Watch,
) -> Result<Solution, MapError> {
    let shape = (problem.rows(), problem.columns());
    check("W", weights.as_ref(), shape)?;
    check("C⁰", start.as_ref(), shape)?;
    let (c, mut report) = regulariser.minimiser(Search { problem, weights, start, watch })?;
    // The solvers compare objectives without ‖B‖²_F; nothing that is reported is negative by rounding.
    report.history.iter_mut().for_each(|value| *value = (*value + problem.constant()).max(0.0));
    Ok(Solution { c, report })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::functional_map::problem::least_squares;
    use crate::functional_map::regulariser::{L1, L2, L2Solver, LeastSquares, Nuclear};
    use crate::numerics::proximal_operators::{singular_value_threshold, soft_threshold};
    use crate::numerics::{Cancelled, Stopped, Unwatched, random};

    const SHAPES: [(usize, usize); 3] = [(8, 8), (12, 7), (6, 11)];

    fn problem(rows: usize, columns: usize, condition: f64) -> Problem {
        let a = random::ill_conditioned(columns, 60, condition, 1);
        let b = random::normal(rows, columns, 2) * &a + 0.1 * random::normal(rows, 60, 3);
        Problem::new(a.as_ref(), b.as_ref()).unwrap()
    }

    fn slanted(rows: usize, columns: usize) -> Mat<f64> {
        Mat::from_fn(rows, columns, |i, j| ((i * columns) as f64 / rows as f64 - j as f64).abs().powf(1.2))
    }

    fn l2(gamma: f64, solver: L2Solver) -> Regulariser {
        Regulariser::L2(L2 { gamma, max_iterations: 20_000, tolerance: 1e-8, solver })
    }

    fn l1(gamma: f64) -> Regulariser {
        Regulariser::L1(L1 { gamma, max_iterations: 20_000, tolerance: 1e-7 })
    }

    fn nuclear(gamma: f64) -> Regulariser {
        Regulariser::Nuclear(Nuclear { gamma, max_iterations: 20_000, tolerance: 1e-7 })
    }

    fn solved(problem: &Problem, regulariser: &Regulariser) -> Solution {
        let weights = slanted(problem.rows(), problem.columns());
        solve(problem, regulariser, &weights, least_squares(problem).unwrap(), &Unwatched).unwrap()
    }

    fn assert_descends(report: &Report) {
        assert_eq!(report.history.len(), report.iterations.max(1) + 1);
        assert!(report.objective() <= report.history[0]);
    }

    #[test]
    fn conjugate_gradients_reach_the_exact_l2_solution() {
        for (rows, columns) in SHAPES {
            // A residual of 1e-8 leaves C off by up to the ratio of the curvatures, condition², times as much.
            for (condition, off) in [(1.0, 1e-6), (10.0, 1e-5), (1e2, 1e-3)] {
                let problem = problem(rows, columns, condition);
                let exact = solved(&problem, &l2(10.0, L2Solver::Exact));
                let iterated = solved(&problem, &l2(10.0, L2Solver::ConjugateGradient));
                assert_descends(&exact.report);
                assert_descends(&iterated.report);
                assert_eq!(
                    (exact.report.iterations, iterated.report.stopped),
                    (0, Stopped::Converged),
                    "{rows} {columns} {condition}"
                );
                let (low, high) = (exact.report.objective(), iterated.report.objective());
                assert!((high - low).abs() < 1e-8 * high);
                assert!((exact.c - iterated.c).norm_l2() < off, "{rows} {columns} {condition}");
            }
        }
    }

    #[test]
    fn l1_reaches_its_optimality_condition() {
        for (rows, columns) in SHAPES {
            for condition in [1.0, 1e2, 1e4] {
                let problem = problem(rows, columns, condition);
                let Solution { c, report } = solved(&problem, &l1(1.0));
                assert_eq!(report.stopped, Stopped::Converged, "{rows} {columns} {condition}");
                assert_descends(&report);
                let step = 1.0 / problem.lipschitz().unwrap();
                let thresholds = step * slanted(rows, columns);
                let again = soft_threshold((&c - step * problem.gradient(c.as_ref())).as_ref(), thresholds.as_ref());
                assert!((again - &c).norm_l2() < 1e-6 * c.norm_l2().max(1.0));
            }
        }
    }

    #[test]
    fn an_entry_of_the_l1_solution_balances_gradient_and_weight() {
        let problem = problem(9, 6, 10.0);
        let regulariser = Regulariser::L1(L1 { gamma: 2.0, max_iterations: 20_000, tolerance: 1e-11 });
        let (c, w) = (solved(&problem, &regulariser).c, slanted(9, 6));
        let gradient = problem.gradient(c.as_ref());
        for j in 0..6 {
            for i in 0..9 {
                let (pull, limit) = (gradient[(i, j)], 2.0 * w[(i, j)]);
                let balanced = if c[(i, j)] == 0.0 {
                    pull.abs() <= limit + 1e-6
                } else {
                    (pull + limit.copysign(c[(i, j)])).abs() < 1e-6
                };
                assert!(balanced, "{i} {j}: {pull} against {limit}");
            }
        }
    }

    #[test]
    fn nuclear_reaches_its_optimality_condition() {
        for (rows, columns) in SHAPES {
            for condition in [1.0, 1e2, 1e4] {
                let problem = problem(rows, columns, condition);
                let Solution { c, report } = solved(&problem, &nuclear(20.0));
                assert_eq!(report.stopped, Stopped::Converged, "{rows} {columns} {condition}");
                assert_descends(&report);
                let step = 1.0 / problem.lipschitz().unwrap();
                let forward = &c - step * problem.gradient(c.as_ref());
                let (again, _) = singular_value_threshold(forward.as_ref(), 20.0 * step).unwrap();
                assert!((again - &c).norm_l2() < 1e-6 * c.norm_l2().max(1.0));
            }
        }
    }

    #[test]
    fn without_a_tolerance_200_iterations_are_reported() {
        let problem = problem(20, 20, 1e2);
        for regulariser in
            [r#"{"type": "l1"}"#, r#"{"type": "nuclear"}"#, r#"{"type": "l2", "solver": "conjugate_gradient"}"#]
        {
            let report = solved(&problem, &serde_json::from_str(regulariser).unwrap()).report;
            assert_eq!((report.iterations, report.stopped), (200, Stopped::MaxIterations));
            assert!(report.history.is_sorted_by(|before, after| after <= before));
            assert_descends(&report);
        }
    }

    #[test]
    fn no_weight_of_the_term_gives_least_squares() {
        let problem = problem(7, 5, 10.0);
        let wanted = least_squares(&problem).unwrap();
        for regulariser in [
            Regulariser::None(LeastSquares {}),
            l2(0.0, L2Solver::Exact),
            l2(0.0, L2Solver::ConjugateGradient),
            l1(0.0),
            nuclear(0.0),
        ] {
            let solution = solve(&problem, &regulariser, &Mat::ones(7, 5), wanted.clone(), &Unwatched).unwrap();
            assert!((solution.c - &wanted).norm_max() < 1e-10);
            assert!(solution.report.objective() <= solution.report.history[0] + 1e-10);
        }
    }

    #[test]
    fn equal_coefficients_give_the_identity() {
        let a = random::normal(10, 50, 1);
        let problem = Problem::new(a.as_ref(), a.as_ref()).unwrap();
        let weights = slanted(10, 10);
        for regulariser in [Regulariser::None(LeastSquares {}), l2(10.0, L2Solver::Exact), l1(1.0)] {
            let c = solve(&problem, &regulariser, &weights, Mat::zeros(10, 10), &Unwatched).unwrap().c;
            assert!((c - Mat::<f64>::identity(10, 10)).norm_max() < 1e-5);
        }
    }

    #[test]
    fn without_constraints_the_term_alone_decides() {
        let problem = Problem::unconstrained(3, 4);
        for regulariser in [l2(1.0, L2Solver::Exact), l2(1.0, L2Solver::ConjugateGradient), l1(1.0), nuclear(1.0)] {
            let c = solve(&problem, &regulariser, &Mat::ones(3, 4), random::normal(3, 4, 1), &Unwatched).unwrap().c;
            assert!(c.norm_max() < 1e-9);
        }
    }

    #[test]
    fn the_watcher_is_obeyed() {
        struct Never;
        impl Watch for Never {
            fn proceed(&self, _fraction: f64) -> Result<(), Cancelled> {
                Err(Cancelled)
            }
        }
        let problem = problem(4, 4, 1.0);
        for regulariser in [l2(1.0, L2Solver::ConjugateGradient), l1(1.0), nuclear(1.0)] {
            let error = solve(&problem, &regulariser, &Mat::ones(4, 4), Mat::zeros(4, 4), &Never).unwrap_err();
            assert_eq!(error, MapError::Cancelled(Cancelled));
        }
    }

    #[test]
    fn matrices_that_do_not_fit_are_named() {
        let problem = problem(4, 5, 1.0);
        let error = solve(&problem, &l1(1.0), &Mat::ones(5, 4), Mat::zeros(4, 5), &Unwatched).unwrap_err();
        assert_eq!(error.to_string(), "W has 5 rows and 4 columns where 4 and 5 belong");
        let error = solve(&problem, &l1(1.0), &Mat::ones(4, 5), Mat::full(4, 5, f64::NAN), &Unwatched).unwrap_err();
        assert_eq!(error.to_string(), "C⁰ is not finite in row 0, column 0");
    }
}
