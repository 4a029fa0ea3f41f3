//! One match from beginning to end.

use std::sync::Arc;

use faer::Mat;

use super::aligned::{Aligned, aligned};
use super::bases::{ASKED_BY, at_unit_area, both};
use super::constraints::{Constraints, Points as AlignedPoints, given, spectral_scale};
use super::figure::{Chosen, given_points};
use super::map::{Energy, Mapped, Together};
use super::outcome::{Correspondence, Intermediate, MatchResult, Matrix, PairedRegions, Rating, Solver};
use super::regions::{self, Shape};
use super::request::{Alignment, Conversion, GivenMap, Refinement, Regions, Within};
use super::settings::{Settings, check, upsampled};
use super::stages::{Stage, Stages};
use super::{MatchError, Surroundings};
use crate::alignment::Place;
use crate::correspondence::{confidence, functional_map, icp, points, zoomout};
use crate::mesh::figure::Figure;
use crate::mesh::file_mesh::FileMesh;
use crate::numerics::Watch;
use crate::sketch::Sketch;
use crate::spectral::Spectrum;

/// Landmarks that a warning names at most.
const NAMED: usize = 10;
/// The value of the part's indicator, from 0 to 1, from which a vertex is on it rather than off it.
const ON_PART: f64 = 0.5;

/// The match of a sketch and a mesh; the same input gives the same answer but for `timings_ms`.
///
/// # Errors
/// [`MatchError`].
pub fn run(
    sketch: &Sketch,
    mesh: &FileMesh,
    settings: &Settings,
    surroundings: &Surroundings<'_>,
) -> Result<MatchResult, MatchError> {
    let faults = check(settings, sketch.mesh().positions().len(), mesh.positions().len());
    if !faults.is_empty() {
        return Err(MatchError::Faults(faults));
    }
    let stages = Stages::begin(surroundings);
    let mut chosen = Chosen::of(sketch, mesh, settings, &stages, surroundings)?;
    let laid = chosen.aligned.take();
    let full = stages.run(Stage::Spectrum, |watch| spectra(settings, sketch, &chosen.figure, surroundings, watch))?;
    let matching = Matching::new(sketch, mesh, settings, chosen, full);
    let first = surroundings.preview.map(|preview| {
        let (matching, stages) = (&matching, &stages);
        move |aligned: Aligned| {
            // Who is asked to stop, and what fails at first sight, is found out by the answer itself.
            if let Ok(answer) = matching.answer(Some(&aligned), stages.within(Stage::Alignment)) {
                preview(MatchResult { preview: true, ..answer });
            }
        }
    });
    let first = first.as_ref().map(|first| first as &dyn Fn(Aligned));
    let aligned = match settings.alignment {
        Alignment::View { .. } if laid.is_some() => laid,
        Alignment::View { .. } => Some(stages.run(Stage::Alignment, |watch| {
            let Chosen { figure, landmarks, .. } = &matching.chosen;
            aligned(sketch, figure, landmarks, settings, surroundings, first, watch)
        })?),
        Alignment::None {} => None,
    };
    matching.answer(aligned.as_ref(), stages)
}

/// A sketch and a figure whose spectra are known.
struct Matching<'a> {
    sketch: &'a Sketch,
    mesh: &'a FileMesh,
    settings: &'a Settings,
    chosen: Chosen,
    /// As long as refinement needs them, in the units of the files.
    full: [Arc<Spectrum>; 2],
    /// At area 1, of the lengths of C.
    bases: [Spectrum; 2],
    /// The factor on the mesh's eigenvalues that descriptors are made with.
    scale: f64,
}

