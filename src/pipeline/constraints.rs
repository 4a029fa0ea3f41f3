//! The corresponding functions A (k × q) and B (l × q): indicators of regions, heat and wave signatures within each,
//! heat spreading from landmarks, §3.2.1.

use faer::{Mat, MatRef};

use super::regions::Correspondence;
use super::request::{Columns, SpectralScale};
use super::settings::Descriptors;
use crate::descriptors::projection::{RegionProjection, projections};
use crate::descriptors::{first_positive, heat_kernel, wave_kernel};
use crate::functional_map::MapError;
use crate::functional_map::problem::Problem;
use crate::numerics::Watch;
use crate::spectral::Spectrum;

/// Times at which the heat of a landmark is compared.
const LANDMARK_TIMES: usize = 10;

/// The factor on the eigenvalues of the mesh, both shapes at area 1, their areas in the files as given.
pub(super) fn spectral_scale(
    kind: SpectralScale,
    sketch: &[f64],
    mesh: &[f64],
    [sketch_area, mesh_area]: [f64; 2],
) -> f64 {
    match kind {
        SpectralScale::Fitted => fitted_scale(sketch, mesh),
        // Area 1 for both is what this kind asks for.
        SpectralScale::Area => 1.0,
        SpectralScale::AreaSquared => mesh_area / sketch_area,
        SpectralScale::None => sketch_area / mesh_area,
    }
}

/// exp(mean of log λ_sketch − log λ_mesh) over the common pairs where neither is the zero of the constant function.
fn fitted_scale(sketch: &[f64], mesh: &[f64]) -> f64 {
    let (Some(least_sketch), Some(least_mesh)) = (first_positive(sketch), first_positive(mesh)) else { return 1.0 };
    let positive = |(s, m): &(&f64, &f64)| **s >= least_sketch && **m >= least_mesh;
    let ratios: Vec<f64> = sketch.iter().zip(mesh).filter(positive).map(|(s, m)| (s / m).ln()).collect();
    if ratios.is_empty() { 1.0 } else { (ratios.iter().sum::<f64>() / ratios.len() as f64).exp() }
}

/// A point map among the constraints, and what it weighs: a vertex of the mesh for every vertex of the sketch.
#[derive(Clone, Copy)]
pub(super) struct Points<'a> {
    pub map: &'a [u32],
    pub weight: f64,
}

/// The data term of the corresponding regions and landmarks, for spectra at area 1; `scaled` are the eigenvalues of the
/// mesh as descriptors see them. Landmarks are pairs of vertices.
pub(super) fn problem(
    descriptors: &Descriptors,
    [sketch, mesh]: [&Spectrum; 2],
    scaled: &[f64],
    regions: &Correspondence,
    landmarks: &[[usize; 2]],
    points: Option<Points<'_>>,
    watch: &dyn Watch,
) -> Result<Problem, MapError> {
    let common = sketch.eigenvalues.as_slice();
    let times = match descriptors.hks.times {
        Some(range) => heat_kernel::times_between(range, descriptors.hks.count),
        None => heat_kernel::times(common, descriptors.hks.count),
    };
    // Heat is compared at the same times, waves at energies of the same rank in either spectrum.
    let ranks = common.len().min(scaled.len());
    let bands = [common, scaled].map(|eigenvalues| first_positive(&eigenvalues[..ranks]));
    let waves = if bands.contains(&None) { 0 } else { descriptors.wks.count };
    let filters = |eigenvalues: &[f64]| {
        let energies = wave_kernel::energies(&eigenvalues[..ranks], waves, descriptors.wks.variance);
        [heat_kernel::filters(eigenvalues, &times), wave_kernel::filters(eigenvalues, &energies)]
    };
    let (sketch_filters, mesh_filters) = (filters(common), filters(scaled));
    let (on_sketch, on_mesh) = (projections(sketch, &regions.sketch, watch)?, projections(mesh, &regions.mesh, watch)?);

    let mut problem = Problem::unconstrained(mesh.len(), sketch.len());
    let mut constrain = |a: Mat<f64>, b: Mat<f64>| match descriptors.columns {
        Columns::Unit => problem.constrain(unit_columns(a).as_ref(), unit_columns(b).as_ref()),
        Columns::Raw => problem.constrain(a.as_ref(), b.as_ref()),
    };
    for pair in &regions.pairs {
        let columns = |region: &RegionProjection, filters: &[Mat<f64>; 2]| {
            let indicator = Mat::from_fn(region.indicator.len(), 1, |i, _| region.indicator[i]);
            [indicator, &region.gram * &filters[0], &region.gram * &filters[1]]
        };
        let a = columns(&on_sketch[pair.sketch], &sketch_filters);
        let b = columns(&on_mesh[pair.mesh], &mesh_filters);
        for (a, b) in a.into_iter().zip(b) {
            constrain(a, b)?;
        }
    }
    let times = heat_kernel::times(common, LANDMARK_TIMES);
    for &[x, y] in landmarks {
        let heat = |spectrum: &Spectrum, eigenvalues: &[f64], vertex: usize| {
            let filters = heat_kernel::filters(eigenvalues, &times);
            Mat::from_fn(spectrum.len(), times.len(), |i, t| filters[(i, t)] * spectrum.eigenfunctions[(vertex, i)])
        };
        constrain(heat(sketch, common, x), heat(mesh, scaled, y))?;
    }
    if let Some(Points { map, weight }) = points {
        // A unit mass at x goes to a unit mass at T(x): weight · Σ_x m(x) ‖C φ(x) − ψ(T(x))‖².
        let root = |x: usize| (weight * sketch.mass[x]).sqrt();
        let a = Mat::from_fn(sketch.len(), map.len(), |i, x| root(x) * sketch.eigenfunctions[(x, i)]);
        let b = Mat::from_fn(mesh.len(), map.len(), |i, x| root(x) * mesh.eigenfunctions[(map[x] as usize, i)]);
        problem.constrain(a.as_ref(), b.as_ref())?;
    }
    Ok(problem)
}

/// Every column to Euclidean norm 1; a column of zeros stays.
fn unit_columns(matrix: Mat<f64>) -> Mat<f64> {
    let norms: Vec<f64> = (0..matrix.ncols()).map(|j| norm(matrix.as_ref(), j)).collect();
    Mat::from_fn(matrix.nrows(), matrix.ncols(), |i, j| if norms[j] == 0.0 { 0.0 } else { matrix[(i, j)] / norms[j] })
}

fn norm(matrix: MatRef<'_, f64>, column: usize) -> f64 {
    matrix.col(column).norm_l2()
}
