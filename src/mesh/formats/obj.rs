//! Wavefront OBJ: the `v` and `f` lines.
//!
//! tobj reads the faces. It renumbers vertices by their first use, names no line, and splits a file by its groups, while
//! answers name the vertices and lines of the user's file. So it is given the geometry alone, and every vertex has its
//! own number for a coordinate: the positions of what tobj returns tell which vertices they are.

use tobj::{LoadError, LoadOptions, Mesh};

use super::text;
use super::{Polygons, triangles_of};
use crate::mesh::refusal::{Place, Refusal};
use crate::mesh::soundness::MOST_CORNERS;

/// Bytes looked at to recognise a file.
const HEAD: usize = 1 << 16;

/// Whether one of the first lines is a vertex.
pub(super) fn looks_like(bytes: &[u8]) -> bool {
    text::lines(&bytes[..bytes.len().min(HEAD)]).any(|(_, line)| {
        let mut words = text::words(line);
        words.next() == Some(b"v") && text::position(words).is_ok()
    })
}

pub(super) fn read(bytes: &[u8], mut polygons: Polygons) -> Result<Polygons, Refusal> {
    polygons.first_vertex = 1;
    let geometry = Geometry::of(bytes, &mut polygons)?;
    match parsed(&geometry.text) {
        Ok(mesh) => geometry.take(&mesh, &mut polygons)?,
        Err(_) => geometry.explain(&mut polygons)?,
    }
    Ok(polygons)
}

/// What tobj makes of a text without groups: one mesh, its polygons whole.
fn parsed(text: &str) -> Result<Mesh, LoadError> {
    let no_materials = |_: &std::path::Path| Err(LoadError::OpenFileFailed);
    let (models, _) = tobj::load_obj_buf(&mut text.as_bytes(), &LoadOptions::default(), no_materials)?;
    Ok(models.into_iter().next().map(|model| model.mesh).unwrap_or_default())
}

/// The part of a file that tobj is given.
#[derive(Default)]
struct Geometry {
    /// A line `v NUMBER 0 0` for every vertex, numbered from 0, and the `f` lines between them as they stand in the
    /// file.
    text: String,
    /// Per face its line in the file.
    lines: Vec<u64>,
    triangles: usize,
}

impl Geometry {
    /// The geometry of a file, whose vertices are added to `polygons` here: tobj would divide them by their weights.
    fn of(bytes: &[u8], polygons: &mut Polygons) -> Result<Geometry, Refusal> {
        let mut geometry = Geometry::default();
        let mut lines = text::lines(bytes);
        while let Some((number, first)) = lines.next() {
            let joined;
            let line = if first.ends_with(b"\\") {
                joined = continued(first, &mut lines);
                &joined
            } else {
                first
            };
            let mut words = text::words(line);
            match words.next() {
                Some(b"v") => {
                    geometry.text += &format!("v {} 0 0\n", polygons.positions.len());
                    match text::position(words) {
                        Ok(position) => polygons.push_vertex(position, Some(number))?,
                        Err(detail) => polygons.push_unread_vertex(detail, number)?,
                    }
                }
                Some(b"f") => {
                    let face = std::str::from_utf8(line).unwrap_or_else(|_| {
                        polygons.faults.push(Place::line(number), unreadable(line));
                        // A face without corners keeps its place among the others.
                        "f"
                    });
                    geometry.push_face(face, number, polygons)?;
                }
                Some(b"l" | b"p") => polygons.ignored += 1,
                _ => {}
            }
        }
        Ok(geometry)
    }

    /// Adds a face. tobj knows no limits: corners and triangles are counted before it takes memory for them.
    fn push_face(&mut self, face: &str, line: u64, polygons: &Polygons) -> Result<(), Refusal> {
        // tobj separates words in the same way.
        let corners = face.split_whitespace().skip(1).take(MOST_CORNERS + 1);
        self.text.push('f');
        let mut count = 0;
        for corner in corners {
            self.text.push(' ');
            self.text.push_str(corner);
            count += 1;
        }
        self.text.push('\n');
        self.lines.push(line);
        self.triangles += triangles_of(count);
        polygons.limits.admit_triangles(self.triangles)
    }

    /// Adds the faces of the mesh that tobj made of this geometry.
    fn take(&self, mesh: &Mesh, polygons: &mut Polygons) -> Result<(), Refusal> {
        let mut vertices = mesh.indices.iter().map(|&i| mesh.positions[3 * i as usize] as i64);
        for (f, &line) in self.lines.iter().enumerate() {
            // Where all faces are triangles tobj leaves the list out.
            let corners = mesh.face_arities.get(f).map_or(3, |&arity| arity as usize);
            polygons.push_face(vertices.by_ref().take(corners), Some(line))?;
        }
        Ok(())
    }

