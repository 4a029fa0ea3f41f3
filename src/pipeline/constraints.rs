//! The corresponding functions A (k × q) and B (l × q): indicators of regions, heat and wave signatures within each,
//! heat spreading from landmarks, §3.2.1.

use faer::{Mat, MatRef};

use super::regions::Correspondence;
use super::request::{Columns, Coupling, FunctionPair, Regions as Method, SpectralScale};
use super::settings::{Descriptors, Heat, Settings, Wave};
use crate::descriptors::projection::{RegionProjection, at_points, projections};
use crate::descriptors::{first_positive, heat_kernel, wave_kernel};
use crate::functional_map::MapError;
use crate::functional_map::part::{Group, Partial};
use crate::functional_map::permutation::Unordered;
use crate::functional_map::problem::Problem;
use crate::functional_map::regulariser::Regulariser;
use crate::functional_map::surface::Surface;
use crate::functional_map::term::Term;
use crate::mesh::TriangleMesh;
use crate::mesh::figure::Figure;
use crate::numerics::Watch;
use crate::regions::Regions;
use crate::regions::pairing::RegionPair;
use crate::spectral::Spectrum;

/// Times at which the heat of a landmark is compared.
const LANDMARK_TIMES: usize = 10;

/// Heat and wave components that added terms are made of, at most.
const COMPONENTS: usize = 8;

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

/// What corresponding functions are made of.
#[derive(Clone, Copy)]
pub(super) struct Constraints<'a> {
    pub descriptors: &'a Descriptors,
    /// Of sketch and mesh, at area 1.
    pub spectra: [&'a Spectrum; 2],
    /// The eigenvalues of the mesh as descriptors see them.
    pub scaled: &'a [f64],
    pub regions: &'a Correspondence,
    /// Pairs of vertices.
    pub landmarks: &'a [[usize; 2]],
    /// Functions of the user's own at the vertices of the sketch (m × q) and of the figure (n × q).
    pub functions: Option<&'a [Mat<f64>; 2]>,
    pub points: Option<Points<'a>>,
}

/// The data term of the corresponding functions.
pub(super) fn problem(constraints: &Constraints<'_>, watch: &dyn Watch) -> Result<Problem, MapError> {
    let [sketch, mesh] = constraints.spectra;
    let mut problem = Problem::unconstrained(mesh.len(), sketch.len());
    each(constraints, &mut |a, b| problem.constrain(a.as_ref(), b.as_ref()), watch)?;
    Ok(problem)
}

/// The data term without the functions of regions.
fn without_regions(constraints: &Constraints<'_>, watch: &dyn Watch) -> Result<Problem, MapError> {
    problem(&Constraints { regions: &constraints.regions.unpaired(), ..*constraints }, watch)
}

