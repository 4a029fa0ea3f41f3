//! glTF 2.0 that holds all its data, binary or as JSON: the triangles of the default scene, in the order of a walk through
//! its nodes.

mod accessors;
pub(super) mod appearance;
mod container;
mod matrix;
mod morph;
mod skin;

use gltf::mesh::Mode;
use gltf::{Document, Mesh, Node, Primitive, Semantic};

use super::{Polygons, admit};
use crate::mesh::refusal::{Place, Refusal};
use container::Container;
use matrix::{IDENTITY, Matrix, determinant, placed, product};
use skin::Bones;

pub(super) fn looks_like(bytes: &[u8]) -> bool {
    container::looks_binary(bytes)
}

pub(super) fn looks_like_json(bytes: &[u8]) -> bool {
    container::looks_like_json(bytes)
}

pub(super) fn read(bytes: &[u8], polygons: Polygons) -> Result<Polygons, Refusal> {
    let container = Container::open(bytes)?;
    let document = &container.document;
    let worlds = worlds(document)?;
    let skins = document.skins().map(|skin| Bones::of(&skin, &worlds, &container)).collect::<Result<Vec<_>, _>>();
    let skins = skins.map_err(refusal)?;
    let mut read = Read { polygons, primitives: 0, indices: 0, offsets: 0, container: &container };
    walk(&container, |node, primitive, mesh| {
        // A skin places its vertices itself: its node's transform does not count.
        let bones = node.skin().and_then(|skin| skins[skin.index()].as_ref());
        let transform = if node.skin().is_some() { IDENTITY } else { worlds[node.index()] };
        let weights = node.weights().or(mesh.weights()).unwrap_or_default();
        let place = format!("primitive {} of mesh {}", primitive.index(), mesh.index());
        read.primitive(primitive, weights, &transform, bones, &place)
    })?;
    Ok(read.polygons)
}

/// Goes through the primitives of what is shown, in the order of a walk through the nodes. A node that is hidden hides all below
/// it.
fn walk<'a>(
    Container { document, hidden, .. }: &'a Container,
    mut visit: impl FnMut(&Node<'a>, &Primitive<'a>, &Mesh<'a>) -> Result<(), Refusal>,
) -> Result<(), Refusal> {
    let mut visited = vec![false; document.nodes().len()];
    let mut pending: Vec<Node> = shown(document).into_iter().rev().collect();
    while let Some(node) = pending.pop() {
        if std::mem::replace(&mut visited[node.index()], true) {
            return Err(twice(&node));
        }
        if hidden.contains(&node.index()) {
            continue;
        }
        if let Some(mesh) = node.mesh() {
            mesh.primitives().try_for_each(|primitive| visit(&node, &primitive, &mesh))?;
        }
        let children: Vec<Node> = node.children().collect();
        pending.extend(children.into_iter().rev());
    }
    Ok(())
}

fn refusal(detail: impl Into<String>) -> Refusal {
    Refusal::because(Place::file(), detail)
}

/// The nodes of a valid file form trees; others might never end.
fn twice(node: &Node) -> Refusal {
    refusal(format!("node {} is in the scene twice", node.index()))
}

/// The nodes at the top of what is shown: those of the default scene, else of the first, else all that are nobody's child.
fn shown(document: &Document) -> Vec<Node<'_>> {
    if let Some(scene) = document.default_scene().or_else(|| document.scenes().next()) {
        return scene.nodes().collect();
    }
    tops(document)
}

/// The nodes that are nobody's child.
fn tops(document: &Document) -> Vec<Node<'_>> {
    let mut is_child = vec![false; document.nodes().len()];
    document.nodes().for_each(|node| node.children().for_each(|child| is_child[child.index()] = true));
    document.nodes().filter(|node| !is_child[node.index()]).collect()
}

