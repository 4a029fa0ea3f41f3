//! Descriptors of regions, projected onto the basis without ever being formed at the points.
//!
//! Component f of a descriptor within a region r is the function 1_r(x) Σ_i f(λ_i) φ_i(x)²; its coefficients are G_r f
//! with G_r[a, i] = Σ_{x ∈ r} m(x) φ_a(x) φ_i(x)², one k × k matrix per region whatever the number of components.

use std::ops::Range;

use faer::{Mat, MatRef};

use crate::numerics::lanes::{self, Kernel, Lanes};
use crate::numerics::{Cancelled, Watch};
use crate::regions::Regions;
use crate::spectral::Spectrum;

/// Vertices between two questions to the watcher.
const ROUND: usize = 1024;

/// What a region contributes to the constraints of a functional map.
#[derive(Clone, Debug)]
pub struct RegionProjection {
    /// Coefficients of the region's indicator, k.
    pub indicator: Vec<f64>,
    /// G_r, k × k.
    pub gram: Mat<f64>,
}

/// The projections of all regions, one pass over the vertices: n k² multiplications.
///
/// # Errors
/// [`Cancelled`] by the watcher, asked every so many vertices.
pub fn projections(
    spectrum: &Spectrum,
    regions: &Regions,
    watch: &dyn Watch,
) -> Result<Vec<RegionProjection>, Cancelled> {
    let k = spectrum.len();
    let mut projections: Vec<RegionProjection> =
        (0..regions.count()).map(|_| RegionProjection { indicator: vec![0.0; k], gram: Mat::zeros(k, k) }).collect();
    let vertices = spectrum.vertices();
    for first in (0..vertices).step_by(ROUND) {
        watch.proceed(first as f64 / vertices as f64)?;
        let vertices = first..vertices.min(first + ROUND);
        lanes::run(AddVertices { spectrum, regions, vertices, projections: &mut projections });
    }
    Ok(projections)
}

/// Adds what some vertices contribute to the projections of their regions.
struct AddVertices<'a> {
    spectrum: &'a Spectrum,
    regions: &'a Regions,
    vertices: Range<usize>,
    projections: &'a mut [RegionProjection],
}

impl Kernel for AddVertices<'_> {
    #[inline(always)]
    fn compute<L: Lanes>(self, _: L) {
        let k = self.spectrum.len();
        let (mut row, mut squares) = (vec![0.0; k], vec![0.0; k]);
        for x in self.vertices {
            let Some(region) = self.regions.region(x) else { continue };
            let mass = self.spectrum.mass[x];
            for i in 0..k {
                row[i] = self.spectrum.eigenfunctions[(x, i)];
                squares[i] = mass * row[i] * row[i];
            }
            let projection = &mut self.projections[region];
            for (i, square) in squares.iter().enumerate() {
                let column = projection.gram.col_as_slice_mut(i);
                for (entry, value) in column.iter_mut().zip(&row) {
                    *entry += value * square;
                }
            }
            for (entry, value) in projection.indicator.iter_mut().zip(&row) {
                *entry += mass * value;
            }
        }
    }
}

/// The components `filters` (k × count) of the descriptor at every point, n × count: for means over regions.
pub fn at_points(spectrum: &Spectrum, filters: MatRef<'_, f64>) -> Mat<f64> {
    let phi = &spectrum.eigenfunctions;
    let squares = Mat::from_fn(phi.nrows(), phi.ncols(), |x, i| phi[(x, i)] * phi[(x, i)]);
    squares * filters
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numerics::Unwatched;

    #[test]
    fn a_projection_is_that_of_the_function_formed_at_the_points() {
        let (n, k) = (40, 5);
        let spectrum = Spectrum {
            eigenvalues: (0..k).map(|i| i as f64).collect(),
            eigenfunctions: Mat::from_fn(n, k, |x, i| ((x * (i + 2)) as f64).sin()),
            mass: (0..n).map(|x| 1.0 + (x % 3) as f64).collect(),
        };
        let regions = Regions::new((0..n).map(|x| (x % 4) as i32 - 1).collect()).unwrap();
        let filters = Mat::from_fn(k, 3, |i, t| 1.0 / (1.0 + (i * t) as f64));
        let points = at_points(&spectrum, filters.as_ref());
        for (region, projection) in projections(&spectrum, &regions, &Unwatched).unwrap().iter().enumerate() {
            let fast = &projection.gram * &filters;
            for (a, t) in (0..k).flat_map(|a| (0..3).map(move |t| (a, t))) {
                let naive: f64 = (0..n)
                    .filter(|&x| regions.region(x) == Some(region))
                    .map(|x| spectrum.mass[x] * spectrum.eigenfunctions[(x, a)] * points[(x, t)])
                    .sum();
                assert!((fast[(a, t)] - naive).abs() < 1e-10);
            }
        }
    }
}
