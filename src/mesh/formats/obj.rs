//! Wavefront OBJ: the `v` and `f` lines.
//!
//! Read here and not by a crate, because answers name the user's vertices and lines: `v` lines keep their order, polygons
//! stay whole, groups and objects do not split anything, texture and normal indices do not double vertices.

use super::Polygons;
use super::text;
use crate::mesh::refusal::{Faults, Place, Refusal};
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
    let mut faults = Faults::default();
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
            Some(b"v") => match text::position(words) {
                Ok(position) => polygons.push_vertex(position, Some(number))?,
                Err(detail) => faults.push(Place::line(number), detail),
            },
            Some(b"f") => {
                match words.take(MOST_CORNERS + 1).map(|word| corner(word, polygons.positions.len())).collect() {
                    Ok::<Vec<i64>, _>(corners) => polygons.push_face(corners, Some(number))?,
                    Err(detail) => faults.push(Place::line(number), detail),
                }
            }
            Some(b"l" | b"p") => polygons.ignored += 1,
            _ => {}
        }
    }
    faults.into_result()?;
    Ok(polygons)
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

/// The vertex of a corner `v`, `v/vt`, `v//vn` or `v/vt/vn`, from 0. In the file vertices count from 1, and negative
/// numbers count back from the last vertex so far.
fn corner(word: &[u8], vertices_so_far: usize) -> Result<i64, String> {
    let vertex = word.split(|&b| b == b'/').next().unwrap_or_default();
    match text::integer(vertex) {
        None => Err(format!("a corner is not a number: {}", text::shown(word))),
        Some(0) => Err("a corner is vertex 0: in an obj file vertices count from 1".into()),
        Some(v) if v > 0 => Ok(v - 1),
        Some(v) => Ok(v.saturating_add(vertices_so_far as i64)),
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Format, Limits, Polygons, read};
    use crate::mesh::refusal::{Place, Refusal};

    fn obj(text: &str) -> Result<Polygons, Refusal> {
        read(text.as_bytes(), Format::Obj, &Limits::default())
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
    fn stops_at_the_limit_of_triangles() {
        let limits = Limits { triangles: 2, ..Limits::default() };
        let text = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\nf 1 2 3\n";
        let refusal = read(text.as_bytes(), Format::Obj, &limits).unwrap_err();
        assert_eq!(refusal, Refusal::TooLarge { unit: "triangles", found: 3, limit: 2 });
    }
}
