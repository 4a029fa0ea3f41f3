//! Rows of a matrix in patches: groups of rows that lie near one another.

use faer::MatRef;

use super::lanes::{self, Kernel, Lanes, vectorised};

/// Rows in a patch.
pub const PATCH: usize = 64;

/// Columns whose spread decides where rows are parted: of eigenfunctions the slowest, which tell places apart. On the
/// bodies of the bench 4 leave patches that three times as many searches have to look at, 16 twice as many.
const LEADING: usize = 8;

/// One column of a patch.
pub type Column = [f64; PATCH];

/// The same in single precision.
pub type Rounded = [f32; PATCH];

/// The rows of a matrix (n × d) in an order where every [`PATCH`] consecutive ones are a patch.
///
/// The order only decides how fast a search is, never its answer.
pub struct PatchedRows {
    /// d columns per patch, patch after patch; the last patch is filled up with zeros.
    values: Vec<Column>,
    rounded: Vec<Rounded>,
    columns: usize,
    /// The number in the matrix of every row, in the order of the patches.
    order: Vec<u32>,
}

impl PatchedRows {
    /// The patches of a matrix of fewer than 2³² rows, by repeated halving where the leading columns spread most.
    pub fn of(matrix: MatRef<'_, f64>) -> PatchedRows {
        let (n, columns) = matrix.shape();
        let mut places: Vec<Place> = (0..n).map(|row| Place { leading: [0.0; LEADING], row: row as u32 }).collect();
        for (j, column) in matrix.col_iter().take(LEADING).enumerate() {
            places.iter_mut().zip(column.iter()).for_each(|(place, &x)| place.leading[j] = x as f32);
        }
        halve(&mut places);
        let order: Vec<u32> = places.iter().map(|place| place.row).collect();
        let mut values = vec![[0.0; PATCH]; n.div_ceil(PATCH) * columns];
        for (j, column) in matrix.col_iter().enumerate() {
            for (patch, rows) in order.chunks(PATCH).enumerate() {
                for (value, &row) in values[patch * columns + j].iter_mut().zip(rows) {
                    *value = column[row as usize];
                }
            }
        }
        let rounded = values.iter().map(rounded).collect();
        PatchedRows { values, rounded, columns, order }
    }

    /// Number of patches.
    pub fn patches(&self) -> usize {
        self.order.len().div_ceil(PATCH)
    }

    /// Number of columns, d.
    pub fn columns(&self) -> usize {
        self.columns
    }

    /// The columns of a patch.
    pub fn patch(&self, patch: usize) -> &[Column] {
        &self.values[patch * self.columns..(patch + 1) * self.columns]
    }

    /// The columns of a patch in single precision.
    pub fn rounded(&self, patch: usize) -> &[Rounded] {
        &self.rounded[patch * self.columns..(patch + 1) * self.columns]
    }

    /// The sums of squares of the first `columns` columns, patch by patch.
    pub fn squared_lengths(&self, columns: usize) -> Vec<Rounded> {
        let origin = vec![0.0; columns];
        let of = |patch: usize| squared_distances(&self.patch(patch)[..columns], &origin);
        (0..self.patches()).map(|patch| rounded(&of(patch))).collect()
    }

    /// The numbers in the matrix of the rows of a patch, at most [`PATCH`].
    pub fn rows(&self, patch: usize) -> &[u32] {
        &self.order[patch * PATCH..((patch + 1) * PATCH).min(self.order.len())]
    }
}

/// A row on its way into a patch.
#[derive(Clone, Copy)]
struct Place {
    leading: [f32; LEADING],
    row: u32,
}

/// Orders `places` so that every [`PATCH`] consecutive ones, counted from the first, are near one another.
fn halve(places: &mut [Place]) {
    if places.len() <= PATCH {
        return;
    }
    let (mut low, mut high) = (places[0].leading, places[0].leading);
    for place in &*places {
        for j in 0..LEADING {
            let x = place.leading[j];
            low[j] = if x < low[j] { x } else { low[j] };
            high[j] = if x > high[j] { x } else { high[j] };
        }
    }
    let spread = |j: &usize| high[*j] - low[*j];
    let widest = (0..LEADING).max_by(|a, b| spread(a).total_cmp(&spread(b))).unwrap_or(0);
    let middle = places.len().div_ceil(2 * PATCH) * PATCH;
    places.select_nth_unstable_by(middle, |a, b| a.leading[widest].total_cmp(&b.leading[widest]));
    let (first, second) = places.split_at_mut(middle);
    halve(first);
    halve(second);
}

/// Σ_j weights_j column_j for every row of a patch.
///
/// Every sum is taken in the order of the columns and rounded after every multiplication and addition, so that it is
/// the same on every processor.
pub fn products(columns: &[Column], weights: &[f64]) -> Column {
    let mut sums = [0.0; PATCH];
    lanes::run(Products { columns, weights, sums: &mut sums });
    sums
}

