//! STL, text and binary. Every facet repeats its corners' coordinates: equal ones become one vertex, numbered by first
//! appearance.
//!
//! Read here and not by a crate, because the kind cannot be told by the word `solid` alone (binary headers have it too)
//! and because messages name lines.

use std::iter::Peekable;

use super::Polygons;
use super::text;
use super::weld::Weld;
use crate::mesh::refusal::{Place, Refusal};

/// Bytes before the facets: the header and their number.
const PREAMBLE: usize = 84;
/// Bytes of a facet: the normal, three corners, an attribute.
const FACET: usize = 50;
/// Bytes looked at to recognise a text.
const HEAD: usize = 1 << 12;

/// Whether the bytes are as many as a binary file's count says, or start like a text file.
pub(super) fn looks_like(bytes: &[u8]) -> bool {
    is_binary(bytes) || is_text(bytes)
}

pub(super) fn read(bytes: &[u8], polygons: Polygons) -> Result<Polygons, Refusal> {
    if !is_binary(bytes) && is_text(bytes) { read_text(bytes, polygons) } else { read_binary(bytes, polygons) }
}

fn announced(bytes: &[u8]) -> Option<u64> {
    let count = bytes.get(PREAMBLE - 4..PREAMBLE)?;
    count.try_into().ok().map(u32::from_le_bytes).map(u64::from)
}

fn is_binary(bytes: &[u8]) -> bool {
    announced(bytes).is_some_and(|count| count > 0 && bytes.len() as u64 == PREAMBLE as u64 + FACET as u64 * count)
}

fn is_text(bytes: &[u8]) -> bool {
    let mut words = text::words(&bytes[..bytes.len().min(HEAD)]);
    let is = |word: &[u8], keyword: &str| word.eq_ignore_ascii_case(keyword.as_bytes());
    words.next().is_some_and(|first| is(first, "solid")) && words.any(|word| is(word, "facet") || is(word, "endsolid"))
}

/// The vertices and faces of facets that arrive corner by corner.
struct Facets {
    polygons: Polygons,
    weld: Weld,
    corners: Vec<i64>,
}

impl Facets {
    fn new(polygons: Polygons) -> Facets {
        Facets { polygons, weld: Weld::default(), corners: Vec::with_capacity(3) }
    }

    fn push_corner(&mut self, position: [f64; 3], line: Option<u64>) -> Result<(), Refusal> {
        let next = self.polygons.positions.len();
        let vertex = self.weld.first(position, next as u32);
        if vertex as usize == next {
            self.polygons.push_vertex(position, line)?;
        }
        self.corners.push(vertex.into());
        Ok(())
    }

    /// Ends the facet that began on this line.
    fn end(&mut self, start: u64) -> Result<(), Refusal> {
        match self.corners.len() {
            3 => self.finish(Some(start)),
            corners => self.give_up(start, format!("a facet of {corners} vertices: 3 are needed")),
        }
    }

    /// Ends the facet that began on this line and cannot be read.
    fn give_up(&mut self, start: u64, detail: impl Into<String>) -> Result<(), Refusal> {
        self.corners.clear();
        self.polygons.push_unread_face(detail.into(), start)
    }

    fn finish(&mut self, line: Option<u64>) -> Result<(), Refusal> {
        self.polygons.push_face(self.corners.drain(..), line)
    }
}

fn read_binary(bytes: &[u8], polygons: Polygons) -> Result<Polygons, Refusal> {
    let count = announced(bytes).ok_or_else(|| {
        Refusal::because(Place::file(), format!("an stl file has at least {PREAMBLE} bytes, this one {}", bytes.len()))
    })?;
    let facets = &bytes[PREAMBLE..];
    let present = (facets.len() / FACET) as u64;
    if count > present {
        let detail = format!("the header announces {count} triangles, the file has {present}");
        return Err(Refusal::because(Place::file(), detail));
    }
    // Some programs leave the number 0, others write more behind the facets.
    let facets = &facets[..FACET * if count == 0 { present } else { count } as usize];
    let mut read = Facets::new(polygons);
    for facet in facets.chunks_exact(FACET) {
        let (coordinates, _) = facet[12..48].as_chunks::<4>();
        let (corners, _) = coordinates.as_chunks::<3>();
        for corner in corners {
            // Negative zero becomes zero, so that equal points have equal bits.
            read.push_corner(corner.map(|x| f64::from(f32::from_le_bytes(x)) + 0.0), None)?;
        }
        read.finish(None)?;
    }
    Ok(read.polygons)
}

