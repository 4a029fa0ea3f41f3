//! Functions of a shape made of its eigenpairs, one by one or all of a family, at its vertices.

use std::ops::Range;

use faer::Mat;
use serde::Deserialize;
use utoipa::ToSchema;

use super::projection::at_points;
use super::{first_positive, global_point_signature, heat_kernel, wave_kernel};
use crate::spectral::Spectrum;

/// Which functions.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum Family {
    /// The eigenfunctions themselves, k of them.
    Eigenfunctions,
    /// The heat kernel signature at `count` times.
    HeatKernel,
    /// The wave kernel signature at `count` energies.
    WaveKernel,
    /// The global point signature of all eigenvalues above 0.
    GlobalPointSignature,
}

/// How many there are, and how wide the bands of energies are in spacings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sampling {
    pub count: usize,
    pub variance: f64,
}

impl Family {
    /// How many functions there are of it for a spectrum of k pairs: no signature of the constant function alone.
    pub fn columns(self, spectrum: &Spectrum, sampling: Sampling) -> usize {
        match self {
            Family::Eigenfunctions => spectrum.len(),
            Family::HeatKernel | Family::WaveKernel if first_positive(&spectrum.eigenvalues).is_none() => 0,
            Family::HeatKernel | Family::WaveKernel => sampling.count,
            Family::GlobalPointSignature => global_point_signature::dimensions(spectrum),
        }
    }

    /// How many there are of it at most for a spectrum of k pairs.
    pub const fn most_columns(self, k: usize, sampling: Sampling) -> usize {
        match self {
            Family::Eigenfunctions | Family::GlobalPointSignature => k,
            Family::HeatKernel | Family::WaveKernel => sampling.count,
        }
    }

    /// These of them at the vertices, n × columns: of the spectrum as it is, in its units.
    ///
    /// Times and energies are sampled as those of a match, of which this is the sketch.
    pub fn at_vertices(self, spectrum: &Spectrum, sampling: Sampling, columns: Range<usize>) -> Mat<f64> {
        let eigenvalues = &spectrum.eigenvalues;
        let these = |all: Mat<f64>| all.subcols(columns.start, columns.len()).to_owned();
        match self {
            Family::Eigenfunctions => these(spectrum.eigenfunctions.clone()),
            Family::HeatKernel => {
                let times = heat_kernel::times(eigenvalues, sampling.count);
                at_points(spectrum, these(heat_kernel::filters(eigenvalues, &times)).as_ref())
            }
            Family::WaveKernel => {
                let energies = wave_kernel::energies(eigenvalues, sampling.count, sampling.variance);
                at_points(spectrum, these(wave_kernel::filters(eigenvalues, &energies)).as_ref())
            }
            Family::GlobalPointSignature => these(global_point_signature::signature(spectrum, usize::MAX)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::solids::sheet;
    use crate::numerics::Unwatched;
    use crate::spectral::{Boundary, spectrum};

    #[test]
    fn some_columns_are_those_of_all() {
        let spectrum = spectrum(&sheet(8, 5), 12, Boundary::Neumann, &Unwatched).unwrap().at_unit_area(12);
        let sampling = Sampling { count: 9, variance: 6.0 };
        for family in [Family::Eigenfunctions, Family::HeatKernel, Family::WaveKernel, Family::GlobalPointSignature] {
            let columns = family.columns(&spectrum, sampling);
            let all = family.at_vertices(&spectrum, sampling, 0..columns);
            assert_eq!(all.shape(), (54, columns), "{family:?}");
            assert!(columns <= family.most_columns(12, sampling), "{family:?}");
            let some = family.at_vertices(&spectrum, sampling, 3..5);
            assert!((some - all.subcols(3, 2)).norm_max() < 1e-12, "{family:?}");
        }
        assert_eq!(Family::GlobalPointSignature.columns(&spectrum, sampling), 11);
    }

    #[test]
    fn the_constant_alone_has_no_signature() {
        let spectrum = spectrum(&sheet(8, 5), 12, Boundary::Neumann, &Unwatched).unwrap().at_unit_area(1);
        let sampling = Sampling { count: 9, variance: 6.0 };
        for family in [Family::HeatKernel, Family::WaveKernel, Family::GlobalPointSignature] {
            assert_eq!(family.columns(&spectrum, sampling), 0, "{family:?}");
            assert_eq!(family.at_vertices(&spectrum, sampling, 0..0).shape(), (54, 0), "{family:?}");
        }
    }
}
