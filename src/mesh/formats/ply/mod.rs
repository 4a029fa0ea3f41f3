//! Stanford PLY, text and binary of either byte order.
//!
//! Read here and not by a crate: those at hand know neither integers of eight bytes nor blank and wrapped lines nor strips
//! of triangles, and stop at a NaN in a property nobody reads.

mod header;

use std::array::from_fn;
use std::iter::Peekable;

use super::{Polygons, text};
use crate::mesh::refusal::{Place, Refusal};
use header::{Element, Encoding, Header, Kind, Property, Scalar};

/// Both names are in use, for faces and for strips.
const CORNERS: [&str; 2] = ["vertex_indices", "vertex_index"];

pub(super) fn looks_like(bytes: &[u8]) -> bool {
    bytes.strip_prefix(b"ply").and_then(<[u8]>::first).is_some_and(u8::is_ascii_whitespace)
}

pub(super) fn read(bytes: &[u8], mut polygons: Polygons) -> Result<Polygons, Refusal> {
    let (header, body, line) = Header::of(bytes)?;
    match header.encoding {
        Encoding::Text => {
            let words = text::numbered_words(body).map(move |(number, word)| (number + line - 1, word));
            let read = |of_one_line: bool| {
                let mut polygons = Polygons::new(polygons.limits);
                let words = Words { words: words.clone().peekable(), line, of_one_line };
                read_elements(&header, words, body.len(), &mut polygons).map(|()| polygons)
            };
            // Some programs write more on the line of an element than they announce; others break lines where they like. What
            // is wrong with the lines is told; a file that ended too soon by them may only be broken otherwise.
            read(true).or_else(|by_lines| {
                read(false).map_err(|otherwise| if by_lines == ended() { otherwise } else { by_lines })
            })
        }
        Encoding::Binary { little } => {
            read_elements(&header, Bytes { rest: body, little }, body.len(), &mut polygons)?;
            Ok(polygons)
        }
    }
}

fn read_elements(
    header: &Header,
    mut values: impl Values,
    bytes: usize,
    polygons: &mut Polygons,
) -> Result<(), Refusal> {
    for element in &header.elements {
        let Element { name, count, properties } = element;
        if *count > 0 && properties.is_empty() {
            return Err(Refusal::because(Place::file(), format!("element {name} has no properties")));
        }
        // Every element takes a byte at least.
        if *count > bytes {
            let detail = format!("the header announces {count} of element {name}, {bytes} bytes follow it");
            return Err(Refusal::because(Place::file(), detail));
        }
        match name.as_str() {
            "vertex" => {
                let axes = axes(element)?;
                polygons.limits.admit_vertices(*count)?;
                for _ in 0..*count {
                    let (position, line) = vertex(properties, axes, &mut values)?;
                    polygons.push_vertex(position, line)?;
                    values.end();
                }
            }
            "face" | "tristrips" if *count > 0 => {
                let corners = corners(element)?;
                for _ in 0..*count {
                    faces(properties, corners, name == "tristrips", &mut values, polygons)?;
                    values.end();
                }
            }
            _ => {
                for _ in 0..*count {
                    properties.iter().try_for_each(|property| skip(property, &mut values))?;
                    values.end();
                }
                polygons.ignored += count;
            }
        }
    }
    Ok(())
}

/// Where x, y and z stand among the properties of a vertex.
fn axes(vertex: &Element) -> Result<[usize; 3], Refusal> {
    let place = |name| vertex.properties.iter().position(|p| p.name == name && matches!(p.kind, Kind::Scalar(_)));
    let places = ["x", "y", "z"].map(place);
    match (0..3).find(|&axis| places[axis].is_none()) {
        None => Ok(places.map(Option::unwrap_or_default)),
        Some(axis) => {
            let detail = format!("element vertex has no number {}", ["x", "y", "z"][axis]);
            Err(Refusal::because(Place::file(), detail))
        }
    }
}

