//! Sparse symmetric factorisation: faer's supernodal L Lᵀ and L D Lᵀ with the AMD ordering, run sequentially.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::sparse::linalg::SupernodalThreshold;
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, LltRef, SymbolicCholesky, SymbolicCholeskyRaw, SymmetricOrdering,
    factorize_symbolic_cholesky, supernodal::SupernodalLdltRef,
};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};
use faer::{Conj, MatMut, Par, Side};
use sprs::CsMat;

/// Why a matrix could not be factorised.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum FactorisationError {
    #[error("the matrix is not numerically positive definite")]
    NotPositiveDefinite,
    #[error("the matrix is numerically singular")]
    Singular,
    #[error("the factor does not fit into memory")]
    OutOfMemory,
}

/// The factor of a symmetric positive definite matrix: factorised once, solved many times.
pub struct SparseCholesky {
    symbolic: SymbolicCholesky<usize>,
    values: Vec<f64>,
}

impl SparseCholesky {
    /// L with L Lᵀ = P A Pᵀ for the symmetric n × n matrix A, both triangles stored.
    ///
    /// # Errors
    /// [`FactorisationError`] where a pivot is not positive or memory runs out.
    pub fn new(matrix: &CsMat<f64>) -> Result<SparseCholesky, FactorisationError> {
        let indptr = matrix.proper_indptr();
        let view = view(matrix, &indptr);
        let symbolic = symbolic(view.symbolic())?;
        let mut values = zeros(symbolic.len_val())?;
        let scratch = symbolic.factorize_numeric_llt_scratch::<f64>(Par::Seq, Default::default());
        let mut memory = MemBuffer::try_new(scratch).map_err(|_| FactorisationError::OutOfMemory)?;
        symbolic
            .factorize_numeric_llt(
                &mut values,
                view,
                Side::Lower,
                Default::default(),
                Par::Seq,
                MemStack::new(&mut memory),
                Default::default(),
            )
            .map_err(|_| FactorisationError::NotPositiveDefinite)?;
        Ok(SparseCholesky { symbolic, values })
    }

    /// Replaces the n × b block X by A⁻¹ X.
    ///
    /// # Errors
    /// [`FactorisationError::OutOfMemory`].
    pub fn solve(&self, block: MatMut<'_, f64>) -> Result<(), FactorisationError> {
        let scratch = self.symbolic.solve_in_place_scratch::<f64>(block.ncols(), Par::Seq);
        let mut memory = MemBuffer::try_new(scratch).map_err(|_| FactorisationError::OutOfMemory)?;
        let factor = LltRef::new(&self.symbolic, &self.values);
        factor.solve_in_place_with_conj(Conj::No, block, Par::Seq, MemStack::new(&mut memory));
        Ok(())
    }
}

/// The number of negative eigenvalues of a symmetric matrix, both triangles stored, by Sylvester's law of inertia: the
/// negative pivots of L D Lᵀ.
///
/// # Errors
/// [`FactorisationError::Singular`] where a pivot vanishes.
pub fn negative_eigenvalues(matrix: &CsMat<f64>) -> Result<usize, FactorisationError> {
    let indptr = matrix.proper_indptr();
    let view = view(matrix, &indptr);
    let symbolic = symbolic(view.symbolic())?;
    let mut values = zeros(symbolic.len_val())?;
    let scratch = symbolic.factorize_numeric_ldlt_scratch::<f64>(Par::Seq, Default::default());
    let mut memory = MemBuffer::try_new(scratch).map_err(|_| FactorisationError::OutOfMemory)?;
    symbolic
        .factorize_numeric_ldlt(
            &mut values,
            view,
            Side::Lower,
            Default::default(),
            Par::Seq,
            MemStack::new(&mut memory),
            Default::default(),
        )
        .map_err(|_| FactorisationError::Singular)?;
    let SymbolicCholeskyRaw::Supernodal(supernodes) = symbolic.raw() else {
        unreachable!("`symbolic` asks for supernodes whatever the matrix");
    };
    let factor = SupernodalLdltRef::new(supernodes, &values);
    let pivots = (0..supernodes.n_supernodes()).flat_map(|s| {
        let block = factor.supernode(s).val();
        (0..block.ncols()).map(move |i| block[(i, i)])
    });
    let mut negative = 0;
    for pivot in pivots {
        match pivot.partial_cmp(&0.0) {
            Some(std::cmp::Ordering::Less) => negative += 1,
            Some(std::cmp::Ordering::Greater) => {}
            _ => return Err(FactorisationError::Singular),
        }
    }
    Ok(negative)
}

