//! The line along which the large entries of a functional map lie.

/// Slopes of a fitted line that still are a diagonal's, as shares of the plain diagonal's.
const SLOPES: std::ops::RangeInclusive<f64> = 0.1..=10.0;

/// The line row = `offset` + `slope` · column through the places of a matrix, both counted from 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Diagonal {
    pub offset: f64,
    pub slope: f64,
}

impl Diagonal {
    /// From the first place of a rows × columns matrix, at slope rows / columns.
    pub fn plain(rows: usize, columns: usize) -> Self {
        Diagonal { offset: 0.0, slope: rows as f64 / columns.max(1) as f64 }
    }

    /// The line of least squares through `places` (row, column) of a rows × columns matrix, distances counted at right
    /// angles as in [`Diagonal::distance`], so that neither shape is the one without error.
    ///
    /// A few places far off can turn it until it is no diagonal. If its slope is negative or not within a factor of 10
    /// of the plain diagonal's, or all places lie in one row or column, it is the plain diagonal instead.
    pub fn through(places: &[(usize, usize)], rows: usize, columns: usize) -> Self {
        let plain = Diagonal::plain(rows, columns);
        let count = places.len() as f64;
        let mean_row = places.iter().map(|place| place.0 as f64).sum::<f64>() / count;
        let mean_column = places.iter().map(|place| place.1 as f64).sum::<f64>() / count;
        let (mut of_rows, mut of_columns, mut covariance) = (0.0, 0.0, 0.0);
        for &(row, column) in places {
            let (row, column) = (row as f64 - mean_row, column as f64 - mean_column);
            of_rows += row * row;
            of_columns += column * column;
            covariance += row * column;
        }
        // The principal axis. Without covariance, and without places, the slope is in no range or not a number.
        let excess: f64 = of_rows - of_columns;
        let slope = (excess + excess.hypot(2.0 * covariance)) / (2.0 * covariance);
        if SLOPES.contains(&(slope / plain.slope)) {
            Diagonal { offset: mean_row - slope * mean_column, slope }
        } else {
            plain
        }
    }

    /// Distance of a place from the line, at right angles to it, in places.
    pub fn distance(&self, row: usize, column: usize) -> f64 {
        (self.offset + self.slope * column as f64 - row as f64).abs() / self.slope.hypot(1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_is_found_through_its_own_places() {
        let places: Vec<_> = (0..10).map(|column| (2 * column + 3, column)).collect();
        let line = Diagonal::through(&places, 24, 12);
        assert!((line.slope - 2.0).abs() < 1e-12 && (line.offset - 3.0).abs() < 1e-12);
        assert!(places.iter().all(|&(row, column)| line.distance(row, column) < 1e-12));
        assert!((line.distance(8, 0) - 5.0 / 5f64.sqrt()).abs() < 1e-12);
    }

    #[test]
    fn the_fit_is_least_squares_at_right_angles() {
        // Worked by hand: of columns 0, 1, 2 and rows 0, 2, 1 both variances are 2 and the covariance is 1.
        let line = Diagonal::through(&[(0, 0), (2, 1), (1, 2)], 3, 3);
        assert_eq!(line, Diagonal { offset: 0.0, slope: 1.0 });
        // Columns 0, 1, 2 and rows 0, 1, 4: variances 2 and 26/3, covariance 4, slope (20/3 + √(400/9 + 64)) / 8.
        let line = Diagonal::through(&[(0, 0), (1, 1), (4, 2)], 6, 3);
        assert!((line.slope - (20.0 / 3.0 + (400.0 / 9.0 + 64.0f64).sqrt()) / 8.0).abs() < 1e-14);
    }

    #[test]
    fn what_is_no_diagonal_is_replaced_by_the_plain_one() {
        let plain = Diagonal::plain(30, 20);
        assert_eq!(plain.slope, 1.5);
        let falling: Vec<_> = (0..20).map(|column| (20 - column, column)).collect();
        let level: Vec<_> = (0..20).map(|column| (5, column)).collect();
        let upright: Vec<_> = (0..20).map(|row| (row, 5)).collect();
        for places in [falling, level, upright, vec![(1, 1)], vec![]] {
            assert_eq!(Diagonal::through(&places, 30, 20), plain);
        }
    }
}
