//! Nonlinear conjugate gradients with backtracking.

use faer::{Mat, MatRef};

use super::{Cancelled, Report, Stopped, Stopping, Watch, inner_product};

/// Share of the decrease a step's slope promises that it has to bring: c of eq. 3.13 \[NW06, §3.1\].
const SUFFICIENT_DECREASE: f64 = 1e-4;
/// Factor on a step that does not: ρ of eq. 3.13.
const CONTRACTION: f64 = 0.5;
/// Steps tried along a direction: the last is 2⁻⁴⁰ of the first.
const TRIES: usize = 40;

/// A convex function of a matrix with a Lipschitz gradient.
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
/// Converged means ‖∇f(X)‖_F / L ≤ tolerance · max(1, ‖X‖_F) at the X returned.
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
    O: Fn(MatRef<'_, f64>) -> f64,
    G: Fn(MatRef<'_, f64>) -> Mat<f64>,
{
    let mut x = start;
    let mut history = vec![(f.objective)(x.as_ref())];
    let mut g = (f.gradient)(x.as_ref());
    let mut d = -&g;
    let stopped = loop {
        let iterations = history.len() - 1;
        if stopping.reached(f.step * g.norm_l2(), x.norm_l2()) {
            break Stopped::Converged;
        }
        if iterations == stopping.max_iterations {
            break Stopped::MaxIterations;
        }
        watch.proceed(iterations as f64 / stopping.max_iterations as f64)?;
        if inner_product(g.as_ref(), d.as_ref()) >= 0.0 {
            d = -&g;
        }
        let value = history[iterations];
        match line_search(f, &x, value, &g, &d) {
            Some((next, next_value)) => {
                x = next;
                history.push(next_value);
            }
            None => history.push(value),
        }
        let g_next = (f.gradient)(x.as_ref());
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

/// The point and value of a sufficient decrease from `x` along `d`; none if no step tried brings one.
fn line_search<O, G>(
    f: &Smooth<O, G>,
    x: &Mat<f64>,
    value: f64,
    g: &Mat<f64>,
    d: &Mat<f64>,
) -> Option<(Mat<f64>, f64)>
where
    O: Fn(MatRef<'_, f64>) -> f64,
    G: Fn(MatRef<'_, f64>) -> Mat<f64>,
{
    let slope = inner_product(g.as_ref(), d.as_ref());
    let slope_further = inner_product((f.gradient)((x + f.step * d).as_ref()).as_ref(), d.as_ref());
    let rise = slope_further - slope;
    let mut alpha = if rise > 0.0 { -f.step * slope / rise } else { f.step };
    for _ in 0..TRIES {
        let next = x + alpha * d;
        let next_value = (f.objective)(next.as_ref());
        if next_value <= value + SUFFICIENT_DECREASE * alpha * slope {
            return Some((next, next_value));
        }
        alpha *= CONTRACTION;
    }
    None
}