    /// Tells what is wrong with the faces tobj refused, for it does not say which they are. Those that name vertices
    /// out of range are added with the sound ones, to be refused among all that is wrong with the mesh.
    fn explain(&self, polygons: &mut Polygons) -> Result<(), Refusal> {
        let mut lines = self.lines.iter();
        let mut vertices_so_far = 0;
        for statement in self.text.lines() {
            if statement.starts_with('v') {
                vertices_so_far += 1;
            } else if let Some(&line) = lines.next() {
                match stated_corners(statement, vertices_so_far) {
                    Ok(corners) => polygons.push_face(corners, Some(line))?,
                    Err(detail) => polygons.push_unread_face(detail, line)?,
                }
            }
        }
        Ok(())
    }
}

/// A line that ends in a backslash together with those it goes on in.
fn continued<'a>(first: &[u8], rest: &mut impl Iterator<Item = (u64, &'a [u8])>) -> Vec<u8> {
    let mut joined = first.to_vec();
    while joined.last() == Some(&b'\\') {
        joined.pop();
        joined.push(b' ');
        if let Some((_, next)) = rest.next() {
            joined.extend_from_slice(next);
        }
    }
    joined
}

/// The vertices a face names, from 0, in range or not; what tobj cannot read in it otherwise. In the file vertices count
/// from 1, and negative numbers count back from the last vertex so far.
fn stated_corners(face: &str, vertices_so_far: i64) -> Result<Vec<i64>, String> {
    // Alone, without vertices, a face that can be read is out of bounds.
    if let Err(LoadError::FaceParseError) = parsed(face) {
        return Err(unreadable(face.as_bytes()));
    }
    let vertex = |corner: &str| corner.split('/').next().and_then(|vertex| vertex.parse::<i64>().ok());
    let from_zero = |corner| match vertex(corner) {
        None => Err(format!("a corner names no vertex: {}", text::shown(corner.as_bytes()))),
        Some(0) => Err("a corner is vertex 0: in an obj file vertices count from 1".into()),
        Some(v) if v > 0 => Ok(v - 1),
        Some(v) => Ok(v.saturating_add(vertices_so_far)),
    };
    face.split_whitespace().skip(1).map(from_zero).collect()
}

