//! Meshes of every format, by their looks, mended and made coarser.
#![no_main]

use libfuzzer_sys::fuzz_target;
use sketchmatch::mesh::formats::{Format, Limits};
use sketchmatch::mesh::validation::import;

/// Few triangles, so that many files have more.
const LIMITS: Limits = Limits { triangles: 300, bytes: 1 << 20 };

fuzz_target!(|bytes: &[u8]| {
    let Some(format) = Format::sniff(bytes) else { return };
    if let Ok(imported) = import(bytes, format, &LIMITS) {
        let sound = imported.mesh.sound();
        assert!(sound.area() > 0.0 && sound.triangles().len() <= LIMITS.triangles);
        let vertices = imported.mesh.positions().len() as u32;
        assert!((0..vertices).all(|v| (imported.mesh.sound_vertices(v).end as usize) <= sound.positions().len()));
    }
});