impl<'a> Matching<'a> {
    fn new(
        sketch: &'a Sketch,
        mesh: &'a FileMesh,
        settings: &'a Settings,
        chosen: Chosen,
        full: [Arc<Spectrum>; 2],
    ) -> Matching<'a> {
        let bases = at_unit_area(&full, [settings.basis.k, settings.basis.k_mesh]);
        let [phi, psi] = &bases;
        let areas = [sketch.mesh().area(), chosen.figure.mesh.area()];
        let scale = spectral_scale(settings.descriptors.spectral_scale, &phi.eigenvalues, &psi.eigenvalues, areas);
        Matching { sketch, mesh, settings, chosen, full, bases, scale }
    }

    /// The stages after the alignment, where there is one.
    fn answer(&self, aligned: Option<&Aligned>, stages: Stages<'_>) -> Result<MatchResult, MatchError> {
        let Matching { sketch, mesh, settings, chosen, full, bases, scale } = self;
        let Chosen { figure, landmarks, of_several, .. } = chosen;
        let [phi, psi] = bases;
        let scaled: Vec<f64> = psi.eigenvalues.iter().map(|l| scale * l).collect();
        let regions = stages.run(Stage::Regions, |watch| {
            let [flat, solid] = [(sketch.mesh(), phi), (&figure.mesh, psi)];
            let [flat, solid] = [flat, solid].map(|(mesh, spectrum)| Shape { mesh, spectrum });
            regions::Correspondence::find(settings, flat, solid, (mesh, figure), aligned, &scaled, watch)
        })?;
        let laid = aligned.zip(weight(&settings.alignment));
        let functions = given(&settings.functions, figure);
        let own = own_map(settings, bases, figure)?;
        let constraints = Constraints {
            descriptors: &settings.descriptors,
            spectra: [phi, psi],
            scaled: &scaled,
            regions: &regions,
            landmarks,
            functions: functions.as_ref(),
            points: laid.map(|(aligned, weight)| AlignedPoints { map: &aligned.alignment.map, weight }),
        };
        let meshes = [sketch.mesh(), &figure.mesh];
        let energy = stages.run(Stage::Descriptors, |watch| Energy::of(settings, &constraints, meshes, watch))?;
        let Mapped { start, weights: w, solution, together } =
            stages.run(Stage::Map, |watch| energy.minimiser(settings, &constraints, own, watch))?;
        let (pairs, part) = match together {
            Together::Nothing => (None, None),
            Together::Pairs(pairs) => (Some(pairs), None),
            Together::Part(part) => (None, Some(part)),
        };
        let part = part.as_deref();
        let mut points = stages.run(Stage::Points, |watch| {
            let sizes = upsampled(settings);
            let longer = (sizes != (settings.basis.k, settings.basis.k_mesh)).then(|| at_unit_area(full, sizes.into()));
            points(
                settings,
                sketch,
                longer.as_ref().unwrap_or(bases),
                Showing { aligned, regions: &regions, part },
                solution.c,
                watch,
            )
        })?;
        // What the user knows is not traded for anything.
        landmarks.iter().for_each(|&[x, y]| (points.map[x], points.places[x]) = (y as u32, None));
        // But where most of it contradicts a landmark, its answer is not to be relied on.
        let at_odds = aligned.map_or(&[][..], |aligned| &aligned.alignment.at_odds);
        at_odds.iter().for_each(|&i| points.confidence[landmarks[i][0]] = 0.0);

        let confidence: f64 = phi.mass.iter().zip(&points.confidence).map(|(mass, confidence)| mass * confidence).sum();
        let calibrated = aligned.is_some() && settings.conversion == (Conversion::Alignment {});
        let components = of_several.then(|| figure.components.clone());
        Ok(MatchResult {
            id: None,
            version: Some(env!("CARGO_PKG_VERSION").to_owned()),
            preview: false,
            sketch: settings.sketch.clone(),
            mesh: settings.mesh.clone(),
            request: Settings { components, ..(*settings).clone() },
            c: Matrix::from(points.c.as_ref()),
            correspondences: holding(correspondences(sketch, figure, &points), settings, landmarks),
            confidence,
            rating: calibrated.then(|| Rating::of(confidence)),
            alignment: aligned.map(|aligned| aligned.report(figure)),
            alternatives: aligned.map_or_else(Vec::new, |aligned| aligned.alternatives(figure)),
            solver: Solver::new(settings.regulariser.name(), solution.report),
            intermediate: Intermediate {
                sketch_eigenvalues: phi.eigenvalues.clone(),
                mesh_eigenvalues: psi.eigenvalues.clone(),
                spectral_scale: *scale,
                regions: PairedRegions { pairs: pairs.unwrap_or(regions.pairs.clone()), ..regions.reported(figure) },
                initial_c: Matrix::from(start.as_ref()),
                weights: Matrix::from(w.as_ref()),
                part: part.map(|part| figure.of_file().map(|own| own.map_or(0.0, |own| part[own])).collect()),
            },
            warnings: warnings(settings, figure, &regions, aligned),
            timings_ms: stages.finish(),
        })
    }
}

/// What the aligned points weigh in the data term, where they are in it.
pub(super) fn weight(alignment: &Alignment) -> Option<f64> {
    match alignment {
        Alignment::View { weight } => Some(*weight).filter(|weight| *weight > 0.0),
        Alignment::None {} => None,
    }
}

