//! The data of a glTF file, and what is where in them.

use gltf::binary::{Glb, Header};
use serde_json::{Map, Value, json};

/// What accessors and buffer views call their numbers and their use (glTF 2.0, §3.6 and §3.7).
const FLOAT: u32 = 5126;
const UNSIGNED_INT: u32 = 5125;
pub const ARRAY_BUFFER: u32 = 34962;
const ELEMENT_ARRAY_BUFFER: u32 = 34963;

/// Seconds from one pose to the next.
pub const PACE: f32 = 0.5;

/// The buffer of a file, and what is where in it.
#[derive(Default)]
pub struct Content {
    data: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
}

impl Content {
    /// What a document has already, of whose lists of views and accessors they are taken out.
    pub fn of(document: &mut Map<String, Value>, data: Vec<u8>) -> Content {
        let mut taken = |name: &str| match document.remove(name) {
            Some(Value::Array(list)) => list,
            _ => Vec::new(),
        };
        let (views, accessors) = (taken("bufferViews"), taken("accessors"));
        Content { data, views, accessors }
    }

    /// Adds rows of numbers; the number of their accessor.
    fn add(&mut self, bytes: &[u8], target: Option<u32>, mut accessor: Value) -> usize {
        // Numbers stand at multiples of their size.
        self.data.resize(self.data.len().next_multiple_of(4), 0);
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

    pub fn triples(&mut self, rows: &[[f32; 3]], bounded: bool, target: Option<u32>) -> usize {
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

    pub fn corners(&mut self, triangles: &[[u32; 3]]) -> usize {
        let accessor = json!({"componentType": UNSIGNED_INT, "count": 3 * triangles.len(), "type": "SCALAR"});
        let bytes: Vec<u8> = triangles.as_flattened().iter().flat_map(|v| v.to_le_bytes()).collect();
        self.add(&bytes, Some(ELEMENT_ARRAY_BUFFER), accessor)
    }

    /// An animation of node 0 that leads through so many morph targets.
    pub fn animation(&mut self, count: usize) -> Value {
        let times: Vec<f32> = (0..count).map(|i| PACE * i as f32).collect();
        let weights = (0..count * count).map(|i| if i / count == i % count { 1.0 } else { 0.0 }).collect::<Vec<f32>>();
        let (input, output) = (self.scalars(&times), self.scalars(&weights));
        json!({
            "samplers": [{"input": input, "output": output, "interpolation": "LINEAR"}],
            "channels": [{"sampler": 0, "target": {"node": 0, "path": "weights"}}],
        })
    }

    /// The file of a document that shows its mesh 0.
    pub fn finished<'a>(self, mut document: Map<String, Value>) -> Glb<'a> {
        document.extend(
            [
                ("asset", json!({"version": "2.0", "generator": "sketchmatch"})),
                ("scene", json!(0)),
                ("scenes", json!([{"nodes": [0]}])),
                ("nodes", json!([{"mesh": 0}])),
                ("accessors", json!(self.accessors)),
                ("bufferViews", json!(self.views)),
                ("buffers", json!([{"byteLength": self.data.len()}])),
            ]
            .map(|(name, value)| (name.to_owned(), value)),
        );
        Glb {
            // The length is filled in when the file is written.
            header: Header { magic: *b"glTF", version: 2, length: 0 },
            json: Value::from(document).to_string().into_bytes().into(),
            bin: Some(self.data.into()),
        }
    }
}
