//! Which part of the mesh is matched.

use super::aligned::{Aligned, aligned};
use super::request::{Alignment, GivenMap};
use super::settings::Settings;
use super::stages::{Stage, Stages};
use super::{Fault, MatchError, Surroundings, landmarks};
use crate::mesh::connectivity::{Components, components};
use crate::mesh::figure::Figure;
use crate::mesh::file_mesh::FileMesh;
use crate::mesh::parts::figures;
use crate::numerics::Unwatched;
use crate::sketch::Sketch;

/// The part of the mesh that is matched, with what is known of it already.
pub(super) struct Chosen {
    pub figure: Figure,
    /// Pairs of vertices.
    pub landmarks: Vec<[usize; 2]>,
    /// Where the sketch was laid on several figures to find the one it shows.
    pub aligned: Option<Aligned>,
    /// Whether there was a choice.
    pub of_several: bool,
}

impl Chosen {
    /// The figure of the components the request names, else of those sets that may be one the figure on which the sketch
    /// lies best; without an alignment the likeliest.
    pub fn of(
        sketch: &Sketch,
        mesh: &FileMesh,
        settings: &Settings,
        stages: &Stages<'_>,
        surroundings: &Surroundings<'_>,
    ) -> Result<Chosen, MatchError> {
        let components = components(mesh.sound());
        surroundings.watcher.proceed(Stage::Spectrum, 0.0)?;
        let sets = candidates(settings, mesh, &components).map_err(MatchError::Faults)?;
        let of_several = sets.len() > 1 || settings.components.is_some();
        let sets = tried(&sets, settings);
        if let [set] = sets {
            let figure = match &set[..] {
                &[number] => Some(Figure::of_component(mesh, &components, number)),
                set => stages.run(Stage::Alignment, |watch| Figure::of_components(mesh, &components, set, watch))?,
            };
            let figure = figure.ok_or_else(|| MatchError::Faults(vec![nothing_around(set)]))?;
            let landmarks = landmarks::vertices(&settings.landmarks, sketch, &figure).map_err(MatchError::Faults)?;
            return Ok(Chosen { figure, landmarks, aligned: None, of_several });
        }
        stages.run(Stage::Alignment, |watch| {
            let mut best: Option<Chosen> = None;
            for set in sets {
                let Some(figure) = Figure::of_components(mesh, &components, set, watch)? else { continue };
                let landmarks =
                    landmarks::vertices(&settings.landmarks, sketch, &figure).map_err(MatchError::Faults)?;
                let laid = aligned(sketch, &figure, &landmarks, settings, surroundings, None, watch)?;
                if best.as_ref().is_none_or(|best| laid.alignment.score < best.score()) {
                    best = Some(Chosen { figure, landmarks, aligned: Some(laid), of_several: true });
                }
            }
            best.ok_or_else(|| MatchError::Faults(vec![nothing_around(&sets[0])]))
        })
    }

    /// The less the better.
    fn score(&self) -> f64 {
        self.aligned.as_ref().map_or(0.0, |aligned| aligned.alignment.score)
    }
}

/// The part of the mesh that a match was of, by the settings its result tells.
///
/// # Errors
/// [`MatchError::Faults`] where the mesh has no such part, which no result tells.
pub fn matched(mesh: &FileMesh, settings: &Settings) -> Result<Figure, MatchError> {
    let components = components(mesh.sound());
    let sets = candidates(settings, mesh, &components).map_err(MatchError::Faults)?;
    let set = &sets[0];
    let figure = Figure::of_components(mesh, &components, set, &Unwatched)?;
    figure.ok_or_else(|| MatchError::Faults(vec![nothing_around(set)]))
}

fn nothing_around(set: &[usize]) -> Fault {
    Fault::new("/components", format!("components {} do not enclose anything together", numbers(set)))
}

fn numbers(set: &[usize]) -> String {
    set.iter().map(usize::to_string).collect::<Vec<_>>().join(", ")
}

