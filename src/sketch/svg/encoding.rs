//! The text of a document, in the encodings that drawing programs write.

use std::borrow::Cow;
use std::io::Read;

use flate2::read::GzDecoder;

use crate::sketch::gzip;
use crate::sketch::refusal::Refusal;

/// The bytes of a document, unpacked where it is compressed.
///
/// # Errors
/// A document of more than `most` bytes, and one whose compressed bytes are broken.
pub(super) fn unpacked(bytes: &[u8], most: usize) -> Result<Cow<'_, [u8]>, Refusal> {
    let found = bytes.len();
    if found > most {
        return Err(Refusal::plain(format!("the SVG has {found} bytes; at most {most} are taken")));
    }
    if !gzip::is_packed(bytes) {
        return Ok(Cow::Borrowed(bytes));
    }
    let mut unpacked = Vec::new();
    let within = (most as u64).saturating_add(1);
    GzDecoder::new(bytes)
        .take(within)
        .read_to_end(&mut unpacked)
        .map_err(|_| Refusal::plain("the compressed SVG is broken or cut off"))?;
    if unpacked.len() > most {
        return Err(Refusal::plain(format!(
            "the SVG is too large when it is unpacked: at most {most} bytes are taken"
        )));
    }
    Ok(Cow::Owned(unpacked))
}

/// The text of a document: UTF-8, UTF-16, or any encoding in which the letters of ASCII are bytes. What is written with
/// others is titles and captions, which are not drawn: each byte of them is taken for the character of its number.
///
/// # Errors
/// Broken UTF-16.
pub(super) fn text(bytes: &[u8]) -> Result<Cow<'_, str>, Refusal> {
    let wide = |bytes: &[u8], unit: fn([u8; 2]) -> u16| {
        let units: Vec<u16> = bytes.chunks_exact(2).map(|pair| unit([pair[0], pair[1]])).collect();
        String::from_utf16(&units).map(Cow::Owned).map_err(|_| Refusal::plain("the SVG is broken UTF-16"))
    };
    match bytes {
        [0xff, 0xfe, rest @ ..] => wide(rest, u16::from_le_bytes),
        [0xfe, 0xff, rest @ ..] => wide(rest, u16::from_be_bytes),
        [b'<', 0, ..] => wide(bytes, u16::from_le_bytes),
        [0, b'<', ..] => wide(bytes, u16::from_be_bytes),
        _ => Ok(match std::str::from_utf8(bytes) {
            Ok(text) => Cow::Borrowed(text.trim_start_matches('\u{feff}')),
            Err(_) => Cow::Owned(bytes.iter().map(|&byte| char::from(byte)).collect()),
        }),
    }
}

#[cfg(test)]
mod tests {
    use std::io::Write;

    use flate2::Compression;
    use flate2::write::GzEncoder;

    use super::*;

    #[test]
    fn encodings_are_told_apart() {
        for latin in [&b"<?xml version='1.0' encoding='ISO-8859-1'?><svg id='\xe9'/>"[..], b"<svg id='\xe9'/>"] {
            assert!(text(latin).unwrap().ends_with("<svg id='é'/>"));
        }
        assert_eq!(text("\u{feff}<svg id='é'/>".as_bytes()).unwrap(), "<svg id='é'/>");
        for start in ["\u{feff}", ""] {
            let wide: Vec<u8> = format!("{start}<svg/>").encode_utf16().flat_map(u16::to_le_bytes).collect();
            assert_eq!(text(&wide).unwrap(), "<svg/>");
        }
        assert!(text(&[0xfe, 0xff, 0xd8, 0x00]).is_err());
    }

    #[test]
    fn what_is_compressed_is_unpacked_as_far_as_it_may_go() {
        let mut encoder = GzEncoder::new(Vec::new(), Compression::default());
        encoder.write_all(&[b' '; 5000]).unwrap();
        let packed = encoder.finish().unwrap();
        assert_eq!(unpacked(&packed, 5000).unwrap(), &[b' '; 5000][..]);
        assert!(unpacked(&packed, 4999).unwrap_err().to_string().contains("at most 4999"));
        assert!(unpacked(&packed[..packed.len() - 9], 5000).unwrap_err().to_string().contains("cut off"));
        assert_eq!(unpacked(b"<svg/>", 6).unwrap(), &b"<svg/>"[..]);
        assert!(unpacked(b"<svg/>", 5).is_err());
    }
}
