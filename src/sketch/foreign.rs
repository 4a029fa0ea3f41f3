//! Files that are not the drawing that was expected, by their first bytes: named, never read.

use std::fmt;

/// What a file is, and what to do instead.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Foreign {
    /// What the file is, as people call it.
    pub kind: &'static str,
    /// What to send in its place.
    pub instead: &'static str,
}

/// An SVG, where a picture was expected.
pub const SVG: Foreign = Foreign { kind: "an SVG drawing", instead: "send it as image/svg+xml" };

const EXPORT: &str = "export it as PNG or JPEG";
const EXPORT_DRAWN: &str = "export it as SVG or PNG";
const UNPACK: &str = "send the drawing in it, as SVG, PNG or JPEG";
const WEB_PAGE: &str = "save the drawing itself, as SVG, PNG or JPEG";
const IPHONE: &str = "a HEIC picture, as iPhones take them";

/// At which byte of a file which others tell what it is, and what to do.
const BYTES: [(usize, &[u8], &str, &str); 34] = [
    (0, b"\x89PNG\r\n\x1a\n", "a PNG picture", "send it as image/png"),
    (0, b"\xff\xd8\xff", "a JPEG picture", "send it as image/jpeg"),
    (8, b"WEBP", "a WebP picture", EXPORT),
    (4, b"ftyphe", IPHONE, EXPORT),
    (4, b"ftypmif1", IPHONE, EXPORT),
    (4, b"ftypmsf1", IPHONE, EXPORT),
    (4, b"ftypavi", "an AVIF picture", EXPORT),
    (4, b"ftyp", "a film", "send one picture of it, as PNG or JPEG"),
    (4, b"jP  ", "a JPEG 2000 picture", EXPORT),
    (0, b"\xff\x4f\xff\x51", "a JPEG 2000 picture", EXPORT),
    (4, b"JXL ", "a JPEG XL picture", EXPORT),
    (0, b"\xff\x0a", "a JPEG XL picture", EXPORT),
    (0, b"GIF8", "a GIF picture", EXPORT),
    (0, b"BM", "a BMP picture", EXPORT),
    (0, b"II*\0", "a TIFF picture", EXPORT),
    (0, b"MM\0*", "a TIFF picture", EXPORT),
    (0, b"\0\0\x01\0", "an ICO icon", EXPORT),
    (0, b"8BPS", "a Photoshop file", EXPORT),
    (0, b"gimp xcf", "a GIMP file", EXPORT),
    (0, b"CSFCHUNK", "a Clip Studio file", EXPORT),
    (0, b"%PDF", "a PDF document", EXPORT_DRAWN),
    (0, b"%!PS", "a PostScript file", EXPORT_DRAWN),
    (0, b"\xc5\xd0\xd3\xc6", "an EPS file", EXPORT_DRAWN),
    (0, b"\xd7\xcd\xc6\x9a", "a Windows metafile", EXPORT_DRAWN),
    (40, b" EMF", "a Windows metafile", EXPORT_DRAWN),
    (0, b"0\nSECTION", "a DXF drawing", EXPORT_DRAWN),
    (0, b"0\r\nSECTION", "a DXF drawing", EXPORT_DRAWN),
    (0, b"  0\nSECTION", "a DXF drawing", EXPORT_DRAWN),
    (0, b"  0\r\nSECTION", "a DXF drawing", EXPORT_DRAWN),
    (0, b"PK\x03\x04", "a ZIP archive, or the file of a program that packs its drawings", UNPACK),
    (0, b"Rar!\x1a\x07", "a RAR archive", UNPACK),
    (0, b"7z\xbc\xaf\x27\x1c", "a 7z archive", UNPACK),
    (0, b"\x1f\x8b", "a file compressed with gzip", "unpack it, or send it as image/svg+xml where it is an SVG"),
    (0, b"data:", "the address of a picture, with the picture in it", "send the picture itself, as PNG or JPEG"),
];

/// How texts begin, in small letters, what they are, and what to do.
const TEXTS: [(&[u8], Foreign); 7] = [
    (b"<!doctype html", Foreign { kind: "a web page", instead: WEB_PAGE }),
    (b"<html", Foreign { kind: "a web page", instead: WEB_PAGE }),
    (b"<vector", Foreign { kind: "a vector drawable of Android", instead: EXPORT_DRAWN }),
    (b"<!doctype svg", SVG),
    (b"<?xml", SVG),
    (b"<!--", SVG),
    (b"<svg", SVG),
];

impl fmt::Display for Foreign {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "this is {}; {}", self.kind, self.instead)
    }
}

/// What the bytes are, where that can be told; asked of bytes that are not what was expected.
pub fn name(bytes: &[u8]) -> Option<Foreign> {
    let text = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes).trim_ascii_start();
    if text.is_empty() {
        return Some(Foreign { kind: "an empty file", instead: "send the drawing itself" });
    }
    let by_bytes = BYTES.iter().find(|(at, mark, ..)| bytes.get(*at..).is_some_and(|rest| rest.starts_with(mark)));
    let begins = |start: &[u8]| text.get(..start.len()).is_some_and(|found| found.eq_ignore_ascii_case(start));
    let by_text = || TEXTS.iter().find(|(start, _)| begins(start)).map(|&(_, foreign)| foreign);
    by_bytes.map(|&(_, _, kind, instead)| Foreign { kind, instead }).or_else(by_text)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_are_named_and_what_is_unknown_is_not() {
        for (bytes, kind) in [
            (&b"RIFF\x54\0\0\0WEBPVP8 "[..], "a WebP picture"),
            (b"\0\0\0\x1cftypheic\0\0\0\0mif1", IPHONE),
            (b"\0\0\0\x20ftypavif", "an AVIF picture"),
            (b"\0\0\0\x20ftypisom", "a film"),
            (b"\0\0\0\x0cjP  \r\n", "a JPEG 2000 picture"),
            (b"%!PS-Adobe-3.0 EPSF-3.0\n", "a PostScript file"),
            (b"", "an empty file"),
            (b"\xef\xbb\xbf \r\n", "an empty file"),
            (b"\xef\xbb\xbf\n<!DOCTYPE HTML><html>", "a web page"),
            (b"\n<?xml version='1.0'?>", SVG.kind),
        ] {
            assert_eq!(name(bytes).map(|foreign| foreign.kind), Some(kind));
        }
        for bytes in [&b"a cat"[..], b"{\"outline\": []}", b"<", b"R", b"\0\0\0\x1cft"] {
            assert_eq!(name(bytes), None);
        }
    }
}
