//! Meshes: which format bytes are in, the mesh they hold, and what is told of it.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::{Cause, Fault, Untaken, warnings};
use crate::alignment::prepared::standing::{self, Up};
use crate::mesh::connectivity::{Summary, components, summary};
use crate::mesh::formats::{Format, Limits, foreign};
use crate::mesh::parts::figures;
use crate::mesh::refusal::{Refusal, Warning};
use crate::mesh::validation::{Imported, import};

/// Bytes of memory per byte of a mesh file while it is read, about: STL and binary PLY, of few bytes a triangle, take most.
pub const MEMORY_OF_FILE: usize = 12;

#[derive(Debug, Serialize, Deserialize, ToSchema)]
pub struct MeshMeasures {
    #[serde(flatten)]
    pub summary: Summary,
    /// What was mended, and what is to be known.
    #[serde(deserialize_with = "warnings::known")]
    pub warnings: Vec<Warning>,
    /// Which way is up on it: what matches take unless they say otherwise, where it is surer than even. None of meshes
    /// taken before this was told.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub up: Option<Up>,
}

impl MeshMeasures {
    /// What is told of a mesh that came in this format.
    pub fn of(Imported { mesh, warnings }: &Imported, format: Format) -> MeshMeasures {
        let components = components(mesh.sound());
        let likeliest = figures(mesh.sound(), &components).swap_remove(0);
        let body = components.cut_out(mesh.sound(), &likeliest).mesh;
        let up = Some(standing::up(&body, format.up()));
        MeshMeasures { summary: summary(mesh), warnings: warnings.clone(), up }
    }
}

/// The format named, else that which the media type, the file's name or the bytes tell.
///
/// # Errors
/// Unsupported where nothing tells it.
pub fn format(
    bytes: &[u8],
    named: Option<Format>,
    media_type: Option<&str>,
    file_name: Option<&str>,
) -> Result<Format, Untaken> {
    if let Some(foreign) = foreign::name(bytes) {
        return Err(Untaken::of(Cause::Unsupported, format!("this is {}: {}", foreign.kind, foreign.instead)));
    }
    let by_name = || Format::from_name(file_name?.rsplit_once('.')?.1);
    let format = named.or_else(|| media_type.and_then(Format::from_media_type)).or_else(by_name);
    format.or_else(|| Format::sniff(bytes)).ok_or_else(|| {
        Untaken::of(
            Cause::Unsupported,
            "neither the content type nor the bytes tell the format: say ?format=obj|off|ply|stl|glb|gltf",
        )
    })
}

/// The mesh in a file of this format.
///
/// # Errors
/// Too large beyond the limits, unacceptable with every fault of a mesh that cannot be matched.
pub fn taken(bytes: &[u8], format: Format, limits: &Limits) -> Result<Imported, Untaken> {
    import(bytes, format, limits).map_err(untaken)
}

/// Why a mesh is not taken.
fn untaken(refusal: Refusal) -> Untaken {
    match refusal {
        Refusal::TooLarge { .. } => Untaken::of(Cause::TooLarge, refusal.to_string()),
        Refusal::Invalid(faults) => {
            let unlisted = match faults.unlisted {
                0 => String::new(),
                more => format!("; {more} more faults are not listed"),
            };
            let faults = faults.listed.into_iter().map(|fault| Fault::at_place(fault.place.to_string(), fault.detail));
            Untaken::unacceptable(format!("the file is not a mesh that can be matched{unlisted}"), faults.collect())
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::solids::star;

    #[test]
    fn up_is_judged_on_all_parts_together() {
        // The legs by themselves, a little below the rest, which is larger and stands on nothing.
        let body = star(0.0);
        let is_leg = |p: [f64; 3]| p[2] < -0.1;
        let mut text = String::new();
        for &[x, y, z] in body.positions() {
            text += &format!("v {x} {y} {z}\nv {x} {y} {}\n", z - 0.01);
        }
        for triangle in body.triangles() {
            let below = usize::from(triangle.iter().all(|&v| is_leg(body.positions()[v as usize])));
            let [a, b, c] = triangle.map(|v| 2 * v as usize + 1 + below);
            text += &format!("f {a} {b} {c}\n");
        }
        let imported = taken(text.as_bytes(), Format::Obj, &Limits::default()).unwrap();
        let measures = MeshMeasures::of(&imported, Format::Obj);
        assert!(measures.summary.components > 1);
        assert_eq!(measures.up.unwrap().direction, [0.0, 0.0, 1.0]);
    }
}
