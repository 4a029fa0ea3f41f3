//! Dense kernels on tall, narrow blocks: n rows of 4 Q numbers, stored row by row.
//!
//! The work of a block Krylov method beside its operator: Vᵀ X, X + V C for bases V of many blocks. Each streams V from
//! memory once and keeps the rest in registers and the nearest cache.

use sprs::CsMat;

use super::lanes::{self, Kernel, Lanes};
use super::{Cancelled, Pace, Watch};

/// A row of 4 Q numbers.
pub type Row<const Q: usize> = [[f64; 4]; Q];

/// Rows taken at a time: so few that a stretch of X stays in the nearest cache while the blocks of V pass by.
const STRETCH: usize = 256;

/// Vᵀ X (m × 4 Q) for the basis V of m / 4Q blocks (n × 4 Q each) and X (n × 4 Q).
///
/// # Errors
/// [`Cancelled`] by the watcher, asked as V passes by.
pub fn inner<const Q: usize>(basis: &[Vec<Row<Q>>], x: &[Row<Q>], watch: &dyn Watch) -> Result<Vec<Row<Q>>, Cancelled> {
    let mut pace = Pace::new(watch, x.len() * basis.len());
    let mut sums = vec![[[0.0; 4]; Q]; 4 * Q * basis.len()];
    for start in (0..x.len()).step_by(STRETCH) {
        let rows = start..(start + STRETCH).min(x.len());
        for (sums, v) in sums.chunks_exact_mut(4 * Q).zip(basis) {
            lanes::run(AddInner { sums, v: &v[rows.clone()], x: &x[rows.clone()] });
        }
        pace.steps(rows.len() * basis.len())?;
    }
    Ok(sums)
}

/// Adds V C to X: V of m / 4Q blocks (n × 4 Q each), C (m × 4 Q), X (n × 4 Q).
///
/// # Errors
/// [`Cancelled`] by the watcher, asked as V passes by.
pub fn add_product<const Q: usize>(
    x: &mut [Row<Q>],
    basis: &[Vec<Row<Q>>],
    coefficients: &[Row<Q>],
    watch: &dyn Watch,
) -> Result<(), Cancelled> {
    add_products(&mut [x], basis, &[coefficients], watch)
}

/// [`add_product`] for several X, each with its own C: V is read once for all.
///
/// # Errors
/// As [`add_product`].
pub fn add_products<const Q: usize>(
    xs: &mut [&mut [Row<Q>]],
    basis: &[Vec<Row<Q>>],
    coefficients: &[&[Row<Q>]],
    watch: &dyn Watch,
) -> Result<(), Cancelled> {
    let n = basis.first().map_or(0, Vec::len);
    let mut pace = Pace::new(watch, n * basis.len() * xs.len());
    for start in (0..n).step_by(STRETCH) {
        let rows = start..(start + STRETCH).min(n);
        for (x, c) in xs.iter_mut().zip(coefficients) {
            for (c, v) in c.chunks_exact(4 * Q).zip(basis) {
                lanes::run(AddProduct { x: &mut x[rows.clone()], v: &v[rows.clone()], c });
            }
            pace.steps(rows.len() * basis.len())?;
        }
    }
    Ok(())
}

/// The inner product of each column of X with that of Y.
pub fn column_products<const Q: usize>(x: &[Row<Q>], y: &[Row<Q>]) -> Vec<f64> {
    let mut sums = [[0.0; 4]; Q];
    for (x, y) in x.iter().zip(y) {
        for q in 0..Q {
            for l in 0..4 {
                sums[q][l] += x[q][l] * y[q][l];
            }
        }
    }
    sums.as_flattened().to_vec()
}

/// Replaces X (n × 4 Q) by X C, C 4 Q × 4 Q.
pub fn multiply_right<const Q: usize>(x: &mut [Row<Q>], coefficients: &[Row<Q>]) {
    lanes::run(MultiplyRight { x, c: coefficients });
}

/// sums += vᵀ x.
struct AddInner<'a, const Q: usize> {
    sums: &'a mut [Row<Q>],
    v: &'a [Row<Q>],
    x: &'a [Row<Q>],
}

