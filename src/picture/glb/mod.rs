//! A mesh as glTF 2.0 in one binary file: coloured, or in the appearance its own file gave it.

mod content;
mod poses;

use serde_json::{Map, Value, json};

use super::colour::Colour;
use super::surface;
use crate::mesh::file_mesh::FileMesh;
use crate::mesh::formats::Appearance;
use content::Content;
use poses::Poses;

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
    let poses = Poses::of(mesh, poses);
    let (mut content, mut document) = (Content::default(), Map::new());
    let sound = (0..mesh.positions().len() as u32).map(|v| mesh.sound_vertices(v).next());
    let colours: Vec<[f32; 3]> =
        sound.map(|v| v.map_or(surface::plain(), |own| colours[own as usize]).0.map(|x| x as f32)).collect();
    let mut primitive = Map::from_iter([("material".to_owned(), json!(0))]);
    poses.put(&mut primitive, 0..colours.len(), &mut content);
    primitive["attributes"]["COLOR_0"] = json!(content.triples(&colours, false, Some(content::ARRAY_BUFFER)));
    primitive.insert("indices".into(), json!(content.corners(mesh.triangles())));
    poses.show(vec![primitive.into()], &mut document, &mut content);
    let matt = json!({"baseColorFactor": [1, 1, 1, 1], "metallicFactor": 0, "roughnessFactor": 0.9});
    document.insert("materials".into(), json!([{"pbrMetallicRoughness": matt, "doubleSided": true}]));
    content.finished(document).to_vec()
}

