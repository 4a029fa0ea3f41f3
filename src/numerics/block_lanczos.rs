//! The smallest eigenpairs of S φ = λ A φ, S sparse symmetric positive semidefinite, A diagonal positive.
//!
//! Shift-invert block Lanczos: the largest eigenpairs (θ, y) of D (S + σA)⁻¹ D with D = A^½ give λ = 1/θ − σ and
//! φ = D⁻¹ y. A block of several vectors finds repeated eigenvalues, full re-orthogonalisation keeps them from
//! appearing twice, and the inertia of S − μA proves that none below μ is missing [GLS94].

use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatMut, MatRef, Par, Side};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use sprs::CsMat;

use super::cholesky::{FactorisationError, SparseCholesky, negative_eigenvalues};
use super::{Cancelled, Watch};

/// Distance of the shift below the spectrum, in units of the eigenvalues: the problem is expected to be scaled so that
/// its first positive eigenvalues are of the order of 1 to 100 (unit area).
const SHIFT: f64 = 0.1;
/// Block sizes of the attempts: a wider block where the inertia shows that a pair is missing.
const BLOCKS: [usize; 3] = [4, 8, 16];
const SEED: u64 = 0x5ee_d1a9;
/// Pairs sought beyond the k that are wanted, to find a gap in the spectrum for the inertia count.
const GUARD: usize = 4;
/// Residual, relative to θ, at which a wanted pair has converged; one further inverse iteration follows.
const TOLERANCE: f64 = 1e-10;
/// The same for a guarding pair.
const GUARD_TOLERANCE: f64 = 1e-6;
/// Relative distance of two eigenvalues that the inertia count can tell apart.
const GAP: f64 = 1e-7;

/// The first k eigenpairs.
#[derive(Clone, Debug)]
pub struct Eigenpairs {
    /// k values, ascending.
    pub values: Vec<f64>,
    /// n × k, orthonormal with respect to A.
    pub vectors: Mat<f64>,
}

