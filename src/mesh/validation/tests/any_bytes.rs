//! Whatever bytes come in, of a file or of none.

use proptest::prelude::*;

use super::*;

const FORMATS: [Format; 6] = [Format::Obj, Format::Off, Format::Ply, Format::Stl, Format::Glb, Format::Gltf];

const OFF: &str = "OFF\n4 4 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n";
const PLY: &str = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
                   element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
const PLY_BINARY: &[u8] = b"ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty char x\n\
    property char y\nproperty char z\nelement face 1\nproperty list uchar uchar vertex_index\nend_header\n\
    \x00\x00\x00\x01\x00\x00\x00\x01\x00\x03\x00\x01\x02";
const STL: &str = "solid\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\n\
                   endfacet\nendsolid\n";

#[test]
fn imports_every_text_sample_by_its_looks() {
    for sample in [CUBE.as_bytes(), OFF.as_bytes(), PLY.as_bytes(), PLY_BINARY, STL.as_bytes()] {
        let format = Format::sniff(sample).unwrap();
        assert!(import(sample, format, &Limits::default()).is_ok(), "{format:?}");
    }
}

proptest! {
    #[test]
    fn survives_any_bytes(bytes in prop::collection::vec(any::<u8>(), 0..300)) {
        for format in FORMATS {
            let _ = import(&bytes, format, &Limits::default());
        }
        let _ = Format::sniff(&bytes);
    }

    /// A valid file with bytes overwritten by digits, signs, blanks or anything, then cut.
    #[test]
    fn survives_damage(
        sample in prop::sample::select(vec![
            CUBE.as_bytes(), OFF.as_bytes(), PLY.as_bytes(), PLY_BINARY, STL.as_bytes()
        ]),
        damage in prop::collection::vec((any::<prop::sample::Index>(), prop_oneof![
            prop::sample::select(b"0123456789-+.e/\\# \n".to_vec()), any::<u8>()
        ]), 0..6),
        end in any::<prop::sample::Index>(),
        cut in any::<bool>(),
    ) {
        let mut bytes = sample.to_vec();
        damage.iter().for_each(|(at, byte)| { let at = at.index(bytes.len()); bytes[at] = *byte; });
        if cut {
            bytes.truncate(end.index(bytes.len()));
        }
        for format in FORMATS {
            if let Ok(imported) = import(&bytes, format, &Limits::default()) {
                prop_assert!(imported.mesh.sound().area().is_finite() && imported.mesh.sound().area() > 0.0);
            }
        }
    }
}