/// The C that the user gives, or that of the points given.
///
/// # Errors
/// [`MatchError::Faults`] where points are not on the figure.
fn own_map(settings: &Settings, [phi, psi]: &[Spectrum; 2], figure: &Figure) -> Result<Option<Mat<f64>>, MatchError> {
    if let Some(GivenMap::C { rows }) = &settings.given_map {
        return Ok(Some(Mat::from_fn(psi.len(), phi.len(), |i, j| rows[i][j])));
    }
    let of_points =
        |map: Vec<u32>| functional_map(phi.eigenfunctions.as_ref(), &phi.mass, psi.eigenfunctions.as_ref(), &map);
    Ok(given_points(settings, figure).map_err(MatchError::Faults)?.map(of_points))
}

/// The spectra of both shapes, as long as refinement needs them, in the units of their files.
fn spectra(
    settings: &Settings,
    sketch: &Sketch,
    figure: &Figure,
    surroundings: &Surroundings<'_>,
    watch: &dyn Watch,
) -> Result<[Arc<Spectrum>; 2], MatchError> {
    let (k, l) = upsampled(settings);
    let upsampled = (k, l) != (settings.basis.k, settings.basis.k_mesh);
    let asked_by = if upsampled { ["/refinement/k"; 2] } else { ASKED_BY };
    both(surroundings.spectra, (sketch, figure), [k, l], settings.basis.boundary, asked_by, watch)
}

/// The refined map, the vertex of the figure for every vertex of the sketch, and how far each is to be trusted.
struct Points {
    c: Mat<f64>,
    map: Vec<u32>,
    /// Where each lies between the vertices, where that is known.
    places: Vec<Option<Place>>,
    confidence: Vec<f64>,
}

/// What tells which part of the mesh the sketch shows.
#[derive(Clone, Copy)]
struct Showing<'a> {
    aligned: Option<&'a Aligned>,
    regions: &'a regions::Correspondence,
    /// As [`Together::Part`].
    part: Option<&'a [f64]>,
}

impl Showing<'_> {
    /// The vertices that answers are looked for among, of n: of the part that was found, or those seen where an alignment says so;
    /// none where that is all or nothing.
    fn answering(&self, n: usize) -> Option<Vec<u32>> {
        let found = self.part.map(|part| (0..n as u32).filter(|&v| part[v as usize] >= ON_PART).collect::<Vec<u32>>());
        let seen = || self.aligned.map(|aligned| aligned.visible.clone());
        found.or_else(seen).filter(|part| !part.is_empty() && part.len() < n)
    }

    /// The same, or where nothing tells those in a region.
    fn shown(&self, n: usize) -> Option<Vec<u32>> {
        let in_region =
            || (0..n as u32).filter(|&v| self.regions.mesh.region(v as usize).is_some()).collect::<Vec<u32>>();
        Some(self.answering(n).unwrap_or_else(in_region)).filter(|part| !part.is_empty() && part.len() < n)
    }
}

/// The points of the map C, refined to these bases at area 1.
fn points(
    settings: &Settings,
    sketch: &Sketch,
    [phi, psi]: &[Spectrum; 2],
    showing: Showing<'_>,
    c: Mat<f64>,
    watch: &dyn Watch,
) -> Result<Points, MatchError> {
    let (basis, mass) = (phi.eigenfunctions.as_ref(), &phi.mass);
    let target = psi.eigenfunctions.as_ref();
    let c = match settings.refinement {
        Refinement::None {} => c,
        Refinement::Icp { iterations } => icp::refined(c, basis, mass, target, iterations, watch)?,
        Refinement::Zoomout { within, .. } => {
            let part = match within {
                Within::Mesh => None,
                Within::Part => showing.shown(target.nrows()),
            };
            zoomout::refined(c, basis, mass, target, part.as_deref(), watch)?
        }
    };
    if let (Conversion::Alignment {}, Some(Aligned { alignment, .. })) = (&settings.conversion, showing.aligned) {
        let (places, confidence) = (alignment.places.clone(), alignment.confidence.clone());
        return Ok(Points { c, map: alignment.map.clone(), places, confidence });
    }
    // Only vertices of the part that is seen can be answers.
    let seen = showing.answering(target.nrows());
    let rows = seen.as_ref().map(|seen| Mat::from_fn(seen.len(), target.ncols(), |i, j| target[(seen[i] as usize, j)]));
    let among = rows.as_ref().map_or(target, Mat::as_ref);
    let found = match settings.conversion {
        Conversion::Indicator {} => points::by_indicator(c.as_ref(), basis, among, watch)?,
        Conversion::Nearest {} | Conversion::Alignment {} => {
            points::by_nearest_neighbour(c.as_ref(), basis, among, watch)?
        }
    };
    let map: Vec<u32> = found.into_iter().map(|i| seen.as_ref().map_or(i, |seen| seen[i as usize])).collect();
    let flat = sketch.mesh();
    let confidence = confidence::of_points(c.as_ref(), basis, target, &map, flat.positions(), flat.area(), watch)?;
    Ok(Points { c, places: vec![None; map.len()], map, confidence })
}

