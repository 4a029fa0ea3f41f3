//! SVGs.
#![no_main]

use libfuzzer_sys::fuzz_target;
use sketchmatch::sketch::{Choice, Config, from_svg};

fuzz_target!(|bytes: &[u8]| {
    let config = Config { max_points: 1000, max_picture_side: 512, max_picture_pixels: 1 << 16, ..Config::default() };
    let _ = from_svg(bytes, Choice { vertices: 100, figure: 0 }, &config);
});