impl<const Q: usize> Kernel for AddInner<'_, Q> {
    #[inline(always)]
    fn compute<L: Lanes>(self, lanes: L) {
        for (q, sums) in self.sums.as_chunks_mut::<4>().0.iter_mut().enumerate() {
            // Four columns of v at a time: their sums are 4 Q registers.
            let mut s = [
                lanes.load_row(&sums[0]),
                lanes.load_row(&sums[1]),
                lanes.load_row(&sums[2]),
                lanes.load_row(&sums[3]),
            ];
            for (v, x) in self.v.iter().zip(self.x) {
                let x = lanes.load_row(x);
                for l in 0..4 {
                    for p in 0..Q {
                        s[l][p] = lanes.multiply_add(v[q][l], x[p], s[l][p]);
                    }
                }
            }
            for l in 0..4 {
                lanes.store_row(s[l], &mut sums[l]);
            }
        }
    }
}

/// x += v c.
struct AddProduct<'a, const Q: usize> {
    x: &'a mut [Row<Q>],
    v: &'a [Row<Q>],
    c: &'a [Row<Q>],
}

impl<const Q: usize> Kernel for AddProduct<'_, Q> {
    #[inline(always)]
    fn compute<L: Lanes>(self, lanes: L) {
        let (xs, last_xs) = self.x.as_chunks_mut::<4>();
        let (vs, last_vs) = self.v.as_chunks::<4>();
        // Four rows at a time, so that each row of c is loaded once for four.
        for (x, v) in xs.iter_mut().zip(vs) {
            let sums = loaded(lanes, x);
            *x = stored(lanes, multiply_add(lanes, sums, v, self.c));
        }
        for (x, v) in last_xs.iter_mut().zip(last_vs) {
            let sums = loaded(lanes, std::array::from_ref(x));
            [*x] = stored(lanes, multiply_add(lanes, sums, std::array::from_ref(v), self.c));
        }
    }
}

/// x ← x c.
struct MultiplyRight<'a, const Q: usize> {
    x: &'a mut [Row<Q>],
    c: &'a [Row<Q>],
}

impl<const Q: usize> Kernel for MultiplyRight<'_, Q> {
    #[inline(always)]
    fn compute<L: Lanes>(self, lanes: L) {
        let zero = [lanes.load(&[0.0; 4]); Q];
        let (xs, last_xs) = self.x.as_chunks_mut::<4>();
        for x in xs {
            *x = stored(lanes, multiply_add(lanes, [zero; 4], x, self.c));
        }
        for x in last_xs {
            [*x] = stored(lanes, multiply_add(lanes, [zero], &[*x], self.c));
        }
    }
}

/// sums + v c.
#[inline(always)]
fn multiply_add<L: Lanes, const Q: usize, const R: usize>(
    lanes: L,
    mut sums: [[L::Four; Q]; R],
    v: &[Row<Q>; R],
    c: &[Row<Q>],
) -> [[L::Four; Q]; R] {
    for (q, c) in c.as_chunks::<4>().0.iter().enumerate().take(Q) {
        for l in 0..4 {
            let c = lanes.load_row(&c[l]);
            for r in 0..R {
                for p in 0..Q {
                    sums[r][p] = lanes.multiply_add(v[r][q][l], c[p], sums[r][p]);
                }
            }
        }
    }
    sums
}

#[inline(always)]
fn loaded<L: Lanes, const Q: usize, const R: usize>(lanes: L, rows: &[Row<Q>; R]) -> [[L::Four; Q]; R] {
    std::array::from_fn(
        #[inline(always)]
        |r| lanes.load_row(&rows[r]),
    )
}

#[inline(always)]
fn stored<L: Lanes, const Q: usize, const R: usize>(lanes: L, fours: [[L::Four; Q]; R]) -> [Row<Q>; R] {
    let mut rows = [[[0.0; 4]; Q]; R];
    for r in 0..R {
        lanes.store_row(fours[r], &mut rows[r]);
    }
    rows
}

/// H X for a sparse symmetric H, n × n, and X, n × 4 Q.
pub fn sparse_product<const Q: usize>(matrix: &CsMat<f64>, x: &[Row<Q>]) -> Vec<Row<Q>> {
    let mut product = vec![[[0.0; 4]; Q]; x.len()];
    lanes::run(SparseProduct { matrix, x, product: &mut product });
    product
}

struct SparseProduct<'a, const Q: usize> {
    matrix: &'a CsMat<f64>,
    x: &'a [Row<Q>],
    product: &'a mut [Row<Q>],
}

