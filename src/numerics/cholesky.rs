//! Sparse symmetric factorisation: faer's supernodal L Lᵀ and L D Lᵀ with the AMD ordering, run sequentially,
//! and triangular solves of our own.

use std::sync::Arc;

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::prelude::ReborrowMut;
use faer::sparse::linalg::SupernodalThreshold;
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, SymbolicCholesky, SymbolicCholeskyRaw, SymmetricOrdering, factorize_symbolic_cholesky,
    supernodal::{SupernodalLdltRef, SymbolicSupernodalCholesky},
};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};
use faer::{MatMut, Par, Side};
use sprs::CsMat;

use super::apart;
use super::tall_block::Row;
use super::triangular_solve::{self, Supernode};

/// Unknowns from which what is done with a matrix takes some milliseconds, and more.
const LARGE: usize = 5_000;

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

/// What depends on the pattern of a symmetric matrix alone: the ordering P and the pattern of L.
#[derive(Clone)]
pub struct Analysis(Arc<SymbolicCholesky<usize>>);

impl Analysis {
    /// The analysis of a symmetric matrix, both triangles stored.
    ///
    /// # Errors
    /// [`FactorisationError::OutOfMemory`].
    pub fn new(matrix: &CsMat<f64>) -> Result<Analysis, FactorisationError> {
        let indptr = matrix.proper_indptr();
        Ok(Analysis(Arc::new(symbolic(view(matrix, &indptr).symbolic())?)))
    }

    /// As [`Analysis::new`], `ask` saying whether to go on while it takes long.
    ///
    /// # Errors
    /// That of `ask`; within, as [`Analysis::new`].
    pub fn asking<E>(
        matrix: &CsMat<f64>,
        ask: impl Fn() -> Result<(), E>,
    ) -> Result<Result<Analysis, FactorisationError>, E> {
        if matrix.rows() < LARGE {
            return Ok(Analysis::new(matrix));
        }
        let matrix = matrix.clone();
        apart(move || Analysis::new(&matrix), ask)
    }

    /// P: the row of the matrix that comes i-th in the factor.
    pub fn order(&self) -> &[usize] {
        self.0.perm().map_or(&[], |perm| perm.arrays().0)
    }

    fn supernodes(&self) -> &SymbolicSupernodalCholesky<usize> {
        let SymbolicCholeskyRaw::Supernodal(supernodes) = self.0.raw() else {
            unreachable!("`symbolic` asks for supernodes whatever the matrix");
        };
        supernodes
    }
}

/// The factor of a symmetric positive definite matrix: factorised once, solved many times.
pub struct SparseCholesky {
    analysis: Analysis,
    /// The strips of all supernodes.
    values: Vec<f64>,
    /// Where those of each begin.
    starts: Vec<usize>,
}

impl SparseCholesky {
    /// L with L Lᵀ = P A Pᵀ for the symmetric n × n matrix A, both triangles stored.
    ///
    /// # Errors
    /// [`FactorisationError`] where a pivot is not positive or memory runs out.
    pub fn new(matrix: &CsMat<f64>) -> Result<SparseCholesky, FactorisationError> {
        SparseCholesky::analysed(Analysis::new(matrix)?, matrix)
    }

    /// As [`SparseCholesky::new`], for a matrix of the pattern that was analysed.
    ///
    /// # Errors
    /// As [`SparseCholesky::new`].
    pub fn analysed(analysis: Analysis, matrix: &CsMat<f64>) -> Result<SparseCholesky, FactorisationError> {
        let indptr = matrix.proper_indptr();
        let view = view(matrix, &indptr);
        let symbolic = &analysis.0;
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
        let starts = pack(analysis.supernodes(), &mut values);
        Ok(SparseCholesky { analysis, values, starts })
    }

    /// As [`SparseCholesky::analysed`], `ask` saying whether to go on while it takes long.
    ///
    /// # Errors
    /// That of `ask`; within, as [`SparseCholesky::new`].
    pub fn asking<E>(
        analysis: Analysis,
        matrix: CsMat<f64>,
        ask: impl Fn() -> Result<(), E>,
    ) -> Result<Result<SparseCholesky, FactorisationError>, E> {
        if matrix.rows() < LARGE {
            return Ok(SparseCholesky::analysed(analysis, &matrix));
        }
        apart(move || SparseCholesky::analysed(analysis, &matrix), ask)
    }

