//! The file formats a mesh arrives in, read to vertices and polygons that are still unproven.

pub mod foreign;
mod glb;
mod obj;
mod off;
mod ply;
mod stl;
mod text;
mod weld;

pub use glb::appearance::Appearance;

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::refusal::{Faults, Place, Refusal};

/// What is accepted at most.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Triangles that are matched, after polygons are cut. Vertices are limited to three for each of them.
    pub triangles: usize,
    /// Bytes of the file.
    pub bytes: usize,
}

impl Default for Limits {
    /// 1,000,000 triangles, 128 MiB.
    fn default() -> Limits {
        Limits { triangles: 1_000_000, bytes: 128 << 20 }
    }
}

/// A file may hold so many times the triangles that are matched.
const TIMES: usize = 4;
/// Bytes a triangle takes at least in a file that holds more than are matched; the tersest formats take about 12. So the memory
/// for reading stays in proportion to the file, whatever it repeats.
const BYTES_OF_TRIANGLE: usize = 8;

impl Limits {
    /// What is read of a file of so many bytes: more triangles than are matched, which leaves them to be made fewer.
    pub(super) fn of_reading(self, bytes: usize) -> Limits {
        let more = (bytes / BYTES_OF_TRIANGLE).min(self.triangles.saturating_mul(TIMES));
        Limits { triangles: self.triangles.max(more), ..self }
    }

    pub(super) fn admit_bytes(&self, found: usize) -> Result<(), Refusal> {
        admit("bytes", found, self.bytes)
    }

    fn admit_vertices(&self, found: usize) -> Result<(), Refusal> {
        admit("vertices", found, self.triangles.saturating_mul(3))
    }

    fn admit_triangles(&self, found: usize) -> Result<(), Refusal> {
        admit("triangles", found, self.triangles)
    }
}

fn admit(unit: &'static str, found: usize, limit: usize) -> Result<(), Refusal> {
    if found <= limit { Ok(()) } else { Err(Refusal::TooLarge { unit, found: found as u64, limit: limit as u64 }) }
}

/// A file format of meshes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
#[schema(as = MeshFormat)]
pub enum Format {
    Obj,
    Off,
    Ply,
    Stl,
    Glb,
    /// glTF as JSON, its data in it.
    Gltf,
}

impl Format {
    /// The format of a name or file extension, in any case.
    pub fn from_name(name: &str) -> Option<Format> {
        match name.to_ascii_lowercase().as_str() {
            "obj" => Some(Format::Obj),
            "off" => Some(Format::Off),
            "ply" => Some(Format::Ply),
            "stl" => Some(Format::Stl),
            "glb" => Some(Format::Glb),
            "gltf" => Some(Format::Gltf),
            _ => None,
        }
    }

    /// The format of a content type, its parameters aside.
    pub fn from_media_type(media_type: &str) -> Option<Format> {
        let essence = media_type.split(';').next().unwrap_or_default().trim().to_ascii_lowercase();
        match essence.as_str() {
            "model/obj" => Some(Format::Obj),
            "model/off" | "application/x-off" | "text/off" => Some(Format::Off),
            "model/ply" | "application/ply" | "application/x-ply" | "text/ply" => Some(Format::Ply),
            "model/stl"
            | "model/x.stl-ascii"
            | "model/x.stl-binary"
            | "application/sla"
            | "application/stl"
            | "application/vnd.ms-pki.stl" => Some(Format::Stl),
            "model/gltf-binary" => Some(Format::Glb),
            "model/gltf+json" => Some(Format::Gltf),
            _ => None,
        }
    }

    /// The content type of a file of this format.
    pub const fn media_type(self) -> &'static str {
        match self {
            Format::Obj => "model/obj",
            Format::Off => "model/off",
            Format::Ply => "model/ply",
            Format::Stl => "model/stl",
            Format::Glb => "model/gltf-binary",
            Format::Gltf => "model/gltf+json",
        }
    }

    /// The direction that is up by the format's standard, where it has one.
    pub fn up(self) -> Option<[f64; 3]> {
        match self {
            Format::Glb | Format::Gltf => Some([0.0, 1.0, 0.0]),
            Format::Obj | Format::Off | Format::Ply | Format::Stl => None,
        }
    }

    /// The format the bytes look like.
    pub fn sniff(bytes: &[u8]) -> Option<Format> {
        let bytes = text::without_mark(bytes);
        if foreign::name(bytes).is_some() {
            None
        } else if glb::looks_like(bytes) {
            Some(Format::Glb)
        } else if glb::looks_like_json(bytes) {
            Some(Format::Gltf)
        } else if ply::looks_like(bytes) {
            Some(Format::Ply)
        } else if stl::looks_like(bytes) {
            Some(Format::Stl)
        } else if off::looks_like(bytes) {
            Some(Format::Off)
        } else if obj::looks_like(bytes) {
            Some(Format::Obj)
        } else {
            None
        }
    }
}

