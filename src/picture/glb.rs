//! A coloured mesh as glTF 2.0 in one binary file.

use gltf::binary::{Glb, Header};
use serde_json::{Value, json};

use super::colour::Colour;
use super::surface;
use crate::mesh::file_mesh::FileMesh;
use crate::mesh::normals::normals;

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
/// Where a vertex of no triangle faces.
const NOWHERE: [f64; 3] = [0.0, 0.0, 1.0];

/// Seconds from one pose to the next.
const PACE: f32 = 0.5;

/// The mesh of a file with the colours of the sound mesh's vertices as a GLB file: one primitive with `POSITION`, `NORMAL`, `COLOR_0` (linear, as
/// glTF has it) and indices. Vertices and triangles keep their order. Of poses, places of the file's vertices, one takes the
/// place of the mesh's own, and several are morph targets that an animation leads through.
///
/// Coordinates are those of the mesh. One that single precision would spoil, because it is far from the origin or very
/// large or small, is moved to the origin and scaled to extent 1.
///
/// # Errors
/// What the encoder reports: the file would be larger than 4 GiB.
pub fn file(mesh: &FileMesh, colours: &[Colour], poses: &[Vec<[f64; 3]>]) -> Result<Vec<u8>, gltf::Error> {
    let single = Single::of(mesh);
    let sound: Vec<Option<usize>> =
        (0..mesh.positions().len() as u32).map(|v| mesh.sound_vertices(v).next().map(|own| own as usize)).collect();
    let (rest, targets) = match poses {
        [one] => (one.as_slice(), &[][..]),
        targets => (mesh.positions(), targets),
    };
    let attributes = |places: &[[f64; 3]]| {
        let own = mesh.origins().iter().map(|&v| places[v as usize]).collect::<Vec<_>>();
        let normals = normals(&own, mesh.sound().triangles());
        let normals = sound.iter().map(|v| v.map_or(NOWHERE, |v| normals[v]).map(|x| x as f32));
        let positions: Vec<[f32; 3]> = places.iter().map(|&p| single.place(p)).collect();
        (positions, normals.collect::<Vec<[f32; 3]>>())
    };
    let (positions, normals) = attributes(rest);
    let colours: Vec<[f32; 3]> =
        sound.iter().map(|v| v.map_or(surface::plain(), |v| colours[v]).0.map(|x| x as f32)).collect();
    let mut content = Content::default();
    let [position, normal, colour] = [(&positions, true), (&normals, false), (&colours, false)]
        .map(|(rows, bounded)| content.triples(rows, bounded, Some(ARRAY_BUFFER)));
    let indices = content.numbers(mesh.triangles());
    let mut primitive = json!({
        "attributes": {"POSITION": position, "NORMAL": normal, "COLOR_0": colour},
        "indices": indices, "material": 0, "mode": 4,
    });
    let mut document = json!({});
    if !targets.is_empty() {
        let offsets = |to: Vec<[f32; 3]>, from: &[[f32; 3]]| -> Vec<[f32; 3]> {
            to.iter().zip(from).map(|(to, from)| std::array::from_fn(|i| to[i] - from[i])).collect()
        };
        let written = targets.iter().map(|places| {
            let (to, facing) = attributes(places);
            let (to, facing) = (offsets(to, &positions), offsets(facing, &normals));
            json!({"POSITION": content.triples(&to, true, None), "NORMAL": content.triples(&facing, false, None)})
        });
        primitive["targets"] = json!(written.collect::<Vec<Value>>());
        let count = targets.len();
        let times: Vec<f32> = (0..count).map(|i| PACE * i as f32).collect();
        let weights = (0..count * count).map(|i| if i / count == i % count { 1.0 } else { 0.0 }).collect::<Vec<f32>>();
        let (input, output) = (content.scalars(&times), content.scalars(&weights));
        document["animations"] = json!([{
            "samplers": [{"input": input, "output": output, "interpolation": "LINEAR"}],
            "channels": [{"sampler": 0, "target": {"node": 0, "path": "weights"}}],
        }]);
    }
    document["meshes"] = json!([{"primitives": [primitive]}]);
    if !targets.is_empty() {
        let first = (0..targets.len()).map(|i| u8::from(i == 0)).collect::<Vec<u8>>();
        document["meshes"][0]["weights"] = json!(first);
    }
    content.finished(document).to_vec()
}

/// The buffer of a file, and what is where in it.
#[derive(Default)]
struct Content {
    data: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
}

impl Content {
    /// Adds rows of numbers; the number of their accessor.
    fn add(&mut self, bytes: &[u8], target: Option<u32>, mut accessor: Value) -> usize {
        let mut view = json!({"buffer": 0, "byteOffset": self.data.len(), "byteLength": bytes.len()});
        if let Some(target) = target {
            view["target"] = json!(target);
        }
        accessor["bufferView"] = json!(self.views.len());
        self.views.push(view);
        self.accessors.push(accessor);
        self.data.extend_from_slice(bytes);
        self.accessors.len() - 1
    }

    fn triples(&mut self, rows: &[[f32; 3]], bounded: bool, target: Option<u32>) -> usize {
        let mut accessor = json!({"componentType": FLOAT, "count": rows.len(), "type": "VEC3"});
        if bounded {
            let bound = |pick: fn(f32, f32) -> f32, start: f32| -> [f32; 3] {
                std::array::from_fn(|i| rows.iter().map(|p| p[i]).fold(start, pick))
            };
            accessor["min"] = json!(bound(f32::min, f32::INFINITY));
            accessor["max"] = json!(bound(f32::max, f32::NEG_INFINITY));
        }
        let bytes: Vec<u8> = rows.as_flattened().iter().flat_map(|x| x.to_le_bytes()).collect();
        self.add(&bytes, target, accessor)
    }