    /// Replaces P X by P A⁻¹ X for an n × 4 Q block X.
    pub fn solve_rows<const Q: usize>(&self, x: &mut [Row<Q>]) {
        assert_eq!(x.len(), self.analysis.0.nrows());
        triangular_solve::solve(self.supernodes(), x);
    }

    fn supernodes(&self) -> impl DoubleEndedIterator<Item = Supernode<'_>> + Clone {
        let symbolic = self.analysis.supernodes();
        let (first, end) = (symbolic.supernode_begin(), symbolic.supernode_end());
        let (row_idx, rows, count) = (symbolic.row_idx(), symbolic.col_ptr_for_row_idx(), symbolic.nnz_per_super());
        (0..symbolic.n_supernodes()).map(move |s| Supernode {
            first: first[s],
            width: end[s] - first[s],
            rows: &row_idx[rows[s]..][..count[s]],
            values: &self.values[self.starts[s]..self.starts[s + 1]],
        })
    }

    /// Replaces the n × b block X by A⁻¹ X.
    pub fn solve(&self, mut block: MatMut<'_, f64>) {
        for first in (0..block.ncols()).step_by(8) {
            let count = (block.ncols() - first).min(8);
            let mut columns = block.rb_mut().subcols_mut(first, count);
            let entry = |i: usize, j: usize| if j < count { columns[(i, j)] } else { 0.0 };
            let row = |&i: &usize| std::array::from_fn(|q| std::array::from_fn(|l| entry(i, 4 * q + l)));
            let mut x: Vec<Row<2>> = self.analysis.order().iter().map(row).collect();
            self.solve_rows(&mut x);
            for (&i, x) in self.analysis.order().iter().zip(&x) {
                for j in 0..count {
                    columns[(i, j)] = x[j / 4][j % 4];
                }
            }
        }
    }
}

/// The number of negative eigenvalues of a symmetric matrix of the pattern that was analysed, both triangles stored, by
/// Sylvester's law of inertia: the negative pivots of L D Lᵀ. It takes the memory of a factor that is needed no more.
///
/// # Errors
/// [`FactorisationError::Singular`] where a pivot vanishes.
pub fn negative_eigenvalues(factor: SparseCholesky, matrix: &CsMat<f64>) -> Result<usize, FactorisationError> {
    let SparseCholesky { analysis, mut values, .. } = factor;
    let indptr = matrix.proper_indptr();
    let view = view(matrix, &indptr);
    let symbolic = &analysis.0;
    values.resize(symbolic.len_val(), 0.0);
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
    let supernodes = analysis.supernodes();
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

/// Moves the columns of each supernode into strips, one supernode after the other without a gap, and returns where each
/// begins and the last ends.
fn pack(nodes: &SymbolicSupernodalCholesky<usize>, values: &mut Vec<f64>) -> Vec<usize> {
    let mut strips = Vec::new();
    let mut starts = vec![0];
    let mut end = 0;
    for s in 0..nodes.n_supernodes() {
        let columns = nodes.col_ptr_for_val()[s]..nodes.col_ptr_for_val()[s + 1];
        strips.clear();
        triangular_solve::strips(&values[columns], nodes.supernode_end()[s] - nodes.supernode_begin()[s], &mut strips);
        // No longer than the columns of this supernode and all before it.
        values[end..end + strips.len()].copy_from_slice(&strips);
        end += strips.len();
        starts.push(end);
    }
    values.truncate(end);
    starts
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
        factor.solve(x.as_mut());
        assert!((&x - &expected).norm_max() < 1e-10);
    }

    #[test]
    fn counts_eigenvalues_below_a_shift() {
        let n = 60;
        for below in [0, 1, 7, 31, 59] {
            let eigenvalue = |j: usize| 2.0 - 2.0 * (std::f64::consts::PI * j as f64 / n as f64).cos();
            let shift = if below == 0 { -0.5 } else { 0.5 * (eigenvalue(below - 1) + eigenvalue(below)) };
            let matrix = path(n, shift);
            let definite = SparseCholesky::new(&path(n, -0.1)).unwrap();
            assert_eq!(negative_eigenvalues(definite, &matrix), Ok(below));
        }
    }

    #[test]
    fn refuses_an_indefinite_matrix() {
        assert_eq!(SparseCholesky::new(&path(20, 1.0)).err(), Some(FactorisationError::NotPositiveDefinite));
    }
}
