//! Binary glTF 2.0 that holds all its data: the triangles of the default scene, in the order of a walk through its nodes.
//!
//! Seams (vertices doubled for normals or texture) are closed: faces use the first of the vertices at one point.

use gltf::accessor::{Accessor, DataType, Dimensions};
use gltf::buffer::Source;
use gltf::mesh::Mode;
use gltf::{Document, Glb, Node, Primitive, Semantic};

use super::weld::Weld;
use super::{Polygons, admit};
use crate::mesh::refusal::{Place, Refusal};

const MAGIC: &[u8] = b"glTF";
/// Bytes of the file's header and of the first chunk's.
const PREAMBLE: usize = 20;
/// Most bytes of the JSON chunk: parsed it takes a hundred times the memory.
const LONGEST_JSON: usize = 4 << 20;
/// Required extensions that change no geometry.
const HARMLESS: [&str; 5] = ["KHR_lights_", "KHR_materials_", "KHR_texture_", "EXT_texture_", "KHR_xmp"];

/// A 4 × 4 matrix by columns.
type Matrix = [[f64; 4]; 4];

const IDENTITY: Matrix = [[1., 0., 0., 0.], [0., 1., 0., 0.], [0., 0., 1., 0.], [0., 0., 0., 1.]];

pub(super) fn looks_like(bytes: &[u8]) -> bool {
    bytes.starts_with(MAGIC)
}

pub(super) fn read(bytes: &[u8], polygons: Polygons) -> Result<Polygons, Refusal> {
    let (document, data) = open(bytes)?;
    let scene =
        document.default_scene().or_else(|| document.scenes().next()).ok_or_else(|| refusal("it has no scene"))?;
    let mut read = Read { polygons, weld: Weld::default(), firsts: Vec::new(), primitives: 0, indices: 0, data: &data };
    let mut visited = vec![false; document.nodes().len()];
    let mut pending: Vec<(Node, Matrix)> = scene.nodes().map(|node| (node, IDENTITY)).collect();
    pending.reverse();
    while let Some((node, parent)) = pending.pop() {
        // The nodes of a valid file form trees; others might never end.
        if std::mem::replace(&mut visited[node.index()], true) {
            return Err(refusal(format!("node {} is in the scene twice", node.index())));
        }
        let world = product(parent, node.transform().matrix().map(|column| column.map(f64::from)));
        if let Some(mesh) = node.mesh() {
            // A skin places its vertices itself: its node's transform does not count.
            let transform = if node.skin().is_some() { IDENTITY } else { world };
            for primitive in mesh.primitives() {
                let place = format!("primitive {} of mesh {}", primitive.index(), mesh.index());
                read.primitive(&primitive, transform, &place)?;
            }
        }
        let children = pending.len();
        pending.extend(node.children().map(|child| (child, world)));
        pending[children..].reverse();
    }
    Ok(read.polygons)
}

fn refusal(detail: impl Into<String>) -> Refusal {
    Refusal::because(Place::file(), detail)
}

/// The document, valid JSON that keeps to the schema, and the binary chunk.
fn open(bytes: &[u8]) -> Result<(Document, Vec<u8>), Refusal> {
    let word = |at: usize| bytes.get(at..at + 4).and_then(|w| w.try_into().ok()).map_or(0, u32::from_le_bytes) as usize;
    if bytes.len() < PREAMBLE || !looks_like(bytes) || word(8) < PREAMBLE {
        return Err(refusal("it is no binary gltf file"));
    }
    if word(12) > LONGEST_JSON {
        return Err(Refusal::TooLarge {
            unit: "bytes of gltf json",
            found: word(12) as u64,
            limit: LONGEST_JSON as u64,
        });
    }
    let unreadable = |error: &dyn std::fmt::Display| refusal(format!("the gltf file cannot be read: {error}"));
    let glb = Glb::from_slice(bytes).map_err(|error| unreadable(&error))?;
    let mut root = gltf::json::Root::from_slice(&glb.json).map_err(|error| unreadable(&error))?;
    root.extensions_required.retain(|name| !HARMLESS.iter().any(|harmless| name.starts_with(harmless)));
    if let Some(name) = root.extensions_required.first() {
        return Err(refusal(format!("it requires the extension {name:?}, which is not supported")));
    }
    // The crate's own validation takes these indices for granted.
    let mut attributes = root.meshes.iter().flat_map(|mesh| &mesh.primitives).flat_map(|p| p.attributes.values());
    if attributes.any(|accessor| accessor.value() >= root.accessors.len()) {
        return Err(refusal("a primitive names an accessor that does not exist"));
    }
    let document = Document::from_json(root).map_err(|error| unreadable(&error))?;
    Ok((document, glb.bin.unwrap_or_default().into_owned()))
}

