//! From a functional map to a point map, §2.2.1, in blocks: the n × m matrix Ψ C Φᵀ never stands in memory.

use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatRef, Par};

use crate::numerics::{Cancelled, Watch};

/// Vertices of the mesh and of the sketch in a block: 256 × 128 products stay in the cache.
const ROWS: usize = 256;
const COLUMNS: usize = 128;

/// T(x) = argmax_y (Ψ C Φᵀ)[y, x] for every vertex x of the sketch: where the image of the point's indicator is
/// largest; of equals, the first.
///
/// # Errors
/// [`Cancelled`] by the watcher, asked at every block.
pub fn by_indicator(
    c: MatRef<'_, f64>,
    phi: MatRef<'_, f64>,
    psi: MatRef<'_, f64>,
    watch: &dyn Watch,
) -> Result<Vec<u32>, Cancelled> {
    best(psi, &vec![0.0; psi.nrows()], (c * phi.transpose()).as_ref(), watch)
}

/// T(x) = argmin_y ‖C φ(x) − ψ(y)‖: the nearest neighbour of column x of C Φᵀ among the rows of Ψ; of equals, the first.
///
/// # Errors
/// As [`by_indicator`].
pub fn by_nearest_neighbour(
    c: MatRef<'_, f64>,
    phi: MatRef<'_, f64>,
    psi: MatRef<'_, f64>,
    watch: &dyn Watch,
) -> Result<Vec<u32>, Cancelled> {
    // ‖p − ψ‖² = ‖p‖² − 2 (ψ·p − ‖ψ‖²/2): the nearest has the largest ψ·p − ‖ψ‖²/2.
    let offsets: Vec<f64> = (0..psi.nrows()).map(|y| -0.5 * psi.row(y).squared_norm_l2()).collect();
    best(psi, &offsets, (c * phi.transpose()).as_ref(), watch)
}

/// argmax_y ψ(y)·p + offset(y) for every column p of `points` (l × m).
fn best(
    psi: MatRef<'_, f64>,
    offsets: &[f64],
    points: MatRef<'_, f64>,
    watch: &dyn Watch,
) -> Result<Vec<u32>, Cancelled> {
    let (n, m) = (psi.nrows(), points.ncols());
    let mut map = Vec::with_capacity(m);
    for first in (0..m).step_by(COLUMNS) {
        watch.proceed(first as f64 / m as f64)?;
        let columns = COLUMNS.min(m - first);
        let points = points.subcols(first, columns);
        let mut best = vec![(f64::NEG_INFINITY, 0u32); columns];
        for top in (0..n).step_by(ROWS) {
            let rows = ROWS.min(n - top);
            let mut scores = Mat::<f64>::zeros(rows, columns);
            matmul(scores.as_mut(), Accum::Replace, psi.subrows(top, rows), points, 1.0, Par::Seq);
            for (j, best) in best.iter_mut().enumerate() {
                for (i, score) in scores.col_as_slice(j).iter().enumerate() {
                    let score = score + offsets[top + i];
                    if score > best.0 {
                        *best = (score, (top + i) as u32);
                    }
                }
            }
        }
        map.extend(best.iter().map(|&(_, y)| y));
    }
    Ok(map)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numerics::Unwatched;

    fn bases() -> (Mat<f64>, Mat<f64>, Mat<f64>) {
        let wave = |x: usize, i: usize, step: f64| ((x as f64 * step) * (i as f64 + 1.3)).sin();
        (
            Mat::from_fn(5, 4, |i, j| wave(i, j, 0.9)),
            Mat::from_fn(300, 4, |x, i| wave(x, i, 0.37)),
            Mat::from_fn(700, 5, |y, i| wave(y, i, 0.11)),
        )
    }

    #[test]
    fn blocks_agree_with_the_whole_matrix() {
        let (c, phi, psi) = bases();
        let scores = &psi * &c * phi.transpose();
        let indicator = by_indicator(c.as_ref(), phi.as_ref(), psi.as_ref(), &Unwatched).unwrap();
        let nearest = by_nearest_neighbour(c.as_ref(), phi.as_ref(), psi.as_ref(), &Unwatched).unwrap();
        let images = &c * phi.transpose();
        for x in 0..phi.nrows() {
            let largest = (0..psi.nrows()).map(|y| scores[(y, x)]).fold(f64::NEG_INFINITY, f64::max);
            assert!(scores[(indicator[x] as usize, x)] > largest - 1e-12);
            let distance = |y: usize| (psi.row(y).transpose() - images.col(x)).squared_norm_l2();
            let least = (0..psi.nrows()).map(distance).fold(f64::INFINITY, f64::min);
            assert!(distance(nearest[x] as usize) < least + 1e-12);
        }
    }

    #[test]
    fn the_identity_maps_every_vertex_to_itself() {
        let (_, phi, _) = bases();
        let c = Mat::<f64>::identity(4, 4);
        let map = by_nearest_neighbour(c.as_ref(), phi.as_ref(), phi.as_ref(), &Unwatched).unwrap();
        assert!(map.iter().enumerate().all(|(x, &y)| x == y as usize));
    }
}
