//! Random matrices for tests.

use faer::Mat;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// rows × columns of independent standard normal numbers [BM58].
pub(crate) fn normal(rows: usize, columns: usize, seed: u64) -> Mat<f64> {
    let mut source = ChaCha8Rng::seed_from_u64(seed);
    Mat::from_fn(rows, columns, |_, _| {
        let (radius, angle): (f64, f64) = (1.0 - source.random::<f64>(), source.random());
        (-2.0 * radius.ln()).sqrt() * (std::f64::consts::TAU * angle).cos()
    })
}

/// As [`normal`], row i multiplied by a factor that falls geometrically from 1 in the first row to 1 / `condition` in
/// the last.
pub(crate) fn ill_conditioned(rows: usize, columns: usize, condition: f64, seed: u64) -> Mat<f64> {
    let normal = normal(rows, columns, seed);
    let last = rows.saturating_sub(1).max(1) as f64;
    Mat::from_fn(rows, columns, |i, j| normal[(i, j)] * condition.powf(-(i as f64) / last))
}
