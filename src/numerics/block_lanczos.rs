//! The smallest eigenpairs of S φ = λ A φ, S sparse symmetric positive semidefinite, A diagonal positive.
//!
//! With D = A^½ they are those of H = D⁻¹ S D⁻¹, φ = D⁻¹ y. Shift-invert block Lanczos: the largest eigenpairs (θ, y) of
//! (H + σI)⁻¹ give λ = 1/θ − σ. A block of several vectors finds repeated eigenvalues, re-orthogonalisation keeps them
//! from appearing twice, and the inertia of H − μI proves that none below μ is missing [GLS94].

use faer::{Mat, Side};
use sprs::CsMat;

use super::cholesky::{Analysis, FactorisationError, SparseCholesky, negative_eigenvalues};
use super::krylov_space::{Block, KrylovSpace, RitzPairs};
use super::tall_block::{Row, column_products, sparse_product};
use super::{Cancelled, Share, Watch, apart};

/// The shift σ below the spectrum, for each pair sought. The problem is expected to be scaled to unit area, where λ_k is
/// about 4π k (Weyl): σ costs little convergence near λ_k and keeps θ_1 / θ_k, and so the growth of rounding, small.
const SHIFT: f64 = 1.0;
/// Up to so many pairs are sought by blocks of 4, which need fewer vectors; more by blocks of 8, which pass over the
/// factor less often.
const NARROW: usize = 32;
const SEED: u64 = 0x5ee_d1a9;
/// Pairs sought beyond the k that are wanted, to find a gap in the spectrum for the inertia count.
const GUARD: usize = 4;
/// Residual, relative to θ, at which a wanted pair has converged: by the inverse iteration that the coefficients of a
/// Ritz vector hold, that of H relative to λ + σ.
const TOLERANCE: f64 = 4e-9;
/// The same for a guarding pair where the spectrum has no clear gap.
const GUARD_TOLERANCE: f64 = 1e-6;
/// Residual of a pair of H, relative to λ or to 1, above which it goes through an inverse iteration more.
const SHARP: f64 = 6e-9;
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
    if k == 0 {
        return Ok(Eigenpairs { values: Vec::new(), vectors: Mat::zeros(n, 0) });
    }
    let problem = Problem::new(stiffness, mass);
    watch.proceed(0.0)?;
    if n <= 200 || n < 3 * (k + GUARD + 8) {
        return problem.dense(k, watch);
    }
    let analysis = Analysis::asking(&problem.matrix, || watch.proceed(0.0))??;
    // A wider block, from another start, where the inertia shows that a pair is missing.
    let narrow = if k <= NARROW { problem.by_blocks::<1>(&analysis, k, watch)? } else { None };
    if let Some(pairs) = narrow {
        return Ok(pairs);
    }
    if let Some(pairs) = problem.by_blocks::<2>(&analysis, k, watch)? {
        return Ok(pairs);
    }
    problem.by_blocks::<4>(&analysis, k, watch)?.ok_or(EigenError::NotConverged)
}

/// H and what leads from its eigenvectors to those of S.
struct Problem {
    /// H.
    matrix: CsMat<f64>,
    /// Diagonal of D.
    root_mass: Vec<f64>,
}

impl Problem {
    fn new(stiffness: &CsMat<f64>, mass: &[f64]) -> Problem {
        let root_mass: Vec<f64> = mass.iter().map(|a| a.sqrt()).collect();
        let mut matrix = stiffness.clone();
        for (i, mut row) in matrix.outer_iterator_mut().enumerate() {
            row.iter_mut().for_each(|(j, value)| *value /= root_mass[i] * root_mass[j]);
        }
        Problem { matrix, root_mass }
    }

    /// All n eigenpairs, of which the first k are kept.
    fn dense(&self, k: usize, watch: &dyn Watch) -> Result<Eigenpairs, EigenError> {
        let n = self.root_mass.len();
        let mut matrix = Mat::<f64>::zeros(n, n);
        for (value, (i, j)) in self.matrix.iter() {
            matrix[(i, j)] = *value;
        }
        let eigen = apart(move || matrix.self_adjoint_eigen(Side::Lower), || watch.proceed(0.0))?;
        let eigen = eigen.map_err(|_| EigenError::NotConverged)?;
        let vectors = Mat::from_fn(n, k, |i, j| eigen.U()[(i, j)] / self.root_mass[i]);
        Ok(Eigenpairs { values: eigen.S().column_vector().iter().take(k).copied().collect(), vectors })
    }

