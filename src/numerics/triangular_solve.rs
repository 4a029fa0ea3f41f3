//! L⁻¹ and L⁻ᵀ of a sparse Cholesky factor, applied to several right-hand sides at once.
//!
//! Right-hand sides lie row by row, so that an entry of L is loaded once for all of them and multiplies whole registers.
//! Four columns of a supernode are taken at a time, a strip, so that a row of X is loaded once for four; L lies row by
//! row within a strip, so that it streams from memory front to back.

use super::lanes::{self, Kernel, Lanes};
use super::tall_block::Row;

/// Neighbouring columns of L of one pattern: a triangle, then the rows below it.
pub struct Supernode<'a> {
    /// Its first column.
    pub first: usize,
    pub width: usize,
    /// Below the triangle.
    pub rows: &'a [usize],
    /// Its [`strips`].
    pub values: &'a [f64],
}

/// Appends a supernode's `width` columns, one after the other (what is above the diagonal counts for nothing), in strips
/// of four columns, the last of fewer: each row by row from its diagonal on, the reciprocal on the diagonal.
pub fn strips(columns: &[f64], width: usize, strips: &mut Vec<f64>) {
    let height = columns.len() / width;
    for first in (0..width).step_by(4) {
        let strip = first..width.min(first + 4);
        for row in first..height {
            strips.extend(strip.clone().map(|column| {
                let entry = columns[column * height + row];
                if row == column { 1.0 / entry } else { entry }
            }));
        }
    }
}

/// Replaces X (n × 4 Q) by (L Lᵀ)⁻¹ X, L given by its supernodes from left to right.
pub fn solve<'a, const Q: usize>(supernodes: impl DoubleEndedIterator<Item = Supernode<'a>> + Clone, x: &mut [Row<Q>]) {
    lanes::run(Solve { supernodes, x });
}

struct Solve<'x, S, const Q: usize> {
    supernodes: S,
    x: &'x mut [Row<Q>],
}

impl<'a, S, const Q: usize> Kernel for Solve<'_, S, Q>
where
    S: DoubleEndedIterator<Item = Supernode<'a>> + Clone,
{
    #[inline(always)]
    fn compute<L: Lanes>(self, lanes: L) {
        for node in self.supernodes.clone() {
            let mut strips = node.values;
            for first in (0..node.width).step_by(4) {
                strips = through::<Forward, L, Q>(lanes, Place { node: &node, first, strips }, self.x);
            }
        }
        for node in self.supernodes.rev() {
            let mut strips = node.values;
            for first in (0..node.width).step_by(4).rev() {
                strips = through::<Backward, L, Q>(lanes, Place { node: &node, first, strips }, self.x);
            }
        }
    }
}

/// Where a sweep has come to: the strip of `node` that begins at its column `first`.
#[derive(Clone, Copy)]
struct Place<'n, 'a> {
    node: &'n Supernode<'a>,
    first: usize,
    /// That strip and the further ones of the supernode, in the order of L.
    strips: &'a [f64],
}

/// A way through L, strip by strip.
trait Sweep {
    /// Does what is to be done with a strip of W columns, and returns the further strips.
    fn strip<'a, L: Lanes, const Q: usize, const W: usize>(
        lanes: L,
        place: Place<'_, 'a>,
        x: &mut [Row<Q>],
    ) -> &'a [f64];
}

/// [`Sweep::strip`] for as many columns as the strip has.
#[inline(always)]
fn through<'a, S: Sweep, L: Lanes, const Q: usize>(lanes: L, place: Place<'_, 'a>, x: &mut [Row<Q>]) -> &'a [f64] {
    match place.node.width - place.first {
        1 => S::strip::<L, Q, 1>(lanes, place, x),
        2 => S::strip::<L, Q, 2>(lanes, place, x),
        3 => S::strip::<L, Q, 3>(lanes, place, x),
        _ => S::strip::<L, Q, 4>(lanes, place, x),
    }
}

/// From left to right: solves with the columns, then takes their part from the rows below.
struct Forward;

impl Sweep for Forward {
    #[inline(always)]
    fn strip<'a, L: Lanes, const Q: usize, const W: usize>(
        lanes: L,
        place: Place<'_, 'a>,
        x: &mut [Row<Q>],
    ) -> &'a [f64] {
        let Place { node, first, strips } = place;
        let (strip, further) = strips.split_at(W * (node.width - first + node.rows.len()));
        let (triangle, strip) = strip.as_chunks::<W>().0.split_at(W);
        let (top, below) = x[node.first + first..].split_at_mut(W);
        let mut t = [[lanes.load(&[0.0; 4]); Q]; W];
        for j in 0..W {
            t[j] = lanes.load_row(&top[j]);
            for i in 0..j {
                t[j] = subtract(lanes, t[j], triangle[j][i], t[i]);
            }
            t[j] = multiply(lanes, triangle[j][j], t[j]);
            lanes.store_row(t[j], &mut top[j]);
        }
        let (beside, under) = strip.split_at(node.width - first - W);
        for (l, row) in beside.iter().zip(&mut *below) {
            lanes.store_row(subtract_all(lanes, lanes.load_row(row), l, &t), row);
        }
        let offset = node.first + first + W;
        for (l, row) in under.iter().zip(node.rows) {
            let row = &mut below[row - offset];
            lanes.store_row(subtract_all(lanes, lanes.load_row(row), l, &t), row);
        }
        further
    }
}