/// The sets of components that may be matched as asked, at least one: those the request names, or those that may be a
/// figure and have all landmarks on them.
///
/// # Errors
/// Components that there are not; landmarks that are on none, or on no figure together.
pub(super) fn candidates(
    settings: &Settings,
    mesh: &FileMesh,
    components: &Components,
) -> Result<Vec<Vec<usize>>, Vec<Fault>> {
    let count = components.list.len();
    let mut faults = Vec::new();
    let sets = match &settings.components {
        Some(named) => {
            for (i, number) in named.iter().enumerate().filter(|(_, number)| **number >= count) {
                let detail = format!("there is no component {number}: the mesh has {count}, counted from 0");
                faults.push(Fault::new(format!("/components/{i}"), detail));
            }
            let mut set = named.clone();
            set.sort_unstable();
            set.dedup();
            vec![set]
        }
        None => figures(mesh.sound(), components),
    };
    if !faults.is_empty() || settings.landmarks.is_empty() {
        return if faults.is_empty() { Ok(sets) } else { Err(faults) };
    }
    let of_vertex = components.of_vertices(mesh.sound());
    let mut fitting = sets.clone();
    for (i, landmark) in settings.landmarks.iter().enumerate() {
        let on: Vec<usize> = mesh.sound_vertices(landmark.mesh).map(|v| of_vertex[v as usize] as usize).collect();
        fitting.retain(|set| on.iter().any(|component| set.contains(component)));
        let pointer = format!("/landmarks/{i}/mesh");
        if on.is_empty() {
            faults.push(Fault::new(pointer, format!("vertex {} belongs to no face that is matched", landmark.mesh)));
        } else if !sets.iter().any(|set| on.iter().any(|component| set.contains(component))) {
            let detail = format!(
                "vertex {} is on component {}, what is matched is component {} of {count}: name those to match in \
                 `components`",
                landmark.mesh,
                on[0],
                numbers(&sets[0])
            );
            faults.push(Fault::new(pointer, detail));
        }
    }
    if faults.is_empty() && fitting.is_empty() {
        let detail =
            "the landmarks are on components that are not matched together: name those to match in `components`";
        faults.push(Fault::new("/landmarks", detail));
    }
    if faults.is_empty() { Ok(fitting) } else { Err(faults) }
}

/// The sets that the sketch is laid on to find the one it shows: without an alignment the likeliest alone.
fn tried<'a>(sets: &'a [Vec<usize>], settings: &Settings) -> &'a [Vec<usize>] {
    if settings.alignment == (Alignment::None {}) { &sets[..sets.len().min(1)] } else { sets }
}

/// The points of a map of the user's own as vertices of the figure; none where there are none.
///
/// # Errors
/// Every point that is not on the figure.
pub(super) fn given_points(settings: &Settings, figure: &Figure) -> Result<Option<Vec<u32>>, Vec<Fault>> {
    let Some(GivenMap::Points { mesh_vertices: vertices }) = &settings.given_map else { return Ok(None) };
    let off = vertices.iter().enumerate().filter(|(_, vertex)| figure.at(**vertex).is_none());
    let fault = |(x, vertex): (usize, &u32)| {
        let detail = format!("vertex {vertex} is not on the part of the mesh that is matched");
        Fault::new(format!("/given_map/mesh_vertices/{x}"), detail)
    };
    let faults: Vec<Fault> = off.map(fault).collect();
    let own = |&vertex: &u32| figure.at(vertex).map(|own| own as u32);
    if faults.is_empty() { Ok(vertices.iter().map(own).collect()) } else { Err(faults) }
}

/// What the shapes themselves rule out of a match: landmarks off the drawing or off the figure, components that there are
/// not, labels that contradict each other along a seam. Where it is known which component is matched also landmarks that contradict
/// each other and points of a given map that are not on it.
pub fn faults_on_shapes(settings: &Settings, sketch: &Sketch, mesh: &FileMesh) -> Vec<Fault> {
    let components = components(mesh.sound());
    let sets = candidates(settings, mesh, &components);
    let figure = match sets.as_ref().map(|sets| tried(sets, settings)) {
        Ok([set]) if let &[number] = &set[..] => Some(Figure::of_component(mesh, &components, number)),
        // To join some takes as long as many a match.
        _ => None,
    };
    let mut faults = match &figure {
        Some(figure) => {
            let of_landmarks = landmarks::vertices(&settings.landmarks, sketch, figure).err();
            of_landmarks.into_iter().chain(given_points(settings, figure).err()).flatten().collect()
        }
        None => landmarks::off_the_drawing(&settings.landmarks, sketch),
    };
    faults.extend(sets.err().into_iter().flatten());
    if let super::request::Regions::Given { mesh: labels, .. } = &settings.regions {
        faults.extend(super::regions::labels_of_vertices(labels, mesh).err().into_iter().flatten());
    }
    faults
}