/// Σ_j (column_j − point_j)² for every row of a patch, rounded like [`products`].
pub fn squared_distances(columns: &[Column], point: &[f64]) -> Column {
    let mut sums = [0.0; PATCH];
    lanes::run(SquaredDistances { columns, point, sums: &mut sums });
    sums
}

fn rounded(column: &Column) -> Rounded {
    column.map(|value| value as f32)
}

/// Whether ‖ψ‖² − 2 p·ψ, reckoned in single precision, is not above `most` for some row ψ of a patch: a quarter of the
/// work of [`squared_distances`]. `lengths` are the ‖ψ‖². Rounded by less than 2 (d + 6) units roundoff times the square
/// of ‖p‖ + ‖ψ‖.
pub fn reach(columns: &[Rounded], point: &[f32], lengths: &Rounded, most: f32) -> bool {
    vectorised(
        #[inline(always)]
        || {
            let mut products = [0.0; PATCH];
            for (column, &number) in columns.iter().zip(point) {
                for l in 0..PATCH {
                    products[l] += column[l] * number;
                }
            }
            let mut any = false;
            for l in 0..PATCH {
                // What is not a number, by overflow, may be anything.
                let beyond = lengths[l] - 2.0 * products[l] > most;
                any |= !beyond;
            }
            any
        },
    )
}

struct Products<'a> {
    columns: &'a [Column],
    weights: &'a [f64],
    sums: &'a mut Column,
}

impl Kernel for Products<'_> {
    #[inline(always)]
    fn compute<L: Lanes>(self, _: L) {
        summed(self.columns, self.weights, self.sums, |value, weight| value * weight);
    }
}

struct SquaredDistances<'a> {
    columns: &'a [Column],
    point: &'a [f64],
    sums: &'a mut Column,
}

impl Kernel for SquaredDistances<'_> {
    #[inline(always)]
    fn compute<L: Lanes>(self, _: L) {
        summed(self.columns, self.point, self.sums, |value, coordinate| (value - coordinate) * (value - coordinate));
    }
}

/// Sums over the columns, a part of the rows at a time: as many sums as registers hold.
#[inline(always)]
fn summed(columns: &[Column], numbers: &[f64], sums: &mut Column, term: impl Fn(f64, f64) -> f64) {
    const PART: usize = 32;
    for (part, sums) in sums.as_chunks_mut::<PART>().0.iter_mut().enumerate() {
        let mut running = [0.0; PART];
        for (column, &number) in columns.iter().zip(numbers) {
            let column = &column.as_chunks::<PART>().0[part];
            for l in 0..PART {
                running[l] += term(column[l], number);
            }
        }
        *sums = running;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numerics::random;

    #[test]
    fn every_row_is_in_one_patch_with_all_its_columns() {
        for (n, d) in [(0, 3), (1, 1), (64, 2), (65, 9), (129, 1), (1000, 12)] {
            let matrix = random::normal(n, d, 1);
            let rows = PatchedRows::of(matrix.as_ref());
            let mut seen = vec![0; n];
            for patch in 0..rows.patches() {
                for (place, &row) in rows.rows(patch).iter().enumerate() {
                    seen[row as usize] += 1;
                    assert!((0..d).all(|j| rows.patch(patch)[j][place] == matrix[(row as usize, j)]));
                }
            }
            assert_eq!(seen, vec![1; n], "{n} {d}");
        }
    }

    #[test]
    fn patches_are_smaller_than_the_whole() {
        let matrix = random::normal(64 * 64, 2, 2);
        let rows = PatchedRows::of(matrix.as_ref());
        let width = |patch: usize| {
            let column = rows.patch(patch)[0];
            column.iter().fold(f64::MIN, |a, &b| a.max(b)) - column.iter().fold(f64::MAX, |a, &b| a.min(b))
        };
        let mean = (0..rows.patches()).map(width).sum::<f64>() / rows.patches() as f64;
        assert!(mean < 1.5, "{mean} of about 7");
    }

    #[test]
    fn sums_are_those_of_plain_arithmetic_bit_for_bit() {
        let (columns, numbers) = (random::normal(PATCH, 37, 3), random::normal(37, 1, 4));
        let patch: Vec<Column> = (0..37).map(|j| std::array::from_fn(|l| columns[(l, j)])).collect();
        let numbers: Vec<f64> = numbers.col_as_slice(0).to_vec();
        let (products, distances) = (products(&patch, &numbers), squared_distances(&patch, &numbers));
        for l in 0..PATCH {
            let (mut product, mut distance) = (0.0, 0.0);
            for (column, number) in patch.iter().zip(&numbers) {
                product += column[l] * number;
                distance += (column[l] - number) * (column[l] - number);
            }
            assert_eq!((products[l], distances[l]), (product, distance));
        }
    }
}