/// Room for a factor, asked for rather than taken: it is the largest single piece of memory of all.
fn zeros(len: usize) -> Result<Vec<f64>, FactorisationError> {
    let mut values = Vec::new();
    values.try_reserve_exact(len).map_err(|_| FactorisationError::OutOfMemory)?;
    values.resize(len, 0.0);
    Ok(values)
}

/// A symmetric matrix is its own transpose: rows stored one after the other serve as columns.
fn view<'a>(matrix: &'a CsMat<f64>, indptr: &'a [usize]) -> SparseColMatRef<'a, usize, f64> {
    let n = matrix.rows();
    SparseColMatRef::new(SymbolicSparseColMatRef::new_checked(n, n, indptr, None, matrix.indices()), matrix.data())
}

fn symbolic(pattern: SymbolicSparseColMatRef<'_, usize>) -> Result<SymbolicCholesky<usize>, FactorisationError> {
    let params = CholeskySymbolicParams {
        supernodal_flop_ratio_threshold: SupernodalThreshold::FORCE_SUPERNODAL,
        ..Default::default()
    };
    factorize_symbolic_cholesky(pattern, Side::Lower, SymmetricOrdering::Amd, params)
        .map_err(|_| FactorisationError::OutOfMemory)
}

#[cfg(test)]
mod tests {
    use faer::Mat;
    use sprs::TriMat;

    use super::*;

    /// The path graph's Laplacian, n × n, minus `shift` on the diagonal: eigenvalues 2 − 2 cos(π j / n) − shift.
    fn path(n: usize, shift: f64) -> CsMat<f64> {
        let mut triplets = TriMat::new((n, n));
        for i in 0..n {
            let degree = if i == 0 || i == n - 1 { 1.0 } else { 2.0 };
            triplets.add_triplet(i, i, degree - shift);
            if i + 1 < n {
                triplets.add_triplet(i, i + 1, -1.0);
                triplets.add_triplet(i + 1, i, -1.0);
            }
        }
        triplets.to_csc()
    }

    #[test]
    fn solves_what_it_factorised() {
        let matrix = path(200, -0.1);
        let factor = SparseCholesky::new(&matrix).unwrap();
        let expected = Mat::from_fn(200, 3, |i, j| ((i * (j + 1)) as f64).sin());
        let mut x = Mat::<f64>::zeros(200, 3);
        for (value, (row, column)) in matrix.iter() {
            for j in 0..3 {
                x[(row, j)] += value * expected[(column, j)];
            }
        }
        factor.solve(x.as_mut()).unwrap();
        assert!((&x - &expected).norm_max() < 1e-10);
    }

    #[test]
    fn counts_eigenvalues_below_a_shift() {
        let n = 60;
        for below in [0, 1, 7, 31, 59] {
            let eigenvalue = |j: usize| 2.0 - 2.0 * (std::f64::consts::PI * j as f64 / n as f64).cos();
            let shift = if below == 0 { -0.5 } else { 0.5 * (eigenvalue(below - 1) + eigenvalue(below)) };
            assert_eq!(negative_eigenvalues(&path(n, shift)), Ok(below));
        }
    }

    #[test]
    fn refuses_an_indefinite_matrix() {
        assert_eq!(SparseCholesky::new(&path(20, 1.0)).err(), Some(FactorisationError::NotPositiveDefinite));
    }
}
