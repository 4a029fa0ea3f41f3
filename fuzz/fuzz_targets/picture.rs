//! Pictures: PNG and JPEG.
#![no_main]

use libfuzzer_sys::fuzz_target;
use sketchmatch::sketch::{Choice, Config, from_picture};

fuzz_target!(|bytes: &[u8]| {
    let config = Config { max_points: 1000, max_picture_side: 512, max_picture_pixels: 1 << 16, ..Config::default() };
    let _ = from_picture(bytes, Choice { vertices: 100, figure: 0 }, &config);
});
