//! Stanford PLY, text and binary of either byte order.

use ply_rs_bw::parser::{ParseError, Parser, Reader};
use ply_rs_bw::ply::{ElementDef, Encoding, Header, Property, PropertyAccess, PropertyAccessResult, PropertyType};

use super::Polygons;
use crate::mesh::refusal::{Place, Refusal};

/// Most bytes of a line of a text, which the parser takes apart in sixteen times the memory.
const LONGEST_LINE: usize = 1 << 16;
/// Most bytes of a header, which the parser keeps whole.
const LONGEST_HEADER: usize = 1 << 16;

pub(super) fn looks_like(bytes: &[u8]) -> bool {
    bytes.starts_with(b"ply\n") || bytes.starts_with(b"ply\r")
}

pub(super) fn read(bytes: &[u8], mut polygons: Polygons) -> Result<Polygons, Refusal> {
    let mut file = File::open(bytes)?;
    let elements: Vec<ElementDef> = file.header.elements.values().cloned().collect();
    for element in &elements {
        match element.name.as_str() {
            "vertex" => {
                require_coordinates(element)?;
                polygons.limits.admit_vertices(element.count)?;
                for (line, vertex) in file.elements::<Vertex>(element)? {
                    polygons.push_vertex(vertex.position, line)?;
                }
            }
            "face" => {
                require_corners(element)?;
                polygons.limits.admit_triangles(element.count)?;
                for (line, face) in file.elements::<Face>(element)? {
                    polygons.push_face(face.corners, line)?;
                }
            }
            _ => polygons.ignored += file.elements::<Other>(element)?.count(),
        }
    }
    Ok(polygons)
}

fn require_coordinates(vertex: &ElementDef) -> Result<(), Refusal> {
    let is_scalar = |name| matches!(vertex.properties.get(name).map(|p| &p.data_type), Some(PropertyType::Scalar(_)));
    match ["x", "y", "z"].into_iter().find(|name| !is_scalar(*name)) {
        None => Ok(()),
        Some(name) => Err(Refusal::because(Place::file(), format!("element vertex has no number {name}"))),
    }
}

fn require_corners(face: &ElementDef) -> Result<(), Refusal> {
    let is_list = |p: &PropertyType| matches!(p, PropertyType::List(..));
    if CORNERS.iter().any(|name| face.properties.get(*name).is_some_and(|p| is_list(&p.data_type))) {
        Ok(())
    } else {
        Err(Refusal::because(Place::file(), "element face has no list vertex_indices"))
    }
}

/// A file whose header has been read.
struct File<'a> {
    header: Header,
    /// Stands at the next element.
    reader: Reader<&'a [u8]>,
}

impl File<'_> {
    /// Reads the header and checks that no element is counted more often than there are bytes.
    fn open(bytes: &[u8]) -> Result<File<'_>, Refusal> {
        let (head, mark) = (&bytes[..bytes.len().min(LONGEST_HEADER)], b"end_header");
        if !head.windows(mark.len()).any(|window| window == mark) {
            return Err(Refusal::because(Place::file(), format!("no end_header in the first {} bytes", head.len())));
        }
        let mut reader = Reader::new(bytes);
        let header = Parser::<Other>::new().read_header(&mut reader).map_err(|error| unreadable(&error, true))?;
        let is_text = header.encoding == Encoding::Ascii;
        if is_text && reader.get_ref().split(|&b| b == b'\n').any(|line| line.len() > LONGEST_LINE) {
            let detail = format!("a line of more than {LONGEST_LINE} bytes");
            return Err(Refusal::because(Place::file(), detail));
        }
        let bytes_left = reader.get_ref().len();
        for ElementDef { name, count, properties } in header.elements.values() {
            if *count > 0 && properties.is_empty() {
                return Err(Refusal::because(Place::file(), format!("element {name} has no properties")));
            }
            if *count > bytes_left {
                let detail = format!("the header announces {count} of element {name}, {bytes_left} bytes follow it");
                return Err(Refusal::because(Place::file(), detail));
            }
        }
        Ok(File { header, reader })
    }

    /// The next elements, all of one kind, each with its line in a text.
    fn elements<E: PropertyAccess>(
        &mut self,
        element: &ElementDef,
    ) -> Result<impl ExactSizeIterator<Item = (Option<u64>, E)> + use<E>, Refusal> {
        let is_text = self.header.encoding == Encoding::Ascii;
        let first = self.reader.line() as u64;
        let elements = Parser::<E>::new().read_payload_for_element(&mut self.reader, element, &self.header);
        let elements = elements.map_err(|error| unreadable(&error, is_text))?;
        // A text has one element on each line.
        let line = move |i: usize| is_text.then_some(first + i as u64);
        Ok(elements.into_iter().enumerate().map(move |(i, element)| (line(i), element)))
    }
}

