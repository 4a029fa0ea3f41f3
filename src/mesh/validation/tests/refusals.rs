//! What is refused, with every reason in its place.

use super::*;

fn reasons(text: &str) -> Vec<String> {
    let Err(Refusal::Invalid(faults)) = obj(text) else { panic!("not refused as invalid: {text}") };
    faults.listed.iter().map(ToString::to_string).collect()
}

#[test]
fn lists_the_faults_of_lines_and_those_of_faces() {
    let text = "v 0 0 0\nv 1 x 0\nv 0 1 0\nv nan 0 0\nf 1 2 3\nf 1 2 7\nf 1 a 3\nf 1 3 4\nf 3 2 9\n";
    assert_eq!(
        reasons(text),
        [
            "line 2: a coordinate is not a number: \"x\"",
            "line 7: a corner is none of v, v/vt, v//vn and v/vt/vn: \"f 1 a 3\"",
            "line 6, face 1: vertex 7 is out of range: there are 4, from 1",
            "line 9, face 4: vertex 9 is out of range: there are 4, from 1",
            "line 4, vertex 3: a coordinate is not a finite number: [NaN, 0.0, 0.0]",
        ]
    );
    let back = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 -9\nf 1 2 3\n";
    assert_eq!(reasons(back), ["line 4, face 0: a corner counts back beyond the first vertex: there are 3"]);
    let off = "OFF\n3 2 0\n0 0 0\n1 0\n0 1 0\n3 0 1 2\n3 0 1 5\n";
    let Err(Refusal::Invalid(faults)) = import(off.as_bytes(), Format::Off, &Limits::default()) else {
        panic!("accepted")
    };
    let lines: Vec<_> = faults.listed.iter().map(|fault| fault.place.line).collect();
    assert_eq!(lines, [Some(4), Some(7)]);
}

#[test]
fn refuses_with_every_reason_in_its_place() {
    let text = "v 0 0 0\nv 1 0 0\nv nan 1 0\nv 1 inf 0\nv 2 0 0\nv 0 3 0\nf 1 2 9\nf 1 2 6\nf 2 1 4 3\n";
    let expected = [
        "line 7, face 0: vertex 9 is out of range: there are 6, from 1",
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
    let points =
        "file: there are no faces, only points: make a surface of them first, for example by Poisson reconstruction";
    assert_eq!(reasons("v 0 0 0\n"), [points]);
    let lines = "file: there are no faces, only lines or points: save the surface itself";
    assert_eq!(reasons("v 0 0 0\nv 1 0 0\nl 1 2\n"), [lines]);
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