/// Hands on the coefficients of corresponding functions, blocks of A (k × p) and B (l × p) in the order of their columns.
pub(super) fn each(
    &Constraints { descriptors, spectra: [sketch, mesh], scaled, regions, landmarks, functions, points }: &Constraints<
        '_,
    >,
    hand_on: &mut dyn FnMut(Mat<f64>, Mat<f64>) -> Result<(), MapError>,
    watch: &dyn Watch,
) -> Result<(), MapError> {
    let common = sketch.eigenvalues.as_slice();
    let [sketch_filters, mesh_filters] = filters(descriptors, common, scaled);
    let (on_sketch, on_mesh) = (projections(sketch, &regions.sketch, watch)?, projections(mesh, &regions.mesh, watch)?);

    let mut constrain = |a: Mat<f64>, b: Mat<f64>| match descriptors.columns {
        Columns::Unit => hand_on(unit_columns(a), unit_columns(b)),
        Columns::Raw => hand_on(a, b),
    };
    for pair in &regions.pairs {
        let a = of_region(&on_sketch[pair.sketch], &sketch_filters);
        let b = of_region(&on_mesh[pair.mesh], &mesh_filters);
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
    if let Some([on_sketch, on_mesh]) = functions {
        constrain(coefficients(sketch, on_sketch), coefficients(mesh, on_mesh))?;
    }
    if let Some(Points { map, weight }) = points {
        // A unit mass at x goes to a unit mass at T(x): weight · Σ_x m(x) ‖C φ(x) − ψ(T(x))‖².
        let root = |x: usize| (weight * sketch.mass[x]).sqrt();
        let a = Mat::from_fn(sketch.len(), map.len(), |i, x| root(x) * sketch.eigenfunctions[(x, i)]);
        let b = Mat::from_fn(mesh.len(), map.len(), |i, x| root(x) * mesh.eigenfunctions[(map[x] as usize, i)]);
        hand_on(a, b)?;
    }
    Ok(())
}

/// The filters of heat and wave components on the eigenvalues of the sketch and on those of the mesh.
fn filters(descriptors: &Descriptors, common: &[f64], scaled: &[f64]) -> [[Mat<f64>; 2]; 2] {
    let times = match descriptors.hks.times {
        Some(range) => heat_kernel::times_between(range, descriptors.hks.count),
        None => heat_kernel::times(common, descriptors.hks.count),
    };
    // Heat is compared at the same times, waves at energies of the same rank in either spectrum.
    let ranks = common.len().min(scaled.len());
    let bands = [common, scaled].map(|eigenvalues| first_positive(&eigenvalues[..ranks]));
    let waves = if bands.contains(&None) { 0 } else { descriptors.wks.count };
    [common, scaled].map(|eigenvalues| {
        let energies = wave_kernel::energies(&eigenvalues[..ranks], waves, descriptors.wks.variance);
        [heat_kernel::filters(eigenvalues, &times), wave_kernel::filters(eigenvalues, &energies)]
    })
}

/// The coefficients of a region's indicator and of the heat and wave components within it.
fn of_region(region: &RegionProjection, filters: &[Mat<f64>; 2]) -> [Mat<f64>; 3] {
    let indicator = Mat::from_fn(region.indicator.len(), 1, |i, _| region.indicator[i]);
    [indicator, &region.gram * &filters[0], &region.gram * &filters[1]]
}

/// The columns of three matrices beside each other.
fn beside(blocks: [Mat<f64>; 3]) -> Mat<f64> {
    let widths = blocks.each_ref().map(Mat::ncols);
    Mat::from_fn(blocks[0].nrows(), widths.iter().sum(), |i, j| match j {
        j if j < widths[0] => blocks[0][(i, j)],
        j if j < widths[0] + widths[1] => blocks[1][(i, j - widths[0])],
        j => blocks[2][(i, j - widths[0] - widths[1])],
    })
}

/// What is known without the order of the regions, and the functions of every region of both shapes that has a vertex, in the
/// order of their numbers.
///
/// # Errors
/// As [`problem`].
pub(super) fn unordered(constraints: &Constraints<'_>, watch: &dyn Watch) -> Result<Unordered, MapError> {
    let Constraints { descriptors, spectra: [sketch, mesh], scaled, regions, .. } = *constraints;
    let known = without_regions(constraints, watch)?;
    let [of_sketch, of_mesh] = filters(descriptors, &sketch.eigenvalues, scaled);
    let blocks = |spectrum: &Spectrum, regions: &Regions, filters: &[Mat<f64>; 2]| {
        let projections = projections(spectrum, regions, watch)?;
        let block = |region: &RegionProjection| {
            let columns = of_region(region, filters);
            let scaled = columns.map(|columns| match descriptors.columns {
                Columns::Unit => unit_columns(columns),
                Columns::Raw => columns,
            });
            beside(scaled)
        };
        Ok::<_, MapError>(regions.numbers().into_iter().map(|number| block(&projections[number])).collect())
    };
    Ok(Unordered {
        known,
        sketch: blocks(sketch, &regions.sketch, &of_sketch)?,
        mesh: blocks(mesh, &regions.mesh, &of_mesh)?,
    })
}

/// What is known whatever part of the mesh is shown, and the functions of every pair of regions, of which those of the mesh count
/// where they are shown. Those of the sketch, at area 1, are smaller by the root of the `area` that the part has on the mesh.
///
/// # Errors
/// As [`problem`].
pub(super) fn partial<'a>(
    constraints: &Constraints<'a>,
    figure: &TriangleMesh,
    area: f64,
    watch: &dyn Watch,
) -> Result<Partial<'a>, MapError> {
    let Constraints { descriptors, spectra: [sketch, mesh], scaled, regions, .. } = *constraints;
    let known = without_regions(constraints, watch)?;
    let [of_sketch, of_mesh] = filters(descriptors, &sketch.eigenvalues, scaled);
    let (on_sketch, on_mesh) = (projections(sketch, &regions.sketch, watch)?, projections(mesh, &regions.mesh, watch)?);
    // The indicator is the 1 after the squares of the eigenfunctions, of which heat and waves are made.
    let l = mesh.len();
    let padded = |m: &Mat<f64>| Mat::from_fn(l + 1, m.ncols(), |i, j| if i < l { m[(i, j)] } else { 0.0 });
    let indicator = Mat::from_fn(l + 1, 1, |i, _| if i < l { 0.0 } else { 1.0 });
    let filters = beside([indicator, padded(&of_mesh[0]), padded(&of_mesh[1])]);
    let group = |pair: &RegionPair| {
        let a = beside(of_region(&on_sketch[pair.sketch], &of_sketch));
        let b = beside(of_region(&on_mesh[pair.mesh], &of_mesh));
        let (a, filters) = match descriptors.columns {
            Columns::Unit => (by_norms(&a, &a), by_norms(&filters, &b)),
            Columns::Raw => (a, filters.clone()),
        };
        Group { sketch: area.sqrt() * a, filters }
    };
    let of_region = |region: usize| regions.pairs.iter().position(|pair| pair.mesh == region);
    Ok(Partial {
        known,
        groups: regions.pairs.iter().map(group).collect(),
        basis: mesh.eigenfunctions.as_ref(),
        mass: &mesh.mass,
        group_of: (0..mesh.vertices()).map(|y| regions.mesh.region(y).and_then(of_region)).collect(),
        surface: Surface::of(figure),
    })
}

