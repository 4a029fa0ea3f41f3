//! The block Krylov space of a symmetric operator: an orthonormal basis V and the operator projected to it, T = Vᵀ Op V.

use faer::linalg::triangular_solve::solve_upper_triangular_in_place;
use faer::{Mat, MatRef, Par, Side};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::tall_block::{Row, add_product, add_products, column_products, inner, multiply_right};
use super::{Cancelled, DecompositionError, Watch, apart};

/// A block of the basis, n × 4 Q.
pub type Block<const Q: usize> = Vec<Row<Q>>;

/// Ratio of the squared lengths of a column beside its predecessors and alone below which it counts as dependent.
const DEPENDENT: f64 = 1e-12;
/// The ratio below which the rest of the space may show through what is left, so that it is projected out once more.
const WEAK: f64 = 1e-4;
/// What is left of a column beside what the recurrence took below which it is mostly rounding, made orthogonal at once.
const VANISHED: f64 = 1e-4;
/// Passes over a block: one as a rule, two more for each time that columns had to be replaced.
const MOST_PASSES: usize = 10;
/// The departure from orthogonality that is let grow before the basis is mended; T keeps full accuracy up to √ε [Sim84].
const ORTHOGONALITY: f64 = 1e-9;
/// Departures that rounding makes at once.
const ROUNDING: f64 = 1e-15;

/// An orthonormal basis of span {X, Op X, Op² X, …}, X a random block, one block longer than the operator has been
/// applied to, and T, block tridiagonal by the three-term recurrence Op V_j = V_{j−1} B_jᵀ + V_j A_j + V_{j+1} B_{j+1}.
pub struct KrylovSpace<const Q: usize> {
    blocks: Vec<Block<Q>>,
    /// The A_j, 4 Q × 4 Q.
    diagonal: Vec<Mat<f64>>,
    /// The B_{j+1}, 4 Q × 4 Q, upper triangular.
    coupling: Vec<Mat<f64>>,
    random: ChaCha8Rng,
    mending: Mending,
}

/// When the basis is made orthogonal again: rounding along converged vectors grows by a factor with every block, so that
/// some blocks are trusted, then two on end made orthogonal to all [Sim84].
#[derive(Default)]
struct Mending {
    /// Blocks to trust now, and the next time.
    trust: [usize; 2],
    /// Blocks since the last mending.
    blocks: usize,
}

/// A Ritz pair's value and, as a column of coefficients in the basis, its vector.
pub struct RitzPairs {
    /// The largest first.
    pub values: Vec<f64>,
    /// Norms of Op y − θ y.
    pub residuals: Vec<f64>,
    /// Coefficients in the basis, its last block included, of Op y / θ: an inverse iteration that costs nothing, for
    /// the recurrence knows Op V [ER80].
    pub coefficients: Mat<f64>,
}

impl<const Q: usize> KrylovSpace<Q> {
    /// The space of a random block of n rows.
    ///
    /// # Errors
    /// [`Cancelled`] by the watcher.
    pub fn new(rows: usize, seed: u64, watch: &dyn Watch) -> Result<KrylovSpace<Q>, Cancelled> {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut start = vec![[[0.0; 4]; Q]; rows];
        start.as_flattened_mut().as_flattened_mut().fill_with(|| random.random_range(-1.0..1.0));
        let mut space =
            KrylovSpace { blocks: vec![], diagonal: vec![], coupling: vec![], random, mending: Mending::default() };
        space.orthonormalise(&mut start, watch)?;
        space.blocks.push(start);
        Ok(space)
    }

    /// Number of vectors the operator has been applied to.
    pub fn dimension(&self) -> usize {
        4 * Q * self.diagonal.len()
    }