/// Per node the matrix that places it, all its parents' in it.
fn worlds(document: &Document) -> Result<Vec<Matrix>, Refusal> {
    let mut worlds = vec![IDENTITY; document.nodes().len()];
    let mut visited = vec![false; worlds.len()];
    let mut pending: Vec<(Node, Matrix)> = tops(document).into_iter().map(|node| (node, IDENTITY)).collect();
    while let Some((node, parent)) = pending.pop() {
        if std::mem::replace(&mut visited[node.index()], true) {
            return Err(twice(&node));
        }
        let world = product(parent, node.transform().matrix().map(|column| column.map(f64::from)));
        worlds[node.index()] = world;
        pending.extend(node.children().map(|child| (child, world)));
    }
    Ok(worlds)
}

/// What has been read of a file.
struct Read<'a> {
    polygons: Polygons,
    /// Primitives and indices gone through so far, once for every node that shows them.
    primitives: usize,
    indices: usize,
    /// Likewise the offsets of morph targets.
    offsets: usize,
    container: &'a Container,
}

impl Read<'_> {
    fn primitive(
        &mut self,
        primitive: &Primitive,
        weights: &[f32],
        transform: &Matrix,
        bones: Option<&Bones>,
        place: &str,
    ) -> Result<(), Refusal> {
        self.primitives += 1;
        admit("primitives", self.primitives, self.polygons.limits.triangles)?;
        let Some(triangles) = triangles_of(primitive.mode()) else {
            self.polygons.ignored += 1;
            return Ok(());
        };
        let first = self.polygons.positions.len();
        let here = |detail: String| refusal(format!("{place}: {detail}"));
        let accessor = primitive.get(&Semantic::Positions).ok_or_else(|| here("it has no positions".into()))?;
        self.polygons.limits.admit_vertices(first.saturating_add(accessor.count()))?;
        let mut positions = self.container.numbers::<3>(&accessor).map_err(here)?;
        for (weight, offsets) in morph::targets(primitive, weights) {
            self.offsets = self.offsets.saturating_add(offsets.count());
            admit("offsets of morph targets", self.offsets, morph::most_offsets(self.polygons.limits.triangles))?;
            morph::moved(&mut positions, weight, &offsets, self.container).map_err(here)?;
        }
        if let Some(bones) = bones {
            bones.place(&mut positions, primitive, self.container).map_err(here)?;
        }
        for position in positions {
            self.polygons.push_vertex(placed(transform, position), None)?;
        }
        let vertices = self.polygons.positions.len() - first;
        let indices = match primitive.indices() {
            Some(accessor) => {
                // Those of triangles that are left out count too: lists have the most for their triangles, three each.
                self.indices = self.indices.saturating_add(accessor.count());
                admit("indices", self.indices, self.polygons.limits.triangles.saturating_mul(3))?;
                self.container.indices(&accessor).map_err(here)?
            }
            None => (0..vertices as u32).collect(),
        };
        if let Some(index) = indices.iter().find(|&&index| index as usize >= vertices) {
            return Err(here(format!("index {index} is out of range: there are {vertices} vertices")));
        }
        let mirrored = determinant(transform) < 0.0 || bones.is_some_and(Bones::mirror);
        for [a, b, c] in triangles(&indices) {
            let corners = if mirrored { [a, c, b] } else { [a, b, c] };
            self.polygons.push_face(corners.map(|v| (first + v as usize) as i64), None)?;
        }
        Ok(())
    }
}

/// Triangles by their corners' indices.
type Triangles = fn(&[u32]) -> Vec<[u32; 3]>;

/// What makes triangles of the indices of a primitive of this mode; nothing where that is no surface.
fn triangles_of(mode: Mode) -> Option<Triangles> {
    match mode {
        Mode::Triangles => Some(triangles_of_list),
        Mode::TriangleStrip => Some(triangles_of_strip),
        Mode::TriangleFan => Some(triangles_of_fan),
        Mode::Points | Mode::Lines | Mode::LineLoop | Mode::LineStrip => None,
    }
}

