//! What the user is told of a mesh that is taken, in the words of those who model.

use super::connectivity::{self, Extent};
use super::cut::Cut;
use super::file_mesh::FileMesh;
use super::formats::Polygons;
use super::mending::Mends;
use super::parts::NEARLY_ALL;
use super::refusal::{Place, Warning, WarningCode};
use super::soundness;

/// Share of the whole area below which a component is a speck.
const SPECK: f64 = 1e-3;

/// The warnings of what was left out of the file, and of faces that had to be cut as well as it goes.
pub(super) fn of_file(polygons: &Polygons, cut: &Cut) -> Vec<Warning> {
    let mut warnings = Vec::new();
    let ignored = polygons.ignored + cut.too_few.len();
    if ignored > 0 {
        let detail = format!("{ignored} elements of the file are no faces and are left out");
        warnings.push(Warning::new(WarningCode::IgnoredElements, detail, places_of_faces(polygons, &cut.too_few)));
    }
    if !cut.crossing.is_empty() {
        let n = cut.crossing.len();
        let detail =
            format!("{n} faces cross themselves or enclose no area: they are cut into triangles as well as it goes");
        warnings.push(Warning::new(WarningCode::CrossingFaces, detail, places_of_faces(polygons, &cut.crossing)));
    }
    warnings
}

/// The warnings of what was mended.
pub(super) fn of_mends(polygons: &Polygons, cut: &Cut, mends: &Mends, mesh: &FileMesh) -> Vec<Warning> {
    let mut warnings = Vec::new();
    let mut warn = |code, places: Vec<Place>, detail: String| {
        if !places.is_empty() {
            warnings.push(Warning::new(code, detail, places));
        }
    };
    let faces = |triangles: &[usize]| {
        let mut faces: Vec<usize> = triangles.iter().map(|&t| cut.faces[t]).collect();
        faces.sort_unstable();
        faces.dedup();
        faces
    };
    let at_faces = |faces: &[usize]| places_of_faces(polygons, faces).collect::<Vec<Place>>();
    let at_vertices =
        |vertices: &[u32]| vertices.iter().map(|&v| polygons.vertex_place(v as usize)).collect::<Vec<_>>();
    let at_edges = |edges: &[[u32; 2]]| edges.iter().map(|&[a, b]| Place::edge(a, b)).collect::<Vec<_>>();

    let merged: Vec<u32> = (0..).zip(mesh.merged()).filter(|(v, lowest)| v != *lowest).map(|(v, _)| v).collect();
    let detail =
        format!("{} vertices along seams stand where an earlier one does, which takes their place", merged.len());
    warn(WarningCode::MergedVertices, at_vertices(&merged), detail);

    let left_out = [faces(&mends.degenerate), cut.collapsed.clone()].concat();
    let kept = faces(&mends.flat);
    let detail = format!(
        "{} faces have no area or the same corner twice: {} are left out, {} are kept for what they join",
        left_out.len() + kept.len(),
        left_out.len(),
        kept.len()
    );
    warn(WarningCode::DegenerateFaces, at_faces(&[left_out, kept].concat()), detail);

    let doubled = faces(&mends.doubled);
    let detail = format!("{} faces repeat another face and are dropped", doubled.len());
    warn(WarningCode::DuplicateFaces, at_faces(&doubled), detail);

    let detail = format!(
        "more than two faces meet at {} edges, as at a fin or an inner wall: the surface goes on over two of them, the \
         others end there",
        mends.crowded.len()
    );
    warn(WarningCode::CutEdges, at_edges(&mends.crowded), detail);

    let detail =
        format!("at {} vertices parts of the surface meet in a point only: they are parted there", mends.pinched.len());
    warn(WarningCode::SplitVertices, at_vertices(&mends.pinched), detail);

    let detail = format!(
        "the surface has no inside and outside, like a strip of Möbius: it is cut open at {} edges",
        mends.one_sided.len()
    );
    warn(WarningCode::OneSided, at_edges(&mends.one_sided), detail);

    let flipped = faces(&mends.flipped);
    let detail = format!("{} faces are turned over to agree with their neighbours", flipped.len());
    warn(WarningCode::FlippedWinding, at_faces(&flipped), detail);
    warnings
}

fn places_of_faces<'a>(polygons: &'a Polygons, faces: &'a [usize]) -> impl Iterator<Item = Place> + use<'a> {
    faces.iter().map(|&face| polygons.face_place(face))
}

/// The warning of vertices that no face ever named.
pub(super) fn of_unreferenced(polygons: &Polygons, triangles: &[[u32; 3]]) -> Option<Warning> {
    let mut accounted = vec![false; polygons.positions.len()];
    for &v in triangles.as_flattened() {
        accounted[v as usize] = true;
    }
    let vertices: Vec<usize> = (0..accounted.len()).filter(|&v| !accounted[v]).collect();
    let nowhere = vertices.iter().filter(|&&v| !soundness::is_sound(polygons.positions[v])).count();
    let mut detail = format!("{} vertices belong to no face and are not matched", vertices.len());
    if nowhere > 0 {
        detail += &format!("; {nowhere} of them have a coordinate that is no number");
    }
    let places = vertices.iter().map(|&v| polygons.vertex_place(v));
    (!vertices.is_empty()).then(|| Warning::new(WarningCode::UnreferencedVertices, detail, places))
}

/// The warning of a mesh that had more triangles than are matched.
pub(super) fn of_decimation(before: usize, mesh: &FileMesh) -> Warning {
    let after = mesh.sound().triangles().len();
    let detail = format!(
        "the surface of {before} triangles is made coarser, {after} are matched: vertices that are left answer for those \
         near them"
    );
    Warning::new(WarningCode::Decimated, detail, [])
}

/// The warnings of a mesh in several pieces.
pub(super) fn of_components(mesh: &FileMesh) -> Vec<Warning> {
    let components = connectivity::components(mesh.sound()).list;
    if components.len() < 2 {
        return Vec::new();
    }
    let area = mesh.sound().area();
    let place = |component: &Extent| Place::vertex(mesh.origins()[component.first_vertex as usize] as usize);
    let largest = components.iter().map(|c| c.area).fold(0.0, f64::max);
    let matched = if largest >= NEARLY_ALL * area {
        format!("only the largest, {:.1} % of the area, is matched", 100.0 * largest / area)
    } else {
        "those are matched that look most like the sketch, together where they nearly touch, unless a request names some"
            .to_owned()
    };
    let detail = format!("the mesh has {} components: {matched}", components.len());
    let mut warnings = vec![Warning::new(WarningCode::SeveralComponents, detail, components.iter().map(place))];
    let specks: Vec<&Extent> = components.iter().filter(|c| c.area < SPECK * area).collect();
    if !specks.is_empty() {
        let triangles: usize = specks.iter().map(|c| c.triangles).sum();
        let detail = format!("{} components of {triangles} triangles are specks", specks.len());
        warnings.push(Warning::new(WarningCode::IsolatedSpecks, detail, specks.into_iter().map(place)));
    }
    warnings
}
