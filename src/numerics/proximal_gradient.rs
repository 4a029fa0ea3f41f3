//! The fast proximal gradient method.

use faer::{Mat, MatRef};

use super::{Cancelled, Report, Stopped, Stopping, Watch};

/// A convex function f + g of a matrix, f with a Lipschitz gradient and g with a proximal operator.
pub struct Composite<F, T, G, P> {
    /// f; a constant may be left out.
    pub smooth: F,
    /// g, asked at the start alone.
    pub term: T,
    /// ∇f.
    pub gradient: G,
    /// V ↦ the minimiser X of λ g(X) + ½ ‖X − V‖²_F with λ = `step`, and g(X), which often comes with it.
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
pub fn minimise<E: From<Cancelled>, F, T, G, P>(
    function: &Composite<F, T, G, P>,
    start: Mat<f64>,
    stopping: Stopping,
    watch: &dyn Watch,
) -> Result<(Mat<f64>, Report), E>
where
    F: Fn(MatRef<'_, f64>) -> f64,
    T: Fn(MatRef<'_, f64>) -> Result<f64, E>,
    G: Fn(MatRef<'_, f64>) -> Mat<f64>,
    P: Fn(MatRef<'_, f64>) -> Result<(Mat<f64>, f64), E>,
{
    let step = |y: &Mat<f64>| -> Result<(Mat<f64>, f64), E> {
        let (x, term) = (function.proximal)((y - function.step * (function.gradient)(y.as_ref())).as_ref())?;
        let value = (function.smooth)(x.as_ref()) + term;
        Ok((x, value))
    };
    let mut value = (function.smooth)(start.as_ref()) + (function.term)(start.as_ref())?;
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numerics::proximal_operators::soft_threshold;
    use crate::numerics::{Unwatched, inner_product, random};

    /// ‖X A − B‖²_F/2 + t ‖X‖₁ with A Aᵀ = `gram` and B Aᵀ = `cross`.
    struct Lasso {
        gram: Mat<f64>,
        cross: Mat<f64>,
        threshold: f64,
        step: f64,
    }

    impl Lasso {
        fn random(condition: f64) -> Self {
            let (a, b) = (random::ill_conditioned(6, 30, condition, 1), random::normal(4, 30, 2));
            let largest = a.singular_values().unwrap()[0];
            Lasso {
                gram: &a * a.transpose(),
                cross: b * a.transpose(),
                threshold: 0.5,
                step: 1.0 / (largest * largest),
            }
        }

        fn smooth(&self, x: MatRef<'_, f64>) -> f64 {
            inner_product((0.5 * (x * &self.gram) - &self.cross).as_ref(), x)
        }

        fn term(&self, x: MatRef<'_, f64>) -> f64 {
            let sum: f64 = x.col_iter().map(|column| column.iter().map(|x| x.abs()).sum::<f64>()).sum();
            self.threshold * sum
        }

        fn value(&self, x: MatRef<'_, f64>) -> f64 {
            self.smooth(x) + self.term(x)
        }

        fn gradient(&self, x: MatRef<'_, f64>) -> Mat<f64> {
            x * &self.gram - &self.cross
        }

        fn proximal(&self, v: MatRef<'_, f64>) -> Mat<f64> {
            let thresholds = Mat::full(v.nrows(), v.ncols(), self.step * self.threshold);
            soft_threshold(v, thresholds.as_ref())
        }

        fn minimise(&self, stopping: Stopping, watch: &dyn Watch) -> Result<(Mat<f64>, Report), Cancelled> {
            let function = Composite {
                smooth: |x: MatRef<'_, f64>| self.smooth(x),
                term: |x: MatRef<'_, f64>| Ok(self.term(x)),
                gradient: |x: MatRef<'_, f64>| self.gradient(x),
                proximal: |v: MatRef<'_, f64>| {
                    let x = self.proximal(v);
                    let term = self.term(x.as_ref());
                    Ok((x, term))
                },
                step: self.step,
            };
            minimise(&function, Mat::zeros(4, 6), stopping, watch)
        }
    }

    #[test]
    fn while_it_descends_the_iterates_are_those_of_equation_3_27() {
        let lasso = Lasso::random(1e4);
        let (mut x, mut x_before) = (Mat::zeros(4, 6), Mat::zeros(4, 6));
        let mut omega = 1f64;
        let mut history = vec![lasso.value(x.as_ref())];
        for iterations in 1..=15 {
            let omega_next = (1.0 + (1.0 + 4.0 * omega.powi(2)).sqrt()) / 2.0;
            let y = &x + (omega - 1.0) / omega_next * (&x - &x_before);
            x_before = x;
            x = lasso.proximal((&y - lasso.step * lasso.gradient(y.as_ref())).as_ref());
            omega = omega_next;
            history.push(lasso.value(x.as_ref()));
            let (found, report) =
                lasso.minimise(Stopping { max_iterations: iterations, tolerance: 0.0 }, &Unwatched).unwrap();
            assert_eq!(found, x);
            assert_eq!(report, Report { iterations, history: history.clone(), stopped: Stopped::MaxIterations });
        }
        assert!(history.is_sorted_by(|before, after| after < before), "this case has to descend by itself");
    }

    #[test]
    fn the_history_never_rises_and_the_residual_is_reached() {
        for condition in [1.0, 1e2, 1e4] {
            let lasso = Lasso::random(condition);
            let stopping = Stopping { max_iterations: 20_000, tolerance: 1e-9 };
            let (x, report) = lasso.minimise(stopping, &Unwatched).unwrap();
            assert_eq!(report.stopped, Stopped::Converged, "{condition}");
            assert!(report.history.is_sorted_by(|before, after| after <= before));
            let again = lasso.proximal((&x - lasso.step * lasso.gradient(x.as_ref())).as_ref());
            assert!((again - &x).norm_l2() <= 1e-9 * x.norm_l2().max(1.0));
        }
    }

    #[test]
    fn it_stops_when_nobody_waits() {
        struct Third;
        impl Watch for Third {
            fn proceed(&self, fraction: f64) -> Result<(), Cancelled> {
                if fraction < 1.0 / 3.0 { Ok(()) } else { Err(Cancelled) }
            }
        }
        let stopping = Stopping { max_iterations: 200, tolerance: 0.0 };
        assert_eq!(Lasso::random(1e2).minimise(stopping, &Third).unwrap_err(), Cancelled);
    }
}
