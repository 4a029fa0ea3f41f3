//! The row of a matrix that is nearest to a point, or has the largest product with it: exact, though few rows are
//! looked at.
//!
//! Branch and bound over [`OrientedBoxes`]: the patch of the least bound is looked at first, and then those whose
//! bound is not above the best found. A bound is below what it bounds by more than all rounding, so that the answer is
//! that of looking at every row, on every processor.

use faer::{Mat, MatRef};

use super::oriented_boxes::OrientedBoxes;
use super::patched_rows::{self, PatchedRows, Rounded};
use super::{Cancelled, Watch};

/// Points whose products with the boxes are taken together.
const POINTS: usize = 64;

/// What is least at the row that is sought.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Measure {
    /// ‖p − ψ‖².
    SquaredDistance,
    /// −p·ψ.
    NegatedProduct,
}

/// The row ψ of the least measure for every column p of `points` (d × m), among the first d columns of `rows`; of
/// equals the first, 0 where there is none. m answers.
///
/// At worst, where rows lie in no neighbourhoods, all n d m products are taken.
///
/// # Errors
/// [`Cancelled`] by the watcher, asked every few points.
pub fn least(
    rows: &PatchedRows,
    measure: Measure,
    points: MatRef<'_, f64>,
    watch: &dyn Watch,
) -> Result<Vec<u32>, Cancelled> {
    let m = points.ncols();
    let boxes = OrientedBoxes::around(rows, points.nrows());
    let lengths = match measure {
        Measure::SquaredDistance => rows.squared_lengths(points.nrows()),
        Measure::NegatedProduct => Vec::new(),
    };
    let (mut bounds, mut others) = (vec![0.0; boxes.count()], Vec::new());
    let mut found = vec![0; m];
    // Points near one another look at the same patches, which then are still in the cache.
    let places = PatchedRows::of(points.transpose());
    let near = (0..places.patches()).flat_map(|patch| places.rows(patch).chunks(POINTS));
    for (done, near) in near.enumerate() {
        watch.proceed(((done * POINTS) as f64 / m as f64).min(1.0))?;
        let points = Mat::from_fn(points.nrows(), near.len(), |i, j| points[(i, near[j] as usize)]);
        let rounded = Mat::from_fn(points.nrows(), near.len(), |i, j| points[(i, j)] as f32);
        let products = boxes.products(rounded.as_ref());
        for (j, &x) in near.iter().enumerate() {
            let (point, rounded, products) =
                (points.col_as_slice(j), rounded.col_as_slice(j), products.col_as_slice(j));
            let squared = point.iter().map(|p| p * p).sum::<f64>() as f32;
            match measure {
                Measure::SquaredDistance => boxes.least_squared_distances(products, squared, &mut bounds),
                Measure::NegatedProduct => boxes.least_negated_products(products, squared, &mut bounds),
            }
            let search = Search { rows, boxes: &boxes, lengths: &lengths, measure, point, rounded, squared };
            found[x as usize] = search.least(&bounds, &mut others);
        }
    }
    Ok(found)
}

/// The search for one point.
struct Search<'a> {
    rows: &'a PatchedRows,
    boxes: &'a OrientedBoxes,
    /// ‖ψ‖² of the rows, patch by patch, where distances are measured.
    lengths: &'a [Rounded],
    measure: Measure,
    point: &'a [f64],
    /// The point in single precision.
    rounded: &'a [f32],
    /// ‖p‖².
    squared: f32,
}

/// The best row so far, and its measure.
struct Best {
    measure: f64,
    row: u32,
}