/// The innermost reason the parser gives, without its excerpts of the file.
fn unreadable(error: &ParseError, is_text: bool) -> Refusal {
    let place = error.line().filter(|_| is_text).map_or(Place::file(), |line| Place::line(line as u64));
    let message = error.to_string();
    let reason = message.rsplit("Error: ").next().and_then(|reason| reason.lines().next()).unwrap_or_default();
    let reason: String = reason.chars().take(200).collect();
    Refusal::because(place, format!("the ply file cannot be read: {reason}"))
}

struct Vertex {
    position: [f64; 3],
}

impl PropertyAccess for Vertex {
    fn new() -> Vertex {
        Vertex { position: [0.0; 3] }
    }

    fn set_property(&mut self, name: &str, value: Property) -> PropertyAccessResult {
        let axis = match name {
            "x" => 0,
            "y" => 1,
            "z" => 2,
            _ => return PropertyAccessResult::Ignored,
        };
        // Negative zero becomes zero, so that equal points have equal bits.
        self.position[axis] = 0.0
            + match value {
                Property::Char(x) => x.into(),
                Property::UChar(x) => x.into(),
                Property::Short(x) => x.into(),
                Property::UShort(x) => x.into(),
                Property::Int(x) => x.into(),
                Property::UInt(x) => x.into(),
                Property::Float(x) => x.into(),
                Property::Double(x) => x,
                _ => return PropertyAccessResult::UnsupportedType,
            };
        PropertyAccessResult::Set
    }
}

/// Both names are in use.
const CORNERS: [&str; 2] = ["vertex_indices", "vertex_index"];

struct Face {
    corners: Vec<i64>,
}

impl PropertyAccess for Face {
    fn new() -> Face {
        Face { corners: Vec::new() }
    }

    fn set_property(&mut self, name: &str, value: Property) -> PropertyAccessResult {
        if !CORNERS.contains(&name) {
            return PropertyAccessResult::Ignored;
        }
        self.corners = match value {
            Property::ListChar(list) => list.into_iter().map(i64::from).collect(),
            Property::ListUChar(list) => list.into_iter().map(i64::from).collect(),
            Property::ListShort(list) => list.into_iter().map(i64::from).collect(),
            Property::ListUShort(list) => list.into_iter().map(i64::from).collect(),
            Property::ListInt(list) => list.into_iter().map(i64::from).collect(),
            Property::ListUInt(list) => list.into_iter().map(i64::from).collect(),
            _ => return PropertyAccessResult::UnsupportedType,
        };
        PropertyAccessResult::Set
    }
}

/// An element that is read past; takes no memory.
struct Other;

impl PropertyAccess for Other {
    fn new() -> Other {
        Other
    }
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
            ("face 2", "face 18446744073709551615", "announces 18446744073709551615"),
            ("edge 1", "edge 18446744073709551616", "line 11"),
            ("element edge 1\nproperty int vertex1", "element edge 1000000000000", "no properties"),
            ("property float x", "property float u", "no number x"),
            ("vertex_indices", "tristrips", "no list vertex_indices"),
            ("list uchar int", "list uchar float", "cannot be read"),
            ("end_header", "end", "no end_header"),
            ("4 0 1 2 3", "4000000000 0 1 2 3", "line 18"),
            ("1 0 0.5 255", "1 zero 0.5 255", "line 15"),
            ("1 0 0.5 255", "1 0", "line 15"),
        ] {
            let broken = text.replace(from, to);
            assert_ne!(broken, text);
            let refusal = read(broken.as_bytes(), Format::Ply, &Limits::default()).unwrap_err().to_string();
            assert!(refusal.contains(reason) && !refusal.contains('\n'), "{to}: {refusal}");
        }
    }

    #[test]
    fn refuses_endless_lines() {
        let bytes = [text(), vec![b' '; LONGEST_LINE + 1]].concat();
        let refusal = read(&bytes, Format::Ply, &Limits::default()).unwrap_err().to_string();
        assert!(refusal.contains("a line of more than"), "{refusal}");
    }

    #[test]
    fn checks_counts_against_the_limits() {
        let limits = Limits { triangles: 1, ..Limits::default() };
        let refusal = read(&text(), Format::Ply, &limits).unwrap_err();
        assert_eq!(refusal, Refusal::TooLarge { unit: "vertices", found: 4, limit: 3 });
    }
}