/// Where the list of corners stands among the properties of a face or strip: under its name, else the only list of whole
/// numbers.
fn corners(face: &Element) -> Result<usize, Refusal> {
    let is_corners = |p: &Property| CORNERS.contains(&p.name.as_str()) && matches!(p.kind, Kind::List(..));
    let is_whole = |p: &Property| matches!(p.kind, Kind::List(_, kind) if kind.is_whole());
    let mut lists = (0..face.properties.len()).filter(|&place| is_whole(&face.properties[place]));
    let only = lists.next().filter(|_| lists.next().is_none());
    let place = face.properties.iter().position(is_corners).or(only);
    place.ok_or_else(|| Refusal::because(Place::file(), format!("element {} has no list vertex_indices", face.name)))
}

fn vertex(
    properties: &[Property],
    axes: [usize; 3],
    values: &mut impl Values,
) -> Result<([f64; 3], Option<u64>), Refusal> {
    let mut position = [0.0; 3];
    let mut line = None;
    for (place, property) in properties.iter().enumerate() {
        match (axes.iter().position(|&axis| axis == place), &property.kind) {
            // Negative zero becomes zero, so that equal points have equal bits.
            (Some(axis), Kind::Scalar(kind)) => position[axis] = values.number(*kind, &property.name)? + 0.0,
            _ => skip(property, values)?,
        }
        line = line.or(values.line());
    }
    Ok((position, line))
}

/// Reads a face, or the triangles of a strip.
fn faces(
    properties: &[Property],
    corners: usize,
    is_strip: bool,
    values: &mut impl Values,
    polygons: &mut Polygons,
) -> Result<(), Refusal> {
    let mut list: Vec<i64> = Vec::new();
    let mut line = None;
    for (place, property) in properties.iter().enumerate() {
        match &property.kind {
            Kind::List(count, kind) if place == corners => {
                let length = values.length(*count, &property.name)?;
                line = values.line();
                polygons.admit_face(length)?;
                list.reserve(length);
                for _ in 0..length {
                    list.push(values.index(*kind, &property.name)?);
                }
            }
            _ => skip(property, values)?,
        }
    }
    if !is_strip {
        return polygons.push_face(list, line);
    }
    // A number below 0 ends a strip and begins another one; every other triangle is turned.
    for strip in list.split(|&v| v < 0 || v == i64::from(u32::MAX)) {
        for (i, w) in strip.windows(3).enumerate() {
            polygons.push_face(if i % 2 == 0 { [w[0], w[1], w[2]] } else { [w[1], w[0], w[2]] }, line)?;
        }
    }
    Ok(())
}

fn skip(property: &Property, values: &mut impl Values) -> Result<(), Refusal> {
    match property.kind {
        Kind::Scalar(kind) => values.skip(kind, 1),
        Kind::List(count, kind) => {
            let length = values.length(count, &property.name)?;
            values.skip(kind, length)
        }
    }
}

/// The values of a body one after the other.
trait Values {
    /// The next value, which has to be a number.
    fn number(&mut self, kind: Scalar, of: &str) -> Result<f64, Refusal>;
    /// Passes over values, whatever they are.
    fn skip(&mut self, kind: Scalar, count: usize) -> Result<(), Refusal>;
    /// Passes over what follows an element and does not belong to another.
    fn end(&mut self) {}
    /// The line of the last value in a text.
    fn line(&self) -> Option<u64>;
    /// How much may follow at most.
    fn left(&self) -> usize;

    fn place(&self) -> Place {
        self.line().map_or(Place::file(), Place::line)
    }

    /// The next value as a whole number, as which `255.0` counts.
    fn index(&mut self, kind: Scalar, of: &str) -> Result<i64, Refusal> {
        let number = self.number(kind, of)?;
        if number.fract() == 0.0 && number.abs() < 9e15 {
            return Ok(number as i64);
        }
        Err(Refusal::because(self.place(), format!("{of} holds {number}, which is no whole number")))
    }

    /// The length of a list, no more than may follow.
    fn length(&mut self, kind: Scalar, of: &str) -> Result<usize, Refusal> {
        let length = self.index(kind, of)?;
        match usize::try_from(length) {
            Ok(length) if length <= self.left() => Ok(length),
            _ => Err(Refusal::because(self.place(), format!("a list {of} of {length} values, more than the file has"))),
        }
    }
}

