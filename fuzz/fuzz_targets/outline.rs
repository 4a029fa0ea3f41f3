//! Outlines in JSON.
#![no_main]

use libfuzzer_sys::fuzz_target;
use sketchmatch::sketch::outline::OutlineRequest;
use sketchmatch::sketch::{Config, from_outline};

fuzz_target!(|bytes: &[u8]| {
    if let Ok(request) = serde_json::from_slice::<OutlineRequest>(bytes) {
        let (drawing, _) = request.into_parts();
        let _ = from_outline(&drawing, 100, &Config { max_points: 1000, ..Config::default() });
    }
});