fn unreadable(face: &[u8]) -> String {
    format!("a corner is none of v, v/vt, v//vn and v/vt/vn: {}", text::shown(face))
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::super::{Format, Limits, Polygons, read};
    use super::MOST_CORNERS;
    use crate::mesh::refusal::{Place, Refusal};

    fn obj(text: &str) -> Result<Polygons, Refusal> {
        let polygons = read(text.as_bytes(), Format::Obj, &Limits::default())?;
        polygons.faults.clone().into_result().map(|()| polygons)
    }

    fn faces(polygons: &Polygons) -> Vec<Vec<i64>> {
        polygons.faces().map(<[i64]>::to_vec).collect()
    }

    #[test]
    fn keeps_the_ids_of_the_file() {
        let text = "# header\nmtllib a.mtl\no one\nv 9 9 9\nv 0 0 0 1.0\nv 1 0 0 0.5 0.5 0.5\nvt 0 0\nvn 0 0 1\ng left\n\
                    f 2/1/1 3/1/1 4/1/1\no two\nv 0 1 0\nv 1 1 0\nf 3//1 -1//1 -2//1\nf 2 3 5 4\n";
        let polygons = obj(text).unwrap();
        assert_eq!(polygons.positions.len(), 5);
        assert_eq!(polygons.positions[0], [9.0; 3]);
        assert_eq!(faces(&polygons), [vec![1, 2, 3], vec![2, 4, 3], vec![1, 2, 4, 3]]);
        assert_eq!(polygons.vertex_place(3).line, Some(12));
        assert_eq!(polygons.face_place(2).line, Some(15));
    }

    #[test]
    fn ignores_lines_points_and_unreadable_comments() {
        let mut bytes = b"# caf\xe9\r\nv 0 0 0\r\nv 1 0 0\r\nv 0 1 0\r\nl 1 2 3\r\np 1\r\n".to_vec();
        bytes.extend_from_slice(b"f 1 \\\r\n 2 \\\r\n 3 # \xff\r\n");
        let polygons = read(&bytes, Format::Obj, &Limits::default()).unwrap();
        assert_eq!(faces(&polygons), [vec![0, 1, 2]]);
        assert_eq!(polygons.ignored, 2);
    }

    #[test]
    fn names_every_unreadable_line() {
        let Err(Refusal::Invalid(faults)) = obj("v 0 0\nv 0 x 0\nv 0 0 0\nf 1 0 1\nf a b c\nf 1/ 1 1\n") else {
            panic!("accepted")
        };
        let lines: Vec<_> = faults.listed.iter().map(|fault| fault.place.clone()).collect();
        assert_eq!(lines, [1, 2, 4, 5].map(Place::line));
    }

    #[test]
    fn names_the_faces_that_cannot_be_read() {
        let text =
            "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1/1/1/1 2 3\nf 1/a 2 3\nf /1 2 3\nf 1 2 99999999999999999999\nf 1 2 3\n";
        let Err(Refusal::Invalid(faults)) = obj(text) else { panic!("accepted") };
        let lines: Vec<_> = faults.listed.iter().map(|fault| fault.place.clone()).collect();
        assert_eq!(lines, [4, 5, 6, 7].map(Place::line));
        let polygons = read(b"f 1 2 \xff\nf 1 1 1\n", Format::Obj, &Limits::default()).unwrap();
        assert_eq!(polygons.faults.listed[0].place, Place::line(1));
        assert_eq!(polygons.face_place(1).line, Some(2));
    }

    #[test]
    fn leaves_vertices_out_of_range_and_their_faces_as_stated() {
        let polygons = obj(&format!("v 0 0 0\nf 1 {} {} -2\nf 1\nf\n", i64::MAX, i64::MIN)).unwrap();
        assert_eq!(faces(&polygons), [vec![0, i64::MAX - 1, i64::MIN + 1, -1], vec![0], vec![]]);
    }

    #[test]
    fn takes_no_more_corners_than_are_judged() {
        // \x0b is a blank to tobj alone.
        for blank in [" ", "\x0b", "\u{a0}"] {
            let polygons = obj(&format!("v 0 0 0\nf 1 {}", format!("1{blank}").repeat(1 << 16))).unwrap();
            assert_eq!(faces(&polygons), [vec![0; MOST_CORNERS + 1]]);
        }
    }

    #[test]
    fn stops_at_the_limit_of_triangles() {
        let limits = Limits { triangles: 2, ..Limits::default() };
        let text = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\nf 1 2 3\n";
        let refusal = read(text.as_bytes(), Format::Obj, &limits).unwrap_err();
        assert_eq!(refusal, Refusal::TooLarge { unit: "triangles", found: 3, limit: 2 });
    }

    /// A corner of vertex `id`, from 0, in one of the forms of the format, after `so_far` vertices.
    fn corner(id: i64, so_far: i64, form: usize) -> String {
        let number = if form % 2 == 1 && id < so_far { id - so_far } else { id + 1 };
        format!("{number}{}", ["", "/7", "//-9", "/", "/2/5"][form % 5])
    }

    proptest! {
        /// Vertices of later lines, groups, materials and every form of corner; then the same with a face out of range.
        #[test]
        fn reads_the_faces_that_are_written(
            faces_at in prop::collection::vec(
                prop::collection::vec((0..9i64, 0..10usize), 0..6), 9),
        ) {
            let (mut text, mut written, mut lines) = (String::new(), Vec::new(), Vec::new());
            for (v, corners) in (1..).zip(faces_at) {
                text += &format!("v {v} 0.1 -0 0.5\nvt 0 0\ng part {v}\nusemtl m{v}\n");
                let words: Vec<_> = corners.iter().map(|&(id, form)| corner(id, v, form)).collect();
                text += &format!("f {}\n", words.join(" "));
                written.push(corners.iter().map(|&(id, _)| id).collect::<Vec<_>>());
                lines.push(Some(5 * v as u64));
            }
            let polygons = obj(&text).unwrap();
            prop_assert_eq!(&faces(&polygons), &written);
            prop_assert_eq!((0..9).map(|f| polygons.face_place(f).line).collect::<Vec<_>>(), lines);
            prop_assert_eq!(polygons.positions[8], [9.0, 0.1, 0.0]);
            written.push(vec![0, 9, 2]);
            prop_assert_eq!(faces(&obj(&(text + "f 1 10 3\n")).unwrap()), written);
        }
    }
}