    /// Applies the operator to the last block and appends what leaves the space.
    ///
    /// # Errors
    /// [`Cancelled`] by the watcher, asked as blocks pass by.
    pub fn expand(&mut self, apply: impl Fn(&[Row<Q>]) -> Block<Q>, watch: &dyn Watch) -> Result<(), Cancelled> {
        let (last, b) = (self.blocks.len() - 1, 4 * Q);
        let mut image = apply(&self.blocks[last]);
        if let Some(coupling) = self.coupling.last() {
            let back = rows((coupling.transpose() * -1.0).as_ref());
            add_product(&mut image, &self.blocks[last - 1..last], &back, watch)?;
        }
        let mut diagonal = take(&self.blocks[last..], &mut image, watch)?;
        let (due, left) = (self.mending.due(), lengths(&image));
        let vanished = (0..b).any(|j| left[j] <= VANISHED * diagonal.col(j).norm_l2());
        if due || vanished {
            let rest = project(&self.blocks, &mut image, watch)?;
            diagonal += rest.subrows(b * last, b);
            if due {
                self.mending.mended((0..b).map(|j| rest.col(j).norm_l2() / left[j]).fold(0.0, f64::max));
            }
        }
        self.diagonal.push(Mat::from_fn(b, b, |i, j| 0.5 * (diagonal[(i, j)] + diagonal[(j, i)])));
        let coupling = self.orthonormalise(&mut image, watch)?;
        self.blocks.push(image);
        self.coupling.push(coupling);
        Ok(())
    }

    /// Replaces the block X by V with V R = X, R upper triangular, and returns R: Cholesky of Xᵀ X, repeated until V is
    /// orthonormal. A column that depends on those before it is replaced by a random one, orthogonal to the space, its
    /// diagonal in R zero.
    fn orthonormalise(&mut self, x: &mut Block<Q>, watch: &dyn Watch) -> Result<Mat<f64>, Cancelled> {
        let mut total = Mat::identity(4 * Q, 4 * Q);
        for _ in 0..MOST_PASSES {
            let gram = matrix(&inner(std::slice::from_ref(x), x, watch)?);
            let Some((factor, ratio)) = upper_cholesky(gram.as_ref()) else {
                total = self.replace_dependent(x, watch)? * total;
                continue;
            };
            let mut inverse = Mat::identity(4 * Q, 4 * Q);
            solve_upper_triangular_in_place(factor.as_ref(), inverse.as_mut(), Par::Seq);
            multiply_right(x, &rows(inverse.as_ref()));
            total = factor * total;
            if ratio > WEAK {
                return Ok(total);
            }
            project(&self.blocks, x, watch)?;
        }
        // Only a block that is not finite comes here; its Ritz pairs do not converge.
        Ok(total)
    }

    /// Gram–Schmidt by columns, for a block whose columns depend on each other, and its R.
    fn replace_dependent(&mut self, x: &mut Block<Q>, watch: &dyn Watch) -> Result<Mat<f64>, Cancelled> {
        let mut factor = Mat::zeros(4 * Q, 4 * Q);
        for j in 0..4 * Q {
            let before = length(x, j);
            for i in (0..j).chain(0..j) {
                factor[(i, j)] += take_column(x, i, j);
            }
            let after = length(x, j);
            if after > DEPENDENT * before {
                factor[(j, j)] = after;
                scale_column(x, j, 1.0 / after);
                continue;
            }
            for row in x.iter_mut() {
                row[j / 4][j % 4] = self.random.random_range(-1.0..1.0);
            }
            for i in (0..j).chain(0..j) {
                take_column(x, i, j);
            }
            let after = length(x, j);
            scale_column(x, j, 1.0 / after);
        }
        project(&self.blocks, x, watch)?;
        Ok(factor)
    }

    /// The pairs of the `count` largest Ritz values, at most as many as the dimension.
    ///
    /// # Errors
    /// [`Cancelled`] by the watcher; within, [`DecompositionError`].
    pub fn ritz_pairs(
        &self,
        count: usize,
        watch: &dyn Watch,
    ) -> Result<Result<RitzPairs, DecompositionError>, Cancelled> {
        let (m, b) = (self.dimension(), 4 * Q);
        let mut projected = Mat::zeros(m, m);
        for (j, (diagonal, coupling)) in self.diagonal.iter().zip(&self.coupling).enumerate() {
            projected.submatrix_mut(j * b, j * b, b, b).copy_from(diagonal);
            if (j + 1) * b < m {
                projected.submatrix_mut((j + 1) * b, j * b, b, b).copy_from(coupling);
            }
        }
        let Ok(eigen) = apart(move || projected.self_adjoint_eigen(Side::Lower), || watch.proceed(0.0))? else {
            return Ok(Err(DecompositionError::Eigenvalues { size: m }));
        };
        let value = |i: usize| eigen.S().column_vector()[m - 1 - i];
        let inside = Mat::from_fn(m, count, |i, j| eigen.U()[(i, m - 1 - j)]);
        let outside = match self.coupling.last() {
            Some(coupling) => coupling * inside.subrows(m - b, b),
            None => Mat::zeros(b, count),
        };
        Ok(Ok(RitzPairs {
            values: (0..count).map(value).collect(),
            residuals: (0..count).map(|j| outside.col(j).norm_l2()).collect(),
            coefficients: Mat::from_fn(m + b, count, |i, j| {
                if i < m { inside[(i, j)] } else { outside[(i - m, j)] / value(j) }
            }),
        }))
    }