/// The mesh of a glTF file in poses as [`file`] has them, with the texture coordinates, colours, materials and textures of
/// that file: a primitive for each of its own. Nothing where the file's vertices are others.
///
/// # Errors
/// What the encoder reports: the file would be larger than 4 GiB.
pub fn in_appearance(
    mesh: &FileMesh,
    appearance: Appearance,
    poses: &[Vec<[f64; 3]>],
) -> Result<Option<Vec<u8>>, gltf::Error> {
    let Appearance { mut document, data, parts } = appearance;
    if parts.last().is_none_or(|part| part.vertices.end != mesh.positions().len()) {
        return Ok(None);
    }
    let poses = Poses::of(mesh, poses);
    let mut content = Content::of(&mut document, data);
    let mut primitives: Vec<Value> = Vec::new();
    let mut unseen = mesh.triangles();
    for part in parts {
        let vertices = part.vertices;
        // Triangles come in the order of the primitives they are of.
        let own = unseen.iter().take_while(|triangle| triangle.iter().all(|&v| (v as usize) < vertices.end)).count();
        let (triangles, others) = unseen.split_at(own);
        unseen = others;
        if triangles.as_flattened().iter().any(|&v| (v as usize) < vertices.start) {
            return Ok(None);
        }
        if triangles.is_empty() {
            continue;
        }
        let mut primitive = part.primitive;
        let corners: Vec<[u32; 3]> = triangles.iter().map(|t| t.map(|v| v - vertices.start as u32)).collect();
        primitive.insert("indices".into(), json!(content.corners(&corners)));
        poses.put(&mut primitive, vertices, &mut content);
        primitives.push(primitive.into());
    }
    if !unseen.is_empty() {
        return Ok(None);
    }
    poses.show(primitives, &mut document, &mut content);
    content.finished(document).to_vec().map(Some)
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
        // As it is shown before it is led through the others: in the first pose.
        let several = reimported(&bytes);
        assert_eq!((several.positions(), several.triangles()), (poses[0].as_slice(), mesh.triangles()));
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
        assert_eq!(reader.read_inputs().unwrap().collect::<Vec<f32>>(), [0.0, content::PACE, 2.0 * content::PACE]);
        let Some(gltf::animation::util::ReadOutputs::MorphTargetWeights(weights)) = reader.read_outputs() else {
            panic!("the weights are animated")
        };
        assert_eq!(weights.into_f32().collect::<Vec<f32>>(), [1., 0., 0., 0., 1., 0., 0., 0., 1.]);
    }

    /// A tetrahedron shown by two nodes, one of which mirrors it, with texture coordinates of bytes and a texture whose picture
    /// is among the data, as JSON and data.
    fn textured() -> (Value, Vec<u8>) {
        let corners: [[f32; 3]; 4] = [[0., 0., 0.], [1., 0., 0.], [0., 1., 0.], [0., 0., 1.]];
        let mut data = vec![7u8; 6];
        data.resize(8, 0);
        data.extend(corners.as_flattened().iter().flat_map(|x| x.to_le_bytes()));
        data.extend([0, 0, 0, 0, 255, 0, 0, 0, 0, 255, 0, 0, 255, 255, 0, 0]);
        data.extend([0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3]);
        let json = json!({
            "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0, 1]}],
            "nodes": [{"mesh": 0}, {"mesh": 0, "scale": [-1, 1, 1], "translation": [-5, 0, 0]}],
            "extensionsUsed": ["KHR_texture_transform", "KHR_lights_punctual"],
            "meshes": [{"primitives": [
                {"attributes": {"POSITION": 0, "TEXCOORD_0": 1, "JOINTS_0": 1}, "indices": 2, "material": 0}]}],
            "materials": [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}],
            "textures": [{"source": 0}],
            "images": [{"bufferView": 0, "mimeType": "image/png"}],
            "accessors": [
                {"bufferView": 1, "componentType": 5126, "count": 4, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 1]},
                {"bufferView": 2, "componentType": 5121, "normalized": true, "count": 4, "type": "VEC2"},
                {"bufferView": 3, "componentType": 5121, "count": 12, "type": "SCALAR"}],
            "bufferViews": [
                {"buffer": 0, "byteLength": 6}, {"buffer": 0, "byteOffset": 8, "byteLength": 48},
                {"buffer": 0, "byteOffset": 56, "byteLength": 16, "byteStride": 4},
                {"buffer": 0, "byteOffset": 72, "byteLength": 12}],
            "buffers": [{"byteLength": data.len()}]
        });
        (json, data)
    }

    fn binary((json, data): &(Value, Vec<u8>)) -> Vec<u8> {
        let header = gltf::binary::Header { magic: *b"glTF", version: 2, length: 0 };
        let json = serde_json::to_vec(json).unwrap();
        gltf::Glb { header, json: json.into(), bin: Some(data.into()) }.to_vec().unwrap()
    }

    #[test]
    fn a_pose_has_the_texture_of_the_file() {
        let textured = textured();
        let mut as_json = textured.0.clone();
        let text = base64::Engine::encode(&base64::engine::general_purpose::STANDARD, &textured.1);
        as_json["buffers"][0]["uri"] = json!(format!("data:application/octet-stream;base64,{text}"));
        for (bytes, format) in [(binary(&textured), Format::Glb), (serde_json::to_vec(&as_json).unwrap(), Format::Gltf)]
        {
            let mesh = import(&bytes, format, &Limits::default()).unwrap().mesh;
            let moved: Vec<[f64; 3]> = mesh.positions().iter().map(|&[x, y, z]| [x, y + 2.0, z]).collect();
            let appearance = || Appearance::of(&bytes).unwrap().unwrap();
            let written = in_appearance(&mesh, appearance(), std::slice::from_ref(&moved)).unwrap().unwrap();
            let read = reimported(&written);
            assert_eq!((read.positions(), read.triangles()), (&moved[..], mesh.triangles()));

            let Gltf { document, blob } = Gltf::from_slice(&written).unwrap();
            let blob = blob.unwrap();
            let primitives: Vec<_> = document.meshes().next().unwrap().primitives().collect();
            assert_eq!(primitives.len(), 2);
            for primitive in &primitives {
                let reader = primitive.reader(|_| Some(&blob));
                let uv: Vec<[f32; 2]> = reader.read_tex_coords(0).unwrap().into_f32().collect();
                assert_eq!(uv, [[0., 0.], [1., 0.], [0., 1.], [1., 1.]]);
                assert!(reader.read_joints(0).is_none(), "bones would move it again");
                let texture = primitive.material().pbr_metallic_roughness().base_color_texture().unwrap().texture();
                let gltf::image::Source::View { view, .. } = texture.source().source() else { panic!("in the data") };
                assert_eq!(blob[view.offset()..view.offset() + view.length()], [7; 6]);
            }
            assert_eq!(document.extensions_used().collect::<Vec<_>>(), ["KHR_texture_transform"]);

            let several = in_appearance(&mesh, appearance(), &[moved.clone(), moved]).unwrap().unwrap();
            let document = Gltf::from_slice(&several).unwrap().document;
            assert_eq!(document.animations().count(), 1);
            assert!(document.meshes().flat_map(|mesh| mesh.primitives()).all(|part| part.morph_targets().len() == 2));
        }
    }

    #[test]
    fn the_appearance_of_another_mesh_is_not_taken() {
        let appearance = Appearance::of(&binary(&textured())).unwrap().unwrap();
        assert!(in_appearance(&cube().into(), appearance, &[]).unwrap().is_none());
    }

    #[test]
    fn data_packed_in_a_way_of_their_own_are_left() {
        let (mut json, data) = textured();
        json["bufferViews"][2]["extensions"] = json!({"EXT_meshopt_compression": {}});
        assert!(Appearance::of(&binary(&(json, data))).unwrap().is_none());
    }
}
