//! Geomview OFF, text or binary: OFF and its variants with colours, normals or texture coordinates per vertex.

mod binary;

use super::Polygons;
use super::text;
use crate::mesh::refusal::{Place, Refusal};

/// Whether the first line that is no comment starts with a keyword of the family.
pub(super) fn looks_like(bytes: &[u8]) -> bool {
    content(bytes).next().is_some_and(|(_, line)| keyword(line).is_some())
}

/// What each line holds is read line by line, so that colours behind a face are no trouble. A file whose lines do not
/// hold what they should is read as a stream of numbers, as Geomview itself does.
pub(super) fn read(bytes: &[u8], polygons: Polygons) -> Result<Polygons, Refusal> {
    if let Some((keyword, body)) = binary_body(bytes) {
        let besides = besides(keyword).ok_or_else(|| of_other_dimensions(keyword, 1))?;
        return binary::read(body, besides, polygons);
    }
    let limits = polygons.limits;
    match by_lines(bytes, polygons) {
        Err(Refusal::TooLarge { unit, found, limit }) => Err(Refusal::TooLarge { unit, found, limit }),
        Ok(polygons) if polygons.faults.is_empty() => Ok(polygons),
        faulty => stream(bytes, Polygons::new(limits)).map_or(faulty, Ok),
    }
}

/// The keyword of a binary file and what follows its line.
fn binary_body(bytes: &[u8]) -> Option<(&[u8], &[u8])> {
    let end = bytes.iter().position(|&b| b == b'\n').unwrap_or(bytes.len());
    let (keyword, rest) = keyword(&bytes[..end])?;
    let binary = text::words(rest).next().is_some_and(|word| word.eq_ignore_ascii_case(b"BINARY"));
    binary.then(|| (keyword, bytes.get(end + 1..).unwrap_or_default()))
}

/// How many numbers follow the coordinates of a vertex: two of a texture, four of a colour, three of a normal, as the
/// keyword says by `ST`, `C` and `N` (Geomview, OFF files); nothing where its points are of other than 3 dimensions.
fn besides(keyword: &[u8]) -> Option<usize> {
    let capitals = keyword.to_ascii_uppercase();
    let (mut rest, mut count) = (&capitals[..capitals.len() - "OFF".len()], 0);
    for (letters, numbers) in [(&b"ST"[..], 2), (b"C", 4), (b"N", 3)] {
        if let Some(after) = rest.strip_prefix(letters) {
            (rest, count) = (after, count + numbers);
        }
    }
    // A small n is for dimensions.
    (rest.is_empty() && !keyword.contains(&b'n')).then_some(count)
}

fn of_other_dimensions(keyword: &[u8], line: u64) -> Refusal {
    let detail = format!("{} has points of other than 3 dimensions", text::shown(keyword));
    Refusal::because(Place::line(line), detail)
}

fn by_lines(bytes: &[u8], mut polygons: Polygons) -> Result<Polygons, Refusal> {
    let mut lines = content(bytes).peekable();
    let [vertices, faces] = header(&mut lines)?;
    for _ in 0..vertices {
        let (number, line) = lines.next().ok_or_else(|| ended(vertices, polygons.positions.len(), "vertices"))?;
        match text::position(text::words(line)) {
            Ok(position) => polygons.push_vertex(position, Some(number))?,
            Err(detail) => polygons.push_unread_vertex(detail, number)?,
        }
    }
    for read in 0..faces {
        let (number, line) = lines.next().ok_or_else(|| ended(faces, read, "faces"))?;
        match face(line) {
            Ok(corners) => polygons.push_face(corners, Some(number))?,
            Err(detail) => polygons.push_unread_face(detail, number)?,
        }
    }
    Ok(polygons)
}