impl<const Q: usize> Kernel for SparseProduct<'_, Q> {
    #[inline(always)]
    fn compute<L: Lanes>(self, lanes: L) {
        let (columns, values) = (self.matrix.indices(), self.matrix.data());
        for (target, ends) in self.product.iter_mut().zip(self.matrix.proper_indptr().windows(2)) {
            let (start, end) = (ends[0], ends[1]);
            let mut sum = [lanes.load(&[0.0; 4]); Q];
            for (&column, &value) in columns[start..end].iter().zip(&values[start..end]) {
                let x = &self.x[column];
                for q in 0..Q {
                    sum[q] = lanes.multiply_add(value, lanes.load(&x[q]), sum[q]);
                }
            }
            lanes.store_row(sum, target);
        }
    }
}

#[cfg(test)]
mod tests {
    use faer::Mat;
    use sprs::TriMat;

    use super::*;
    use crate::numerics::watch::counting::Counting;
    use crate::numerics::{Unwatched, random};

    fn rows<const Q: usize>(matrix: &Mat<f64>, first: usize) -> Vec<Row<Q>> {
        let row = |i| std::array::from_fn(|q| std::array::from_fn(|l| matrix[(i, first + 4 * q + l)]));
        (0..matrix.nrows()).map(row).collect()
    }

    fn assert_close<const Q: usize>(fast: &[Row<Q>], naive: &Mat<f64>) {
        let fast = Mat::from_fn(fast.len(), 4 * Q, |i, j| fast[i][j / 4][j % 4]);
        assert!((fast - naive).norm_max() < 1e-10);
    }

    /// A basis of three blocks and X, with more rows than a stretch and no multiple of four.
    fn agree_with_naive_ones<const Q: usize>() {
        let n = 2 * STRETCH + 7;
        let (v, x) = (random::normal(n, 12 * Q, 1), random::normal(n, 4 * Q, 2));
        let basis: Vec<Vec<Row<Q>>> = (0..3).map(|block| rows(&v, 4 * Q * block)).collect();
        let block = rows::<Q>(&x, 0);
        assert_close(&inner(&basis, &block, &Unwatched).unwrap(), &(v.transpose() * &x));

        let c = random::normal(12 * Q, 4 * Q, 3);
        let mut sum = block.clone();
        add_product(&mut sum, &basis, &rows(&c, 0), &Unwatched).unwrap();
        assert_close(&sum, &(&x + &v * &c));

        let c = random::normal(4 * Q, 4 * Q, 4);
        let mut product = block.clone();
        multiply_right(&mut product, &rows(&c, 0));
        assert_close(&product, &(&x * &c));

        let products = column_products(&basis[0], &block);
        for (j, product) in products.iter().enumerate() {
            assert!((product - v.col(j).transpose() * x.col(j)).abs() < 1e-10);
        }
    }

    #[test]
    fn kernels_agree_with_naive_ones() {
        agree_with_naive_ones::<1>();
        agree_with_naive_ones::<2>();
        agree_with_naive_ones::<4>();
    }

    #[test]
    fn the_watcher_is_asked_as_the_basis_passes() {
        let basis = vec![vec![[[1.0; 4]; 1]; 40 * STRETCH]; 5];
        let (mut x, passed) = (basis[0].clone(), basis.len() * basis[0].len());
        let counting = Counting::default();
        let coefficients = inner(&basis, &x, &counting).unwrap();
        counting.assert_asked_within(passed);
        let counting = Counting::default();
        add_product(&mut x, &basis, &coefficients, &counting).unwrap();
        counting.assert_asked_within(passed);
        assert_eq!(inner(&basis, &x, &Counting::until(3)), Err(Cancelled));
    }

    #[test]
    fn sparse_products_agree_with_dense_ones() {
        let (n, x) = (30, random::normal(30, 8, 5));
        let mut triplets = TriMat::new((n, n));
        for (i, j) in (0..n).flat_map(|i| [(i, i), (i, 7 * i % n)]) {
            triplets.add_triplet(i, j, (i + 2 * j) as f64);
        }
        let matrix: CsMat<f64> = triplets.to_csr();
        let dense = Mat::from_fn(n, n, |i, j| matrix.get(i, j).copied().unwrap_or_default());
        assert_close(&sparse_product::<2>(&matrix, &rows(&x, 0)), &(dense * x));
    }
}
