//! From a user's file to a mesh that can be matched: whatever can be mended is mended and told, the rest is refused with
//! every reason.

use std::mem;

use super::cut::Cut;
use super::file_mesh::FileMesh;
use super::formats::{self, Format, Limits, Polygons};
use super::mending::Mends;
use super::refusal::{Faults, Place, Refusal, Warning};
use super::{soundness, warnings};

/// A file's mesh, and what is to be known of it.
#[derive(Clone, Debug, PartialEq)]
pub struct Imported {
    pub mesh: FileMesh,
    pub warnings: Vec<Warning>,
}

/// The mesh of a file, its vertices those of the file in their order, and what was mended for it, each kind with its
/// places.
///
/// What has more triangles than are matched is made coarser, where it can be.
///
/// Refused: what exceeds the limits, what cannot be read, faces of vertices that are nowhere, and what leaves no surface to
/// match; every reason with its vertex, face and line.
pub fn import(bytes: &[u8], format: Format, limits: &Limits) -> Result<Imported, Refusal> {
    limits.admit_bytes(bytes.len())?;
    let mut polygons = formats::read(bytes, format, &limits.of_reading(bytes.len()))?;
    let mut faults = mem::take(&mut polygons.faults);
    if polygons.positions.is_empty() && polygons.ignored == 0 {
        faults.push(Place::file(), "there are no vertices");
    }
    if polygons.faces().len() == 0 {
        faults.push(Place::file(), without_faces(&polygons));
    }
    let cut = Cut::of(&polygons, &mut faults);
    faults.into_result()?;
    let mut told = warnings::of_file(&polygons, &cut);
    let (mesh, mends) = FileMesh::of(polygons.positions.clone(), cut.triangles.clone());
    let mut mesh = mesh.ok_or_else(|| nothing_left(&polygons, &cut, &mends))?;
    told.extend(warnings::of_mends(&polygons, &cut, &mends, &mesh));
    told.extend(warnings::of_unreferenced(&polygons, &cut.triangles));
    let found = mesh.sound().triangles().len();
    if found > limits.triangles {
        let too_large = Refusal::TooLarge { unit: "triangles", found: found as u64, limit: limits.triangles as u64 };
        mesh = mesh.decimated(limits.triangles).ok_or(too_large)?;
        told.push(warnings::of_decimation(found, &mesh));
    }
    told.extend(warnings::of_components(&mesh));
    Ok(Imported { mesh, warnings: told })
}

/// Why a file without faces is not matched.
fn without_faces(polygons: &Polygons) -> &'static str {
    if polygons.ignored > 0 {
        "there are no faces, only lines or points: save the surface itself"
    } else if polygons.positions.is_empty() {
        "there are no faces"
    } else {
        "there are no faces, only points: make a surface of them first, for example by Poisson reconstruction"
    }
}

/// Why a file with faces has no surface that could be matched.
fn nothing_left(polygons: &Polygons, cut: &Cut, mends: &Mends) -> Refusal {
    let mut faults = Faults::default();
    for &face in &cut.too_few {
        let corners = polygons.faces().nth(face).map_or(0, <[i64]>::len);
        faults.push(polygons.face_place(face), format!("a face of {corners} corners: the least is 3"));
    }
    cut.collapsed
        .iter()
        .for_each(|&face| faults.push(polygons.face_place(face), "its corners are one or two vertices"));
    let degenerate = mends.degenerate.iter().chain(&mends.flat).map(|&t| (cut.faces[t], cut.triangles[t]));
    for (face, [a, b, c]) in degenerate {
        let detail = if a == b || b == c || c == a {
            "a vertex is a corner of it twice".to_owned()
        } else {
            format!("the triangle of vertices {a}, {b}, {c} has no area")
        };
        faults.push(polygons.face_place(face), detail);
    }
    if faults.is_empty() {
        faults.push(Place::file(), soundness::NO_AREA);
    }
    Refusal::Invalid(faults)
}

#[cfg(test)]
mod tests;