/// Functions that correspond, at the vertices of both shapes: the indicators of paired regions and some heat and wave components,
/// each in units of its root mean square.
pub(super) fn at_vertices(constraints: &Constraints<'_>) -> [Mat<f64>; 2] {
    let Constraints { descriptors, spectra: [sketch, mesh], scaled, regions, .. } = *constraints;
    let few = Descriptors {
        hks: Heat { count: descriptors.hks.count.min(COMPONENTS), ..descriptors.hks },
        wks: Wave { count: descriptors.wks.count.min(COMPONENTS), ..descriptors.wks },
        ..*descriptors
    };
    let [of_sketch, of_mesh] = filters(&few, &sketch.eigenvalues, scaled);
    let of_shape = |spectrum: &Spectrum, labels: &Regions, numbers: Vec<usize>, [heat, wave]: &[Mat<f64>; 2]| {
        let kernels = [heat, wave].map(|filters| at_points(spectrum, filters.as_ref()));
        let within = |x: usize, region: usize| if labels.region(x) == Some(region) { 1.0 } else { 0.0 };
        let widths = [numbers.len(), heat.ncols(), wave.ncols()];
        let mut functions = Mat::from_fn(spectrum.vertices(), widths.iter().sum(), |x, j| match j {
            j if j < widths[0] => within(x, numbers[j]),
            j if j < widths[0] + widths[1] => kernels[0][(x, j - widths[0])],
            j => kernels[1][(x, j - widths[0] - widths[1])],
        });
        for j in 0..functions.ncols() {
            // Heat that has long spread may be so little that its squares are 0.
            let largest = functions.col(j).norm_max();
            if largest > 0.0 {
                functions.col_mut(j).iter_mut().for_each(|f| *f /= largest);
                let squares: f64 = functions.col(j).iter().zip(&spectrum.mass).map(|(f, mass)| mass * f * f).sum();
                functions.col_mut(j).iter_mut().for_each(|f| *f /= squares.sqrt());
            }
        }
        functions
    };
    let pairs = &regions.pairs;
    [
        of_shape(sketch, &regions.sketch, pairs.iter().map(|pair| pair.sketch).collect(), &of_sketch),
        of_shape(mesh, &regions.mesh, pairs.iter().map(|pair| pair.mesh).collect(), &of_mesh),
    ]
}

