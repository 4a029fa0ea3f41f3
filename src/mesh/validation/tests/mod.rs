mod any_bytes;
mod mends;
mod refusals;

use super::*;
use crate::mesh::TriangleMesh;
use crate::mesh::connectivity;
use crate::mesh::refusal::WarningCode;

fn obj(text: &str) -> Result<Imported, Refusal> {
    import(text.as_bytes(), Format::Obj, &Limits::default())
}

fn codes(imported: &Imported) -> Vec<WarningCode> {
    imported.warnings.iter().map(|warning| warning.code).collect()
}

const CUBE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n\
                    f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";

fn volume(mesh: &TriangleMesh) -> f64 {
    let corners = mesh.triangles().iter().map(|t| t.map(|v| mesh.positions()[v as usize]));
    corners.map(|[a, b, c]| crate::geometry::dot(a, crate::geometry::cross(b, c)) / 6.0).sum()
}

fn summary(imported: &Imported) -> (usize, usize, bool) {
    let summary = connectivity::summary(&imported.mesh);
    (summary.components, summary.boundary_edges, summary.closed)
}

/// A sheet of n × n squares as a file.
fn sheet(n: usize) -> String {
    let corners = (0..=n).flat_map(|y| (0..=n).map(move |x| format!("v {x} {y} 0\n")));
    let squares = (0..n).flat_map(|y| (1..=n).map(move |x| y * (n + 1) + x));
    let faces = squares.map(|v| format!("f {v} {} {} {}\n", v + 1, v + n + 2, v + n + 1));
    corners.chain(faces).collect()
}

#[test]
fn takes_a_valid_mesh_as_it_is() {
    let cube = obj(CUBE).unwrap();
    assert_eq!(codes(&cube), []);
    let summary = connectivity::summary(&cube.mesh);
    assert_eq!((summary.vertices, summary.triangles, summary.closed), (8, 12, true));
    assert!((summary.area - 6.0).abs() < 1e-12);
    assert!((volume(cube.mesh.sound()) - 1.0).abs() < 1e-12);
}

#[test]
fn takes_a_consistently_inward_mesh_as_it_is() {
    let inward = CUBE.lines().map(|line| match line.split_whitespace().collect::<Vec<_>>()[..] {
        ["f", a, b, c, d] => format!("f {d} {c} {b} {a}\n"),
        _ => format!("{line}\n"),
    });
    let cube = obj(&inward.collect::<String>()).unwrap();
    assert_eq!(codes(&cube), []);
    assert!((volume(cube.mesh.sound()) + 1.0).abs() < 1e-12);
}

#[test]
fn keeps_unreferenced_vertices_and_their_ids() {
    let imported = obj("v 5 5 5\nv 0 0 0\nv 1 0 0\nv 7 7 7\nv 0 1 0\nf 2 3 5\n").unwrap();
    assert_eq!(codes(&imported), [WarningCode::UnreferencedVertices]);
    let places = [Place { line: Some(1), ..Place::vertex(0) }, Place { line: Some(4), ..Place::vertex(3) }];
    assert_eq!(imported.warnings[0].places, places);
    assert_eq!(imported.mesh.positions().len(), 5);
    assert_eq!(imported.mesh.triangles(), [[1, 2, 4]]);
}

#[test]
fn warns_of_components_and_specks() {
    let speck = "v 5 0 0\nv 5.01 0 0\nv 5 0.01 0\nf 9 10 11\nl 1 2\n";
    let imported = obj(&format!("{CUBE}{speck}")).unwrap();
    let expected = [WarningCode::IgnoredElements, WarningCode::SeveralComponents, WarningCode::IsolatedSpecks];
    assert_eq!(codes(&imported), expected);
    assert_eq!(imported.warnings[2].places, [Place::vertex(8)]);
}

#[test]
fn a_crossed_quad_is_cut_and_told() {
    let crossed = "v 0 0 0\nv 1 1 0\nv 1 0 0\nv 0 1 0\nf 1 2 3 4\n";
    let imported = obj(crossed).unwrap();
    assert_eq!(codes(&imported)[0], WarningCode::CrossingFaces);
    assert_eq!(imported.mesh.triangles().len(), 2);
}

#[test]
fn a_vertex_that_is_nowhere_and_of_no_face_is_told() {
    let imported = obj(&format!("{CUBE}v nan nan nan\n")).unwrap();
    assert_eq!(codes(&imported), [WarningCode::UnreferencedVertices]);
    assert!(imported.warnings[0].detail.contains("no number"), "{:?}", imported.warnings);
    assert!(imported.mesh.positions()[8][0].is_nan());
}

#[test]
fn of_more_triangles_than_are_matched_the_surface_is_made_coarser() {
    let limits = Limits { triangles: 200, ..Limits::default() };
    let coarser = import(sheet(20).as_bytes(), Format::Obj, &limits).unwrap();
    assert_eq!(codes(&coarser), [WarningCode::Decimated]);
    assert!(coarser.warnings[0].detail.contains("of 800 triangles"), "{:?}", coarser.warnings);
    let mesh = &coarser.mesh;
    assert!(mesh.sound().triangles().len() <= 200 && mesh.triangles().len() == 800);
    assert!((mesh.sound().area() - 400.0).abs() < 1e-9);
}