fn triangles_of_list(indices: &[u32]) -> Vec<[u32; 3]> {
    // What is over is no triangle, and passed over by what draws them.
    indices.as_chunks().0.to_vec()
}

/// Triangles that name a vertex twice only join the parts of a strip.
fn triangles_of_strip(indices: &[u32]) -> Vec<[u32; 3]> {
    let triangles = indices.windows(3).enumerate();
    let triangles = triangles.map(|(i, w)| if i % 2 == 0 { [w[0], w[1], w[2]] } else { [w[1], w[0], w[2]] });
    triangles.filter(|[a, b, c]| a != b && b != c && c != a).collect()
}

fn triangles_of_fan(indices: &[u32]) -> Vec<[u32; 3]> {
    let Some((&centre, rim)) = indices.split_first() else { return Vec::new() };
    rim.windows(2).map(|w| [centre, w[0], w[1]]).collect()
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_1_SQRT_2;

    use gltf::Glb;
    use serde_json::{Value, json};

    use super::super::{Format, Limits, read};
    use super::*;

    /// A file of this JSON and these binary data.
    fn glb(json: &Value, data: &[u8]) -> Vec<u8> {
        let glb = Glb {
            header: gltf::binary::Header { magic: *b"glTF", version: 2, length: 0 },
            json: serde_json::to_vec(json).unwrap().into(),
            bin: Some(data.into()),
        };
        glb.to_vec().unwrap()
    }

    /// Four corners of a unit square in the plane, the first twice, and u16 indices; one primitive of `mode`.
    fn square(mode: u8, indices: &[u16], nodes: Value) -> (Value, Vec<u8>) {
        let corners: [[f32; 3]; 5] = [[0., 0., 0.], [1., 0., 0.], [1., 1., 0.], [0., 1., 0.], [0., 0., 0.]];
        let mut data: Vec<u8> = corners.as_flattened().iter().flat_map(|x| x.to_le_bytes()).collect();
        data.extend(indices.iter().flat_map(|i| i.to_le_bytes()));
        let json = json!({
            "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": nodes,
            "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1, "mode": mode}]}],
            "accessors": [
                {"bufferView": 0, "componentType": 5126, "count": 5, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0]},
                {"bufferView": 1, "componentType": 5123, "count": indices.len(), "type": "SCALAR"}],
            "bufferViews": [
                {"buffer": 0, "byteOffset": 0, "byteLength": 60},
                {"buffer": 0, "byteOffset": 60, "byteLength": 2 * indices.len()}],
            "buffers": [{"byteLength": data.len()}]
        });
        (json, data)
    }

    fn reread(json: &Value, data: &[u8]) -> Result<Polygons, Refusal> {
        let bytes = glb(json, data);
        assert_eq!(Format::sniff(&bytes), Some(Format::Glb));
        read(&bytes, Format::Glb, &Limits::default())
    }

    fn faces(polygons: &Polygons) -> Vec<Vec<i64>> {
        polygons.faces().map(<[i64]>::to_vec).collect()
    }

    #[test]
    fn reads_lists_strips_and_fans() {
        let list: &[u16] = &[0, 1, 2, 4, 2, 3];
        let over: &[u16] = &[0, 1, 2, 4, 2, 3, 1, 2];
        for (mode, indices) in [(4, list), (4, over), (5, &[1, 2, 4, 3]), (5, &[1, 1, 1, 2, 4, 3]), (6, &[4, 1, 2, 3])]
        {
            let (json, data) = square(mode, indices, json!([{"mesh": 0}]));
            let polygons = reread(&json, &data).unwrap();
            assert_eq!(polygons.positions.len(), 5);
            let area: f64 = faces(&polygons).iter().map(|f| signed_area(&polygons.positions, f)).sum();
            assert_eq!((polygons.faces().len(), area), (2, 1.0), "{mode} {indices:?}");
        }
    }

    #[test]
    fn what_nobody_reads_is_no_reason_against_a_file() {
        let (mut json, data) = square(4, &[0, 1, 2], json!([{"mesh": 0}]));
        json["animations"] = json!([{"channels": 3, "samplers": [{"interpolation": 0}]}]);
        assert_eq!(reread(&json, &data).unwrap().faces().len(), 1);
    }

    #[test]
    fn the_version_before_is_named() {
        let old = br#"{"asset": {"version": "1.0"}, "accessors": {}, "meshes": {"a": {"primitives": []}}}"#;
        let mut binary = glb(&json!({}), b"");
        binary[4] = 1;
        for (bytes, format) in [(&old[..], Format::Gltf), (&binary, Format::Glb)] {
            let refusal = read(bytes, format, &Limits::default()).unwrap_err().to_string();
            assert!(refusal.contains("glTF 1.0"), "{refusal}");
        }
    }

    fn signed_area(positions: &[[f64; 3]], face: &[i64]) -> f64 {
        let [a, b, c] = [face[0], face[1], face[2]].map(|v| positions[v as usize]);
        0.5 * ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]))
    }

    #[test]
    fn applies_the_transforms_of_all_parents() {
        let nodes = json!([
            {"children": [1, 2], "translation": [10, 0, 0], "scale": [2, 2, 2]},
            {"mesh": 0, "translation": [1, 0, 0], "rotation": [0, 0, FRAC_1_SQRT_2, FRAC_1_SQRT_2]},
            {"mesh": 0, "scale": [-1, 1, 1]}
        ]);
        let (json, data) = square(4, &[0, 1, 2], nodes);
        let polygons = reread(&json, &data).unwrap();
        let near = |v: usize, expected: [f64; 3]| {
            (0..3).all(|axis| (polygons.positions[v][axis] - expected[axis]).abs() < 1e-5)
        };
        assert!(near(0, [12., 0., 0.]) && near(1, [12., 2., 0.]) && near(2, [10., 2., 0.]), "{:?}", polygons.positions);
        assert!(near(6, [8., 0., 0.]));
        // The mirrored copy is turned over.
        assert_eq!(faces(&polygons), [[0, 1, 2], [5, 7, 6]]);
    }

    /// The square with a target that moves its second corner by (2, 0, 0), all but that corner's offset left out.
    fn with_target(nodes: Value) -> (Value, Vec<u8>) {
        let (mut json, mut data) = square(4, &[0, 1, 2], nodes);
        let start = data.len().next_multiple_of(4);
        data.resize(start, 0);
        data.extend(1u32.to_le_bytes());
        data.extend([2f32, 0.0, 0.0].iter().flat_map(|x| x.to_le_bytes()));
        json["buffers"][0]["byteLength"] = json!(data.len());
        let views = [
            json!({"buffer": 0, "byteOffset": start, "byteLength": 4}),
            json!({"buffer": 0, "byteOffset": start + 4, "byteLength": 12}),
        ];
        json["bufferViews"].as_array_mut().unwrap().extend(views);
        let sparse = json!({
            "componentType": 5126, "count": 5, "type": "VEC3", "sparse": {
                "count": 1, "indices": {"bufferView": 2, "componentType": 5125}, "values": {"bufferView": 3}},
        });
        json["accessors"].as_array_mut().unwrap().push(sparse);
        json["meshes"][0]["primitives"][0]["targets"] = json!([{"NORMAL": 0}, {"POSITION": 2}]);
        (json, data)
    }

    #[test]
    fn applies_the_weights_of_morph_targets() {
        let second = |json: &Value, data: &[u8]| reread(json, data).unwrap().positions[1];
        let (mut json, data) = with_target(json!([{"mesh": 0, "scale": [2, 1, 1]}]));
        assert_eq!(second(&json, &data), [2.0, 0.0, 0.0]);
        json["meshes"][0]["weights"] = json!([1, 0.25]);
        assert_eq!(second(&json, &data), [3.0, 0.0, 0.0]);
        json["nodes"][0]["weights"] = json!([0, 0.5]);
        assert_eq!(second(&json, &data), [4.0, 0.0, 0.0]);
        let refused = |change: &dyn Fn(&mut Value)| {
            let mut json = json.clone();
            change(&mut json);
            reread(&json, &data).unwrap_err().to_string()
        };
        assert!(refused(&|json| json["accessors"][2]["count"] = json!(4)).contains("an offset for every vertex"));
        assert!(refused(&|json| json["accessors"][2]["type"] = json!("VEC2")).contains("does not have 3 numbers"));
        assert!(
            refused(&|json| json["meshes"][0]["primitives"][0]["targets"][1]["POSITION"] = json!(9)).contains("read")
        );
        // Many targets of the same offsets, of which few weigh anything.
        let limits = Limits { triangles: 10, ..Limits::default() };
        let mut of_weights = |weights: Vec<i32>| {
            json["meshes"][0]["primitives"][0]["targets"] = json!(vec![json!({"POSITION": 2}); weights.len()]);
            json["nodes"][0]["weights"] = json!(weights);
            read(&glb(&json, &data), Format::Glb, &limits).map(|polygons| polygons.positions[1])
        };
        assert_eq!(of_weights([vec![0; 200], vec![1; 96]].concat()), Ok([2.0 * (1.0 + 2.0 * 96.0), 0.0, 0.0]));
        let refusal = Refusal::TooLarge { unit: "offsets of morph targets", found: 485, limit: 480 };
        assert_eq!(of_weights(vec![1; 97]), Err(refusal));
    }

    #[test]
    fn leaves_out_nodes_that_are_hidden() {
        let hidden = |visible: bool| json!({"KHR_node_visibility": {"visible": visible}});
        let nodes = json!([
            {"children": [1, 2]}, {"mesh": 0, "extensions": hidden(true)},
            {"extensions": hidden(false), "children": [3]}, {"mesh": 0, "extensions": hidden(true)},
        ]);
        let (mut json, data) = square(4, &[0, 1, 2], nodes);
        assert_eq!(reread(&json, &data).unwrap().faces().len(), 1);
        json["nodes"][2]["extensions"] = hidden(true);
        assert_eq!(reread(&json, &data).unwrap().faces().len(), 2);
    }

    #[test]
    fn refuses_what_is_not_whole_or_not_supported() {
        let (json, data) = square(4, &[0, 1, 2], json!([{"mesh": 0}]));
        let change = |pointer: &str, value: Value| {
            let mut json = json.clone();
            let (parent, key) = pointer.rsplit_once('/').unwrap();
            json.pointer_mut(parent).unwrap()[key] = value;
            json
        };
        for (json, reason) in [
            (change("/extensionsRequired", json!(["KHR_draco_mesh_compression"])), "KHR_draco_mesh_compression"),
            (change("/extensionsRequired", json!(["EXT_meshopt_compression"])), "EXT_meshopt_compression"),
            (change("/buffers", json!([{"byteLength": 66, "uri": "mesh.bin"}])), "outside the file"),
            (change("/nodes", json!([{"children": [0], "mesh": 0}])), "twice"),
            (change("/nodes", json!([{"children": [7]}])), "cannot be read"),
            (change("/scenes", json!([])), "cannot be read"),
            (change("/asset", json!(3)), "cannot be read"),
            (change("/bufferViews", json!([{"buffer": 0, "byteLength": 6}, {"buffer": 0, "byteLength": 6}])), "beyond"),
        ] {
            let refusal = reread(&json, &data).unwrap_err().to_string();
            assert!(refusal.contains(reason), "{reason}: {refusal}");
        }
        let mut hostile = json.clone();
        hostile["accessors"][1]["count"] = json!(u64::MAX);
        assert!(reread(&hostile, &data).is_err());
        hostile["accessors"][1]["count"] = json!(900_000);
        assert!(reread(&hostile, &data).unwrap_err().to_string().contains("beyond its data"));
        hostile["accessors"][1] = json!({"componentType": 5123, "count": 3, "type": "SCALAR"});
        assert!(reread(&hostile, &data).is_err());
        let (json, data) = square(4, &[0, 1, 9], json!([{"mesh": 0}]));
        assert!(reread(&json, &data).unwrap_err().to_string().contains("index 9 is out of range"));
    }

    #[test]
    fn what_is_not_read_is_no_reason_against_a_file() {
        let (mut json, data) = square(4, &[0, 1, 2], json!([{"mesh": 0, "camera": 7}]));
        // A texture whose picture an extension names, and a material that does not exist.
        json["textures"] = json!([{"extensions": {"KHR_texture_basisu": {"source": 0}}}]);
        json["materials"] = json!([{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}, {"alphaMode": "ODD"}]);
        json["meshes"][0]["primitives"][0]["material"] = json!(5);
        json["extensionsRequired"] = json!(["KHR_texture_basisu"]);
        assert_eq!(reread(&json, &data).unwrap().faces().len(), 1);
    }

    #[test]
    fn counts_what_every_node_goes_through() {
        let limits = Limits { triangles: 10, ..Limits::default() };
        let shown = |mode: u8, indices: &[u16], times: usize| {
            let (mut json, data) = square(mode, indices, json!(vec![json!({"mesh": 0}); times]));
            json["scenes"] = json!([{"nodes": (0..times).collect::<Vec<_>>()}]);
            read(&glb(&json, &data), Format::Glb, &limits).map(|polygons| polygons.faces().len())
        };
        let too_large = |unit, found, limit| Err(Refusal::TooLarge { unit, found, limit });
        // Strips of degenerate triangles, which make no face.
        assert_eq!(shown(5, &[0; 5], 6), Ok(0));
        assert_eq!(shown(5, &[0; 6], 6), too_large("indices", 36, 30));
        // Points, which are left out.
        assert_eq!(shown(0, &[0], 10), Ok(0));
        assert_eq!(shown(0, &[0], 11), too_large("primitives", 11, 10));
    }

    #[test]
    fn refuses_truncated_headers() {
        let (json, data) = square(4, &[0, 1, 2], json!([{"mesh": 0}]));
        let whole = glb(&json, &data);
        for length in 0..whole.len() {
            assert!(read(&whole[..length], Format::Glb, &Limits::default()).is_err(), "{length}");
        }
    }

    proptest::proptest! {
        #[test]
        fn survives_damage(
            damage in proptest::collection::vec((proptest::prelude::any::<proptest::sample::Index>(), 0u8..128), 1..5),
        ) {
            let (json, data) = square(4, &[0, 1, 2, 4, 2, 3], json!([{"mesh": 0, "translation": [1, 0, 0]}]));
            let mut bytes = glb(&json, &data);
            damage.iter().for_each(|(at, byte)| { let at = at.index(bytes.len()); bytes[at] = *byte; });
            let _ = read(&bytes, Format::Glb, &Limits::default());
        }

        /// Digits only, so that the JSON stays readable and its numbers lie.
        #[test]
        fn survives_false_numbers(
            damage in proptest::collection::vec((proptest::prelude::any::<proptest::sample::Index>(), b'0'..=b'9'), 1..6),
        ) {
            let (json, data) = square(4, &[0, 1, 2, 4, 2, 3], json!([{"mesh": 0, "translation": [1, 0, 0]}]));
            let mut bytes = glb(&json, &data);
            let digits: Vec<usize> = (20..bytes.len()).filter(|&i| bytes[i].is_ascii_digit()).collect();
            damage.iter().for_each(|(at, digit)| bytes[digits[at.index(digits.len())]] = *digit);
            let _ = read(&bytes, Format::Glb, &Limits::default());
        }
    }
}
