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
    for (count, unit) in [(polygons.positions.len(), "vertices"), (polygons.faces().len(), "faces")] {
        if count == 0 {
            faults.push(Place::file(), format!("there are no {unit}"));
        }
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
mod tests {
    use proptest::prelude::*;

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

    fn reasons(text: &str) -> Vec<String> {
        let Err(Refusal::Invalid(faults)) = obj(text) else { panic!("not refused as invalid: {text}") };
        faults.listed.iter().map(ToString::to_string).collect()
    }

    const CUBE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n\
                        f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";

    fn volume(mesh: &TriangleMesh) -> f64 {
        let corners = mesh.triangles().iter().map(|t| t.map(|v| mesh.positions()[v as usize]));
        corners.map(|[a, b, c]| crate::geometry::dot(a, crate::geometry::cross(b, c)) / 6.0).sum()
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
    fn turns_an_inconsistent_closed_mesh_outward() {
        // Four of six faces are turned inward: the majority does not count where there is an outside.
        let text =
            CUBE.replace("f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6", "f 1 2 3 4\nf 8 7 6 5\nf 5 6 2 1\nf 6 7 3 2");
        let cube = obj(&text).unwrap();
        assert_eq!(codes(&cube), [WarningCode::FlippedWinding]);
        assert!((volume(cube.mesh.sound()) - 1.0).abs() < 1e-12);
        let places: Vec<_> = cube.warnings[0].places.iter().map(|place| (place.face, place.line)).collect();
        assert_eq!(places, [0, 1, 2, 3].map(|f| (Some(f), Some(9 + f))));
    }

    #[test]
    fn keeps_the_winding_of_most_area_where_there_is_a_boundary() {
        let text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 9 9 0\nf 1 2 3\nf 2 3 4\n";
        let sheet = obj(text).unwrap();
        assert_eq!(codes(&sheet), [WarningCode::FlippedWinding]);
        assert_eq!(sheet.mesh.sound().triangles(), [[0, 2, 1], [1, 2, 3]]);
        assert_eq!(sheet.mesh.triangles(), [[0, 1, 2], [1, 2, 3]]);
    }

    #[test]
    fn drops_repeated_faces() {
        let cube = obj(&format!("{CUBE}f 7 3 4 8\nf 2 3 4 1\n")).unwrap();
        assert_eq!(codes(&cube), [WarningCode::DuplicateFaces]);
        assert_eq!(cube.warnings[0].places.iter().map(|p| p.face).collect::<Vec<_>>(), [Some(6), Some(7)]);
        assert_eq!(cube.mesh.sound(), obj(CUBE).unwrap().mesh.sound());
    }

    #[test]
    fn lists_the_faults_of_lines_and_those_of_faces() {
        let text = "v 0 0 0\nv 1 x 0\nv 0 1 0\nv nan 0 0\nf 1 2 3\nf 1 2 7\nf 1 a 3\nf 1 3 4\nf 3 2 9\n";
        assert_eq!(
            reasons(text),
            [
                "line 2: a coordinate is not a number: \"x\"",
                "line 7: a corner is none of v, v/vt, v//vn and v/vt/vn: \"f 1 a 3\"",
                "line 6, face 1: vertex 6 is out of range: there are 4, from 0",
                "line 9, face 4: vertex 8 is out of range: there are 4, from 0",
                "line 4, vertex 3: a coordinate is not a finite number: [NaN, 0.0, 0.0]",
            ]
        );
        let off = "OFF\n3 2 0\n0 0 0\n1 0\n0 1 0\n3 0 1 2\n3 0 1 5\n";
        let Err(Refusal::Invalid(faults)) = import(off.as_bytes(), Format::Off, &Limits::default()) else {
            panic!("accepted")
        };
        let lines: Vec<_> = faults.listed.iter().map(|fault| fault.place.line).collect();
        assert_eq!(lines, [Some(4), Some(7)]);
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
    fn refuses_with_every_reason_in_its_place() {
        let text = "v 0 0 0\nv 1 0 0\nv nan 1 0\nv 1 inf 0\nv 2 0 0\nv 0 3 0\nf 1 2 9\nf 1 2 6\nf 2 1 4 3\n";
        let expected = [
            "line 7, face 0: vertex 8 is out of range: there are 6, from 0",
            "line 3, vertex 2: a coordinate is not a finite number: [NaN, 1.0, 0.0]",
            "line 4, vertex 3: a coordinate is not a finite number: [1.0, inf, 0.0]",
        ];
        assert_eq!(reasons(text), expected);
    }

    #[test]
    fn refuses_what_leaves_no_surface_with_every_face() {
        let text = "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 2\nf 1 2 3\nf 1 2\nf 1 1 2 2\n";
        let expected = [
            "line 6, face 2: a face of 2 corners: the least is 3",
            "line 7, face 3: its corners are one or two vertices",
            "line 4, face 0: a vertex is a corner of it twice",
            "line 5, face 1: the triangle of vertices 0, 1, 2 has no area",
        ];
        assert_eq!(reasons(text), expected);
    }

    #[test]
    fn refuses_what_has_no_vertices_or_faces() {
        assert_eq!(reasons(""), ["file: there are no vertices", "file: there are no faces"]);
        assert_eq!(reasons("v 0 0 0\n"), ["file: there are no faces"]);
    }

    fn summary(imported: &Imported) -> (usize, usize, bool) {
        let summary = connectivity::summary(&imported.mesh);
        (summary.components, summary.boundary_edges, summary.closed)
    }

    #[test]
    fn an_edge_of_three_faces_is_cut() {
        let fin = obj(&format!("{CUBE}v 2 2 2\nf 1 2 9\n")).unwrap();
        assert_eq!(codes(&fin), [WarningCode::CutEdges, WarningCode::SplitVertices, WarningCode::SeveralComponents]);
        assert_eq!(fin.warnings[0].places, [Place::edge(0, 1)]);
        assert_eq!(summary(&fin), (2, 3, false));
        // The cube is whole, and the fin's vertices are still those of the file.
        assert_eq!(fin.mesh.origins(), [0, 0, 1, 1, 2, 3, 4, 5, 6, 7, 8]);
        assert_eq!(fin.mesh.sound_vertices(1), 2..4);
    }

    #[test]
    fn a_wall_inside_is_parted_from_the_body() {
        // Two cubes side by side, and the face between them once.
        let text = CUBE.replace("f 2 3 7 6\n", "")
            + "v 2 0 0\nv 2 1 0\nv 2 0 1\nv 2 1 1\nf 3 10 9 2\nf 6 11 12 7\nf 2 9 11 6\nf 10 3 7 12\nf 9 10 12 11\nf 2 3 7 6\n";
        let walled = obj(&text).unwrap();
        assert!(codes(&walled).contains(&WarningCode::CutEdges));
        assert_eq!(summary(&walled), (2, 4, false));
        let body = connectivity::largest_component(walled.mesh.sound()).mesh;
        assert!((body.area() - 10.0).abs() < 1e-12 && (volume(&body) - 2.0).abs() < 1e-12);
    }

    #[test]
    fn fans_that_meet_in_a_point_are_parted() {
        let bow_tie = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv -1 0 0\nv 0 -1 0\nf 1 2 3\nf 1 4 5\n";
        let imported = obj(bow_tie).unwrap();
        assert_eq!(codes(&imported), [WarningCode::SplitVertices, WarningCode::SeveralComponents]);
        assert_eq!(imported.warnings[0].places, [Place { line: Some(1), ..Place::vertex(0) }]);
        assert_eq!(imported.mesh.origins(), [0, 0, 1, 2, 3, 4]);
    }

    #[test]
    fn a_strip_of_moebius_is_cut_open() {
        let n = 12;
        let mut text = String::new();
        for i in 0..n {
            let angle = f64::from(i) / f64::from(n) * std::f64::consts::TAU;
            for side in [-0.3, 0.3] {
                let radius = 1.0 + side * (angle / 2.0).cos();
                let z = side * (angle / 2.0).sin();
                text += &format!("v {} {} {z}\n", radius * angle.cos(), radius * angle.sin());
            }
        }
        for i in 0..n {
            let (a, b) = (2 * i + 1, 2 * i + 2);
            let (c, d) = if i + 1 < n { (a + 2, b + 2) } else { (2, 1) };
            text += &format!("f {a} {c} {d}\nf {a} {d} {b}\n");
        }
        let strip = obj(&text).unwrap();
        assert!(codes(&strip).contains(&WarningCode::OneSided));
        assert_eq!((summary(&strip).0, strip.mesh.sound().triangles().len()), (1, 24));
    }

    /// The cube with every face on vertices of its own, each moved by up to this much.
    fn apart(noise: f64) -> String {
        let (vertices, faces): (Vec<&str>, Vec<&str>) = CUBE.lines().partition(|line| line.starts_with('v'));
        let corner = |corner: &str| vertices[corner.parse::<usize>().unwrap() - 1].to_owned();
        let corners = faces.iter().flat_map(|face| face.split(' ').skip(1).map(corner)).enumerate();
        let moved = corners.map(|(i, line)| {
            let shifted = line.split(' ').skip(1).enumerate().map(|(axis, x)| {
                let x: f64 = x.parse().unwrap();
                format!("{}", x + noise * ((7 * i + 3 * axis) % 5) as f64 / 5.0)
            });
            format!("v {}\n", shifted.collect::<Vec<_>>().join(" "))
        });
        let own = (0..6).map(|f| format!("f {} {} {} {}\n", 4 * f + 1, 4 * f + 2, 4 * f + 3, 4 * f + 4));
        moved.collect::<String>() + &own.collect::<String>()
    }

    #[test]
    fn seams_close_where_vertices_nearly_meet_and_nowhere_else() {
        for noise in [0.0, 1e-7] {
            let cube = obj(&apart(noise)).unwrap();
            assert_eq!(codes(&cube), [WarningCode::MergedVertices]);
            assert_eq!(summary(&cube), (1, 0, true));
            assert_eq!((cube.mesh.positions().len(), cube.mesh.sound().positions().len()), (24, 8));
            assert!((volume(cube.mesh.sound()) - 1.0).abs() < 1e-6);
        }
        assert_eq!(summary(&obj(&apart(1e-3)).unwrap()).0, 6);
    }

    #[test]
    fn vertices_of_a_sound_mesh_that_stand_at_one_place_stay_apart() {
        // A second cube that touches the first in a vertex of each.
        let second: String = CUBE
            .lines()
            .map(|line| match line.split(' ').collect::<Vec<_>>()[..] {
                ["v", x, y, z] => {
                    let moved = [x, y, z].map(|x| (x.parse::<i32>().unwrap() + 1).to_string());
                    format!("v {}\n", moved.join(" "))
                }
                ["f", ref corners @ ..] => {
                    let moved: Vec<String> =
                        corners.iter().map(|c| (c.parse::<i32>().unwrap() + 8).to_string()).collect();
                    format!("f {}\n", moved.join(" "))
                }
                _ => String::new(),
            })
            .collect();
        let cubes = obj(&format!("{CUBE}{second}")).unwrap();
        assert_eq!(codes(&cubes), [WarningCode::SeveralComponents]);
        assert_eq!((summary(&cubes), cubes.mesh.mends()), ((2, 0, true), None));
    }

    #[test]
    fn a_second_side_is_dropped_whether_or_not_it_has_vertices_of_its_own() {
        let back = CUBE.lines().filter_map(|line| match line.split(' ').collect::<Vec<_>>()[..] {
            ["f", a, b, c, d] => Some([d, c, b, a].map(|v| v.parse::<usize>().unwrap())),
            _ => None,
        });
        let faces = |first: usize| {
            back.clone().map(move |[a, b, c, d]| format!("f {} {} {} {}\n", a + first, b + first, c + first, d + first))
        };
        let same: String = faces(0).collect();
        let vertices: String =
            CUBE.lines().filter(|line| line.starts_with('v')).map(|line| format!("{line}\n")).collect();
        let own = vertices + &faces(8).collect::<String>();
        for (besides, merged) in [(same, vec![]), (own, vec![WarningCode::MergedVertices])] {
            let cube = obj(&format!("{CUBE}{besides}")).unwrap();
            assert_eq!(codes(&cube), [merged, vec![WarningCode::DuplicateFaces]].concat());
            assert_eq!((summary(&cube), cube.mesh.triangles().len()), ((1, 0, true), 24));
            assert_eq!(cube.mesh.sound(), obj(CUBE).unwrap().mesh.sound());
        }
    }

    #[test]
    fn faces_without_area_are_left_out_or_kept_for_what_they_join() {
        // A corner on the middle of an edge, and the sliver that fills the crack.
        let text = CUBE.replace("f 5 6 7 8", "v 0.5 0 1\nf 9 6 7 8\nf 9 8 5\nf 5 6 9\nf 1 2 2");
        let cube = obj(&text).unwrap();
        assert_eq!(codes(&cube), [WarningCode::DegenerateFaces]);
        assert_eq!(cube.warnings[0].places.iter().map(|p| p.face).collect::<Vec<_>>(), [Some(4), Some(3)]);
        assert_eq!(summary(&cube), (1, 0, true));
        assert_eq!(cube.mesh.triangles().len(), 15);
    }

    #[test]
    fn poles_of_repeated_vertices_close() {
        let n = 12;
        let mut text = String::new();
        for row in 0..=6 {
            for column in 0..=n {
                let (latitude, longitude) = (f64::from(row) / 6.0, f64::from(column % n) / f64::from(n));
                let (ring, z) = (std::f64::consts::PI * latitude).sin_cos();
                // Sines of whole turns are not quite zero.
                let ring = if row == 0 || row == 6 { 0.0 } else { ring };
                let (y, x) = (std::f64::consts::TAU * longitude).sin_cos();
                text += &format!("v {} {} {z}\n", ring * x, ring * y);
            }
        }
        for (row, column) in (0..6).flat_map(|row| (0..n).map(move |column| (row, column))) {
            let (a, b) = (row * (n + 1) + column + 1, (row + 1) * (n + 1) + column + 1);
            text += &format!("f {a} {b} {} {}\n", b + 1, a + 1);
        }
        let ball = obj(&text).unwrap();
        assert_eq!(codes(&ball), [WarningCode::MergedVertices, WarningCode::DegenerateFaces]);
        assert_eq!((summary(&ball), ball.mesh.sound().positions().len()), ((1, 0, true), 5 * 12 + 2));
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
    fn caps_the_faults_it_lists() {
        let Err(Refusal::Invalid(faults)) = obj(&"v 0 0 0\nf 1 2 999\n".repeat(250)) else { panic!("accepted") };
        assert_eq!((faults.listed.len(), faults.unlisted), (Faults::LISTED, 150));
    }

    #[test]
    fn refuses_too_many_bytes_as_too_large() {
        let limits = Limits { bytes: 10, ..Limits::default() };
        let refusal = import(CUBE.as_bytes(), Format::Obj, &limits).unwrap_err();
        assert_eq!(refusal, Refusal::TooLarge { unit: "bytes", found: CUBE.len() as u64, limit: 10 });
    }

    /// A sheet of n × n squares as a file.
    fn sheet(n: usize) -> String {
        let corners = (0..=n).flat_map(|y| (0..=n).map(move |x| format!("v {x} {y} 0\n")));
        let squares = (0..n).flat_map(|y| (1..=n).map(move |x| y * (n + 1) + x));
        let faces = squares.map(|v| format!("f {v} {} {} {}\n", v + 1, v + n + 2, v + n + 1));
        corners.chain(faces).collect()
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

    #[test]
    fn refuses_what_is_too_much_to_be_made_coarser() {
        let limits = Limits { triangles: 100, ..Limits::default() };
        let refused = |text: &str| import(text.as_bytes(), Format::Obj, &limits).unwrap_err();
        // More than four times what is matched.
        assert_eq!(refused(&sheet(20)), Refusal::TooLarge { unit: "triangles", found: 402, limit: 400 });
        // Triangles by themselves.
        let alone = |i| format!("v {i} 0 0\nv {i} 1 0\nv {i} 0 1\nf -1 -2 -3\n");
        let alone: String = (0..150).map(alone).collect();
        assert_eq!(refused(&alone), Refusal::TooLarge { unit: "triangles", found: 150, limit: 100 });
        // More than a file of its length could have but by repeating itself.
        let face = format!("f {}\n", "1 2 3 ".repeat(20));
        let repeating = format!("v 0 0 0\nv 1 0 0\nv 0 1 0\n{face}{face}");
        assert_eq!(refused(&repeating), Refusal::TooLarge { unit: "triangles", found: 116, limit: 100 });
    }

    const FORMATS: [Format; 6] = [Format::Obj, Format::Off, Format::Ply, Format::Stl, Format::Glb, Format::Gltf];

    const OFF: &str = "OFF\n4 4 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n";
    const PLY: &str = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
                       element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
    const PLY_BINARY: &[u8] = b"ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty char x\n\
        property char y\nproperty char z\nelement face 1\nproperty list uchar uchar vertex_index\nend_header\n\
        \x00\x00\x00\x01\x00\x00\x00\x01\x00\x03\x00\x01\x02";
    const STL: &str = "solid\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\n\
                       endfacet\nendsolid\n";

    #[test]
    fn imports_every_text_sample_by_its_looks() {
        for sample in [CUBE.as_bytes(), OFF.as_bytes(), PLY.as_bytes(), PLY_BINARY, STL.as_bytes()] {
            let format = Format::sniff(sample).unwrap();
            assert!(import(sample, format, &Limits::default()).is_ok(), "{format:?}");
        }
    }

    proptest! {
        #[test]
        fn survives_any_bytes(bytes in prop::collection::vec(any::<u8>(), 0..300)) {
            for format in FORMATS {
                let _ = import(&bytes, format, &Limits::default());
            }
            let _ = Format::sniff(&bytes);
        }

        /// A valid file with bytes overwritten by digits, signs, blanks or anything, then cut.
        #[test]
        fn survives_damage(
            sample in prop::sample::select(vec![
                CUBE.as_bytes(), OFF.as_bytes(), PLY.as_bytes(), PLY_BINARY, STL.as_bytes()
            ]),
            damage in prop::collection::vec((any::<prop::sample::Index>(), prop_oneof![
                prop::sample::select(b"0123456789-+.e/\\# \n".to_vec()), any::<u8>()
            ]), 0..6),
            end in any::<prop::sample::Index>(),
            cut in any::<bool>(),
        ) {
            let mut bytes = sample.to_vec();
            damage.iter().for_each(|(at, byte)| { let at = at.index(bytes.len()); bytes[at] = *byte; });
            if cut {
                bytes.truncate(end.index(bytes.len()));
            }
            for format in FORMATS {
                if let Ok(imported) = import(&bytes, format, &Limits::default()) {
                    prop_assert!(imported.mesh.sound().area().is_finite() && imported.mesh.sound().area() > 0.0);
                }
            }
        }
    }
}
