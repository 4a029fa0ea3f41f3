//! Lines and numbers of text files. Bytes that are no UTF-8 only matter where a number is expected.

/// The bytes without the mark of UTF-8 that some editors put before a text.
pub(super) fn without_mark(bytes: &[u8]) -> &[u8] {
    bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes)
}

/// The words of a text between blanks with the numbers of their lines, comments as in [`lines`] left out.
pub(super) fn numbered_words(bytes: &[u8]) -> impl Iterator<Item = (u64, &[u8])> + Clone {
    lines(bytes).flat_map(|(number, line)| words(line).map(move |word| (number, word)))
}

/// The lines of a text with their numbers from 1, the comment that `#` starts taken off, blank at both ends trimmed.
/// A line ends at \n, \r\n or \r.
pub(super) fn lines(bytes: &[u8]) -> impl Iterator<Item = (u64, &[u8])> + Clone {
    // A text of the old Mac kind has no \n at all.
    let end = if bytes.contains(&b'\n') { b'\n' } else { b'\r' };
    (1..).zip(bytes.split(move |&b| b == end)).map(|(number, line)| {
        let comment = line.iter().position(|&b| b == b'#').unwrap_or(line.len());
        (number, line[..comment].trim_ascii())
    })
}

/// The parts of a line between blanks.
pub(super) fn words(line: &[u8]) -> impl Iterator<Item = &[u8]> + Clone {
    line.split(|b| b.is_ascii_whitespace()).filter(|word| !word.is_empty())
}

/// The value of a word. Also "nan" and "inf", and infinity for what is too large: to be refused as a coordinate.
pub(super) fn number(word: &[u8]) -> Option<f64> {
    // Negative zero becomes zero, so that equal points have equal bits.
    std::str::from_utf8(word).ok()?.parse().ok().map(|x: f64| x + 0.0)
}

pub(super) fn integer(word: &[u8]) -> Option<i64> {
    std::str::from_utf8(word).ok()?.parse().ok()
}

/// The first three words as coordinates; what follows them (weights, colours, normals) is passed over.
pub(super) fn position<'a>(words: impl Iterator<Item = &'a [u8]>) -> Result<[f64; 3], String> {
    let mut position = [0.0; 3];
    let mut read = 0;
    for (coordinate, word) in position.iter_mut().zip(words) {
        *coordinate = number(word).ok_or_else(|| format!("a coordinate is not a number: {}", shown(word)))?;
        read += 1;
    }
    if read == 3 { Ok(position) } else { Err(format!("a vertex of {read} coordinates: 3 are needed")) }
}

/// A word for a message: at most 40 characters of it.
pub(super) fn shown(word: &[u8]) -> String {
    format!("\"{}\"", String::from_utf8_lossy(&word[..word.len().min(40)]).escape_debug())
}