/// The words of a text.
struct Words<I: Iterator> {
    words: Peekable<I>,
    line: u64,
    /// Whether no other element begins on the line of one.
    of_one_line: bool,
}

impl<'a, I: Iterator<Item = (u64, &'a [u8])>> Words<I> {
    fn next(&mut self) -> Result<&'a [u8], Refusal> {
        let (line, word) = self.words.next().ok_or_else(ended)?;
        self.line = line;
        Ok(word)
    }
}

impl<'a, I: Iterator<Item = (u64, &'a [u8])>> Values for Words<I> {
    fn number(&mut self, _: Scalar, of: &str) -> Result<f64, Refusal> {
        let word = self.next()?;
        let number = text::number(word);
        number.ok_or_else(|| Refusal::because(self.place(), format!("{of} is not a number: {}", text::shown(word))))
    }

    fn skip(&mut self, _: Scalar, count: usize) -> Result<(), Refusal> {
        (0..count).try_for_each(|_| self.next().map(|_| ()))
    }

    fn end(&mut self) {
        if self.of_one_line {
            while self.words.next_if(|(line, _)| *line == self.line).is_some() {}
        }
    }

    fn line(&self) -> Option<u64> {
        Some(self.line)
    }

    fn left(&self) -> usize {
        // Whatever is missing is missed when it is read.
        usize::MAX
    }
}

/// The bytes of a binary body.
struct Bytes<'a> {
    rest: &'a [u8],
    little: bool,
}

impl Bytes<'_> {
    fn take<const N: usize>(&mut self) -> Result<[u8; N], Refusal> {
        let (bytes, rest) = self.rest.split_first_chunk::<N>().ok_or_else(ended)?;
        self.rest = rest;
        Ok(if self.little { *bytes } else { from_fn(|i| bytes[N - 1 - i]) })
    }
}

impl Values for Bytes<'_> {
    fn number(&mut self, kind: Scalar, _: &str) -> Result<f64, Refusal> {
        Ok(match kind {
            Scalar::I8 => i8::from_le_bytes(self.take()?).into(),
            Scalar::U8 => u8::from_le_bytes(self.take()?).into(),
            Scalar::I16 => i16::from_le_bytes(self.take()?).into(),
            Scalar::U16 => u16::from_le_bytes(self.take()?).into(),
            Scalar::I32 => i32::from_le_bytes(self.take()?).into(),
            Scalar::U32 => u32::from_le_bytes(self.take()?).into(),
            Scalar::I64 => i64::from_le_bytes(self.take()?) as f64,
            Scalar::U64 => u64::from_le_bytes(self.take()?) as f64,
            Scalar::F32 => f32::from_le_bytes(self.take()?).into(),
            Scalar::F64 => f64::from_le_bytes(self.take()?),
        })
    }

    fn skip(&mut self, kind: Scalar, count: usize) -> Result<(), Refusal> {
        let bytes = count.checked_mul(kind.size()).filter(|&bytes| bytes <= self.rest.len()).ok_or_else(ended)?;
        self.rest = &self.rest[bytes..];
        Ok(())
    }

    fn line(&self) -> Option<u64> {
        None
    }

    fn left(&self) -> usize {
        self.rest.len()
    }
}

fn ended() -> Refusal {
    Refusal::because(Place::file(), "the file ends before all that its header announces")
}

#[cfg(test)]
mod tests {
    use super::super::{Format, Limits, read};
    use super::*;

    fn header(encoding: &str) -> String {
        format!(
            "ply\nformat {encoding} 1.0\ncomment made by hand\nelement vertex 4\nproperty float x\nproperty float y\n\
             property double z\nproperty uchar red\nelement face 2\nproperty list uchar int vertex_indices\n\
             element edge 1\nproperty int vertex1\nend_header\n"
        )
    }