impl Search<'_> {
    /// The row of the least measure, given a bound for every patch; `others` is room to order patches in.
    fn least(&self, bounds: &[f32], others: &mut Vec<(f64, usize)>) -> u32 {
        let mut best = Best { measure: f64::INFINITY, row: 0 };
        let Some(first) = (0..bounds.len()).min_by(|&a, &b| bounds[a].total_cmp(&bounds[b])) else { return 0 };
        self.look_at(first, &mut best);
        others.clear();
        let bounds = bounds.iter().map(|&bound| f64::from(bound)).zip(0..);
        others.extend(bounds.filter(|&(bound, b)| bound <= best.measure && b != first));
        others.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
        for &(bound, patch) in &*others {
            if bound > best.measure {
                break;
            }
            self.look_at(patch, &mut best);
        }
        best.row
    }

    fn look_at(&self, patch: usize, best: &mut Best) {
        let columns = &self.rows.patch(patch)[..self.point.len()];
        // Few patches hold a better row, so that all of one is asked at once.
        let measures = match self.measure {
            Measure::SquaredDistance => {
                let rounded = &self.rows.rounded(patch)[..self.rounded.len()];
                let most = best.measure as f32 - self.squared + self.boxes.margin(patch, self.squared);
                if !patched_rows::reach(rounded, self.rounded, &self.lengths[patch], most) {
                    return;
                }
                patched_rows::squared_distances(columns, self.point)
            }
            Measure::NegatedProduct => patched_rows::products(columns, self.point).map(|product| -product),
        };
        if !measures.iter().fold(false, |any, &measure| any | (measure <= best.measure)) {
            return;
        }
        for (&measure, &row) in measures.iter().zip(self.rows.rows(patch)) {
            if measure < best.measure || measure == best.measure && row < best.row {
                *best = Best { measure, row };
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numerics::{Unwatched, random};

    /// Every row looked at, in plain arithmetic.
    fn naive(matrix: MatRef<'_, f64>, measure: Measure, points: MatRef<'_, f64>) -> Vec<u32> {
        let of = |row: usize, point: usize| {
            let terms = (0..points.nrows()).map(|j| (matrix[(row, j)], points[(j, point)]));
            match measure {
                Measure::SquaredDistance => terms.fold(0.0, |sum, (a, b)| sum + (a - b) * (a - b)),
                Measure::NegatedProduct => -terms.fold(0.0, |sum, (a, b)| sum + a * b),
            }
        };
        let first_of_least = |point: usize| {
            let better = |best: (f64, u32), row: usize| {
                if of(row, point) < best.0 { (of(row, point), row as u32) } else { best }
            };
            (0..matrix.nrows()).fold((f64::INFINITY, 0), better).1
        };
        (0..points.ncols()).map(first_of_least).collect()
    }

    fn assert_exact(matrix: &Mat<f64>, points: &Mat<f64>, name: &str) {
        let rows = PatchedRows::of(matrix.as_ref());
        for measure in [Measure::SquaredDistance, Measure::NegatedProduct] {
            let found = least(&rows, measure, points.as_ref(), &Unwatched).unwrap();
            assert_eq!(found, naive(matrix.as_ref(), measure, points.as_ref()), "{name} {measure:?}");
        }
    }

    /// A surface in d dimensions, as eigenfunctions bend it: u cos and v sin of growing frequencies.
    fn surface(n: usize, d: usize) -> Mat<f64> {
        let width = (n as f64).sqrt();
        Mat::from_fn(n, d, |row, j| {
            let (u, v) = ((row as f64 % width) / width, (row as f64 / width).floor() / width);
            let (p, q) = ((j % 5) as f64, (j / 5) as f64);
            (3.1 * p * u + 0.3).cos() * (3.1 * q * v + 0.2).cos()
        })
    }

    #[test]
    fn all_shapes_of_input_are_searched_exactly() {
        for (n, d, m) in [(1, 1, 3), (1, 4, 1), (63, 1, 70), (64, 3, 5), (65, 20, 40), (700, 7, 33), (200, 500, 9)] {
            assert_exact(&random::normal(n, d, 1), &random::normal(d, m, 2), &format!("normal {n} {d} {m}"));
            assert_exact(&surface(n, d), &random::normal(d, m, 2), &format!("surface {n} {d} {m}"));
        }
        assert_exact(&random::normal(100, 3, 1), &Mat::zeros(3, 0), "no points");
        assert_exact(&Mat::zeros(0, 3), &Mat::zeros(3, 2), "no rows");
        assert_exact(&random::normal(100, 0, 1), &Mat::zeros(0, 2), "no columns");
    }

    #[test]
    fn points_on_the_surface_and_near_it_are_found() {
        let matrix = surface(3000, 20);
        let near = random::normal(20, 3000, 3);
        let points = Mat::from_fn(20, 100, |j, x| matrix[(17 * x, j)] + (x % 3) as f64 * 0.05 * near[(j, x)]);
        assert_exact(&matrix, &points, "near");
    }

    #[test]
    fn what_single_precision_does_not_hold_is_found() {
        let (rows, points) = (surface(500, 6), random::normal(6, 20, 3));
        for (of_rows, of_points) in
            [(1e-30, 1e-30), (1e-30, 1.0), (1e25, 1e25), (1e25, 1.0), (1e120, 1e120), (1.0, 1e60)]
        {
            let scaled =
                |matrix: &Mat<f64>, by: f64| Mat::from_fn(matrix.nrows(), matrix.ncols(), |i, j| by * matrix[(i, j)]);
            assert_exact(&scaled(&rows, of_rows), &scaled(&points, of_points), &format!("{of_rows} {of_points}"));
        }
        // Far from the origin, where differences drown in squares of the lengths.
        let far = |matrix: &Mat<f64>| Mat::from_fn(matrix.nrows(), matrix.ncols(), |i, j| 1e4 + matrix[(i, j)]);
        assert_exact(&far(&rows), &far(&points), "far");
    }

    #[test]
    fn of_equal_rows_the_first_is_found() {
        let few = random::normal(7, 5, 4);
        let matrix = Mat::from_fn(1000, 5, |row, j| few[(row * row % 7, j)]);
        let points = Mat::from_fn(5, 14, |j, x| few[(x % 7, j)] * (1.0 + (x / 7) as f64));
        assert_exact(&matrix, &points, "copies");
        assert_exact(&Mat::full(300, 4, 2.5), &random::normal(4, 10, 5), "one place");
        // A lattice: points halfway between four rows, and products equal along lines.
        let lattice = Mat::from_fn(900, 2, |row, j| if j == 0 { (row % 30) as f64 } else { (row / 30) as f64 });
        let between = Mat::from_fn(2, 20, |j, x| if j == 0 { x as f64 + 0.5 } else { 28.5 - x as f64 });
        assert_exact(&lattice, &between, "lattice");
        assert_exact(&lattice, &Mat::full(2, 1, 1.0), "diagonal");
    }

    #[test]
    fn badly_scaled_columns_and_extreme_lengths_do_not_mislead() {
        let scales = [1e-9, 1.0, 1e7, 0.0, 1e-3];
        let scaled = |matrix: Mat<f64>| Mat::from_fn(matrix.nrows(), 5, |i, j| matrix[(i, j)] * scales[j]);
        let points = scaled(random::normal(40, 5, 7)).transpose().to_owned();
        assert_exact(&scaled(random::normal(500, 5, 6)), &points, "columns");
        for scale in [1e-320, 1e-170, 1e-155, 1e150, 1e153, 1e154, 1e200, 1e308] {
            let matrix = Mat::from_fn(500, 5, |i, j| ((i * (j + 2)) as f64).sin() * scale);
            let other = Mat::from_fn(5, 40, |i, j| ((3 * j * (i + 1)) as f64).cos());
            assert_exact(&matrix, &(faer::Scale(scale) * &other), &format!("{scale}"));
            assert_exact(&matrix, &other, &format!("{scale} and 1"));
            assert_exact(&surface(500, 5), &(faer::Scale(scale) * &other), &format!("1 and {scale}"));
        }
        // Far from the origin, where most digits are those of the place.
        let far = Mat::from_fn(500, 3, |i, j| 1e8 + 1e-7 * ((i * (j + 2)) as f64).sin());
        assert_exact(&far, &Mat::from_fn(3, 30, |j, x| far[(16 * x, j)]), "far");
    }

    #[test]
    fn leading_columns_are_searched_alone() {
        let matrix = surface(500, 12);
        let points = random::normal(4, 20, 8);
        let rows = PatchedRows::of(matrix.as_ref());
        let found = least(&rows, Measure::SquaredDistance, points.as_ref(), &Unwatched).unwrap();
        assert_eq!(found, naive(matrix.subcols(0, 4), Measure::SquaredDistance, points.as_ref()));
    }

    #[test]
    fn it_stops_when_nobody_waits() {
        struct Never;
        impl Watch for Never {
            fn proceed(&self, _fraction: f64) -> Result<(), Cancelled> {
                Err(Cancelled)
            }
        }
        let rows = PatchedRows::of(surface(100, 4).as_ref());
        let points = random::normal(4, 3, 9);
        assert_eq!(least(&rows, Measure::SquaredDistance, points.as_ref(), &Never), Err(Cancelled));
    }
}