    /// V times the coefficients, 4 Q columns to a block, the last filled up with zeros.
    ///
    /// # Errors
    /// [`Cancelled`] by the watcher.
    pub fn combinations(&self, coefficients: MatRef<'_, f64>, watch: &dyn Watch) -> Result<Vec<Block<Q>>, Cancelled> {
        let b = 4 * Q;
        let count = coefficients.ncols().div_ceil(b);
        let parts: Vec<Block<Q>> = (0..count)
            .map(|p| {
                let columns = b.min(coefficients.ncols() - p * b);
                rows(coefficients.subcols(p * b, columns))
            })
            .collect();
        let mut blocks = vec![vec![[[0.0; 4]; Q]; self.blocks[0].len()]; count];
        let mut targets: Vec<&mut [Row<Q>]> = blocks.iter_mut().map(Vec::as_mut_slice).collect();
        let coefficients: Vec<&[Row<Q>]> = parts.iter().map(Vec::as_slice).collect();
        add_products(&mut targets, &self.blocks, &coefficients, watch)?;
        Ok(blocks)
    }
}

impl Mending {
    fn due(&mut self) -> bool {
        self.blocks += 1;
        self.blocks > self.trust[0]
    }

    /// `lost` was the departure from orthogonality.
    fn mended(&mut self, lost: f64) {
        if self.blocks == self.trust[0] + 1 {
            let growth = (lost / ROUNDING).max(2.0).ln() / self.blocks as f64;
            let bearable = ((ORTHOGONALITY / ROUNDING).ln() / growth) as usize;
            self.trust[1] = bearable.saturating_sub(1).min(self.trust[0] + 1);
        } else {
            *self = Mending { trust: [self.trust[1]; 2], blocks: 0 };
        }
    }
}

/// Takes V Vᵀ X from X and returns Vᵀ X.
fn take<const Q: usize>(basis: &[Block<Q>], x: &mut Block<Q>, watch: &dyn Watch) -> Result<Mat<f64>, Cancelled> {
    let mut coefficients = inner(basis, x, watch)?;
    let result = matrix(&coefficients);
    coefficients.as_flattened_mut().as_flattened_mut().iter_mut().for_each(|c| *c = -*c);
    add_product(x, basis, &coefficients, watch)?;
    Ok(result)
}

/// [`take`], again while most of a column was in the space: what is left would be rounding [DGKS76].
fn project<const Q: usize>(basis: &[Block<Q>], x: &mut Block<Q>, watch: &dyn Watch) -> Result<Mat<f64>, Cancelled> {
    let mut total = Mat::zeros(4 * Q * basis.len(), 4 * Q);
    for _ in 0..4 {
        let taken = take(basis, x, watch)?;
        total += &taken;
        let left = lengths(x);
        if (0..4 * Q).all(|j| taken.col(j).norm_l2() <= left[j]) {
            break;
        }
    }
    Ok(total)
}

/// R with Rᵀ R = G, and the least ratio of a squared diagonal to that of G; none where a column is dependent.
fn upper_cholesky(gram: MatRef<'_, f64>) -> Option<(Mat<f64>, f64)> {
    let n = gram.nrows();
    let mut factor = Mat::<f64>::zeros(n, n);
    let mut least = 1.0f64;
    for j in 0..n {
        for i in 0..j {
            let sum: f64 = (0..i).map(|l| factor[(l, i)] * factor[(l, j)]).sum();
            factor[(i, j)] = (gram[(i, j)] - sum) / factor[(i, i)];
        }
        let pivot = gram[(j, j)] - (0..j).map(|l| factor[(l, j)].powi(2)).sum::<f64>();
        let independent = pivot > DEPENDENT * gram[(j, j)];
        if !independent {
            return None;
        }
        least = least.min(pivot / gram[(j, j)]);
        factor[(j, j)] = pivot.sqrt();
    }
    Some((factor, least))
}

