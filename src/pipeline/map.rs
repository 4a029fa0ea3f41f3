//! The energy of a request and its minimiser.

use faer::Mat;

use super::constraints::{Constraints, at_vertices, partial, problem, unordered};
use super::request::Coupling;
use super::settings::Settings;
use super::{Fault, MatchError};
use crate::functional_map::coupling::{Coupling as Coupled, coupled};
use crate::functional_map::part::{Partial, Shown, shown};
use crate::functional_map::permutation::{Pair, Unordered, ordered};
use crate::functional_map::problem::{Problem, Seen, least_squares};
use crate::functional_map::regulariser::{PartIndicator, PermutedL1, Regulariser};
use crate::functional_map::solve::{Solution, solve};
use crate::functional_map::term::Shape;
use crate::functional_map::weights::weights;
use crate::mesh::TriangleMesh;
use crate::numerics::{Report, Stopped, Watch};
use crate::regions::Regions;
use crate::regions::pairing::RegionPair;
use crate::spectral::Spectrum;

/// Vertices of either shape that sums over both are taken over, about.
const SAMPLES: usize = 300;

/// Regions of either shape whose order can be found: the functions of all are in memory at once.
const MOST_UNORDERED: usize = 16;

/// What is to be minimised.
pub(super) enum Energy<'a> {
    /// In C.
    Ordered(Problem),
    /// In C and the order of the regions.
    Unordered(Unordered, PermutedL1),
    /// In C and the part of the mesh that is shown.
    Partial(Box<Partial<'a>>, PartIndicator),
}

/// The functional map, and what it was found with.
pub(super) struct Mapped {
    /// C⁰.
    pub start: Mat<f64>,
    pub weights: Mat<f64>,
    pub solution: Solution,
    /// What was found together with C.
    pub together: Together,
}

/// What is found together with C by some regularisers.
pub(super) enum Together {
    Nothing,
    /// The order of the regions.
    Pairs(Vec<RegionPair>),
    /// How much every vertex of the figure belongs to the part that is shown, from 0 to 1.
    Part(Vec<f64>),
}

