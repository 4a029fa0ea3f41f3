//! What the user is told of a mesh that is taken, where nothing had to be mended.

use super::TriangleMesh;
use super::connectivity::{self, Extent};
use super::formats::Polygons;
use super::refusal::{Place, Warning, WarningCode};

/// Share of the whole area below which a component is a speck.
const SPECK: f64 = 1e-3;

/// The warnings of what reading the file left out or merged.
pub(super) fn of_file(polygons: &Polygons) -> Vec<Warning> {
    let mut warnings = Vec::new();
    if polygons.ignored > 0 {
        let detail = format!("{} elements of the file are no faces and are left out", polygons.ignored);
        warnings.push(Warning::new(WarningCode::IgnoredElements, detail, []));
    }
    if !polygons.merged.is_empty() {
        let detail =
            format!("{} vertices stand where an earlier one does, which takes their place", polygons.merged.len());
        let places = polygons.merged.iter().map(|&v| polygons.vertex_place(v as usize));
        warnings.push(Warning::new(WarningCode::MergedVertices, detail, places));
    }
    warnings
}

/// The warning of vertices that no face ever named.
pub(super) fn of_unreferenced(polygons: &Polygons, triangles: &[[u32; 3]]) -> Option<Warning> {
    let mut accounted = vec![false; polygons.positions.len()];
    for &v in triangles.as_flattened().iter().chain(&polygons.merged) {
        accounted[v as usize] = true;
    }
    let vertices: Vec<usize> = (0..accounted.len()).filter(|&v| !accounted[v]).collect();
    let detail = format!("{} vertices belong to no face and are not matched", vertices.len());
    let places = vertices.iter().map(|&v| polygons.vertex_place(v));
    (!vertices.is_empty()).then(|| Warning::new(WarningCode::UnreferencedVertices, detail, places))
}

/// The warnings of a mesh in several pieces.
pub(super) fn of_components(mesh: &TriangleMesh) -> Vec<Warning> {
    let components = connectivity::components(mesh).list;
    if components.len() < 2 {
        return Vec::new();
    }
    let area = mesh.area();
    let place = |component: &Extent| Place::vertex(component.first_vertex as usize);
    let largest = components.iter().map(|c| c.area).fold(0.0, f64::max);
    let detail = format!(
        "the mesh has {} components: only the largest, {:.1} % of the area, is matched",
        components.len(),
        100.0 * largest / area
    );
    let mut warnings = vec![Warning::new(WarningCode::SeveralComponents, detail, components.iter().map(place))];
    let specks: Vec<&Extent> = components.iter().filter(|c| c.area < SPECK * area).collect();
    if !specks.is_empty() {
        let triangles: usize = specks.iter().map(|c| c.triangles).sum();
        let detail = format!("{} components of {triangles} triangles are specks", specks.len());
        warnings.push(Warning::new(WarningCode::IsolatedSpecks, detail, specks.into_iter().map(place)));
    }
    warnings
}