/// Why eigenpairs could not be found.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum EigenError {
    #[error("{wanted} eigenpairs of a problem in {unknowns} unknowns")]
    TooMany { wanted: usize, unknowns: usize },
    #[error(transparent)]
    Factorisation(#[from] FactorisationError),
    #[error("the eigenvalues did not converge")]
    NotConverged,
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

/// The k smallest eigenpairs of S φ = λ A φ: n × n stiffness S with both triangles stored, n masses > 0 on the diagonal
/// of A. Small problems are solved densely.
///
/// # Errors
/// [`EigenError`].
pub fn smallest(stiffness: &CsMat<f64>, mass: &[f64], k: usize, watch: &dyn Watch) -> Result<Eigenpairs, EigenError> {
    let n = mass.len();
    if k > n {
        return Err(EigenError::TooMany { wanted: k, unknowns: n });
    }
    if n <= 400 || n < 3 * (k + GUARD + BLOCKS[0]) {
        watch.proceed(0.0)?;
        return dense(stiffness, mass, k);
    }
    let operator = ShiftInvert::new(stiffness, mass)?;
    for (attempt, block) in BLOCKS.into_iter().enumerate() {
        let Some(ritz) = converged_pairs(&operator, k, block, attempt as u64, watch)? else { continue };
        watch.proceed(0.95)?;
        if complete(stiffness, mass, k, &ritz.values)? {
            return rayleigh_ritz(&operator, stiffness, ritz.vectors, k);
        }
    }
    Err(EigenError::NotConverged)
}

/// All n eigenpairs of D⁻¹ S D⁻¹, of which the first k are kept.
fn dense(stiffness: &CsMat<f64>, mass: &[f64], k: usize) -> Result<Eigenpairs, EigenError> {
    let n = mass.len();
    let mut symmetric = Mat::<f64>::zeros(n, n);
    for (value, (i, j)) in stiffness.iter() {
        symmetric[(i, j)] = value / (mass[i] * mass[j]).sqrt();
    }
    let eigen = symmetric.self_adjoint_eigen(Side::Lower).map_err(|_| EigenError::NotConverged)?;
    let vectors = Mat::from_fn(n, k, |i, j| eigen.U()[(i, j)] / mass[i].sqrt());
    Ok(Eigenpairs { values: eigen.S().column_vector().iter().take(k).copied().collect(), vectors })
}

/// D (S + σA)⁻¹ D.
struct ShiftInvert {
    factor: SparseCholesky,
    /// Diagonal of D.
    root_mass: Vec<f64>,
}

impl ShiftInvert {
    fn new(stiffness: &CsMat<f64>, mass: &[f64]) -> Result<ShiftInvert, EigenError> {
        let factor = SparseCholesky::new(&shifted(stiffness, mass, SHIFT))?;
        Ok(ShiftInvert { factor, root_mass: mass.iter().map(|a| a.sqrt()).collect() })
    }

    fn apply(&self, block: MatRef<'_, f64>) -> Result<Mat<f64>, EigenError> {
        let mut x = Mat::from_fn(block.nrows(), block.ncols(), |i, j| self.root_mass[i] * block[(i, j)]);
        self.factor.solve(x.as_mut())?;
        for j in 0..x.ncols() {
            for (value, d) in x.col_as_slice_mut(j).iter_mut().zip(&self.root_mass) {
                *value *= d;
            }
        }
        Ok(x)
    }
}

/// S + shift · A.
fn shifted(stiffness: &CsMat<f64>, mass: &[f64], shift: f64) -> CsMat<f64> {
    let mut matrix = stiffness.clone();
    for (i, mut row) in matrix.outer_iterator_mut().enumerate() {
        if let Some(diagonal) = row.get_mut(i) {
            *diagonal += shift * mass[i];
        }
    }
    matrix
}

/// Ritz values λ, ascending, and orthonormal Ritz vectors y of the k wanted and the guarding pairs.
struct RitzPairs {
    values: Vec<f64>,
    vectors: Mat<f64>,
}

/// The pairs once all have converged; none where the space has grown past its bound.
fn converged_pairs(
    operator: &ShiftInvert,
    k: usize,
    block: usize,
    attempt: u64,
    watch: &dyn Watch,
) -> Result<Option<RitzPairs>, EigenError> {
    let n = operator.root_mass.len();
    let wanted = (k + GUARD).min(n);
    let most = n.min(6 * wanted + 200);
    let mut space = KrylovSpace::new(n, block, SEED + attempt);
    let mut next_check = (wanted + wanted / 2).max(24).min(most);
    loop {
        space.expand(operator)?;
        watch.proceed(space.progress(wanted))?;
        if space.applied < next_check {
            continue;
        }
        watch.proceed(space.progress(wanted))?;
        if let Some(pairs) = space.ritz_pairs(k, wanted)? {
            return Ok(Some(pairs));
        }
        if space.applied + block > most {
            return Ok(None);
        }
        next_check = (space.applied + space.applied / 10).min(most - block);
    }
}

/// An orthonormal basis V of the block Krylov space and the operator projected to it.
struct KrylovSpace {
    rows: usize,
    block: usize,
    /// V by columns: those the operator has been applied to, then one block more.
    basis: Vec<f64>,
    applied: usize,
    /// Vᵀ Op V by columns of growing length: column j holds the rows up to its own block's last.
    projected: Vec<Vec<f64>>,
    /// b × b: what the last application left outside the space, in terms of the last block.
    coupling: Mat<f64>,
    random: ChaCha8Rng,
}

impl KrylovSpace {
    fn new(rows: usize, block: usize, seed: u64) -> KrylovSpace {
        let mut space = KrylovSpace {
            rows,
            block,
            basis: Vec::new(),
            applied: 0,
            projected: Vec::new(),
            coupling: Mat::zeros(block, block),
            random: ChaCha8Rng::seed_from_u64(seed),
        };
        space.append(Mat::zeros(rows, block));
        space
    }

    /// A guess: about 2.5 vectors are needed for a pair.
    fn progress(&self, wanted: usize) -> f64 {
        (self.applied as f64 / (2.5 * wanted as f64)).min(0.95)
    }

    fn width(&self) -> usize {
        self.basis.len() / self.rows
    }

    fn basis(&self, columns: std::ops::Range<usize>) -> MatRef<'_, f64> {
        let slice = &self.basis[columns.start * self.rows..columns.end * self.rows];
        MatRef::from_column_major_slice(slice, self.rows, columns.len())
    }

    /// Applies the operator to the last block and appends what is orthogonal to the space.
    fn expand(&mut self, operator: &ShiftInvert) -> Result<(), EigenError> {
        let width = self.width();
        let mut image = operator.apply(self.basis(self.applied..width))?;
        let coefficients = self.orthogonalise(0, image.as_mut());
        for j in 0..self.block {
            self.projected.push(coefficients.col_as_slice(j).to_vec());
        }
        self.applied = width;
        self.append(image);
        Ok(())
    }

    /// Takes U Uᵀ X from the block X, U the basis vectors from `first` on, twice for safety, and returns Uᵀ X.
    fn orthogonalise(&self, first: usize, mut block: MatMut<'_, f64>) -> Mat<f64> {
        let basis = self.basis(first..self.width());
        let mut total = Mat::zeros(basis.ncols(), block.ncols());
        for _ in 0..2 {
            let mut coefficients = Mat::zeros(basis.ncols(), block.ncols());
            matmul(coefficients.as_mut(), Accum::Replace, basis.transpose(), block.as_ref(), 1.0, Par::Seq);
            matmul(block.as_mut(), Accum::Add, basis, coefficients.as_ref(), -1.0, Par::Seq);
            total += coefficients;
        }
        total
    }

    /// Orthonormalises the columns of a block that is orthogonal to the space and appends them; the coupling keeps the
    /// triangular factor. A column that vanishes is replaced by a random one.
    fn append(&mut self, block: Mat<f64>) {
        let first = self.width();
        self.coupling = Mat::zeros(self.block, self.block);
        for j in 0..self.block {
            let mut column = block.subcols(j, 1).to_owned();
            let before = norm(column.col_as_slice(0));
            let coefficients = self.orthogonalise(first, column.as_mut());
            for i in 0..j {
                self.coupling[(i, j)] = coefficients[(i, 0)];
            }
            let mut length = norm(column.col_as_slice(0));
            if length > 1e-12 * before {
                self.coupling[(j, j)] = length;
            } else {
                column = Mat::from_fn(self.rows, 1, |_, _| self.random.random_range(-1.0..1.0));
            }
            if length < 1e-2 * before || self.coupling[(j, j)] == 0.0 {
                // Little of the column was left, and the rest of the space may show through.
                self.orthogonalise(0, column.as_mut());
                length = norm(column.col_as_slice(0));
            }
            self.basis.extend(column.col_as_slice(0).iter().map(|x| x / length));
        }
    }

    /// The first `wanted` pairs, where the first k and the guarding ones have converged.
    fn ritz_pairs(&self, k: usize, wanted: usize) -> Result<Option<RitzPairs>, EigenError> {
        let m = self.applied;
        if wanted > m {
            return Ok(None);
        }
        let projected = Mat::from_fn(m, m, |i, j| self.projected[i.max(j)].get(i.min(j)).copied().unwrap_or_default());
        let eigen = projected.self_adjoint_eigen(Side::Lower).map_err(|_| EigenError::NotConverged)?;
        let (theta, vectors) = (eigen.S().column_vector(), eigen.U());
        for i in 0..wanted {
            let column = m - 1 - i;
            let last = vectors.subrows(m - self.block, self.block).col(column);
            let residual = (&self.coupling * last).norm_l2();
            let tolerance = if i < k { TOLERANCE } else { GUARD_TOLERANCE };
            if residual > tolerance * theta[column] {
                return Ok(None);
            }
        }
        let coefficients = Mat::from_fn(m, wanted, |i, j| vectors[(i, m - 1 - j)]);
        let mut ritz = Mat::zeros(self.rows, wanted);
        matmul(ritz.as_mut(), Accum::Replace, self.basis(0..m), coefficients.as_ref(), 1.0, Par::Seq);
        let values = (0..wanted).map(|i| 1.0 / theta[m - 1 - i] - SHIFT).collect();
        Ok(Some(RitzPairs { values, vectors: ritz }))
    }
}

