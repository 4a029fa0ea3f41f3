//! Binary OFF: behind the line of the keyword the numbers of vertices, faces and edges, the vertices, and the corners of
//! every face behind their number, all in 32 bits.
//!
//! Geomview writes the high byte first, and behind every face its colour. Libraries of surface meshes write as the
//! machine does, the low byte first, and no colours. No byte tells which: it is the way in which the file comes out even.

use super::super::Polygons;
use crate::mesh::refusal::{Place, Refusal};

/// The ways there are, the usual ones first.
const WAYS: [Way; 4] = [
    Way { little: true, coloured: false },
    Way { little: false, coloured: true },
    Way { little: false, coloured: false },
    Way { little: true, coloured: true },
];

/// How numbers are written, and whether a colour follows every face: how many components it has, and these.
#[derive(Clone, Copy)]
struct Way {
    little: bool,
    coloured: bool,
}

/// Reads what follows the line of the keyword; `besides` numbers follow the coordinates of every vertex.
pub(super) fn read(body: &[u8], besides: usize, mut polygons: Polygons) -> Result<Polygons, Refusal> {
    let words = body.as_chunks::<4>().0;
    let Some((way, vertices, faces)) = WAYS.into_iter().find_map(|way| counts(words, besides, way)) else {
        return Err(Refusal::because(Place::line(1), "the numbers of the binary off do not come out even"));
    };
    polygons.limits.admit_vertices(vertices)?;
    let each = 3 + besides;
    for vertex in words[HEADER..].chunks_exact(each).take(vertices) {
        // Negative zero becomes zero, so that equal points have equal bits.
        polygons.push_vertex([0, 1, 2].map(|axis| f64::from(f32::from_bits(way.word(vertex[axis]))) + 0.0), None)?;
    }
    let mut rest = &words[HEADER + vertices * each..];
    for _ in 0..faces {
        let Some((corners, after)) = way.face(rest) else { break };
        polygons.push_face(corners.iter().map(|&corner| i64::from(way.word(corner))), None)?;
        rest = after;
    }
    Ok(polygons)
}

/// Numbers of 32 bits each.
type Words<'a> = &'a [[u8; 4]];

/// Words before the vertices.
const HEADER: usize = 3;

/// The numbers of vertices and faces, if the file comes out even in this way.
fn counts(words: Words<'_>, besides: usize, way: Way) -> Option<(Way, usize, usize)> {
    let [vertices, faces, _edges] = *words.first_chunk::<HEADER>()?;
    let [vertices, faces] = [vertices, faces].map(|count| way.word(count) as usize);
    let mut rest = words.get(HEADER.checked_add(vertices.checked_mul(3 + besides)?)?..)?;
    for _ in 0..faces {
        rest = way.face(rest)?.1;
    }
    rest.is_empty().then_some((way, vertices, faces))
}

impl Way {
    fn word(self, bytes: [u8; 4]) -> u32 {
        if self.little { u32::from_le_bytes(bytes) } else { u32::from_be_bytes(bytes) }
    }

    /// The corners of the first face, and what follows it. A face has a corner at least: zeros come out even by chance.
    fn face(self, words: Words<'_>) -> Option<(Words<'_>, Words<'_>)> {
        let (&corners, rest) = words.split_first()?;
        let (corners, rest) = rest.split_at_checked(self.word(corners) as usize).filter(|(c, _)| !c.is_empty())?;
        if !self.coloured {
            return Some((corners, rest));
        }
        let (&components, rest) = rest.split_first()?;
        Some((corners, rest.get(self.word(components) as usize..)?))
    }
}

#[cfg(test)]
mod tests {
    use super::super::super::{Format, Limits, Polygons, read};
    use crate::mesh::refusal::Refusal;

    /// A square and a triangle after a keyword, `little` or not, with so many numbers beside the coordinates and, where told,
    /// colours of the faces.
    fn file(keyword: &str, little: bool, besides: usize, colours: bool) -> Vec<u8> {
        let word = |x: u32| if little { x.to_le_bytes() } else { x.to_be_bytes() };
        let mut bytes = format!("{keyword}\n").into_bytes();
        bytes.extend([4, 2, 0].map(word).as_flattened());
        for p in [[0.0f32, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, -0.0], [0.0, 1.0, 0.5]] {
            let numbers = p.into_iter().chain(std::iter::repeat_n(0.25, besides));
            bytes.extend(numbers.flat_map(|x| word(x.to_bits())));
        }
        for (face, components) in [(&[0, 1, 2, 3][..], 4), (&[2, 1, 0], 1)] {
            bytes.extend(word(face.len() as u32));
            bytes.extend(face.iter().flat_map(|&v| word(v)));
            if colours {
                bytes.extend(word(components));
                bytes.extend((0..components).flat_map(|_| word(0.5f32.to_bits())));
            }
        }
        bytes
    }

    fn off(bytes: &[u8]) -> Result<Polygons, Refusal> {
        read(bytes, Format::Off, &Limits::default())
    }

    #[test]
    fn reads_it_however_it_is_written() {
        for little in [true, false] {
            for colours in [true, false] {
                for (keyword, besides) in
                    [("OFF BINARY", 0), ("NOFF BINARY", 3), ("STCNOFF binary", 9), ("OFF BINARY\r", 0)]
                {
                    let bytes = file(keyword, little, besides, colours);
                    assert_eq!(Format::sniff(&bytes), Some(Format::Off));
                    let polygons = off(&bytes).unwrap();
                    assert_eq!(polygons.positions.len(), 4, "{keyword}");
                    assert_eq!(polygons.positions[3], [0.0, 1.0, 0.5]);
                    assert!(polygons.faces().eq([&[0, 1, 2, 3][..], &[2, 1, 0]]), "{keyword}: {polygons:?}");
                }
            }
        }
    }

    #[test]
    fn what_does_not_come_out_even_is_refused_without_taking_memory() {
        let whole = file("OFF BINARY", true, 0, false);
        let word = |at: usize, x: u32| {
            let (mut bytes, start) = (whole.clone(), "OFF BINARY\n".len() + 4 * at);
            bytes[start..start + 4].copy_from_slice(&x.to_le_bytes());
            bytes
        };
        let cut = (0..whole.len()).map(|length| whole[..length].to_vec());
        let longer = [whole.clone(), vec![0; 8]].concat();
        let changed = [word(0, u32::MAX), word(1, u32::MAX), word(1, 3), word(15, u32::MAX), word(15, 0), longer];
        for bytes in cut.skip("OFF BINARY".len()).chain(changed) {
            let refusal = off(&bytes).unwrap_err().to_string();
            assert!(refusal.contains("do not come out even"), "{}: {refusal}", bytes.len());
        }
    }

    #[test]
    fn counts_are_checked_against_the_limits() {
        let limits = Limits { triangles: 1, ..Limits::default() };
        let refusal = read(&file("OFF BINARY", true, 0, false), Format::Off, &limits).unwrap_err();
        assert_eq!(refusal, Refusal::TooLarge { unit: "vertices", found: 4, limit: 3 });
    }
}