/// How many corresponding functions there are of so many pairs of regions and points.
pub(super) fn count(settings: &Settings, pairs: usize, points: usize) -> usize {
    let Settings { descriptors, landmarks, functions, .. } = settings;
    let of_region = 1 + descriptors.hks.count + descriptors.wks.count;
    pairs * of_region + landmarks.len() * LANDMARK_TIMES + functions.len() + points
}

/// Numbers that a functional map keeps at its peak, about, beside the spectra: the projections of regions, the functions of those
/// that are looked at together, and of every function of every term an operator of either shape.
pub fn kept(settings: &Settings) -> usize {
    let Settings { basis, descriptors: Descriptors { hks, wks, .. }, .. } = settings;
    let regions = match &settings.regions {
        Method::Auto { count } => *count,
        Method::Segmented { sketch_regions, mesh_regions, .. } => *sketch_regions.max(mesh_regions),
        Method::Given { sketch, mesh } => {
            let last = sketch.iter().chain(mesh).max();
            last.map_or(0, |&last| usize::try_from(last.saturating_add(1)).unwrap_or(0))
        }
    };
    let (of_both, squares) = (basis.k + basis.k_mesh, basis.k.pow(2) + basis.k_mesh.pow(2));
    let in_turns = matches!(settings.regulariser, Regulariser::PermutedL1(_) | Regulariser::PartIndicator(_));
    let together = if in_turns { regions } else { 1 };
    let of_regions = regions * squares + together * of_both * (1 + hks.count + wks.count);
    let components = hks.count.min(COMPONENTS) + wks.count.min(COMPONENTS);
    let functions = settings.terms.iter().map(|term| match term {
        Term::Laplacian(_) => 1,
        Term::Descriptors(_) | Term::Orientation(_) => regions + components,
    });
    // The energy without what is found in turns, the first and that of the turn; or that of the bases and of coupled ones.
    let copies = match settings.basis.coupling {
        _ if in_turns => 3,
        Coupling::JointDiagonalisation { .. } => 2,
        Coupling::None {} => 1,
    };
    of_regions + copies * functions.sum::<usize>() * squares
}

/// Φᵀ M f of functions at the vertices.
fn coefficients(spectrum: &Spectrum, functions: &Mat<f64>) -> Mat<f64> {
    let weighed = Mat::from_fn(functions.nrows(), functions.ncols(), |x, f| spectrum.mass[x] * functions[(x, f)]);
    spectrum.eigenfunctions.transpose() * weighed
}

/// The functions of the user's own at the vertices of both shapes; none where there are none.
pub(super) fn given(functions: &[FunctionPair], figure: &Figure) -> Option<[Mat<f64>; 2]> {
    let first = functions.first()?;
    let sketch = Mat::from_fn(first.sketch.len(), functions.len(), |x, f| functions[f].sketch[x]);
    let at = |y: usize, f: usize| functions[f].mesh[figure.vertices[y] as usize];
    Some([sketch, Mat::from_fn(figure.vertices.len(), functions.len(), at)])
}

/// Every column to Euclidean norm 1; a column of zeros stays.
fn unit_columns(matrix: Mat<f64>) -> Mat<f64> {
    by_norms(&matrix, &matrix)
}

/// The columns of a matrix divided by the Euclidean norms of another's; 0 where that is 0.
fn by_norms(matrix: &Mat<f64>, other: &Mat<f64>) -> Mat<f64> {
    let norms: Vec<f64> = (0..other.ncols()).map(|j| norm(other.as_ref(), j)).collect();
    Mat::from_fn(matrix.nrows(), matrix.ncols(), |i, j| if norms[j] == 0.0 { 0.0 } else { matrix[(i, j)] / norms[j] })
}

