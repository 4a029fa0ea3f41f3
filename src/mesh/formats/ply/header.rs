//! What a PLY file says it holds.

use super::super::text;
use crate::mesh::refusal::{Place, Refusal};

/// Most bytes of a header.
const LONGEST: usize = 1 << 16;

/// How the values after the header are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Encoding {
    Text,
    Binary { little: bool },
}

/// The types of values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Scalar {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    I64,
    U64,
    F32,
    F64,
}

impl Scalar {
    fn of(name: &[u8]) -> Option<Scalar> {
        Some(match name.to_ascii_lowercase().as_slice() {
            b"char" | b"int8" => Scalar::I8,
            b"uchar" | b"uint8" => Scalar::U8,
            b"short" | b"int16" => Scalar::I16,
            b"ushort" | b"uint16" => Scalar::U16,
            b"int" | b"int32" => Scalar::I32,
            b"uint" | b"uint32" => Scalar::U32,
            b"long" | b"int64" => Scalar::I64,
            b"ulong" | b"uint64" => Scalar::U64,
            b"float" | b"float32" => Scalar::F32,
            b"double" | b"float64" => Scalar::F64,
            _ => return None,
        })
    }

    /// Whether its values are whole numbers.
    pub fn is_whole(self) -> bool {
        !matches!(self, Scalar::F32 | Scalar::F64)
    }

    /// Bytes in a binary file.
    pub fn size(self) -> usize {
        match self {
            Scalar::I8 | Scalar::U8 => 1,
            Scalar::I16 | Scalar::U16 => 2,
            Scalar::I32 | Scalar::U32 | Scalar::F32 => 4,
            Scalar::I64 | Scalar::U64 | Scalar::F64 => 8,
        }
    }
}

/// One value, or a list: the type of its length and of its values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Scalar(Scalar),
    List(Scalar, Scalar),
}

#[derive(Debug)]
pub(super) struct Property {
    pub name: String,
    pub kind: Kind,
}

#[derive(Debug)]
pub(super) struct Element {
    pub name: String,
    pub count: usize,
    pub properties: Vec<Property>,
}

#[derive(Debug)]
pub(super) struct Header {
    pub encoding: Encoding,
    pub elements: Vec<Element>,
}

impl Header {
    /// The header of a file, what follows it, and the line that begins with.
    pub fn of(bytes: &[u8]) -> Result<(Header, &[u8], u64), Refusal> {
        let head = &bytes[..bytes.len().min(LONGEST)];
        let mut encoding = None;
        let mut elements: Vec<Element> = Vec::new();
        let (mut start, mut number) = (0, 0);
        // As the first line ends, all do: what follows the header may begin with any byte.
        let first = head.iter().position(|b| matches!(b, b'\n' | b'\r')).unwrap_or(head.len());
        let ending = if head[first..].starts_with(b"\r\n") { 2 } else { 1 };
        while let Some(length) = head[start..].iter().position(|b| matches!(b, b'\n' | b'\r')) {
            let line = &head[start..start + length];
            start = (start + length + ending).min(head.len());
            number += 1;
            let words: Vec<&[u8]> = text::words(line).collect();
            let misread =
                |what: &str| Err(Refusal::because(Place::line(number), format!("{what}: {}", text::shown(line))));
            match words[..] {
                [b"end_header", ..] => {
                    let encoding =
                        encoding.ok_or_else(|| Refusal::because(Place::file(), "the header tells no format"))?;
                    return Ok((Header { encoding, elements }, &bytes[start..], number + 1));
                }
                [b"format", b"ascii", ..] => encoding = Some(Encoding::Text),
                [b"format", b"binary_little_endian", ..] => encoding = Some(Encoding::Binary { little: true }),
                [b"format", b"binary_big_endian", ..] => encoding = Some(Encoding::Binary { little: false }),
                [b"format", ..] => return misread("this format is not known"),
                [b"element", name, count] => match text::integer(count).and_then(|n| usize::try_from(n).ok()) {
                    Some(count) => elements.push(Element { name: word(name), count, properties: Vec::new() }),
                    None => return misread("the number of elements cannot be read"),
                },
                [b"element", ..] => return misread("an element has a name and a number"),
                [b"property", ..] => match (property(&words[1..]), elements.last_mut()) {
                    (Some(property), Some(element)) => element.properties.push(property),
                    (None, _) => return misread("this property cannot be read"),
                    (_, None) => return misread("this property is of no element"),
                },
                // Comments, and whatever programs add.
                _ => {}
            }
        }
        Err(Refusal::because(Place::file(), format!("no end_header in the first {} bytes", head.len())))
    }
}

/// A property after its keyword.
fn property(words: &[&[u8]]) -> Option<Property> {
    let (kind, name) = match words {
        [b"list", count, kind, name] => (Kind::List(Scalar::of(count)?, Scalar::of(kind)?), name),
        [kind, name] => (Kind::Scalar(Scalar::of(kind)?), name),
        _ => return None,
    };
    Some(Property { name: word(name), kind })
}

fn word(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}
