//! The text of a document, in the encodings that drawing programs write.

use std::borrow::Cow;

use crate::sketch::refusal::Refusal;

/// Encodings in which a byte is the character of its number, or nearly.
const SINGLE_BYTE: [&str; 4] = ["iso-8859-1", "iso-8859-15", "latin1", "windows-1252"];

/// Bytes at the beginning in which the encoding is declared.
const DECLARATION: usize = 200;

/// The text of a document: UTF-8, UTF-16 with its mark, or Latin-1 where the document says so.
///
/// # Errors
/// Anything else.
pub(super) fn text(bytes: &[u8]) -> Result<Cow<'_, str>, Refusal> {
    let wide = |bytes: &[u8], unit: fn([u8; 2]) -> u16| {
        let units: Vec<u16> = bytes.chunks_exact(2).map(|pair| unit([pair[0], pair[1]])).collect();
        String::from_utf16(&units).map(Cow::Owned).map_err(|_| Refusal::plain("the SVG is broken UTF-16"))
    };
    match bytes {
        [0xff, 0xfe, rest @ ..] => wide(rest, u16::from_le_bytes),
        [0xfe, 0xff, rest @ ..] => wide(rest, u16::from_be_bytes),
        _ => match std::str::from_utf8(bytes) {
            Ok(text) => Ok(Cow::Borrowed(text.trim_start_matches('\u{feff}'))),
            Err(_) if is_single_byte(bytes) => Ok(Cow::Owned(bytes.iter().map(|&byte| char::from(byte)).collect())),
            Err(_) => Err(Refusal::plain("the SVG is not text in UTF-8, nor in an encoding that it names")),
        },
    }
}

/// Whether the XML declaration names an encoding of one byte a character.
fn is_single_byte(bytes: &[u8]) -> bool {
    let start = String::from_utf8_lossy(&bytes[..bytes.len().min(DECLARATION)]).to_ascii_lowercase();
    let declaration = start.split("?>").next().unwrap_or_default();
    SINGLE_BYTE.iter().any(|name| declaration.contains(name))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn encodings_are_told_apart() {
        let latin = b"<?xml version='1.0' encoding='ISO-8859-1'?><svg id='\xe9'/>";
        assert!(text(latin).unwrap().ends_with("<svg id='é'/>"));
        assert!(text(b"<svg id='\xe9'/>").is_err());
        assert_eq!(text("\u{feff}<svg id='é'/>".as_bytes()).unwrap(), "<svg id='é'/>");
        let wide: Vec<u8> = "\u{feff}<svg/>".encode_utf16().flat_map(u16::to_le_bytes).collect();
        assert_eq!(text(&wide).unwrap(), "<svg/>");
        assert!(text(&[0xfe, 0xff, 0xd8, 0x00]).is_err());
    }
}