    fn scalars(&mut self, values: &[f32]) -> usize {
        let bound = |pick: fn(f32, f32) -> f32, start: f32| [values.iter().copied().fold(start, pick)];
        let accessor = json!({
            "componentType": FLOAT, "count": values.len(), "type": "SCALAR",
            "min": bound(f32::min, f32::INFINITY), "max": bound(f32::max, f32::NEG_INFINITY),
        });
        let bytes: Vec<u8> = values.iter().flat_map(|x| x.to_le_bytes()).collect();
        self.add(&bytes, None, accessor)
    }

    fn numbers(&mut self, triangles: &[[u32; 3]]) -> usize {
        let accessor = json!({"componentType": UNSIGNED_INT, "count": 3 * triangles.len(), "type": "SCALAR"});
        let bytes: Vec<u8> = triangles.as_flattened().iter().flat_map(|v| v.to_le_bytes()).collect();
        self.add(&bytes, Some(ELEMENT_ARRAY_BUFFER), accessor)
    }

    fn finished<'a>(self, mut document: Value) -> Glb<'a> {
        document["asset"] = json!({"version": "2.0", "generator": "sketchmatch"});
        document["scene"] = json!(0);
        document["scenes"] = json!([{"nodes": [0]}]);
        document["nodes"] = json!([{"mesh": 0}]);
        document["materials"] = json!([{
            "pbrMetallicRoughness": {"baseColorFactor": [1, 1, 1, 1], "metallicFactor": 0, "roughnessFactor": 0.9},
            "doubleSided": true,
        }]);
        document["accessors"] = json!(self.accessors);
        document["bufferViews"] = json!(self.views);
        document["buffers"] = json!([{"byteLength": self.data.len()}]);
        Glb {
            // The length is filled in when the file is written.
            header: Header { magic: *b"glTF", version: 2, length: 0 },
            json: document.to_string().into_bytes().into(),
            bin: Some(self.data.into()),
        }
    }
}

/// How the coordinates of a mesh become numbers of single precision, all finite.
struct Single {
    middle: [f64; 3],
    scale: f64,
}

impl Single {
    fn of(mesh: &FileMesh) -> Single {
        let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        for &v in mesh.triangles().as_flattened() {
            let p = mesh.positions()[v as usize];
            (0..3).for_each(|i| (low[i], high[i]) = (low[i].min(p[i]), high[i].max(p[i])));
        }
        let extent = (0..3).map(|i| high[i] - low[i]).fold(0.0, f64::max);
        let farthest = low.into_iter().chain(high).map(f64::abs).fold(0.0, f64::max);
        if farthest <= FAR * extent && SIZES.contains(&extent) {
            return Single { middle: [0.0; 3], scale: 1.0 };
        }
        Single { middle: std::array::from_fn(|i| low[i] + 0.5 * (high[i] - low[i])), scale: extent.recip() }
    }

    fn place(&self, p: [f64; 3]) -> [f32; 3] {
        // Vertices of no triangle may lie anywhere, or nowhere.
        let within = |x: f64| if x.is_nan() { 0.0 } else { (x as f32).clamp(f32::MIN, f32::MAX) };
        std::array::from_fn(|i| within((p[i] - self.middle[i]) * self.scale))
    }
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
        let bytes = file(&mesh, &colours(8), &[]).unwrap();
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
        let bytes = file(&cube().into(), &colours(8), &[]).unwrap();
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
            let read = reimported(&file(&mesh.clone().into(), &colours(8), &[]).unwrap());
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
        let read = reimported(&file(&mesh.clone().into(), &colours(9), &[]).unwrap());
        assert_eq!((read.positions().len(), read.triangles()), (9, mesh.triangles()));
    }

    #[test]
    fn one_pose_is_the_mesh_and_several_are_morph_targets_led_through() {
        let mesh = FileMesh::from(cube());
        let poses: Vec<Vec<[f64; 3]>> = (1..4)
            .map(|pose| mesh.positions().iter().map(|&[x, y, z]| [x + f64::from(pose), y, z]).collect())
            .collect();
        let one = reimported(&file(&mesh, &colours(8), &poses[..1]).unwrap());
        assert_eq!((one.positions(), one.triangles()), (poses[0].as_slice(), mesh.triangles()));

        let bytes = file(&mesh, &colours(8), &poses).unwrap();
        assert_eq!(reimported(&bytes), mesh);
        let Gltf { document, blob } = Gltf::from_slice(&bytes).unwrap();
        let of_mesh = document.meshes().next().unwrap();
        assert_eq!(of_mesh.weights(), Some(&[1.0, 0.0, 0.0][..]));
        let primitive = of_mesh.primitives().next().unwrap();
        let targets = primitive.morph_targets();
        let offset: Vec<[f32; 3]> = targets
            .map(|target| target.positions().unwrap())
            .map(|accessor| {
                gltf::accessor::Iter::<[f32; 3]>::new(accessor, |_| blob.as_deref()).unwrap().last().unwrap()
            })
            .collect();
        assert_eq!(offset, [[1.0, 0.0, 0.0], [2.0, 0.0, 0.0], [3.0, 0.0, 0.0]]);
        let animation = document.animations().next().unwrap();
        let channel = animation.channels().next().unwrap();
        let reader = channel.reader(|_| blob.as_deref());
        assert_eq!(reader.read_inputs().unwrap().collect::<Vec<f32>>(), [0.0, PACE, 2.0 * PACE]);
        let Some(gltf::animation::util::ReadOutputs::MorphTargetWeights(weights)) = reader.read_outputs() else {
            panic!("the weights are animated")
        };
        assert_eq!(weights.into_f32().collect::<Vec<f32>>(), [1., 0., 0., 0., 1., 0., 0., 0., 1.]);
    }
}
