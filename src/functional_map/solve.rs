//! The functional map that minimises data term and regulariser.

use faer::{Mat, MatRef, Scale};

use super::MapError;
use super::problem::{Problem, check, least_squares};
use super::regulariser::{L2Solver, Regulariser};
use super::ridge;
use crate::numerics::proximal_gradient::{self, Composite};
use crate::numerics::proximal_operators::{nuclear_norm, singular_value_threshold, soft_threshold};
use crate::numerics::{Report, Stopped, Stopping, Watch, conjugate_gradient};

/// A functional map and how it was found.
#[derive(Clone, Debug)]
pub struct Solution {
    /// C, l × k.
    pub c: Mat<f64>,
    /// Its history is that of the whole objective ‖C A − B‖²_F + γ ρ(C), from the start on.
    pub report: Report,
}

/// The minimiser C (l × k) of ‖C A − B‖²_F + γ ρ(C), for `weights` = W (l × k, none negative), reached from `start` = C⁰
/// (l × k, see [`least_squares`]).
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
    let (c, mut report) = match *regulariser {
        Regulariser::None {} => {
            let c = least_squares(problem)?;
            let history = vec![problem.variable(start.as_ref()), problem.variable(c.as_ref())];
            (c, Report { iterations: 0, history, stopped: Stopped::Converged })
        }
        Regulariser::L2 { gamma, solver: L2Solver::Exact, .. } => {
            let c = ridge::minimiser(problem, gamma, weights.as_ref())?;
            let h = |c: &Mat<f64>| problem.variable(c.as_ref()) + gamma * weighted_energy(weights, c.as_ref());
            let history = vec![h(&start), h(&c)];
            (c, Report { iterations: 0, history, stopped: Stopped::Converged })
        }
        Regulariser::L2 { gamma, max_iterations, tolerance, solver: L2Solver::ConjugateGradient } => {
            l2(problem, gamma, weights, start, Stopping { max_iterations, tolerance }, watch)?
        }
        Regulariser::L1 { gamma, max_iterations, tolerance } => {
            l1(problem, gamma, weights, start, Stopping { max_iterations, tolerance }, watch)?
        }
        Regulariser::Nuclear { gamma, max_iterations, tolerance } => {
            nuclear(problem, gamma, start, Stopping { max_iterations, tolerance }, watch)?
        }
    };
    // The solvers compare objectives without ‖B‖²_F; nothing that is reported is negative by rounding.
    report.history.iter_mut().for_each(|value| *value = (*value + problem.constant()).max(0.0));
    Ok(Solution { c, report })
}

/// Eq. 3.6 by conjugate gradients, with the gradient of eq. 3.21: 2 C A Aᵀ − 2 B Aᵀ + 2 γ W ⊙ W ⊙ C.
fn l2(
    problem: &Problem,
    gamma: f64,
    weights: &Mat<f64>,
    start: Mat<f64>,
    stopping: Stopping,
    watch: &dyn Watch,
) -> Result<(Mat<f64>, Report), MapError> {
    let curvature = Mat::from_fn(weights.nrows(), weights.ncols(), |i, j| 2.0 * gamma * weights[(i, j)].powi(2));
    let h = conjugate_gradient::Smooth {
        objective: |c: MatRef<'_, f64>| problem.variable(c) + gamma * weighted_energy(weights, c),
        gradient: |c: MatRef<'_, f64>| {
            let data = problem.gradient(c);
            Mat::from_fn(c.nrows(), c.ncols(), |i, j| data[(i, j)] + curvature[(i, j)] * c[(i, j)])
        },
        step: step(problem.lipschitz()? + curvature.norm_max()),
    };
    Ok(conjugate_gradient::minimise(&h, start, stopping, watch)?)
}

/// Eq. 3.22 by the fast gradient method, thresholds λ γ W.
fn l1(
    problem: &Problem,
    gamma: f64,
    weights: &Mat<f64>,
    start: Mat<f64>,
    stopping: Stopping,
    watch: &dyn Watch,
) -> Result<(Mat<f64>, Report), MapError> {
    let step = step(problem.lipschitz()?);
    let thresholds = Scale(step * gamma) * weights;
    let h = Composite {
        objective: |c: MatRef<'_, f64>| Ok(problem.variable(c) + gamma * weighted_sum(weights, c)),
        gradient: |c: MatRef<'_, f64>| problem.gradient(c),
        proximal: |v: MatRef<'_, f64>| Ok(soft_threshold(v, thresholds.as_ref())),
        step,
    };
    proximal_gradient::minimise(&h, start, stopping, watch)
}

/// Eq. 3.23 by the fast gradient method, threshold λ γ.
fn nuclear(
    problem: &Problem,
    gamma: f64,
    start: Mat<f64>,
    stopping: Stopping,
    watch: &dyn Watch,
) -> Result<(Mat<f64>, Report), MapError> {
    let step = step(problem.lipschitz()?);
    let h = Composite {
        objective: |c: MatRef<'_, f64>| Ok(problem.variable(c) + gamma * nuclear_norm(c)?),
        gradient: |c: MatRef<'_, f64>| problem.gradient(c),
        proximal: |v: MatRef<'_, f64>| Ok(singular_value_threshold(v, step * gamma)?),
        step,
    };
    proximal_gradient::minimise(&h, start, stopping, watch)
}

/// 1/L; 1 for a data term without constraints, where any step will do.
fn step(lipschitz: f64) -> f64 {
    if lipschitz > f64::MIN_POSITIVE { 1.0 / lipschitz } else { 1.0 }
}

/// ‖W ⊙ C‖²_F.
fn weighted_energy(weights: &Mat<f64>, c: MatRef<'_, f64>) -> f64 {
    entries(weights, c).map(|(w, c)| (w * c).powi(2)).sum()
}

/// ‖W ⊙ C‖₁.
fn weighted_sum(weights: &Mat<f64>, c: MatRef<'_, f64>) -> f64 {
    entries(weights, c).map(|(w, c)| (w * c).abs()).sum()
}

fn entries(weights: &Mat<f64>, c: MatRef<'_, f64>) -> impl Iterator<Item = (f64, f64)> {
    weights.col_iter().zip(c.col_iter()).flat_map(|(w, c)| w.iter().copied().zip(c.iter().copied()))
}