/// The numbers of a file one after the other, wherever its lines end; nothing where they do not come out even.
fn stream(bytes: &[u8], mut polygons: Polygons) -> Option<Polygons> {
    let mut words = text::numbered_words(bytes).peekable();
    let keyword = words.next_if(|(_, word)| text::number(word).is_none()).map_or(&[][..], |(_, word)| word);
    let (name, fused) = self::keyword(keyword).unwrap_or((&b"OFF"[..], keyword));
    let besides = besides(name).filter(|_| fused.is_empty())?;
    let mut number = || words.next().and_then(|(line, word)| Some((line, text::number(word)?)));
    let mut count = || number().map(|(_, x)| x).filter(|x| *x >= 0.0 && x.fract() == 0.0).map(|x| x as usize);
    let [vertices, faces, _edges] = [count()?, count()?, count()?];
    for _ in 0..vertices {
        let mut position = [0.0; 3];
        let mut line = 0;
        for x in &mut position {
            (line, *x) = number()?;
        }
        for _ in 0..besides {
            number()?;
        }
        polygons.push_vertex(position, Some(line)).ok()?;
    }
    for _ in 0..faces {
        let (line, corners) = number()?;
        // Of no corners: where numbers are missing, what follows comes out even by chance.
        let corners = if corners >= 1.0 && corners.fract() == 0.0 { corners as usize } else { return None };
        polygons.admit_face(corners).ok()?;
        let corners: Option<Vec<i64>> = (0..corners).map(|_| number().map(|(_, x)| x as i64)).collect();
        polygons.push_face(corners?, Some(line)).ok()?;
    }
    words.next().is_none().then_some(polygons)
}

/// The lines that are neither blank nor comment.
fn content(bytes: &[u8]) -> impl Iterator<Item = (u64, &[u8])> {
    text::lines(bytes).filter(|(_, line)| !line.is_empty())
}

fn ended(announced: usize, read: usize, unit: &str) -> Refusal {
    Refusal::because(
        Place::file(),
        format!("the file ends after {read} of the {announced} {unit} its header announces"),
    )
}

/// The keyword at the start of a line (`OFF`, `COFF`, `STCN4OFF` …), in capitals or not, and what follows it.
fn keyword(line: &[u8]) -> Option<(&[u8], &[u8])> {
    let length = line.windows(3).take(6).position(|word| word.eq_ignore_ascii_case(b"OFF"))? + 3;
    Some(line.split_at(length))
}

/// The numbers of vertices and faces, which stand on the keyword's line or the next one.
fn header<'a>(lines: &mut std::iter::Peekable<impl Iterator<Item = (u64, &'a [u8])>>) -> Result<[usize; 2], Refusal> {
    let &(number, first) = lines.peek().ok_or_else(|| Refusal::because(Place::file(), "the file is empty"))?;
    let mut counts = (number, first);
    if let Some((keyword, rest)) = keyword(first) {
        if keyword.iter().any(|b| matches!(b, b'4' | b'n')) {
            return Err(of_other_dimensions(keyword, number));
        }
        lines.next();
        counts = (number, rest);
        if rest.is_empty() {
            counts =
                lines.peek().copied().ok_or_else(|| Refusal::because(Place::line(number), "there are no counts"))?;
            lines.next();
        }
    } else {
        lines.next();
    }
    let (number, line) = counts;
    let mut words = text::words(line).map(|word| text::integer(word).and_then(|count| usize::try_from(count).ok()));
    match (words.next().flatten(), words.next().flatten()) {
        // More numbers than counts are the vertices, which then do not stand on lines of their own.
        (Some(_), Some(_)) if words.nth(1).is_some() => {
            Err(Refusal::because(Place::line(number), "the numbers after the counts do not come out even"))
        }
        (Some(vertices), Some(faces)) => Ok([vertices, faces]),
        _ => Err(Refusal::because(
            Place::line(number),
            format!("the numbers of vertices, faces and edges are expected here, not {}", text::shown(line)),
        )),
    }
}