/// What has been read of a file.
struct Read<'a> {
    polygons: Polygons,
    weld: Weld,
    /// Per vertex the first one at the same point.
    firsts: Vec<u32>,
    /// Primitives and indices gone through so far, once for every node that shows them.
    primitives: usize,
    indices: usize,
    data: &'a [u8],
}

impl Read<'_> {
    fn primitive(&mut self, primitive: &Primitive, transform: Matrix, place: &str) -> Result<(), Refusal> {
        self.primitives += 1;
        admit("primitives", self.primitives, self.polygons.limits.triangles)?;
        let triangles = match primitive.mode() {
            Mode::Triangles => triangles_of_list,
            Mode::TriangleStrip => triangles_of_strip,
            Mode::TriangleFan => triangles_of_fan,
            Mode::Points | Mode::Lines | Mode::LineLoop | Mode::LineStrip => {
                self.polygons.ignored += 1;
                return Ok(());
            }
        };
        let first = self.polygons.positions.len();
        let here = |detail: String| refusal(format!("{place}: {detail}"));
        let positions = primitive.get(&Semantic::Positions).ok_or_else(|| here("it has no positions".into()))?;
        self.vertices(&positions, transform, &here)?;
        let vertices = self.polygons.positions.len() - first;
        let indices = match primitive.indices() {
            Some(accessor) => self.indices(&accessor, &here)?,
            None => (0..vertices as u32).collect(),
        };
        if let Some(index) = indices.iter().find(|&&index| index as usize >= vertices) {
            return Err(here(format!("index {index} is out of range: there are {vertices} vertices")));
        }
        let mirrored = determinant(transform) < 0.0;
        for [a, b, c] in triangles(&indices).map_err(here)? {
            let corners = if mirrored { [a, c, b] } else { [a, b, c] };
            self.polygons.push_face(corners.map(|v| i64::from(self.firsts[first + v as usize])), None)?;
        }
        Ok(())
    }

    fn vertices(&mut self, accessor: &Accessor, m: Matrix, here: &impl Fn(String) -> Refusal) -> Result<(), Refusal> {
        if (accessor.data_type(), accessor.dimensions()) != (DataType::F32, Dimensions::Vec3) {
            return Err(here("its positions are not three floats each".into()));
        }
        self.polygons.limits.admit_vertices(self.polygons.positions.len().saturating_add(accessor.count()))?;
        for element in elements(accessor, self.data).map_err(here)? {
            let mut p = [0.0; 3];
            element.as_chunks::<4>().0.iter().zip(&mut p).for_each(|(x, c)| *c = f64::from(f32::from_le_bytes(*x)));
            // Negative zero becomes zero, so that equal points have equal bits.
            let position = [0, 1, 2].map(|i: usize| m[0][i] * p[0] + m[1][i] * p[1] + m[2][i] * p[2] + m[3][i] + 0.0);
            let vertex = self.polygons.positions.len() as u32;
            let first = self.weld.first(position, vertex);
            self.firsts.push(first);
            if first != vertex {
                self.polygons.merged.push(vertex);
            }
            self.polygons.push_vertex(position, None)?;
        }
        Ok(())
    }

    fn indices(&mut self, accessor: &Accessor, here: &impl Fn(String) -> Refusal) -> Result<Vec<u32>, Refusal> {
        if accessor.dimensions() != Dimensions::Scalar {
            return Err(here("its indices are not scalars".into()));
        }
        // Those of triangles that are left out count too: lists have the most indices for their triangles, three each.
        self.indices = self.indices.saturating_add(accessor.count());
        admit("indices", self.indices, self.polygons.limits.triangles.saturating_mul(3))?;
        let index = |element: &[u8]| match *element {
            [a] => u32::from(a),
            [a, b] => u32::from(u16::from_le_bytes([a, b])),
            [a, b, c, d] => u32::from_le_bytes([a, b, c, d]),
            _ => u32::MAX,
        };
        match accessor.data_type() {
            DataType::U8 | DataType::U16 | DataType::U32 => {
                Ok(elements(accessor, self.data).map_err(here)?.map(index).collect())
            }
            _ => Err(here("its indices are not unsigned integers".into())),
        }
    }
}