    /// By blocks of 4 Q vectors; none where the space has grown past its bound or a pair is missing.
    fn by_blocks<const Q: usize>(
        &self,
        analysis: &Analysis,
        k: usize,
        watch: &dyn Watch,
    ) -> Result<Option<Eigenpairs>, EigenError> {
        let shift = SHIFT * k as f64;
        let shifted = plus_identity(&self.matrix, shift);
        let factor = SparseCholesky::asking(analysis.clone(), shifted, || watch.proceed(0.0))??;
        let inverse = |x: &[Row<Q>]| {
            let mut x = x.to_vec();
            factor.solve_rows(&mut x);
            x
        };
        let Some((space, ritz)) = converged(self.root_mass.len(), inverse, k, watch)? else { return Ok(None) };
        let mut pairs = Eigenpairs { values: Vec::new(), vectors: Mat::zeros(self.root_mass.len(), k) };
        let (sharpening, counting) = (Share::between(watch, 0.9, 0.95), Share::between(watch, 0.95, 1.0));
        for y in space.combinations(ritz.coefficients.subcols(0, k), &sharpening)? {
            self.append(&mut pairs, y, inverse, analysis.order(), &sharpening)?;
        }
        drop(space);
        let values: Vec<f64> = ritz.values.iter().map(|theta| 1.0 / theta - shift).collect();
        let count = gap_beside(k, &values, separation(k, &ritz));
        let between = count.map(|p| 0.5 * (values[p - 1] + values[p]));
        let below = match between {
            Some(mu) => {
                let shifted = plus_identity(&self.matrix, -mu);
                Some(apart(move || negative_eigenvalues(factor, &shifted), || counting.proceed(0.0))??)
            }
            None => None,
        };
        Ok((below == count).then_some(pairs))
    }

    /// Appends the eigenpairs of a block of Ritz vectors y (rows in the order of the factor), Rayleigh quotients for
    /// values, after another inverse iteration or two where the residuals are not small yet.
    fn append<const Q: usize>(
        &self,
        pairs: &mut Eigenpairs,
        mut y: Block<Q>,
        inverse: impl Fn(&[Row<Q>]) -> Block<Q>,
        order: &[usize],
        watch: &dyn Watch,
    ) -> Result<(), Cancelled> {
        let done = pairs.values.len();
        let count = (4 * Q).min(pairs.vectors.ncols() - done);
        watch.proceed(done as f64 / pairs.vectors.ncols() as f64)?;
        let mut quotients = self.rayleigh_quotients(&y, order);
        for _ in 0..2 {
            watch.proceed(done as f64 / pairs.vectors.ncols() as f64)?;
            if (0..count).all(|j| quotients.residuals[j] <= SHARP * quotients.values[j].max(1.0)) {
                break;
            }
            y = inverse(&y);
            quotients = self.rayleigh_quotients(&y, order);
        }
        for j in 0..count {
            let target = pairs.vectors.col_as_slice_mut(done + j);
            for ((target, y), d) in target.iter_mut().zip(&quotients.vectors).zip(&self.root_mass) {
                *target = y[j / 4][j % 4] / (d * quotients.lengths[j]);
            }
        }
        pairs.values.extend(&quotients.values[..count]);
        Ok(())
    }

    fn rayleigh_quotients<const Q: usize>(&self, y: &[Row<Q>], order: &[usize]) -> RayleighQuotients<Q> {
        let mut vectors = vec![[[0.0; 4]; Q]; y.len()];
        for (&v, row) in order.iter().zip(y) {
            vectors[v] = *row;
        }
        let mut images = sparse_product(&self.matrix, &vectors);
        let squares = column_products(&vectors, &vectors);
        let energies = column_products(&vectors, &images);
        let values: Vec<f64> = energies.iter().zip(&squares).map(|(energy, square)| energy / square).collect();
        for (image, y) in images.iter_mut().zip(&vectors) {
            let (image, y) = (image.as_flattened_mut(), y.as_flattened());
            for j in 0..4 * Q {
                image[j] -= values[j] * y[j];
            }
        }
        let squared_residuals = column_products(&images, &images);
        RayleighQuotients {
            residuals: squared_residuals
                .iter()
                .zip(&squares)
                .map(|(residual, square)| (residual / square).sqrt())
                .collect(),
            lengths: squares.iter().map(|square| square.sqrt()).collect(),
            values,
            vectors,
        }
    }
}

