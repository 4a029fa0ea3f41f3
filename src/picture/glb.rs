//! A coloured mesh as glTF 2.0 in one binary file.

use gltf::binary::{Glb, Header};
use serde_json::{Value, json};

use super::colour::Colour;
use super::surface;
use crate::mesh::file_mesh::FileMesh;
use crate::mesh::normals::vertex_normals;

/// Single precision holds the coordinates of a file well where the mesh is no farther from the origin than this many
/// times its extent.
const FAR: f64 = 1024.0;
/// And where the extent is between these.
const SIZES: std::ops::RangeInclusive<f64> = 1e-18..=1e18;

/// What accessors and buffer views call their numbers and their use (glTF 2.0, §3.6 and §3.7).
const FLOAT: u32 = 5126;
const UNSIGNED_INT: u32 = 5125;
const ARRAY_BUFFER: u32 = 34962;
const ELEMENT_ARRAY_BUFFER: u32 = 34963;
/// Bytes of three numbers.
const STRIDE: usize = 12;
/// Where a vertex of no triangle faces.
const NOWHERE: [f64; 3] = [0.0, 0.0, 1.0];

/// The mesh of a file with the colours of the sound mesh's vertices as a GLB file: one primitive with `POSITION`, `NORMAL`, `COLOR_0` (linear, as
/// glTF has it) and indices. Vertices and triangles keep their order.
///
/// Coordinates are those of the mesh. One that single precision would spoil, because it is far from the origin or very
/// large or small, is moved to the origin and scaled to extent 1.
///
/// # Errors
/// What the encoder reports: the file would be larger than 4 GiB.
pub fn file(mesh: &FileMesh, colours: &[Colour]) -> Result<Vec<u8>, gltf::Error> {
    let positions = single(mesh);
    let normals = vertex_normals(mesh.sound());
    let sound = || (0..positions.len() as u32).map(|v| mesh.sound_vertices(v).next().map(|sound| sound as usize));
    let colours = sound().map(|v| v.map_or(surface::plain(), |v| colours[v]).0.map(|x| x as f32));
    let normals = sound().map(|v| v.map_or(NOWHERE, |v| normals[v]).map(|x| x as f32));
    let (n, m) = (positions.len(), mesh.triangles().len());
    let mut data = Vec::with_capacity(STRIDE * (3 * n + m));
    let floats = |data: &mut Vec<u8>, triple: [f32; 3]| data.extend(triple.map(f32::to_le_bytes).as_flattened());
    positions.iter().for_each(|&position| floats(&mut data, position));
    normals.for_each(|normal| floats(&mut data, normal));
    colours.for_each(|colour| floats(&mut data, colour));
    mesh.triangles().iter().for_each(|triangle| data.extend(triangle.map(u32::to_le_bytes).as_flattened()));
    let glb = Glb {
        // The length is filled in when the file is written.
        header: Header { magic: *b"glTF", version: 2, length: 0 },
        json: description(&positions, m).to_string().into_bytes().into(),
        bin: Some(data.into()),
    };
    glb.to_vec()
}

/// The JSON of a file of these vertices and `m` triangles.
fn description(positions: &[[f32; 3]], m: usize) -> Value {
    let n = positions.len();
    let bound = |pick: fn(f32, f32) -> f32, start: f32| -> [f32; 3] {
        std::array::from_fn(|i| positions.iter().map(|p| p[i]).fold(start, pick))
    };
    let (low, high) = (bound(f32::min, f32::INFINITY), bound(f32::max, f32::NEG_INFINITY));
    let triples = |view: usize| json!({"bufferView": view, "componentType": FLOAT, "count": n, "type": "VEC3"});
    let mut accessors = [triples(0), triples(1), triples(2)];
    accessors[0]["min"] = json!(low);
    accessors[0]["max"] = json!(high);
    let indices = json!({"bufferView": 3, "componentType": UNSIGNED_INT, "count": 3 * m, "type": "SCALAR"});
    let view = |i: usize| {
        let length = STRIDE * if i < 3 { n } else { m };
        let target = if i < 3 { ARRAY_BUFFER } else { ELEMENT_ARRAY_BUFFER };
        json!({"buffer": 0, "byteOffset": STRIDE * i * n, "byteLength": length, "target": target})
    };
    json!({
        "asset": {"version": "2.0", "generator": "sketchmatch"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{
            "attributes": {"POSITION": 0, "NORMAL": 1, "COLOR_0": 2}, "indices": 3, "material": 0, "mode": 4,
        }]}],
        "materials": [{
            "pbrMetallicRoughness": {"baseColorFactor": [1, 1, 1, 1], "metallicFactor": 0, "roughnessFactor": 0.9},
            "doubleSided": true,
        }],
        "accessors": [accessors[0], accessors[1], accessors[2], indices],
        "bufferViews": [view(0), view(1), view(2), view(3)],
        "buffers": [{"byteLength": STRIDE * (3 * n + m)}],
    })
}