/// The corners of a face: their number, then as many vertices; colours after them are passed over.
fn face(line: &[u8]) -> Result<Vec<i64>, String> {
    let mut words = text::words(line);
    let first = words.next().unwrap_or_default();
    let count = text::integer(first).and_then(|count| usize::try_from(count).ok());
    let count = count.ok_or_else(|| format!("the number of corners is expected here, not {}", text::shown(first)))?;
    let vertex = |word| text::integer(word).ok_or_else(|| format!("a corner is not a number: {}", text::shown(word)));
    let corners: Vec<i64> = words.take(count).map(vertex).collect::<Result<_, _>>()?;
    if corners.len() == count {
        Ok(corners)
    } else {
        Err(format!("a face of {count} corners names only {}", corners.len()))
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Format, Limits, Polygons, read};
    use crate::mesh::refusal::{Place, Refusal};

    fn off(text: &str) -> Result<Polygons, Refusal> {
        read(text.as_bytes(), Format::Off, &Limits::default())
    }

    #[test]
    fn reads_the_variants_of_the_header() {
        let body = "0 0 0\n1 0 0 255 0 0\n# inside\n\n1 1 0\n0 1 0\n4 0 1 2 3 0.5 0.5 0.5\n3 0 1 2\n";
        for header in ["OFF\n4 2 0\n", "OFF 4 2 0\n", "OFF4 2 0\n", "COFF\n# c\n4 2 5\n", "# c\nNOFF\n4 2\n", "4 2 0\n"]
        {
            let polygons = off(&format!("{header}{body}")).unwrap();
            assert_eq!(polygons.positions.len(), 4, "{header}");
            let faces: Vec<_> = polygons.faces().map(<[i64]>::to_vec).collect();
            assert_eq!(faces, [vec![0, 1, 2, 3], vec![0, 1, 2]], "{header}");
        }
    }

    #[test]
    fn reads_a_stream_of_numbers_wherever_its_lines_end() {
        let numbers = "4 4 6 0 0 0 1 0 0 0 1 0 0 0 1 3 0 2 1 3 0 1 3 3 0 3 2 3 1 2 3";
        let expected = off("OFF\n4 4 6\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n").unwrap();
        let words: Vec<&str> = numbers.split(' ').collect();
        let wrapped: Vec<String> = words.chunks(5).map(|line| line.join(" ")).collect();
        for text in [format!("OFF {numbers}"), format!("off\n{numbers}\n"), format!("OFF\n{}", wrapped.join("\n"))] {
            let polygons = off(&text).unwrap();
            assert_eq!(polygons.positions, expected.positions, "{text}");
            assert!(polygons.faces().eq(expected.faces()), "{text}");
        }
        assert!(off(&format!("OFF {numbers} 7")).is_err());
    }

    #[test]
    fn counts_lines_from_one() {
        let polygons = off("OFF\n3 1 0\n0 0 0\n\n1 0 0\n0 1 0\n3 0 1 2\n").unwrap();
        assert_eq!(polygons.vertex_place(1), Place { line: Some(5), ..Place::vertex(1) });
        assert_eq!(polygons.face_place(0), Place { line: Some(7), ..Place::face(0) });
    }

    #[test]
    fn refuses_what_it_cannot_read() {
        for (text, reason) in [
            ("", "the file is empty"),
            ("OFF", "no counts"),
            ("OFF BINARY\n", "come out even"),
            ("4OFF BINARY\n", "dimensions"),
            ("nOFF BINARY\n", "dimensions"),
            ("4OFF\n1 1 1\n", "dimensions"),
            ("OFF\nmany few\n", "expected here"),
            ("OFF\n-1 1 0\n", "expected here"),
            ("OFF\n4000000000 1000000000000 0\n0 0 0\n", "ends after 1 of the 4000000000 vertices"),
            ("OFF\n1 2 0\n0 0 0\n1 0\n", "ends after 1 of the 2 faces"),
            ("OFF\n1 1 0\n0 0\n1 0\n", "line 3: a vertex of 2 coordinates"),
            ("OFF\n1 1 0\n0 0 0\n3 0 0\n", "line 4: a face of 3 corners names only 2"),
            ("OFF\n1 1 0\n0 0 0\n18446744073709551615 0\n", "number of corners"),
        ] {
            let faults = off(text).map(|polygons| polygons.faults.to_string());
            let refusal = faults.unwrap_or_else(|refusal| refusal.to_string());
            assert!(refusal.contains(reason), "{text:?}: {refusal}");
        }
    }
}