fn read_text(bytes: &[u8], polygons: Polygons) -> Result<Polygons, Refusal> {
    let mut read = Facets::new(polygons);
    let mut start = 0;
    let mut words = text::numbered_words(bytes).peekable();
    while let Some((line, word)) = words.next() {
        match word.to_ascii_lowercase().as_slice() {
            b"solid" | b"endsolid" => skip_name(line, &mut words),
            b"facet" => {
                if !read.corners.is_empty() {
                    read.give_up(start, "this facet has no end")?;
                }
                start = line;
            }
            b"vertex" => {
                let is_keyword = |word: &[u8]| word.first().is_some_and(|b| matches!(b | 32, b'v' | b'e' | b'f'));
                let coordinates =
                    std::iter::from_fn(|| words.next_if(|(_, word)| !is_keyword(word)).map(|(_, word)| word));
                match text::position(coordinates.take(3)) {
                    Ok(position) => read.push_corner(position, Some(line))?,
                    Err(detail) => read.polygons.faults.push(Place::line(line), detail),
                }
            }
            b"endfacet" => read.end(start)?,
            b"end" if words.next_if(|(_, word)| word.eq_ignore_ascii_case(b"facet")).is_some() => {
                read.end(start)?;
            }
            _ => {}
        }
    }
    if !read.corners.is_empty() {
        read.give_up(start, "the file ends within this facet")?;
    }
    Ok(read.polygons)
}

/// Passes over the name of a solid: what stands on its line, up to a facet where there is one.
fn skip_name<'a>(line: u64, words: &mut Peekable<impl Iterator<Item = (u64, &'a [u8])> + Clone>) {
    let is = |word: Option<(u64, &[u8])>, keyword: &str| {
        word.is_some_and(|(_, word)| word.eq_ignore_ascii_case(keyword.as_bytes()))
    };
    while words.peek().is_some_and(|&(next, _)| next == line) {
        let mut ahead = words.clone();
        if is(ahead.next(), "facet") && is(ahead.next(), "normal") {
            return;
        }
        words.next();
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Format, Limits, read};
    use super::*;

    const TETRAHEDRON: [[[f32; 3]; 3]; 4] = {
        let [o, x, y, z] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [-0.0, 0.0, 1.0]];
        [[o, y, x], [o, x, z], [o, z, y], [x, y, z]]
    };

    fn binary(header: &[u8]) -> Vec<u8> {
        let mut bytes = header.to_vec();
        bytes.resize(80, 0);
        bytes.extend(4u32.to_le_bytes());
        for facet in TETRAHEDRON {
            bytes.extend([0; 12]);
            facet.as_flattened().iter().for_each(|x| bytes.extend(x.to_le_bytes()));
            bytes.extend([0; 2]);
        }
        bytes
    }

    fn text() -> String {
        let facet = |facet: [[f32; 3]; 3]| {
            let corners: String = facet.iter().map(|[x, y, z]| format!("vertex {x} {y} {z:e}\n")).collect();
            format!("facet normal 0 0 0\n outer loop\n{corners} endloop\nendfacet\n")
        };
        format!("solid a b\n{}endsolid a b\n", TETRAHEDRON.map(facet).concat())
    }

    #[test]
    fn welds_by_first_appearance_in_both_kinds() {
        for bytes in [binary(b"solid facet"), binary(b""), text().into_bytes()] {
            assert_eq!(Format::sniff(&bytes), Some(Format::Stl));
            let polygons = read(&bytes, Format::Stl, &Limits::default()).unwrap();
            assert_eq!(polygons.positions, [[0., 0., 0.], [0., 1., 0.], [1., 0., 0.], [0., 0., 1.]]);
            let faces: Vec<_> = polygons.faces().map(<[i64]>::to_vec).collect();
            assert_eq!(faces, [[0, 1, 2], [0, 2, 3], [0, 3, 1], [2, 1, 3]]);
        }
    }

    #[test]
    fn tells_lines_of_a_text() {
        let polygons = read(text().as_bytes(), Format::Stl, &Limits::default()).unwrap();
        assert_eq!(polygons.vertex_place(1).line, Some(5));
        assert_eq!(polygons.face_place(1).line, Some(9));
    }

    #[test]
    fn refuses_counts_that_disagree_with_the_length() {
        let mut short = binary(b"");
        short.truncate(84 + 120);
        let mut hostile = binary(b"");
        hostile[80..84].copy_from_slice(&u32::MAX.to_le_bytes());
        for bytes in [short, hostile, b"solid".to_vec(), Vec::new()] {
            assert!(matches!(read(&bytes, Format::Stl, &Limits::default()), Err(Refusal::Invalid(_))));
        }
    }

    #[test]
    fn names_the_lines_of_broken_facets() {
        let text = "solid\nfacet normal 0 0 1\nvertex 0 0 0\nvertex 1 0 x\nendfacet\nfacet\nvertex 0 0 0\nfacet\nendfacet\n\
                    facet\nvertex 0 0 0\nendsolid\n";
        let polygons = read(text.as_bytes(), Format::Stl, &Limits::default()).unwrap();
        let lines: Vec<_> = polygons.faults.listed.iter().filter_map(|fault| fault.place.line).collect();
        assert_eq!(lines, [4, 2, 6, 8, 10]);
    }

    proptest::proptest! {
        #[test]
        fn survives_damage_to_binary_files(
            damage in proptest::collection::vec((0usize..284, proptest::prelude::any::<u8>()), 0..5),
            length in 0usize..=284,
        ) {
            let mut bytes = binary(b"");
            damage.iter().for_each(|&(at, byte)| bytes[at] = byte);
            let _ = read(&bytes, Format::Stl, &Limits::default());
            let _ = read(&bytes[..length], Format::Stl, &Limits::default());
        }
    }
}