/// The vertices in single precision, all finite.
fn single(mesh: &FileMesh) -> Vec<[f32; 3]> {
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for &v in mesh.triangles().as_flattened() {
        let p = mesh.positions()[v as usize];
        (0..3).for_each(|i| (low[i], high[i]) = (low[i].min(p[i]), high[i].max(p[i])));
    }
    let extent = (0..3).map(|i| high[i] - low[i]).fold(0.0, f64::max);
    let farthest = low.into_iter().chain(high).map(f64::abs).fold(0.0, f64::max);
    let held = farthest <= FAR * extent && SIZES.contains(&extent);
    let (middle, scale) = if held {
        ([0.0; 3], 1.0)
    } else {
        (std::array::from_fn(|i| low[i] + 0.5 * (high[i] - low[i])), extent.recip())
    };
    // Vertices of no triangle may lie anywhere, or nowhere.
    let within = |x: f64| if x.is_nan() { 0.0 } else { (x as f32).clamp(f32::MIN, f32::MAX) };
    mesh.positions().iter().map(|p| std::array::from_fn(|i| within((p[i] - middle[i]) * scale))).collect()
}

#[cfg(test)]
mod tests {
    use gltf::Gltf;

    use super::super::fixtures::cube;
    use super::*;
    use crate::mesh::TriangleMesh;
    use crate::mesh::formats::{Format, Limits};
    use crate::mesh::validation::import;

    fn colours(n: usize) -> Vec<Colour> {
        (0..n).map(|i| Colour([i as f64 / n as f64, 0.25, 0.5])).collect()
    }

    fn reimported(bytes: &[u8]) -> FileMesh {
        import(bytes, Format::Glb, &Limits::default()).unwrap().mesh
    }

    #[test]
    fn a_file_read_again_is_the_same_mesh() {
        let mesh = FileMesh::from(cube());
        let bytes = file(&mesh, &colours(8)).unwrap();
        assert_eq!(reimported(&bytes), mesh);
        // Reading validates.
        let Gltf { document, blob } = Gltf::from_slice(&bytes).unwrap();
        let primitive = document.meshes().next().unwrap().primitives().next().unwrap();
        let reader = primitive.reader(|_| blob.as_deref());
        let read: Vec<[f32; 3]> = reader.read_colors(0).unwrap().into_rgb_f32().collect();
        let expected: Vec<[f32; 3]> = colours(8).iter().map(|colour| colour.0.map(|x| x as f32)).collect();
        assert_eq!(read, expected);
        let bounds = primitive.bounding_box();
        assert_eq!((bounds.min, bounds.max), ([-1.0; 3], [1.0; 3]));
        for (normal, position) in reader.read_normals().unwrap().zip(reader.read_positions().unwrap()) {
            assert!((0..3).all(|i| (normal[i] * 3f32.sqrt() - position[i]).abs() < 0.6), "{normal:?} {position:?}");
        }
    }

    #[test]
    fn everything_is_aligned() {
        let bytes = file(&cube().into(), &colours(8)).unwrap();
        let length = u32::from_le_bytes(bytes[8..12].try_into().unwrap()) as usize;
        let json_length = u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize;
        assert_eq!((length, length % 4, json_length % 4), (bytes.len(), 0, 0));
        let document = Gltf::from_slice(&bytes).unwrap();
        assert!(document.views().all(|view| view.offset() % 4 == 0 && view.length() % 4 == 0));
    }

    #[test]
    fn what_single_precision_would_spoil_is_moved_and_scaled() {
        for (scale, offset) in [(1e49, 0.0), (1e-40, 0.0), (1.0, 1e9)] {
            let positions = cube().positions().iter().map(|p| p.map(|x| x * scale + offset)).collect();
            let mesh = TriangleMesh::new(positions, cube().triangles().to_vec()).unwrap();
            let read = reimported(&file(&mesh.clone().into(), &colours(8)).unwrap());
            assert_eq!(read.triangles(), mesh.triangles());
            let area = read.sound().area();
            assert!((area - 6.0).abs() < 1e-5, "{scale} {offset}: {area}");
        }
    }

    #[test]
    fn a_vertex_of_no_triangle_anywhere_is_kept() {
        let mut positions = cube().positions().to_vec();
        positions.push([1e50, -1e50, 0.0]);
        let mesh = TriangleMesh::new(positions, cube().triangles().to_vec()).unwrap();
        let read = reimported(&file(&mesh.clone().into(), &colours(9)).unwrap());
        assert_eq!((read.positions().len(), read.triangles()), (9, mesh.triangles()));
    }
}
