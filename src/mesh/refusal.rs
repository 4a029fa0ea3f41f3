//! Why a mesh is refused, and what the user is told of one that is taken.

use std::fmt;

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// Where in the user's file something was found. What does not apply is left out.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[schema(as = MeshPlace)]
pub struct Place {
    /// Line of a text file, from 1.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub line: Option<u64>,
    /// Face in the order of the file, from 0.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub face: Option<u64>,
    /// Vertices in the order of the file, from 0: one vertex, or the two ends of an edge.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub vertices: Vec<u64>,
}

impl Place {
    /// The file as a whole.
    pub fn file() -> Place {
        Place::default()
    }

    pub fn line(line: u64) -> Place {
        Place { line: Some(line), ..Place::default() }
    }

    pub fn face(face: usize) -> Place {
        Place { face: Some(face as u64), ..Place::default() }
    }

    pub fn vertex(vertex: usize) -> Place {
        Place { vertices: vec![vertex as u64], ..Place::default() }
    }

    pub fn edge(a: u32, b: u32) -> Place {
        Place { vertices: vec![a.into(), b.into()], ..Place::default() }
    }
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let line = self.line.map(|line| format!("line {line}"));
        let face = self.face.map(|face| format!("face {face}"));
        let vertices = match self.vertices.as_slice() {
            [] => None,
            [v] => Some(format!("vertex {v}")),
            [a, b] => Some(format!("edge {a}–{b}")),
            more => Some(format!("vertices {more:?}")),
        };
        let parts: Vec<String> = [line, face, vertices].into_iter().flatten().collect();
        f.write_str(if parts.is_empty() { "file".into() } else { parts.join(", ") }.as_str())
    }
}

/// One reason why a mesh is refused.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[schema(as = MeshFault)]
pub struct Fault {
    pub place: Place,
    pub detail: String,
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.place, self.detail)
    }
}

/// The reasons against a mesh in the order they were found: the first [`Faults::LISTED`] and the number of all others,
/// so that a hostile file cannot make a long answer.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[schema(as = MeshFaults)]
pub struct Faults {
    pub listed: Vec<Fault>,
    /// Faults found besides the listed ones.
    pub unlisted: u64,
}

impl Faults {
    /// Most faults that are told one by one.
    pub const LISTED: usize = 100;

    pub fn push(&mut self, place: Place, detail: impl Into<String>) {
        if self.listed.len() < Self::LISTED {
            self.listed.push(Fault { place, detail: detail.into() });
        } else {
            self.unlisted += 1;
        }
    }

    pub fn is_empty(&self) -> bool {
        self.listed.is_empty()
    }

    /// Nothing where there are no faults, else the refusal that holds them.
    pub fn into_result(self) -> Result<(), Refusal> {
        if self.is_empty() { Ok(()) } else { Err(Refusal::Invalid(self)) }
    }
}

impl fmt::Display for Faults {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let reasons: Vec<String> = self.listed.iter().map(Fault::to_string).collect();
        f.write_str(&reasons.join("; "))?;
        if self.unlisted > 0 {
            write!(f, "; and {} more", self.unlisted)?;
        }
        Ok(())
    }
}

/// Why there is no mesh.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Refusal {
    /// More of something than the limits allow: HTTP 413.
    #[error("{found} {unit}, more than the {limit} that are accepted")]
    TooLarge { unit: &'static str, found: u64, limit: u64 },
    /// Not a valid mesh: every reason with its place.
    #[error("{0}")]
    Invalid(Faults),
}

impl Refusal {
    /// The refusal for a single reason.
    pub fn because(place: Place, detail: impl Into<String>) -> Refusal {
        Refusal::Invalid(Faults { listed: vec![Fault { place, detail: detail.into() }], unlisted: 0 })
    }
}

/// What was mended, or is to be known about a mesh that was taken.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[schema(as = MeshWarning)]
pub struct Warning {
    pub code: WarningCode,
    pub detail: String,
    /// The first [`Warning::PLACES`] of the places.
    pub places: Vec<Place>,
}

impl Warning {
    /// Most places that a warning tells one by one.
    pub const PLACES: usize = 20;

    pub fn new(code: WarningCode, detail: impl Into<String>, places: impl IntoIterator<Item = Place>) -> Warning {
        Warning { code, detail: detail.into(), places: places.into_iter().take(Self::PLACES).collect() }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
#[schema(as = MeshWarningCode)]
pub enum WarningCode {
    /// Mended: a face that occurs again was dropped.
    DuplicateFaces,
    /// Mended: faces without area or with the same corner twice were left out, or kept only for what they join.
    DegenerateFaces,
    /// Mended: faces that cross themselves were cut into triangles as well as it goes.
    CrossingFaces,
    /// Mended: edges of more than two faces were cut, so that each has two at most.
    CutEdges,
    /// Mended: parts of the surface that met in a point only were parted.
    SplitVertices,
    /// Mended: a one-sided surface was cut open.
    OneSided,
    /// Mended: faces were turned over to agree with their component.
    FlippedWinding,
    /// Mended: vertices of no face keep their ids and take no part in the match.
    UnreferencedVertices,
    /// Mended: vertices along seams became one, which the lowest of them stands for.
    MergedVertices,
    /// Mended: of more triangles than are matched the surface was made coarser, vertices that are left stand for the others.
    Decimated,
    /// Lines, points or other elements of the file that are no faces were left out.
    IgnoredElements,
    /// The mesh is in several components, of which not all may be matched.
    SeveralComponents,
    /// Components of less than a thousandth of the area.
    IsolatedSpecks,
}
