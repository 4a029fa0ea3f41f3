//! What is compressed with gzip: an SVG is, under the name of `.svgz`.

/// How it begins.
const START: &[u8] = b"\x1f\x8b";

/// The most bytes that one of it can stand for: deflate repeats up to 258 bytes by two codes, of a bit each at least
/// (RFC 1951, §3.2.5). The documentation of zlib has the same 1032 to 1.
const LARGEST_RATIO: usize = 258 * 8 / 2;

/// Whether a document is compressed.
pub fn is_packed(bytes: &[u8]) -> bool {
    bytes.starts_with(START)
}

/// The bytes of a document, at most: of one that is compressed, as many as it may become.
pub fn most_unpacked(bytes: &[u8]) -> usize {
    let times = if is_packed(bytes) { LARGEST_RATIO } else { 1 };
    bytes.len().saturating_mul(times)
}