    const POSITIONS: [[f32; 3]; 4] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.5], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
    const FACES: [&[i32]; 2] = [&[0, 1, 2, 3], &[2, 1, 0]];

    fn text() -> Vec<u8> {
        let mut text = header("ascii");
        POSITIONS.iter().for_each(|[x, y, z]| text += &format!("{x} {y} {z} 255\n"));
        text += "4 0 1 2 3\n3 2 1 0\n7\n";
        text.into_bytes()
    }

    fn binary(encoding: &str, order: impl Fn(&[u8]) -> Vec<u8>) -> Vec<u8> {
        let mut bytes = header(encoding).into_bytes();
        for [x, y, z] in POSITIONS {
            bytes.extend(order(&x.to_le_bytes()));
            bytes.extend(order(&y.to_le_bytes()));
            bytes.extend(order(&f64::from(z).to_le_bytes()));
            bytes.push(255);
        }
        for face in FACES {
            bytes.push(face.len() as u8);
            face.iter().for_each(|v| bytes.extend(order(&v.to_le_bytes())));
        }
        bytes.extend(order(&7i32.to_le_bytes()));
        bytes
    }

    #[test]
    fn reads_all_three_encodings_alike() {
        let little = binary("binary_little_endian", <[u8]>::to_vec);
        let big = binary("binary_big_endian", |bytes| bytes.iter().rev().copied().collect());
        let windows = String::from_utf8(text()).unwrap().replace('\n', "\r\n").into_bytes();
        let other_name = String::from_utf8(text()).unwrap().replace("vertex_indices", "vertex_index").into_bytes();
        for bytes in [text(), windows, other_name, little, big] {
            assert_eq!(Format::sniff(&bytes), Some(Format::Ply));
            let polygons = read(&bytes, Format::Ply, &Limits::default()).unwrap();
            assert_eq!(polygons.positions, POSITIONS.map(|p| p.map(f64::from)));
            assert!(polygons.faces().eq(FACES.map(|face| face.iter().copied().map(i64::from).collect::<Vec<_>>())));
            assert_eq!(polygons.ignored, 1);
        }
    }

    #[test]
    fn tells_lines_of_a_text_only() {
        let polygons = read(&text(), Format::Ply, &Limits::default()).unwrap();
        assert_eq!(polygons.vertex_place(0).line, Some(14));
        assert_eq!(polygons.face_place(1).line, Some(19));
        let little = binary("binary_little_endian", <[u8]>::to_vec);
        assert_eq!(read(&little, Format::Ply, &Limits::default()).unwrap().face_place(1), Place::face(1));
    }

    #[test]
    fn refuses_hostile_and_broken_headers_without_taking_memory() {
        let text = String::from_utf8(text()).unwrap();
        for (from, to, reason) in [
            ("vertex 4", "vertex 1000000000000", "announces 1000000000000"),
            ("face 2", "face 18446744073709551615", "line 9: the number of elements cannot be read"),
            ("edge 1", "edge 18446744073709551616", "line 11"),
            ("element edge 1\nproperty int vertex1", "element edge 1000000000000", "no properties"),
            ("property float x", "property float u", "no number x"),
            ("list uchar int vertex_indices", "list uchar float weights", "no list vertex_indices"),
            ("int vertex_indices", "int texnumber\nproperty list uchar int others", "no list vertex_indices"),
            ("list uchar int", "list uchar word", "line 10: this property cannot be read"),
            ("end_header", "end", "no end_header"),
            ("4 0 1 2 3", "4000000000 0 1 2 3", "triangles"),
            ("4 0 1 2 3", "4 0 1 2.5 3", "line 18: vertex_indices holds 2.5"),
            ("1 0 0.5 255", "1 zero 0.5 255", "line 15: y is not a number"),
            ("\n7\n", "\n", "the file ends"),
        ] {
            let broken = text.replace(from, to);
            assert_ne!(broken, text);
            let refusal = read(broken.as_bytes(), Format::Ply, &Limits::default()).unwrap_err().to_string();
            assert!(refusal.contains(reason) && !refusal.contains('\n'), "{to}: {refusal}");
        }
    }

    #[test]
    fn reads_what_other_programs_write() {
        let text = String::from_utf8(text()).unwrap();
        let expected = read(text.as_bytes(), Format::Ply, &Limits::default()).unwrap();
        for (from, to) in [
            ("1 0 0.5 255", "\n1 0\n0.5   nan\n"),
            ("property float x", "comment\nproperty float64 x"),
            ("list uchar int", "list int64 uint64"),
            ("4 0 1 2 3", "4.0 0 1 2.0 3"),
            ("end_header\n", "end_header\n\n"),
            ("ply\n", "ply \n"),
            ("double z", "Float64 z"),
            ("vertex_indices", "vertices"),
            ("element edge 1", "element tristrips 0\nelement edge 1"),
        ] {
            let other = text.replace(from, to);
            assert_ne!(other, text);
            let polygons = read(other.as_bytes(), Format::Ply, &Limits::default()).unwrap();
            assert_eq!(polygons.positions, expected.positions, "{to}");
            assert!(polygons.faces().eq(expected.faces()), "{to}");
        }
    }

    #[test]
    fn passes_over_what_is_on_the_line_of_an_element_and_not_announced() {
        let text = String::from_utf8(text()).unwrap();
        let expected = read(text.as_bytes(), Format::Ply, &Limits::default()).unwrap();
        // As MeshLab writes colours of wedges: a list where four numbers are announced.
        let more =
            text.replace("4 0 1 2 3\n", "4 0 1 2 3 9 1 1 1 1 1 1 1 1 1\n").replace("1 0 0.5 255", "1 0 0.5 255 7");
        assert_ne!(more, text);
        let polygons = read(more.as_bytes(), Format::Ply, &Limits::default()).unwrap();
        assert_eq!(polygons.positions, expected.positions);
        assert!(polygons.faces().eq(expected.faces()));
        // All on one line.
        let (header, body) = text.split_once("end_header\n").unwrap();
        let together = format!("{header}end_header\n{}", body.replace('\n', " "));
        let polygons = read(together.as_bytes(), Format::Ply, &Limits::default()).unwrap();
        assert!(polygons.positions == expected.positions && polygons.faces().eq(expected.faces()));
    }

    #[test]
    fn what_is_wrong_is_told_of_the_lines_there_are() {
        let text = String::from_utf8(text()).unwrap();
        // With more on every line than is announced.
        let broken = text.replace(" 255\n", " 255 7\n").replace("1 1 0 255", "1 1 q 255");
        let refusal = read(broken.as_bytes(), Format::Ply, &Limits::default()).unwrap_err().to_string();
        assert!(refusal.contains("line 16: z is not a number: \"q\""), "{refusal}");
        // All on one line, which is no element.
        let (header, body) = text.split_once("end_header\n").unwrap();
        let broken = format!("{header}end_header\n{}", body.replace('\n', " ").replace("0.5", "zero"));
        let refusal = read(broken.as_bytes(), Format::Ply, &Limits::default()).unwrap_err().to_string();
        assert!(refusal.contains("z is not a number: \"zero\""), "{refusal}");
    }

    #[test]
    fn reads_strips_of_triangles() {
        let strips = "6 0 1 3 2 -1 0\n";
        let text = String::from_utf8(text()).unwrap();
        let text = text.replace("element face 2", "element tristrips 1").replace("4 0 1 2 3\n3 2 1 0\n", strips);
        let polygons = read(text.as_bytes(), Format::Ply, &Limits::default()).unwrap();
        assert!(polygons.faces().eq([vec![0, 1, 3], vec![3, 1, 2]]), "{polygons:?}");
    }

    #[test]
    fn takes_no_memory_for_lists_that_are_not_there() {
        let mut bytes = header("binary_little_endian").replace("uchar int vertex", "uint uchar vertex").into_bytes();
        // A vertex takes 17 bytes.
        bytes.resize(bytes.len() + 4 * 17, 0);
        bytes.extend(u32::MAX.to_le_bytes());
        bytes.extend([0; 8]);
        let refusal = read(&bytes, Format::Ply, &Limits::default()).unwrap_err().to_string();
        assert!(refusal.contains("4294967295"), "{refusal}");
    }

    #[test]
    fn checks_counts_against_the_limits() {
        let limits = Limits { triangles: 1, ..Limits::default() };
        let refusal = read(&text(), Format::Ply, &limits).unwrap_err();
        assert_eq!(refusal, Refusal::TooLarge { unit: "vertices", found: 4, limit: 3 });
    }
}
