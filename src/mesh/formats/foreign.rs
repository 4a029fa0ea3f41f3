//! Files of other kinds, by their first bytes: named, never read.

/// What a file is that is no mesh this service reads, and what to do instead.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Foreign {
    /// What the file is, as people call it.
    pub kind: &'static str,
    /// What to send in its place.
    pub instead: &'static str,
}

/// Bytes looked at.
const HEAD: usize = 1 << 10;

const EXPORT: &str = "export it as GLB, OBJ, PLY or STL from the program that made it";
const UNPACK: &str = "unpack it and send the mesh inside";
const DRAWING: &str = "drawings go to /v1/sketches; of a mesh send the mesh itself";

/// How files begin, what they are and what to do.
const BEGINNINGS: [(&[u8], &str, &str); 26] = [
    (b"Kaydara FBX Binary", "an FBX file", "import it in Blender and export it as GLB, or use FBX2glTF"),
    (b"; FBX", "an FBX file", "import it in Blender and export it as GLB, or use FBX2glTF"),
    (b"BLENDER", "a Blender file", "open it in Blender and export it: File > Export > glTF 2.0 (.glb)"),
    (b"PXR-USDC", "a USD file", "import it in Blender and export it as GLB"),
    (b"#usda", "a USD file", "import it in Blender and export it as GLB"),
    (b"DRACO", "a Draco file", "unpack it with `draco_decoder -i mesh.drc -o mesh.ply`"),
    (b"Rar!\x1a\x07", "a RAR archive", UNPACK),
    (b"7z\xbc\xaf\x27\x1c", "a 7z archive", UNPACK),
    (b"\x1f\x8b\x08", "a gzip archive", UNPACK),
    (
        b"\x28\xb5\x2f\xfd",
        "a file compressed with Zstandard, as Blender saves",
        "save it uncompressed, or export it as GLB",
    ),
    (b"BZh", "a bzip2 archive", UNPACK),
    (b"\xfd7zXZ\x00", "an xz archive", UNPACK),
    (b"ISO-10303-21", "a STEP file", "export it as STL from the CAD program"),
    (b"3D Geometry File Format", "a Rhino file", EXPORT),
    (b"#VRML", "a VRML file", EXPORT),
    (b"#X3D", "an X3D file", EXPORT),
    (b"//Maya ASCII", "a Maya file", EXPORT),
    (b"Ogawa", "an Alembic file", EXPORT),
    (b"xof 0", "a DirectX file", EXPORT),
    (b"\x89PNG\r\n\x1a\n", "a PNG picture", DRAWING),
    (b"\xff\xd8\xff", "a JPEG picture", DRAWING),
    (b"GIF8", "a GIF picture", DRAWING),
    (b"%PDF", "a PDF document", DRAWING),
    (b"\xff\xfe", "text in UTF-16", "save it as UTF-8"),
    (b"\xfe\xff", "text in UTF-16", "save it as UTF-8"),
    (b"version https://git-lfs", "a pointer of Git LFS and not the file itself", "fetch the file with `git lfs pull`"),
];

/// Elements that files of XML begin with.
const DOCUMENTS: [(&[u8], &str, &str); 6] = [
    (b"<COLLADA", "a COLLADA file", EXPORT),
    (b"<X3D", "an X3D file", EXPORT),
    (b"<amf", "an AMF file", "export it as STL"),
    (b"<svg", "an SVG drawing", DRAWING),
    (b"<!DOCTYPE html", "a web page and not a mesh", "download the file itself"),
    (b"<html", "a web page and not a mesh", "download the file itself"),
];

/// Names within archives of ZIP that tell what they are.
const PACKED: [(&[u8], &str, &str); 4] = [
    (b".usd", "a USDZ file (a ZIP archive)", "import it in Blender and export it as GLB"),
    (b"3D/", "a 3MF file (a ZIP archive)", "export it as STL from the slicer or the CAD program"),
    (b"[Content_Types].xml", "a 3MF file (a ZIP archive)", "export it as STL from the slicer or the CAD program"),
    (b"", "a ZIP archive", UNPACK),
];

/// What the bytes are, where they are known to be something else than a mesh.
pub fn name(bytes: &[u8]) -> Option<Foreign> {
    let head = &bytes[..bytes.len().min(HEAD)];
    let contains = |part: &[u8]| part.is_empty() || head.windows(part.len()).any(|w| w.eq_ignore_ascii_case(part));
    let found = if head.starts_with(b"PK\x03\x04") || head.starts_with(b"PK\x05\x06") {
        PACKED.iter().find(|(part, ..)| contains(part))
    } else if let beginning @ Some(_) = BEGINNINGS.iter().find(|(start, ..)| head.starts_with(start)) {
        beginning
    } else if super::text::without_mark(head).trim_ascii_start().starts_with(b"<") {
        DOCUMENTS.iter().find(|(part, ..)| contains(part))
    } else {
        None
    };
    found.map(|&(_, kind, instead)| Foreign { kind, instead })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_what_is_no_mesh_and_nothing_that_is_one() {
        for (bytes, kind) in [
            (&b"PK\x03\x04\x14\0mesh.obj"[..], "a ZIP archive"),
            (b"PK\x03\x04\x14\x003D/3dmodel.model", "a 3MF file (a ZIP archive)"),
            (b"PK\x03\x04\x14\0scene.usdc", "a USDZ file (a ZIP archive)"),
            (b"Kaydara FBX Binary  \0", "an FBX file"),
            (b"BLENDER-v300", "a Blender file"),
            (b"\xef\xbb\xbf<?xml version=\"1.0\"?>\n<COLLADA>", "a COLLADA file"),
            (b"  <!doctype HTML><html>", "a web page and not a mesh"),
        ] {
            assert_eq!(name(bytes).map(|foreign| foreign.kind), Some(kind));
        }
        for bytes in [&b""[..], b"v 0 0 0\n", b"solid a\n", b"OFF\n", b"ply\n", b"glTF", b"<", b"{\"asset\": {}}"] {
            assert_eq!(name(bytes), None);
        }
    }
}
