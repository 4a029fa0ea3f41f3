//! What is mended, and told.

use super::*;

#[test]
fn turns_an_inconsistent_closed_mesh_outward() {
    // Four of six faces are turned inward: the majority does not count where there is an outside.
    let text = CUBE.replace("f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6", "f 1 2 3 4\nf 8 7 6 5\nf 5 6 2 1\nf 6 7 3 2");
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
                let moved: Vec<String> = corners.iter().map(|c| (c.parse::<i32>().unwrap() + 8).to_string()).collect();
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
    let vertices: String = CUBE.lines().filter(|line| line.starts_with('v')).map(|line| format!("{line}\n")).collect();
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