/// The bytes of each element of an accessor, all proven to lie in the file.
fn elements<'a>(
    accessor: &Accessor,
    data: &'a [u8],
) -> Result<impl ExactSizeIterator<Item = &'a [u8]> + use<'a>, String> {
    if accessor.sparse().is_some() {
        return Err("sparse accessors are not supported".into());
    }
    let view = accessor.view().ok_or("an accessor has no data")?;
    if let Source::Uri(_) = view.buffer().source() {
        return Err("its data are outside the file: only self-contained files are accepted".into());
    }
    let (count, size) = (accessor.count(), accessor.size());
    let stride = view.stride().unwrap_or(size);
    let view = view.offset().checked_add(view.length()).and_then(|end| data.get(view.offset()..end));
    let data = view.and_then(|view| view.get(accessor.offset()..)).unwrap_or_default();
    let length = count.saturating_sub(1).checked_mul(stride).and_then(|length| length.checked_add(size));
    if stride < size || (count > 0 && length.is_none_or(|length| length > data.len())) {
        return Err(format!("accessor {} reaches beyond its data", accessor.index()));
    }
    Ok((0..count).map(move |i| &data[i * stride..i * stride + size]))
}

fn triangles_of_list(indices: &[u32]) -> Result<Vec<[u32; 3]>, String> {
    match indices.as_chunks() {
        (triangles, []) => Ok(triangles.to_vec()),
        _ => Err(format!("{} indices are no whole number of triangles", indices.len())),
    }
}

/// Triangles that name a vertex twice only join the parts of a strip.
fn triangles_of_strip(indices: &[u32]) -> Result<Vec<[u32; 3]>, String> {
    let triangles = indices.windows(3).enumerate();
    let triangles = triangles.map(|(i, w)| if i % 2 == 0 { [w[0], w[1], w[2]] } else { [w[1], w[0], w[2]] });
    Ok(triangles.filter(|[a, b, c]| a != b && b != c && c != a).collect())
}

fn triangles_of_fan(indices: &[u32]) -> Result<Vec<[u32; 3]>, String> {
    let Some((&centre, rim)) = indices.split_first() else { return Ok(Vec::new()) };
    Ok(rim.windows(2).map(|w| [centre, w[0], w[1]]).collect())
}

fn product(a: Matrix, b: Matrix) -> Matrix {
    b.map(|column| [0, 1, 2, 3].map(|i: usize| (0..4).map(|j| a[j][i] * column[j]).sum()))
}

/// Of the upper left 3 × 3.
fn determinant([a, b, c, _]: Matrix) -> f64 {
    a[0] * (b[1] * c[2] - b[2] * c[1]) - b[0] * (a[1] * c[2] - a[2] * c[1]) + c[0] * (a[1] * b[2] - a[2] * b[1])
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_1_SQRT_2;

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
    fn reads_lists_strips_and_fans_with_seams_closed() {
        let list: &[u16] = &[0, 1, 2, 4, 2, 3];
        for (mode, indices) in [(4, list), (5, &[1, 2, 4, 3]), (5, &[1, 1, 1, 2, 4, 3]), (6, &[4, 1, 2, 3])] {
            let (json, data) = square(mode, indices, json!([{"mesh": 0}]));
            let polygons = reread(&json, &data).unwrap();
            assert_eq!(polygons.positions.len(), 5);
            assert_eq!(polygons.merged, [4]);
            let area: f64 = faces(&polygons).iter().map(|f| signed_area(&polygons.positions, f)).sum();
            assert_eq!((polygons.faces().len(), area), (2, 1.0), "{mode} {indices:?}");
            assert!(faces(&polygons).concat().iter().all(|&v| v != 4));
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
            let digits: Vec<usize> = (PREAMBLE..bytes.len()).filter(|&i| bytes[i].is_ascii_digit()).collect();
            damage.iter().for_each(|(at, digit)| bytes[digits[at.index(digits.len())]] = *digit);
            let _ = read(&bytes, Format::Glb, &Limits::default());
        }
    }
}
