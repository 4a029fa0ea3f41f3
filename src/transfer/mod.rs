//! What a functional map is for: functions, labels and colours taken from one shape to the other, by C or by points.

mod by_map;
mod by_points;
pub mod request;

use crate::mesh::file_mesh::FileMesh;
use crate::numerics::{Cancelled, Watch};
use crate::pipeline::Bases;
use crate::pipeline::outcome::{AlternativeKind, MatchResult};
use crate::sketch::Sketch;
use request::{By, Given, Moved, Shape, TransferRequest, Values};

/// One thing wrong with a request, and where.
pub use crate::pipeline::Fault;

/// What does not fit the match or its shapes, of which the mesh's file has so many vertices.
pub fn faults(request: &TransferRequest, result: &MatchResult, mesh_vertices: usize) -> Vec<Fault> {
    let vertices = match request.from {
        Shape::Sketch => result.correspondences.len(),
        Shape::Mesh => mesh_vertices,
    };
    let mut faults = request.given.faults(vertices);
    if request.given == (Given::Drawing {}) && request.from == Shape::Mesh {
        let detail = "a drawing is taken from the sketch";
        faults.push(Fault { pointer: "/given/type".to_owned(), detail: detail.to_owned() });
    }
    faults.extend(unanswered(request, mirrored(result).is_some()));
    faults
}

/// Why nothing answers for the other side, where somebody is to.
fn unanswered(request: &TransferRequest, is_mirrored: bool) -> Option<Fault> {
    let detail = match request {
        TransferRequest { both_sides: false, .. } => return None,
        TransferRequest { from: Shape::Sketch, by: By::Points, .. } if is_mirrored => return None,
        TransferRequest { from: Shape::Sketch, by: By::Points, .. } => {
            "the match has no mirrored alternative to answer for the other side"
        }
        _ => "only what is taken from the sketch by points is given to both sides",
    };
    Some(Fault { pointer: "/both_sides".to_owned(), detail: detail.to_owned() })
}

/// What is given by points: each vertex of the mesh has what the nearest answered one answers, each of the sketch what its
/// answer has.
///
/// # Panics
/// Where there are [faults].
pub fn by_points(request: &TransferRequest, given: &Values<'_>, result: &MatchResult, mesh: &FileMesh) -> Moved {
    match request.from {
        Shape::Mesh => {
            let answers = result.correspondences.iter().map(|point| Some(point.mesh_vertex as usize));
            by_points::taken(given, &answers.collect::<Vec<_>>())
        }
        Shape::Sketch => by_points::taken(given, &sketch_vertices(result, mesh, request.both_sides)),
    }
}

/// For every vertex of the mesh's file the vertex of the sketch whose answer is nearest along the surface; none beyond 0.12
/// √area. With `both_sides` those of the mirrored alternative answer too, where there is one.
pub fn sketch_vertices(result: &MatchResult, mesh: &FileMesh, both_sides: bool) -> Vec<Option<usize>> {
    let points = result.correspondences.iter().map(|point| point.mesh_vertex);
    let twins = mirrored(result).filter(|_| both_sides).into_iter().flatten().copied();
    by_points::inverse(mesh, &points.chain(twins).collect::<Vec<_>>(), result.correspondences.len())
}

/// The same by the map: the vertex of the sketch whose image in the basis of the mesh is nearest.
///
/// # Errors
/// [`Cancelled`] by the watcher.
pub fn sketch_vertices_by_map(bases: &Bases, watch: &dyn Watch) -> Result<Vec<Option<usize>>, Cancelled> {
    by_map::inverse(bases, watch)
}

fn mirrored(result: &MatchResult) -> Option<&Vec<u32>> {
    let mirrored = result.alternatives.iter().find(|alternative| alternative.kind == AlternativeKind::Mirrored);
    mirrored.map(|alternative| &alternative.mesh_vertices)
}

/// What is given by C: a function's coefficients are led by it, from the mesh by Cᵀ.
///
/// # Panics
/// Where there are [faults].
pub fn by_map(from: Shape, given: &Values<'_>, bases: &Bases, sketch: &Sketch) -> Moved {
    by_map::taken(from, given, bases, sketch.mesh().positions().len())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_sides_are_given_what_is_taken_from_the_sketch_by_points_alone() {
        for (from, by, is_mirrored, fits) in [
            (Shape::Sketch, By::Points, true, true),
            (Shape::Sketch, By::Points, false, false),
            (Shape::Sketch, By::Map, true, false),
            (Shape::Mesh, By::Points, true, false),
        ] {
            let request = TransferRequest { from, by, both_sides: true, given: Given::Drawing {} };
            assert_eq!(unanswered(&request, is_mirrored).is_none(), fits, "{from:?} {by:?} {is_mirrored}");
            assert_eq!(unanswered(&TransferRequest { both_sides: false, ..request }, is_mirrored), None);
        }
    }
}