fn correspondences(sketch: &Sketch, figure: &Figure, points: &Points) -> Vec<Correspondence> {
    let mut corner_of = vec![[0; 3]; figure.vertices.len()];
    figure
        .mesh
        .triangles()
        .iter()
        .for_each(|triangle| triangle.iter().for_each(|&v| corner_of[v as usize] = *triangle));
    let of_file = |v: u32| figure.vertices[v as usize];
    (0..points.map.len())
        .map(|x| {
            let y = points.map[x];
            let place = points.places[x].unwrap_or_else(|| Place::corner(y, corner_of[y as usize]));
            Correspondence {
                sketch_vertex: x as u32,
                point: sketch.point(x),
                mesh_vertex: of_file(y),
                triangle: Some(place.triangle.map(of_file)),
                barycentric: Some(place.weights),
                confidence: points.confidence[x],
            }
        })
        .collect()
}

/// The same with every landmark's own vertex of the file as its answer: of a figure joined of components or made coarser another
/// may answer for its vertex.
fn holding(mut answers: Vec<Correspondence>, settings: &Settings, landmarks: &[[usize; 2]]) -> Vec<Correspondence> {
    for (landmark, &[x, _]) in settings.landmarks.iter().zip(landmarks) {
        let Correspondence { mesh_vertex, triangle, .. } = &mut answers[x];
        let other = std::mem::replace(mesh_vertex, landmark.mesh);
        triangle.iter_mut().flatten().filter(|corner| **corner == other).for_each(|corner| *corner = landmark.mesh);
    }
    answers
}

fn warnings(
    settings: &Settings,
    figure: &Figure,
    regions: &regions::Correspondence,
    aligned: Option<&Aligned>,
) -> Vec<String> {
    let mut warnings = Vec::new();
    let at_odds = aligned.map_or(&[][..], |aligned| &aligned.alignment.at_odds);
    if !at_odds.is_empty() {
        let places: Vec<String> = at_odds.iter().take(NAMED).map(|i| format!("/landmarks/{i}")).collect();
        let more = if at_odds.len() > NAMED { format!(" and {} more", at_odds.len() - NAMED) } else { String::new() };
        warnings.push(format!("landmarks that contradict most others by their distances: {}{more}", places.join(", ")));
    }
    let (all, besides) = (figure.of_file().len(), figure.of_file().filter(Option::is_none).count());
    if besides > 0 {
        warnings.push(format!("{besides} of the {all} vertices of the mesh are not on the component that is matched"));
    }
    let found = [regions.sketch.count(), regions.mesh.count()];
    for ((shape, found), asked) in ["sketch", "mesh"].into_iter().zip(found).zip(asked_regions(settings)) {
        if let Some(asked) = asked.filter(|asked| found < *asked) {
            warnings.push(format!("{found} regions were found on the {shape} where {asked} were asked for"));
        }
    }
    warnings
}

/// The regions that sketch and mesh were to be segmented into; nothing of a shape that was not: given labels are taken as they
/// are, and with an alignment those of the sketch are carried to the mesh.
fn asked_regions(settings: &Settings) -> [Option<usize>; 2] {
    match (&settings.regions, &settings.alignment) {
        (Regions::Auto { count }, Alignment::View { .. }) => [Some(*count), None],
        (Regions::Auto { count }, Alignment::None {}) => [Some(*count); 2],
        (Regions::Segmented { sketch_regions, mesh_regions, .. }, _) => [Some(*sketch_regions), Some(*mesh_regions)],
        (Regions::Given { .. }, _) => [None; 2],
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pipeline::request::MatchRequest;

    #[test]
    fn regions_are_asked_for_of_every_shape_that_is_segmented() {
        let asked = |text: &str| {
            let request: MatchRequest = serde_json::from_str(text).unwrap();
            asked_regions(&Settings::resolve(&request).unwrap())
        };
        assert_eq!(asked(r#"{"mesh": "", "sketch": ""}"#), [Some(7), None]);
        assert_eq!(asked(r#"{"mesh": "", "sketch": "", "preset": "thesis"}"#), [Some(7); 2]);
        let segmented = r#"{"method": "segmented", "sketch_regions": 5, "mesh_regions": 6, "pairs": [[0, 0]]}"#;
        assert_eq!(asked(&format!(r#"{{"mesh": "", "sketch": "", "regions": {segmented}}}"#)), [Some(5), Some(6)]);
    }
}