/// λ = yᵀ H y / yᵀ y for the columns of a block, whose rows are in the order of H.
struct RayleighQuotients<const Q: usize> {
    values: Vec<f64>,
    /// ‖H y − λ y‖ / ‖y‖.
    residuals: Vec<f64>,
    /// ‖y‖.
    lengths: Vec<f64>,
    vectors: Block<Q>,
}

/// H + shift · I.
fn plus_identity(matrix: &CsMat<f64>, shift: f64) -> CsMat<f64> {
    let mut matrix = matrix.clone();
    for (i, mut row) in matrix.outer_iterator_mut().enumerate() {
        if let Some(diagonal) = row.get_mut(i) {
            *diagonal += shift;
        }
    }
    matrix
}

/// The space once the k wanted pairs have converged in it, and they and the guarding ones; none where it has grown past
/// its bound. Takes (H + σI)⁻¹, n × n.
fn converged<const Q: usize>(
    n: usize,
    inverse: impl Fn(&[Row<Q>]) -> Block<Q>,
    k: usize,
    watch: &dyn Watch,
) -> Result<Option<(KrylovSpace<Q>, RitzPairs)>, EigenError> {
    let wanted = k + GUARD;
    // The basis is a block ahead of the dimension and must have room for another.
    let last_check = n.min(6 * wanted + 200).saturating_sub(8 * Q);
    let mut space = KrylovSpace::new(n, SEED + Q as u64, watch)?;
    // As many vectors as are seen to be needed, or a little fewer.
    let mut schedule = Schedule { next: (5 * wanted / 2 + 36 * Q).min(last_check), last: None };
    loop {
        let reached = |space: &KrylovSpace<Q>| (space.dimension() as f64 / (4.0 * wanted as f64)).min(0.9);
        let share = Share::between(watch, reached(&space), reached(&space));
        share.proceed(0.0)?;
        space.expand(&inverse, &share)?;
        if space.dimension() < schedule.next {
            continue;
        }
        let ritz = space.ritz_pairs(wanted, &share)?.map_err(|_| EigenError::NotConverged)?;
        let within = |i: usize, tolerance: f64| ritz.residuals[i] <= tolerance * ritz.values[i];
        let guarded = separation(k, &ritz).is_some() || (k..wanted).all(|i| within(i, GUARD_TOLERANCE));
        if guarded && (0..k).all(|i| within(i, TOLERANCE)) {
            return Ok(Some((space, ritz)));
        }
        if space.dimension() >= last_check {
            return Ok(None);
        }
        let worst = (0..k).map(|i| ritz.residuals[i] / ritz.values[i]).fold(0.0, f64::max);
        schedule.put_off(space.dimension(), worst);
        schedule.next = schedule.next.min(last_check);
    }
}

/// When the Ritz pairs are looked at: residuals fall geometrically, which tells when they will be small enough.
struct Schedule {
    next: usize,
    /// Dimension and logarithm of the worst residual at the last look.
    last: Option<(usize, f64)>,
}

impl Schedule {
    fn put_off(&mut self, dimension: usize, worst: f64) {
        let present = worst.max(f64::MIN_POSITIVE).ln();
        let patience = dimension as f64 / 20.0;
        let needed = self.last.map_or(patience, |(before, last)| {
            (present - TOLERANCE.ln()) * (dimension - before) as f64 / (last - present).max(0.0)
        });
        self.last = Some((dimension, present));
        self.next = dimension + needed.clamp(0.0, patience) as usize;
    }
}

/// The least p ≥ k such that the error bars of the first p values and of the next do not touch.
fn separation(k: usize, ritz: &RitzPairs) -> Option<usize> {
    (k..ritz.values.len()).find(|&p| {
        let bar = ritz.residuals[..=p].iter().copied().fold(0.0, f64::max);
        ritz.values[p - 1] - ritz.values[p] > 4.0 * bar
    })
}

/// A p such that the first p values end at a gap: the first from the k-th on; where a cluster goes on past the guard, the
/// last below.
fn gap_beside(k: usize, values: &[f64], separation: Option<usize>) -> Option<usize> {
    let gap = |&p: &usize| values[p] - values[p - 1] > GAP * values[p].abs().max(1.0);
    separation.into_iter().chain(k..values.len()).chain((1..k).rev()).find(gap)
}
