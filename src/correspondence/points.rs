//! From a functional map to a point map, §2.2.1: the n × m matrix Ψ C Φᵀ is never formed.

use faer::MatRef;

use crate::numerics::patched_rows::PatchedRows;
use crate::numerics::row_search::{self, Measure};
use crate::numerics::{Cancelled, Watch};

/// The rows of Ψ (n × l) made ready for search: once, where several maps of the same mesh are converted.
pub struct Target(PatchedRows);

impl Target {
    pub fn new(psi: MatRef<'_, f64>) -> Target {
        Target(PatchedRows::of(psi))
    }

    /// As [`by_indicator`], for C of as many rows as Ψ has columns or fewer: the first columns then count.
    ///
    /// # Errors
    /// [`Cancelled`] by the watcher, asked every so many vertices of the sketch.
    pub fn by_indicator(
        &self,
        c: MatRef<'_, f64>,
        phi: MatRef<'_, f64>,
        watch: &dyn Watch,
    ) -> Result<Vec<u32>, Cancelled> {
        row_search::least(&self.0, Measure::NegatedProduct, (c * phi.transpose()).as_ref(), watch)
    }

    /// As [`by_nearest_neighbour`], for C of as many rows as Ψ has columns or fewer: the first columns then count.
    ///
    /// # Errors
    /// As [`Target::by_indicator`].
    pub fn by_nearest_neighbour(
        &self,
        c: MatRef<'_, f64>,
        phi: MatRef<'_, f64>,
        watch: &dyn Watch,
    ) -> Result<Vec<u32>, Cancelled> {
        row_search::least(&self.0, Measure::SquaredDistance, (c * phi.transpose()).as_ref(), watch)
    }
}

/// T(x) = argmax_y (Ψ C Φᵀ)[y, x] for every vertex x of the sketch: where the image of the point's indicator is
/// largest; of equals, the first.
///
/// # Errors
/// As [`Target::by_indicator`].
pub fn by_indicator(
    c: MatRef<'_, f64>,
    phi: MatRef<'_, f64>,
    psi: MatRef<'_, f64>,
    watch: &dyn Watch,
) -> Result<Vec<u32>, Cancelled> {
    Target::new(psi).by_indicator(c, phi, watch)
}

/// T(x) = argmin_y ‖C φ(x) − ψ(y)‖: the nearest neighbour of column x of C Φᵀ among the rows of Ψ; of equals, the first.
///
/// # Errors
/// As [`Target::by_indicator`].
pub fn by_nearest_neighbour(
    c: MatRef<'_, f64>,
    phi: MatRef<'_, f64>,
    psi: MatRef<'_, f64>,
    watch: &dyn Watch,
) -> Result<Vec<u32>, Cancelled> {
    Target::new(psi).by_nearest_neighbour(c, phi, watch)
}

#[cfg(test)]
mod tests {
    use faer::Mat;

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