fn norm(matrix: MatRef<'_, f64>, column: usize) -> f64 {
    matrix.col(column).norm_l2()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::solids::sheet;
    use crate::numerics::{Unwatched, random};
    use crate::pipeline::request::MatchRequest;
    use crate::spectral::{Boundary, spectrum};

    #[test]
    fn a_part_that_is_the_whole_mesh_gives_the_data_term_as_it_is() {
        let (k, meshes) = (7, [sheet(9, 4), sheet(6, 6)]);
        let spectra =
            meshes.each_ref().map(|mesh| spectrum(mesh, k, Boundary::Neumann, &Unwatched).unwrap().at_unit_area(k));
        let thirds = |n: usize| Regions::new((0..n).map(|x| x as i32 % 4 - 1).collect()).unwrap();
        let [on_sketch, on_mesh] = spectra.each_ref().map(|spectrum| thirds(spectrum.vertices()));
        let pairs = [[0, 2], [1, 0]].map(|[sketch, mesh]| RegionPair { sketch, mesh, cost: 0.0 }).into();
        let regions = Correspondence { sketch: on_sketch, mesh: on_mesh, pairs, cost: 0.0 };
        for columns in [Columns::Unit, Columns::Raw] {
            let settings = Settings::resolve(&MatchRequest::default()).unwrap();
            let constraints = Constraints {
                descriptors: &Descriptors { columns, ..settings.descriptors },
                spectra: [&spectra[0], &spectra[1]],
                scaled: &spectra[1].eigenvalues,
                regions: &regions,
                landmarks: &[[3, 5]],
                functions: None,
                points: None,
            };
            let whole = vec![1.0; spectra[1].vertices()];
            let as_part =
                partial(&constraints, &meshes[1], 1.0, &Unwatched).unwrap().problem(&whole, &Unwatched).unwrap();
            let as_it_is = problem(&constraints, &Unwatched).unwrap();
            let c = random::normal(k, k, 1);
            let (part, all) = (as_part.value(c.as_ref()), as_it_is.value(c.as_ref()));
            assert!((part - all).abs() < 1e-9 * all, "{columns:?}: {part} {all}");
        }
    }

    #[test]
    fn functions_of_terms_are_of_one_size_however_little_heat_is_left() {
        let meshes = [sheet(9, 4), sheet(12, 9)];
        let spectra =
            meshes.each_ref().map(|mesh| spectrum(mesh, 7, Boundary::Dirichlet, &Unwatched).unwrap().at_unit_area(7));
        let none = |n: usize| Regions::new(vec![Regions::NONE; n]).unwrap();
        let [sketch, mesh] = spectra.each_ref().map(|spectrum| none(spectrum.vertices()));
        let heat = r#"{"hks": {"count": 2, "times": [20, 1000]}, "wks": {"count": 0}}"#;
        let request =
            MatchRequest { descriptors: Some(serde_json::from_str(heat).unwrap()), ..MatchRequest::default() };
        let settings = Settings::resolve(&request).unwrap();
        let functions = at_vertices(&Constraints {
            descriptors: &settings.descriptors,
            spectra: [&spectra[0], &spectra[1]],
            scaled: &spectra[1].eigenvalues,
            regions: &Correspondence { sketch, mesh, pairs: Vec::new(), cost: 0.0 },
            landmarks: &[],
            functions: None,
            points: None,
        });
        for (functions, spectrum) in functions.iter().zip(&spectra) {
            let square = |j: usize| functions.col(j).iter().zip(&spectrum.mass).map(|(f, m)| m * f * f).sum::<f64>();
            // The last time leaves nothing at all.
            assert_eq!((functions.ncols(), functions.col(1).norm_max()), (2, 0.0));
            assert!((square(0) - 1.0).abs() < 1e-9, "{}", square(0));
        }
    }

    #[test]
    fn every_function_of_a_term_keeps_an_operator_of_either_shape() {
        let numbers = |rest: &str| {
            let request = format!(r#"{{"mesh": "", "sketch": "", "basis": {{"k": 30, "k_mesh": 40}}{rest}}}"#);
            kept(&Settings::resolve(&serde_json::from_str(&request).unwrap()).unwrap())
        };
        let (squares, regions) = (30 * 30 + 40 * 40, 7 * (30 * 30 + 40 * 40) + (30 + 40) * 201);
        assert_eq!(numbers(""), regions);
        let terms = r#", "terms": [{"type": "laplacian"}, {"type": "descriptors"}, {"type": "orientation"}]"#;
        assert_eq!(numbers(terms), regions + (1 + 2 * (7 + 16)) * squares);
        let in_turns = format!(r#"{terms}, "regulariser": {{"type": "part_indicator"}}"#);
        assert_eq!(numbers(&in_turns), regions + 6 * (30 + 40) * 201 + 3 * (1 + 2 * (7 + 16)) * squares);
    }
}
