//! Least squares by the normal equations.

use faer::{Mat, MatRef, Side};

use super::DecompositionError;

/// The X (l × k) of least Frobenius norm among the minimisers of ‖X A − B‖_F, from `gram` = A Aᵀ (k × k) and `cross` =
/// B Aᵀ (l × k).
///
/// X = B Aᵀ (A Aᵀ)⁺, the pseudoinverse by the eigenvalues of A Aᵀ. Those up to k ε times the largest (ε = 2⁻⁵²) are
/// rounding and count as zero: a singular value of A below √(k ε), about 7e-8 at k = 20, of the largest is not seen.
///
/// # Errors
/// [`DecompositionError`] if the eigenvalues do not converge.
pub fn minimum_norm(gram: MatRef<'_, f64>, cross: MatRef<'_, f64>) -> Result<Mat<f64>, DecompositionError> {
    let size = gram.nrows();
    let eigen = gram.self_adjoint_eigen(Side::Lower).map_err(|_| DecompositionError::Eigenvalues { size })?;
    let eigenvalues = eigen.S().column_vector();
    let largest = eigenvalues.iter().copied().fold(0.0, f64::max);
    let cut_off = size as f64 * f64::EPSILON * largest;
    let mut coefficients = cross * eigen.U();
    for (column, &eigenvalue) in coefficients.col_iter_mut().zip(eigenvalues.iter()) {
        let inverse = if eigenvalue > cut_off { 1.0 / eigenvalue } else { 0.0 };
        column.iter_mut().for_each(|c| *c *= inverse);
    }
    Ok(coefficients * eigen.U().transpose())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numerics::random;

    fn from_matrices(a: &Mat<f64>, b: &Mat<f64>) -> Mat<f64> {
        minimum_norm((a * a.transpose()).as_ref(), (b * a.transpose()).as_ref()).unwrap()
    }

    #[test]
    fn a_consistent_system_is_solved() {
        let (x, a) = (random::normal(5, 4, 1), random::normal(4, 30, 2));
        assert!((from_matrices(&a, &(&x * &a)) - &x).norm_max() < 1e-10);
    }

    #[test]
    fn the_residual_is_orthogonal_to_the_rows_of_a() {
        let (a, b) = (random::ill_conditioned(6, 40, 1e3, 3), random::normal(4, 40, 4));
        let residual = from_matrices(&a, &b) * &a - &b;
        assert!((residual * a.transpose()).norm_max() < 1e-8);
    }

    #[test]
    fn a_rank_deficient_system_gets_the_solution_of_least_norm() {
        // A of rank 3 in 6 rows; the solution of least norm is B A⁺, here by the singular values of A itself.
        let a = random::normal(6, 3, 5) * random::normal(3, 25, 6);
        let b = random::normal(4, 25, 7);
        let svd = a.thin_svd().unwrap();
        let pseudoinverse = Mat::from_fn(25, 6, |i, j| {
            (0..3).map(|r| svd.V()[(i, r)] * svd.U()[(j, r)] / svd.S().column_vector()[r]).sum::<f64>()
        });
        assert!((from_matrices(&a, &b) - b * pseudoinverse).norm_max() < 1e-8);
    }

    #[test]
    fn nothing_is_known_from_zero_constraints() {
        let zero = minimum_norm(Mat::zeros(3, 3).as_ref(), Mat::zeros(2, 3).as_ref()).unwrap();
        assert_eq!(zero, Mat::<f64>::zeros(2, 3));
    }
}