/// Takes from column j its part along column i, of unit length, and returns the coefficient.
fn take_column<const Q: usize>(x: &mut Block<Q>, i: usize, j: usize) -> f64 {
    let dot: f64 = x.iter().map(|row| row[i / 4][i % 4] * row[j / 4][j % 4]).sum();
    for row in x.iter_mut() {
        row[j / 4][j % 4] -= dot * row[i / 4][i % 4];
    }
    dot
}

fn scale_column<const Q: usize>(x: &mut Block<Q>, j: usize, factor: f64) {
    x.iter_mut().for_each(|row| row[j / 4][j % 4] *= factor);
}

fn lengths<const Q: usize>(x: &Block<Q>) -> Vec<f64> {
    column_products(x, x).into_iter().map(f64::sqrt).collect()
}

fn length<const Q: usize>(x: &Block<Q>, j: usize) -> f64 {
    x.iter().map(|row| row[j / 4][j % 4].powi(2)).sum::<f64>().sqrt()
}

fn matrix<const Q: usize>(rows: &[Row<Q>]) -> Mat<f64> {
    Mat::from_fn(rows.len(), 4 * Q, |i, j| rows[i][j / 4][j % 4])
}

/// A matrix of at most 4 Q columns by rows, filled up with zeros.
fn rows<const Q: usize>(matrix: MatRef<'_, f64>) -> Vec<Row<Q>> {
    (0..matrix.nrows())
        .map(|i| {
            std::array::from_fn(|q| {
                std::array::from_fn(|l| if 4 * q + l < matrix.ncols() { matrix[(i, 4 * q + l)] } else { 0.0 })
            })
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numerics::Unwatched;

    /// Multiplication by 1 / (1 + i) in row i, `distinct` different values, then zero.
    fn operator(distinct: usize) -> impl Fn(&[Row<1>]) -> Block<1> {
        move |x| {
            let value = |i: usize| if i < distinct { 1.0 / (1.0 + i as f64) } else { 0.0 };
            x.iter().enumerate().map(|(i, row)| row.map(|four| four.map(|x| value(i) * x))).collect()
        }
    }

    fn departure(space: &KrylovSpace<1>) -> f64 {
        let mut worst = 0.0f64;
        for (i, block) in space.blocks.iter().enumerate() {
            let gram = matrix(&inner(&space.blocks, block, &Unwatched).unwrap());
            let identity = Mat::from_fn(gram.nrows(), 4, |r, c| if r == 4 * i + c { 1.0 } else { 0.0 });
            worst = worst.max((gram - identity).norm_max());
        }
        worst
    }

    #[test]
    fn the_basis_stays_orthogonal_while_pairs_converge() {
        let mut space = KrylovSpace::<1>::new(500, 1, &Unwatched).unwrap();
        for _ in 0..40 {
            space.expand(operator(500), &Unwatched).unwrap();
        }
        assert!(departure(&space) < 1e-8, "{}", departure(&space));
        let ritz = space.ritz_pairs(6, &Unwatched).unwrap().unwrap();
        for i in 0..6 {
            assert!((ritz.values[i] * (1.0 + i as f64) - 1.0).abs() < 1e-12);
            assert!(ritz.residuals[i] < 1e-10);
        }
    }

    #[test]
    fn an_exhausted_space_goes_on_with_random_vectors() {
        // Rank 6: the second block already depends on the first, the third is rounding alone.
        let mut space = KrylovSpace::<1>::new(60, 1, &Unwatched).unwrap();
        for _ in 0..8 {
            space.expand(operator(6), &Unwatched).unwrap();
        }
        assert!(departure(&space) < 1e-8, "{}", departure(&space));
        let values = space.ritz_pairs(8, &Unwatched).unwrap().unwrap().values;
        for (i, value) in values.iter().enumerate() {
            assert!((value - if i < 6 { 1.0 / (1.0 + i as f64) } else { 0.0 }).abs() < 1e-12);
        }
    }

    #[test]
    fn a_cholesky_factor_is_refused_to_dependent_columns() {
        let gram = faer::mat![[4.0, 2.0], [2.0, 3.0]];
        let (factor, least) = upper_cholesky(gram.as_ref()).unwrap();
        assert!((factor.transpose() * &factor - &gram).norm_max() < 1e-14 && (least - 2.0 / 3.0).abs() < 1e-14);
        assert!(upper_cholesky(faer::mat![[4.0, 2.0], [2.0, 1.0]].as_ref()).is_none());
    }
}