/// From right to left: takes the part of the rows below from the columns, then solves with them.
struct Backward;

impl Sweep for Backward {
    #[inline(always)]
    fn strip<'a, L: Lanes, const Q: usize, const W: usize>(
        lanes: L,
        place: Place<'_, 'a>,
        x: &mut [Row<Q>],
    ) -> &'a [f64] {
        let Place { node, first, strips } = place;
        let (before, strip) = strips.split_at(strips.len() - W * (node.width - first + node.rows.len()));
        let (triangle, strip) = strip.as_chunks::<W>().0.split_at(W);
        let (top, below) = x[node.first + first..].split_at_mut(W);
        let mut t = [[lanes.load(&[0.0; 4]); Q]; W];
        for j in 0..W {
            t[j] = lanes.load_row(&top[j]);
        }
        // Backwards, so that all strips stream from memory back to front.
        let (beside, under) = strip.split_at(node.width - first - W);
        let offset = node.first + first + W;
        for (l, row) in under.iter().zip(node.rows).rev() {
            let row = lanes.load_row(&below[row - offset]);
            for j in 0..W {
                t[j] = subtract(lanes, t[j], l[j], row);
            }
        }
        for (l, row) in beside.iter().zip(&below[..beside.len()]).rev() {
            let row = lanes.load_row(row);
            for j in 0..W {
                t[j] = subtract(lanes, t[j], l[j], row);
            }
        }
        for j in (0..W).rev() {
            for i in j + 1..W {
                t[j] = subtract(lanes, t[j], triangle[i][j], t[i]);
            }
            t[j] = multiply(lanes, triangle[j][j], t[j]);
            lanes.store_row(t[j], &mut top[j]);
        }
        before
    }
}

/// sum − Σ l_j · t_j.
#[inline(always)]
fn subtract_all<L: Lanes, const Q: usize, const W: usize>(
    lanes: L,
    mut sum: [L::Four; Q],
    l: &[f64; W],
    t: &[[L::Four; Q]; W],
) -> [L::Four; Q] {
    for j in 0..W {
        sum = subtract(lanes, sum, l[j], t[j]);
    }
    sum
}

#[inline(always)]
fn multiply<L: Lanes, const Q: usize>(lanes: L, factor: f64, x: [L::Four; Q]) -> [L::Four; Q] {
    std::array::from_fn(
        #[inline(always)]
        |q| lanes.multiply(factor, x[q]),
    )
}

/// sum − entry · x.
#[inline(always)]
fn subtract<L: Lanes, const Q: usize>(lanes: L, sum: [L::Four; Q], entry: f64, x: [L::Four; Q]) -> [L::Four; Q] {
    std::array::from_fn(
        #[inline(always)]
        |q| lanes.multiply_subtract(entry, x[q], sum[q]),
    )
}

#[cfg(test)]
mod tests {
    use faer::Mat;

    use super::*;
    use crate::numerics::random;

    /// A factor of two supernodes, 7 columns above 2 of the 6 rows below, then those 6, against the dense solution.
    #[test]
    fn solutions_agree_with_dense_ones() {
        let (widths, under) = ([7, 6], [vec![8, 11], vec![]]);
        let n = widths[0] + widths[1];
        let random = random::normal(n, n, 1);
        let mut factor = Mat::<f64>::zeros(n, n);
        let mut packed = [Vec::new(), Vec::new()];
        for (s, first) in [0, widths[0]].into_iter().enumerate() {
            let rows: Vec<usize> = (first..first + widths[s]).chain(under[s].iter().copied()).collect();
            let mut columns = Vec::new();
            for column in first..first + widths[s] {
                for &row in &rows {
                    let entry = random[(row, column)] + if row == column { 5.0 } else { 0.0 };
                    columns.push(entry);
                    factor[(row, column)] = if row < column { 0.0 } else { entry };
                }
            }
            strips(&columns, widths[s], &mut packed[s]);
        }
        let x = random::normal(n, 8, 2);
        let product = &factor * factor.transpose() * &x;
        let mut rows: Vec<Row<2>> =
            (0..n).map(|i| std::array::from_fn(|q| std::array::from_fn(|l| product[(i, 4 * q + l)]))).collect();
        let node = |s: usize| Supernode { first: [0, 7][s], width: widths[s], rows: &under[s], values: &packed[s] };
        solve((0..2).map(node), &mut rows);
        let solved = Mat::from_fn(n, 8, |i, j| rows[i][j / 4][j % 4]);
        assert!((solved - x).norm_max() < 1e-10);
    }
}
