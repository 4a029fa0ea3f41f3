//! Nonlinear conjugate gradients with backtracking.

use faer::{Mat, MatRef};

use super::{Cancelled, Report, Stopped, Stopping, Watch, inner_product};

/// Share of the decrease a step's slope promises that it has to bring: c of eq. 3.13 \[NW06, §3.1\].
const SUFFICIENT_DECREASE: f64 = 1e-4;
/// Factor on a step that does not: ρ of eq. 3.13.
const CONTRACTION: f64 = 0.5;
/// Steps tried along a direction: the last is 2⁻⁴⁰ of the first.
const TRIES: usize = 40;

/// A convex function of a matrix with a Lipschitz gradient. What takes long to evaluate asks a watcher of its own.
pub struct Smooth<O, G> {
    /// f; a constant may be left out.
    pub objective: O,
    /// ∇f.
    pub gradient: G,
    /// 1/L, L the Lipschitz constant of ∇f: the unit in which a gradient is a length.
    pub step: f64,
}

/// The minimiser of f reached from `start`, and the report of how.
///
/// Eq. 3.9–3.13: directions by Hestenes and Stiefel's β, steps by backtracking; a direction that does not descend is
/// replaced by the negative gradient. The first step tried is the secant's \[She94, §14.2\], exact on a quadratic. Where
/// rounding hides any descent the iterate stays, so the history never rises.
///
/// Converged means ‖∇f(X)‖_F / L ≤ tolerance · max(1, ‖X‖_F) at the X returned. Descent is judged by values, so a
/// tolerance below about √ε = 1e-8 may not be reached.
///
/// # Errors
/// [`Cancelled`] by the watcher.
pub fn minimise<O, G>(
    f: &Smooth<O, G>,
    start: Mat<f64>,
    stopping: Stopping,
    watch: &dyn Watch,
) -> Result<(Mat<f64>, Report), Cancelled>
where
    O: Fn(MatRef<'_, f64>) -> Result<f64, Cancelled>,
    G: Fn(MatRef<'_, f64>) -> Result<Mat<f64>, Cancelled>,
{
    let mut x = start;
    let mut history = vec![(f.objective)(x.as_ref())?];
    let mut g = (f.gradient)(x.as_ref())?;
    let mut d = -&g;
    let stopped = loop {
        let iterations = history.len() - 1;
        if stopping.reached(f.step * g.norm_l2(), x.norm_l2()) {
            break Stopped::Converged;
        }
        if iterations == stopping.max_iterations {
            break Stopped::MaxIterations;
        }
        let ask = || watch.proceed(iterations as f64 / stopping.max_iterations as f64);
        ask()?;
        if inner_product(g.as_ref(), d.as_ref()) >= 0.0 {
            d = -&g;
        }
        let value = history[iterations];
        match line_search(f, &x, value, &g, &d, &ask)? {
            Some((next, next_value)) => {
                x = next;
                history.push(next_value);
            }
            None => history.push(value),
        }
        let g_next = (f.gradient)(x.as_ref())?;
        d = hestenes_stiefel(&g_next, &g, &d) * &d - &g_next;
        g = g_next;
    };
    Ok((x, Report { iterations: history.len() - 1, history, stopped }))
}

/// β of eq. 3.12; 0, which begins anew, where the gradient has not changed along the direction.
fn hestenes_stiefel(g_next: &Mat<f64>, g: &Mat<f64>, d: &Mat<f64>) -> f64 {
    let change = g_next - g;
    let curvature = inner_product(d.as_ref(), change.as_ref());
    if curvature > 0.0 { inner_product(g_next.as_ref(), change.as_ref()) / curvature } else { 0.0 }
}

/// The point and value of a sufficient decrease from `x` along `d`; none if no step tried brings one. It is asked before every try
/// whether to go on.
fn line_search<O, G>(
    f: &Smooth<O, G>,
    x: &Mat<f64>,
    value: f64,
    g: &Mat<f64>,
    d: &Mat<f64>,
    ask: &dyn Fn() -> Result<(), Cancelled>,
) -> Result<Option<(Mat<f64>, f64)>, Cancelled>
where
    O: Fn(MatRef<'_, f64>) -> Result<f64, Cancelled>,
    G: Fn(MatRef<'_, f64>) -> Result<Mat<f64>, Cancelled>,
{
    let slope = inner_product(g.as_ref(), d.as_ref());
    let slope_further = inner_product((f.gradient)((x + f.step * d).as_ref())?.as_ref(), d.as_ref());
    let rise = slope_further - slope;
    let mut alpha = if rise > 0.0 { -f.step * slope / rise } else { f.step };
    for _ in 0..TRIES {
        ask()?;
        let next = x + alpha * d;
        let next_value = (f.objective)(next.as_ref())?;
        if next_value <= value + SUFFICIENT_DECREASE * alpha * slope {
            return Ok(Some((next, next_value)));
        }
        alpha *= CONTRACTION;
    }
    Ok(None)
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicUsize, Ordering};

    use super::*;
    use crate::numerics::{Unwatched, random};

    /// The minimiser of ⟨X S, X⟩/2 − ⟨B, X⟩, S symmetric and positive definite.
    fn quadratic(s: &Mat<f64>, b: &Mat<f64>, stopping: Stopping) -> (Mat<f64>, Report) {
        let f = Smooth {
            objective: |x: MatRef<'_, f64>| Ok(inner_product((0.5 * (x * s) - b).as_ref(), x)),
            gradient: |x: MatRef<'_, f64>| Ok(x * s - b),
            step: 1.0 / s.singular_values().unwrap()[0],
        };
        minimise(&f, Mat::zeros(b.nrows(), b.ncols()), stopping, &Unwatched).unwrap()
    }

    #[test]
    fn a_quadratic_takes_as_many_iterations_as_it_has_distinct_eigenvalues() {
        let s = Mat::from_fn(6, 6, |i, j| if i == j { [1.0, 4.0, 9.0][i % 3] } else { 0.0 });
        let b = random::normal(5, 6, 1);
        let (x, report) = quadratic(&s, &b, Stopping { max_iterations: 100, tolerance: 1e-12 });
        assert_eq!((report.iterations, report.stopped), (3, Stopped::Converged));
        assert!((x * s - b).norm_max() < 1e-10);
    }

    #[test]
    fn an_ill_conditioned_quadratic_converges_and_never_rises() {
        let a = random::ill_conditioned(8, 40, 1e2, 2);
        let (s, b) = (&a * a.transpose(), random::normal(3, 8, 3));
        let (_, report) = quadratic(&s, &b, Stopping { max_iterations: 1000, tolerance: 1e-9 });
        assert_eq!(report.stopped, Stopped::Converged);
        assert!(report.history.is_sorted_by(|before, after| after <= before));
    }

    #[test]
    fn without_a_tolerance_all_iterations_are_carried_out() {
        let (s, b) = (Mat::identity(3, 3), random::normal(3, 3, 4));
        let (x, report) = quadratic(&s, &b, Stopping { max_iterations: 20, tolerance: 0.0 });
        assert_eq!((report.iterations, report.stopped), (20, Stopped::MaxIterations));
        assert!((x - b).norm_max() < 1e-15);
    }

    #[test]
    fn a_function_that_is_not_quadratic_is_minimised() {
        // Σ √(1 + (x − m)²) has its minimum at m and curvature at most 1.
        let m = 3.0 * random::normal(4, 4, 5);
        let root = |x: f64| (1.0 + x * x).sqrt();
        let f = Smooth {
            objective: |x: MatRef<'_, f64>| Ok((x - &m).col_iter().flat_map(|c| c.iter()).map(|&x| root(x)).sum()),
            gradient: |x: MatRef<'_, f64>| {
                Ok(Mat::from_fn(4, 4, |i, j| (x[(i, j)] - m[(i, j)]) / root(x[(i, j)] - m[(i, j)])))
            },
            step: 1.0,
        };
        let stopping = Stopping { max_iterations: 200, tolerance: 1e-8 };
        let (x, report) = minimise(&f, Mat::zeros(4, 4), stopping, &Unwatched).unwrap();
        assert_eq!(report.stopped, Stopped::Converged);
        assert!((x - m).norm_max() < 1e-6);
    }

    #[test]
    fn every_try_of_a_line_search_can_be_stopped() {
        struct Third(AtomicUsize);
        impl Watch for Third {
            fn proceed(&self, _fraction: f64) -> Result<(), Cancelled> {
                if self.0.fetch_add(1, Ordering::Relaxed) == 2 { Err(Cancelled) } else { Ok(()) }
            }
        }
        // The value rises wherever one goes: there are as many tries as may be.
        let evaluations = AtomicUsize::new(0);
        let f = Smooth {
            objective: |_: MatRef<'_, f64>| Ok(evaluations.fetch_add(1, Ordering::Relaxed) as f64),
            gradient: |x: MatRef<'_, f64>| Ok(x.to_owned()),
            step: 1.0,
        };
        let stopping = Stopping { max_iterations: 1, tolerance: 0.0 };
        let watch = Third(AtomicUsize::new(0));
        assert_eq!(minimise(&f, Mat::ones(1, 1), stopping, &watch).unwrap_err(), Cancelled);
        assert_eq!(evaluations.into_inner(), 2);
    }
}
