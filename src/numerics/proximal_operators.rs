//! Proximal operators: prox_g(V) = arg min_X g(X) + ½ ‖X − V‖²_F, in closed form.

use faer::{Mat, MatRef};

use super::DecompositionError;

/// The minimiser of Σ tᵢⱼ |xᵢⱼ| + ½ ‖X − V‖²_F: every entry of V (l × k) moved towards zero by its own threshold of
/// `thresholds` (l × k, none negative), and not beyond. Eq. 3.33, the thresholds on C rather than on W ⊙ C.
pub fn soft_threshold(v: MatRef<'_, f64>, thresholds: MatRef<'_, f64>) -> Mat<f64> {
    Mat::from_fn(v.nrows(), v.ncols(), |i, j| {
        let v = v[(i, j)];
        (v.abs() - thresholds[(i, j)]).max(0.0).copysign(v)
    })
}

/// The minimiser of t ‖X‖_* + ½ ‖X − V‖²_F: V (l × k) with every singular value lowered by `threshold` = t ≥ 0, and not
/// below zero \[CCS10\]. With it ‖X‖_*, the sum of the lowered values, which another decomposition would cost as much.
///
/// # Errors
/// [`DecompositionError`] if the singular values do not converge.
pub fn singular_value_threshold(v: MatRef<'_, f64>, threshold: f64) -> Result<(Mat<f64>, f64), DecompositionError> {
    let (rows, columns) = v.shape();
    let svd = v.thin_svd().map_err(|_| DecompositionError::SingularValues { rows, columns })?;
    let mut left = svd.U().to_owned();
    let mut norm = 0.0;
    for (column, singular_value) in left.col_iter_mut().zip(svd.S().column_vector().iter()) {
        let shrunk = (singular_value - threshold).max(0.0);
        norm += shrunk;
        column.iter_mut().for_each(|u| *u *= shrunk);
    }
    Ok((left * svd.V().transpose(), norm))
}

/// ‖X‖_*, the sum of the singular values.
///
/// # Errors
/// [`DecompositionError`] if they do not converge.
pub fn nuclear_norm(x: MatRef<'_, f64>) -> Result<f64, DecompositionError> {
    let (rows, columns) = x.shape();
    let singular_values = x.singular_values().map_err(|_| DecompositionError::SingularValues { rows, columns })?;
    Ok(singular_values.iter().sum())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numerics::random;

    /// The minimiser of a convex function on [−10, 10] by thirds of the interval.
    fn naive_minimiser(f: impl Fn(f64) -> f64) -> f64 {
        let (mut low, mut high) = (-10.0, 10.0);
        for _ in 0..100 {
            let third = (high - low) / 3.0;
            if f(low + third) < f(high - third) {
                high -= third;
            } else {
                low += third;
            }
        }
        0.5 * (low + high)
    }

    #[test]
    fn soft_threshold_is_the_minimiser_entry_by_entry() {
        let v = random::normal(6, 4, 1);
        let thresholds = Mat::from_fn(6, 4, |i, j| 0.1 * (i * j) as f64);
        let x = soft_threshold(v.as_ref(), thresholds.as_ref());
        for j in 0..4 {
            for i in 0..6 {
                let naive = naive_minimiser(|x| thresholds[(i, j)] * x.abs() + 0.5 * (x - v[(i, j)]).powi(2));
                assert!((x[(i, j)] - naive).abs() < 1e-6);
            }
        }
    }

    #[test]
    fn no_threshold_is_no_shrinkage() {
        let v = random::normal(3, 5, 2);
        assert_eq!(soft_threshold(v.as_ref(), Mat::zeros(3, 5).as_ref()), v);
        assert!((singular_value_threshold(v.as_ref(), 0.0).unwrap().0 - &v).norm_max() < 1e-14);
    }

    #[test]
    fn singular_value_threshold_satisfies_its_optimality_condition() {
        // V − X is t times a subgradient of the nuclear norm at X: its singular values are at most t, and its inner
        // product with X is t ‖X‖_*.
        let t = 1.5;
        for (rows, columns) in [(7, 4), (4, 7), (5, 5)] {
            let v = random::normal(rows, columns, 3);
            let (x, norm) = singular_value_threshold(v.as_ref(), t).unwrap();
            assert!((norm - nuclear_norm(x.as_ref()).unwrap()).abs() < 1e-12 * norm);
            let rest = &v - &x;
            assert!(rest.singular_values().unwrap()[0] <= t + 1e-12);
            let inner = crate::numerics::inner_product(rest.as_ref(), x.as_ref());
            assert!((inner - t * norm).abs() < 1e-10);
            assert!(x.norm_l2() > 0.0);
        }
    }

    #[test]
    fn a_large_threshold_leaves_nothing() {
        let v = random::normal(4, 4, 4);
        let (x, norm) = singular_value_threshold(v.as_ref(), 1e3).unwrap();
        assert_eq!((x.norm_l2(), norm), (0.0, 0.0));
    }
}