/// The vertices and polygons of a file. Refused where nothing can be made of it; of a text, lines that cannot be read are
/// among its faults.
pub(super) fn read(bytes: &[u8], format: Format, limits: &Limits) -> Result<Polygons, Refusal> {
    let polygons = Polygons::new(*limits);
    let bytes = text::without_mark(bytes);
    match format {
        Format::Obj => obj::read(bytes, polygons),
        Format::Off => off::read(bytes, polygons),
        Format::Ply => ply::read(bytes, polygons),
        Format::Stl => stl::read(bytes, polygons),
        Format::Glb | Format::Gltf => glb::read(bytes, polygons),
    }
}

/// Triangles that a face of so many corners counts for: those it will be cut into, and one where there are none.
fn triangles_of(corners: usize) -> usize {
    corners.saturating_sub(2).max(1)
}

/// Vertices and polygons as a file states them: nothing is proven but that they keep to the limits.
#[derive(Debug)]
pub(super) struct Polygons {
    pub positions: Vec<[f64; 3]>,
    /// The corners of all faces one after the other; the number of a vertex as stated, counted from 0.
    corners: Vec<i64>,
    /// Per face the end of its corners.
    ends: Vec<usize>,
    /// Line of each vertex in a text file, else empty; of each face likewise.
    vertex_lines: Vec<u32>,
    face_lines: Vec<u32>,
    /// The number of the first vertex in the file's own count.
    pub first_vertex: i64,
    /// Elements that are no faces.
    pub ignored: usize,
    /// The lines that cannot be read. A vertex or face of such a line has its number all the same, so that the others keep
    /// theirs.
    pub faults: Faults,
    triangles: usize,
    limits: Limits,
}

impl Polygons {
    fn new(limits: Limits) -> Polygons {
        Polygons {
            positions: Vec::new(),
            corners: Vec::new(),
            ends: Vec::new(),
            vertex_lines: Vec::new(),
            face_lines: Vec::new(),
            first_vertex: 0,
            ignored: 0,
            faults: Faults::default(),
            triangles: 0,
            limits,
        }
    }

    /// Adds a vertex; `line` from 1 in a text file.
    fn push_vertex(&mut self, position: [f64; 3], line: Option<u64>) -> Result<(), Refusal> {
        self.limits.admit_vertices(self.positions.len() + 1)?;
        self.positions.push(position);
        self.vertex_lines.extend(line.map(|line| line as u32));
        Ok(())
    }

    /// Adds a vertex that cannot be read.
    fn push_unread_vertex(&mut self, detail: String, line: u64) -> Result<(), Refusal> {
        self.faults.push(Place::line(line), detail);
        self.push_vertex([0.0; 3], Some(line))
    }

    /// Adds a face that cannot be read.
    fn push_unread_face(&mut self, detail: String, line: u64) -> Result<(), Refusal> {
        self.faults.push(Place::line(line), detail);
        self.push_face([], Some(line))
    }

    /// That another face of so many corners keeps to the limits: to be asked before memory is taken for them.
    fn admit_face(&self, corners: usize) -> Result<(), Refusal> {
        self.limits.admit_triangles(self.triangles.saturating_add(triangles_of(corners)))
    }

    /// Adds a face, counted as the triangles it will be cut into.
    fn push_face(&mut self, corners: impl IntoIterator<Item = i64>, line: Option<u64>) -> Result<(), Refusal> {
        let start = self.corners.len();
        self.corners.extend(corners);
        self.triangles += triangles_of(self.corners.len() - start);
        self.limits.admit_triangles(self.triangles)?;
        self.ends.push(self.corners.len());
        self.face_lines.extend(line.map(|line| line as u32));
        Ok(())
    }

    /// Every face's corners, in the order of the file.
    pub fn faces(&self) -> impl ExactSizeIterator<Item = &[i64]> {
        (0..self.ends.len()).map(|f| {
            let start = if f == 0 { 0 } else { self.ends[f - 1] };
            &self.corners[start..self.ends[f]]
        })
    }

    /// A face of the file, with its line.
    pub fn face_place(&self, face: usize) -> Place {
        Place { line: self.face_lines.get(face).map(|&line| line.into()), ..Place::face(face) }
    }

    /// A vertex of the file, with its line.
    pub fn vertex_place(&self, vertex: usize) -> Place {
        Place { line: self.vertex_lines.get(vertex).map(|&line| line.into()), ..Place::vertex(vertex) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn knows_names_and_media_types() {
        assert_eq!(Format::from_name("GLB"), Some(Format::Glb));
        assert_eq!(Format::from_name("fbx"), None);
        assert_eq!(Format::from_media_type("Model/STL; charset=binary"), Some(Format::Stl));
        assert_eq!(Format::from_media_type("application/octet-stream"), None);
    }

    #[test]
    fn sniffs_nothing_in_strange_bytes() {
        for bytes in [b"".as_slice(), b"hello", b"\x89PNG\r\n", b"{\"vertices\": []}", b"vn 0 0 1\n"] {
            assert_eq!(Format::sniff(bytes), None);
        }
    }
}