/// Whether all eigenvalues below a gap of the spectrum at the k-th have been found.
fn complete(stiffness: &CsMat<f64>, mass: &[f64], k: usize, values: &[f64]) -> Result<bool, EigenError> {
    let gap = |p: usize| values[p] - values[p - 1] > GAP * values[p].abs().max(1.0);
    // The first gap above the k-th value; where a cluster goes on past the guard, the last below it.
    let Some(count) = (k..values.len()).chain((1..k).rev()).find(|&p| gap(p)) else { return Ok(true) };
    let between = 0.5 * (values[count - 1] + values[count]);
    Ok(negative_eigenvalues(&shifted(stiffness, mass, -between))? == count)
}

/// One inverse iteration and the Rayleigh–Ritz projection of S itself: what the shift has blurred becomes sharp.
fn rayleigh_ritz(
    operator: &ShiftInvert,
    stiffness: &CsMat<f64>,
    ritz: Mat<f64>,
    k: usize,
) -> Result<Eigenpairs, EigenError> {
    let mut vectors = operator.apply(ritz.as_ref())?;
    for j in 0..vectors.ncols() {
        let column = vectors.col_as_slice_mut(j);
        let length = norm(column);
        for (value, d) in column.iter_mut().zip(&operator.root_mass) {
            *value /= length * d;
        }
    }
    let images = product(stiffness, vectors.as_ref());
    let weighted =
        Mat::from_fn(vectors.nrows(), vectors.ncols(), |i, j| operator.root_mass[i].powi(2) * vectors[(i, j)]);
    let gram = vectors.transpose() * &weighted;
    let energy = vectors.transpose() * &images;
    // L⁻¹ E L⁻ᵀ with gram = L Lᵀ.
    let cholesky = gram.llt(Side::Lower).map_err(|_| EigenError::NotConverged)?;
    let mut half = energy;
    faer::linalg::triangular_solve::solve_lower_triangular_in_place(cholesky.L(), half.as_mut(), Par::Seq);
    let mut reduced = half.transpose().to_owned();
    faer::linalg::triangular_solve::solve_lower_triangular_in_place(cholesky.L(), reduced.as_mut(), Par::Seq);
    let eigen = reduced.self_adjoint_eigen(Side::Lower).map_err(|_| EigenError::NotConverged)?;
    let mut coefficients = eigen.U().subcols(0, k).to_owned();
    faer::linalg::triangular_solve::solve_upper_triangular_in_place(
        cholesky.L().transpose(),
        coefficients.as_mut(),
        Par::Seq,
    );
    let mut sharp = Mat::zeros(vectors.nrows(), k);
    matmul(sharp.as_mut(), Accum::Replace, vectors.as_ref(), coefficients.as_ref(), 1.0, Par::Seq);
    Ok(Eigenpairs { values: eigen.S().column_vector().iter().take(k).copied().collect(), vectors: sharp })
}

/// S X for a sparse symmetric S and a dense n × b block X.
fn product(matrix: &CsMat<f64>, block: MatRef<'_, f64>) -> Mat<f64> {
    let mut result = Mat::zeros(block.nrows(), block.ncols());
    for j in 0..block.ncols() {
        let x = block.col(j);
        for (i, row) in matrix.outer_iterator().enumerate() {
            result[(i, j)] = row.iter().map(|(column, value)| value * x[column]).sum();
        }
    }
    result
}

fn norm(x: &[f64]) -> f64 {
    x.iter().map(|v| v * v).sum::<f64>().sqrt()
}
