//! The fast proximal gradient method.

use faer::{Mat, MatRef};

use super::{Cancelled, Report, Stopped, Stopping, Watch};

/// A convex function f + g of a matrix, f with a Lipschitz gradient and g with a proximal operator.
pub struct Composite<O, G, P> {
    /// f + g; a constant may be left out.
    pub objective: O,
    /// ∇f.
    pub gradient: G,
    /// V ↦ the minimiser of λ g(X) + ½ ‖X − V‖²_F with λ = `step`.
    pub proximal: P,
    /// λ = 1/L, L the Lipschitz constant of ∇f.
    pub step: f64,
}

/// The minimiser of f + g reached from `start`, and the report of how.
///
/// The fast gradient method of eq. 3.27 \[Nes07\], begun anew (ω = 1) where a step would raise the objective, and that
/// step taken again without extrapolation \[OC15\]. Such a step lowers the objective at λ ≤ 1/L; where rounding alone
/// says otherwise the iterate stays. So the history never rises, the tail converges linearly, and where eq. 3.27
/// descends by itself the iterates are exactly its own.
///
/// Converged means ‖X − prox(X − λ ∇f(X))‖_F ≤ tolerance · max(1, ‖X‖_F) at the X returned. It is certified by the
/// length of the last step from the extrapolated point, ‖T(Y) − Y‖ ≥ ‖T(T(Y)) − T(Y)‖, the step T being nonexpansive.
///
/// # Errors
/// [`Cancelled`] by the watcher, and whatever the functions return.
pub fn minimise<E: From<Cancelled>, O, G, P>(
    function: &Composite<O, G, P>,
    start: Mat<f64>,
    stopping: Stopping,
    watch: &dyn Watch,
) -> Result<(Mat<f64>, Report), E>
where
    O: Fn(MatRef<'_, f64>) -> Result<f64, E>,
    G: Fn(MatRef<'_, f64>) -> Mat<f64>,
    P: Fn(MatRef<'_, f64>) -> Result<Mat<f64>, E>,
{
    let step = |y: &Mat<f64>| -> Result<(Mat<f64>, f64), E> {
        let x = (function.proximal)((y - function.step * (function.gradient)(y.as_ref())).as_ref())?;
        let value = (function.objective)(x.as_ref())?;
        Ok((x, value))
    };
    let mut value = (function.objective)(start.as_ref())?;
    let mut history = vec![value];
    let (mut x, mut x_before) = (start.clone(), start);
    let mut omega = 1.0;
    let mut stopped = Stopped::MaxIterations;
    for iteration in 0..stopping.max_iterations {
        watch.proceed(iteration as f64 / stopping.max_iterations as f64)?;
        // Extrapolate along the last step, and step from there.
        let mut momentum = Momentum::after(omega);
        let mut y = &x + momentum.factor * (&x - &x_before);
        let (mut next, mut next_value) = step(&y)?;
        if next_value > value && momentum.factor > 0.0 {
            // Begin anew: step from the iterate itself.
            momentum = Momentum::after(1.0);
            y = x.clone();
            (next, next_value) = step(&y)?;
        }
        omega = momentum.omega;
        let residual = (&next - &y).norm_l2();
        x_before = x.clone();
        if next_value <= value {
            (x, value) = (next, next_value);
        }
        history.push(value);
        if stopping.reached(residual, x.norm_l2()) {
            stopped = Stopped::Converged;
            break;
        }
    }
    Ok((x, Report { iterations: history.len() - 1, history, stopped }))
}

/// The sequence ω of eq. 3.27 and the extrapolation it tells.
struct Momentum {
    omega: f64,
    factor: f64,
}

impl Momentum {
    fn after(omega: f64) -> Self {
        let next = 0.5 * (1.0 + (1.0 + 4.0 * omega * omega).sqrt());
        Momentum { omega: next, factor: (omega - 1.0) / next }
    }
}
