//! What chooses between the attempts of an alignment, and what is trusted of the answer, fitted to cases whose truth is known.
//!
//! Cases are read from folders ([`cases`]), all their attempts weighed and judged here, and weights found that choose
//! those of least error ([`weights`]); and how far the answers are to be trusted ([`confidence`]). Half of the cases, by what they were drawn from, is held back: what gains on one
//! half and not on the other was fitted to the cases, not to the task.

pub mod cases;
pub mod confidence;
pub mod weights;

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use crate::alignment::prepared::{FlatShape, PreparedMesh};
use crate::alignment::{DOUBTS, Upright, Weighed, weighed};
use crate::mesh::figure::Figure;
use crate::numerics::{Unwatched, side_by_side};
use cases::{Case, mean};

/// A case that cannot be read or matched, and why.
#[derive(Debug, thiserror::Error)]
#[error("{}: {reason}", .path.display())]
pub struct Unreadable {
    pub path: PathBuf,
    pub reason: String,
}

impl Unreadable {
    pub fn new(path: &Path, reason: impl ToString) -> Unreadable {
        Unreadable { path: path.into(), reason: reason.to_string() }
    }
}

/// All attempts at a case, the answer first.
pub struct Judged {
    pub name: String,
    /// The folder of cases it is from.
    pub set: String,
    pub held_back: bool,
    pub attempts: Vec<Attempt>,
    /// What speaks against the answer at every place whose truth is known, and how far off it is.
    pub points: Vec<([f64; DOUBTS], f64)>,
}

/// An attempt, and how far off it is.
pub struct Attempt {
    /// As [`crate::alignment::Terms::values`].
    pub terms: Vec<f64>,
    /// Mean error in units of √area, of √(area / 2) where the truth says that one side is seen.
    pub error: f64,
}

impl Judged {
    /// The least error of the attempts.
    pub fn best(&self) -> f64 {
        self.attempts.iter().map(|attempt| attempt.error).fold(f64::INFINITY, f64::min)
    }
}

/// A mesh made ready, once for all cases.
struct Target {
    figure: Figure,
    prepared: PreparedMesh,
}

impl Target {
    fn read(path: &Path) -> Result<Target, Unreadable> {
        let mesh = cases::mesh(path)?;
        let figure = Figure::largest(&mesh);
        let prepared = PreparedMesh::new(&figure.mesh, &Unwatched).map_err(|error| Unreadable::new(path, error))?;
        Ok(Target { figure, prepared })
    }
}

/// All attempts at all cases, judged, in the order of the cases.
///
/// # Errors
/// The first mesh or sketch that cannot be read or laid.
pub fn judged(cases: &[Case]) -> Result<Vec<Judged>, Unreadable> {
    let mut paths: Vec<&Path> = cases.iter().map(|case| case.mesh.as_path()).collect();
    paths.sort_unstable();
    paths.dedup();
    let read = |path: &&Path| Target::read(path).map(|target| (path.to_path_buf(), target));
    let targets: HashMap<PathBuf, Target> = side_by_side(&paths, read).into_iter().collect::<Result<_, _>>()?;
    side_by_side(cases, |case| attempted(case, &targets[&case.mesh])).into_iter().collect()
}

fn attempted(case: &Case, target: &Target) -> Result<Judged, Unreadable> {
    let sketch = case.sketch()?;
    let unreadable = |error| Unreadable::new(&case.drawing, error);
    let shape = FlatShape::new(sketch.mesh(), &Unwatched).map_err(unreadable)?.with_eyes(sketch.eyes());
    let Target { figure, prepared } = target;
    let up = prepared.up(None);
    let upright =
        up.is_sure().then(|| Upright { sketch: shape.turned([0.0, 1.0]), mesh: prepared.axes.along(up.direction) });
    let (attempts, doubts) = weighed(&shape, prepared, upright, &Unwatched).map_err(unreadable)?;
    let places = sketch.points();
    let distance = |a: u32, b: u32| {
        let on_figure = |v: u32| figure.at(v);
        let (a, b) = (on_figure(a)?, on_figure(b)?);
        Some(prepared.distances.between(a as u32, b as u32))
    };
    let errors = |map: &[u32]| {
        let vertices: Vec<u32> = map.iter().map(|&v| figure.vertices[v as usize]).collect();
        case.truth.errors(&places, &vertices, &distance)
    };
    let points = attempts.first().map(|answer| errors(&answer.map)).unwrap_or_default();
    let judge =
        |Weighed { terms, map }: Weighed| Attempt { terms: terms.values().to_vec(), error: mean(&errors(&map)) };
    Ok(Judged {
        name: case.name.clone(),
        set: case.set.clone(),
        held_back: case.is_held_back(),
        points: points.into_iter().map(|(at, error)| (doubts[at], error)).collect(),
        attempts: attempts.into_iter().map(judge).collect(),
    })
}