impl<'a> Energy<'a> {
    /// The data term of constraints on these two shapes, with the terms that settings add.
    ///
    /// # Errors
    /// [`MatchError`]: more regions than can be put in order, or the watcher cancels.
    pub fn of(
        settings: &Settings,
        constraints: &Constraints<'a>,
        meshes: [&TriangleMesh; 2],
        watch: &dyn Watch,
    ) -> Result<Energy<'a>, MatchError> {
        let mut energy = match settings.regulariser {
            // Of a map of the user's own nothing is to be found together with it.
            _ if settings.given_map.is_some() => Energy::Ordered(problem(constraints, watch)?),
            Regulariser::PermutedL1(term) => {
                let most = constraints.regions.sketch.numbers().len().max(constraints.regions.mesh.numbers().len());
                if most > MOST_UNORDERED {
                    let detail = format!("{most} regions are too many to put in order: {MOST_UNORDERED} at most");
                    return Err(MatchError::Faults(vec![Fault::new("/regions", detail)]));
                }
                Energy::Unordered(unordered(constraints, watch)?, term)
            }
            Regulariser::PartIndicator(term) => {
                Energy::Partial(Box::new(partial(constraints, meshes[1], term.area, watch)?), term)
            }
            _ => Energy::Ordered(problem(constraints, watch)?),
        };
        let problem = match &mut energy {
            Energy::Ordered(problem) => problem,
            Energy::Unordered(unordered, _) => &mut unordered.known,
            Energy::Partial(partial, _) => &mut partial.known,
        };
        let [sketch, mesh] = constraints.spectra;
        problem.see(seen(constraints.spectra, constraints.scaled));
        if !settings.terms.is_empty() {
            let functions = at_vertices(constraints);
            let shape = |i: usize, spectrum, eigenvalues| Shape {
                mesh: meshes[i],
                spectrum,
                eigenvalues,
                functions: &functions[i],
            };
            let shapes = [shape(0, sketch, sketch.eigenvalues.as_slice()), shape(1, mesh, constraints.scaled)];
            for term in &settings.terms {
                watch.proceed(0.0)?;
                term.commutators(shapes, watch)?.into_iter().try_for_each(|commutator| problem.commute(commutator))?;
            }
        }
        Ok(energy)
    }

    /// The minimiser, from the pairs of the constraints where their order counts; or the user's `own` map, whose energy is told.
    ///
    /// # Errors
    /// [`MatchError`]: a decomposition does not converge, or the watcher cancels.
    pub fn minimiser(
        &self,
        settings: &Settings,
        constraints: &Constraints<'_>,
        own: Option<Mat<f64>>,
        watch: &dyn Watch,
    ) -> Result<Mapped, MatchError> {
        let eigenvalues = &constraints.spectra[0].eigenvalues;
        let w = |start: &Mat<f64>| weights(&settings.weights, start.as_ref(), eigenvalues, constraints.scaled);
        match self {
            Energy::Unordered(unordered, term) => {
                // Numbers that no vertex has are no regions: the others are counted through, and told by their own.
                let [sketch, mesh] = [&constraints.regions.sketch, &constraints.regions.mesh].map(Regions::numbers);
                let known = constraints.regions.pairs.iter();
                let place = |pair: &RegionPair| {
                    Some([sketch.binary_search(&pair.sketch).ok()?, mesh.binary_search(&pair.mesh).ok()?])
                };
                let found = ordered(unordered, term, known.filter_map(place).collect(), &w, watch)?;
                let pair = |&[r, s]: &Pair| RegionPair { sketch: sketch[r], mesh: mesh[s], cost: 0.0 };
                let pairs = Together::Pairs(found.pairs.iter().map(pair).collect());
                Ok(Mapped { start: found.start, weights: found.weights, solution: found.solution, together: pairs })
            }
            Energy::Partial(partial, term) => {
                let Shown { part, start, weights, solution } = shown(partial, term, &w, watch)?;
                Ok(Mapped { start, weights, solution, together: Together::Part(part) })
            }
            Energy::Ordered(problem) => {
                let start = least_squares(problem)?;
                if let (Coupling::JointDiagonalisation { weight }, None) = (settings.basis.coupling, &own) {
                    return coupled_minimiser(problem, &settings.regulariser, (settings, weight), start, watch);
                }
                let weights = w(&start);
                if let Some(c) = own {
                    // The objective is that of the data and of the terms that are added to it.
                    let report =
                        Report { iterations: 0, history: vec![problem.value(c.as_ref())], stopped: Stopped::Converged };
                    return Ok(Mapped {
                        start,
                        weights,
                        solution: Solution { c, report },
                        together: Together::Nothing,
                    });
                }
                let solution = solve(problem, &settings.regulariser, &weights, start.clone(), watch)?;
                Ok(Mapped { start, weights, solution, together: Together::Nothing })
            }
        }
    }
}

/// The minimiser in coupled bases, brought back to the eigenfunctions; W is that of the coupled bases, for eigenvalues as their
/// Laplacians have them on the diagonal.
fn coupled_minimiser(
    problem: &Problem,
    regulariser: &Regulariser,
    (settings, weight): (&Settings, f64),
    start: Mat<f64>,
    watch: &dyn Watch,
) -> Result<Mapped, MatchError> {
    let [sketch, mesh] = &problem.seen().eigenvalues;
    let Coupled { p, q } = coupled([sketch, mesh], problem.cross(), weight, watch)?;
    let turned = problem.turned(p.as_ref(), q.as_ref());
    let c0 = q.transpose() * &start * &p;
    let [along_sketch, along_mesh] = &turned.seen().eigenvalues;
    let weights = weights(&settings.weights, c0.as_ref(), along_sketch, along_mesh);
    let Solution { c, report } = solve(&turned, regulariser, &weights, c0, watch)?;
    let solution = Solution { c: &q * c * p.transpose(), report };
    Ok(Mapped { start, weights, solution, together: Together::Nothing })
}

/// What energies see of the bases.
fn seen([sketch, mesh]: [&Spectrum; 2], scaled: &[f64]) -> Seen {
    let largest = sketch.eigenvalues.iter().chain(scaled).copied().fold(f64::MIN_POSITIVE, f64::max);
    let shares = |eigenvalues: &[f64]| eigenvalues.iter().map(|eigenvalue| eigenvalue / largest).collect();
    let sample = |spectrum: &Spectrum| {
        let step = spectrum.vertices().div_ceil(SAMPLES).max(1);
        let count = spectrum.vertices().div_ceil(step);
        Mat::from_fn(count, spectrum.len(), |i, j| spectrum.eigenfunctions[(i * step, j)])
    };
    Seen { eigenvalues: [shares(&sketch.eigenvalues), shares(scaled)], samples: [sample(sketch), sample(mesh)] }
}
