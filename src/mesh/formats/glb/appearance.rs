//! What a glTF file shows beside geometry: texture coordinates, colours, materials, textures.

use std::ops::Range;

use gltf::Semantic;
use serde_json::{Map, Value, json};

use super::container::{Container, members, objects};
use super::{triangles_of, walk};
use crate::mesh::refusal::Refusal;

/// Lists of a document that say how something looks, and what these lists name.
const LOOKS: [&str; 6] = ["materials", "textures", "images", "samplers", "accessors", "bufferViews"];
/// Attributes of vertices that stay true wherever the vertices go; of an application's own, which begin with `_`, nobody knows.
const STAYING: [&str; 2] = ["TEXCOORD_", "COLOR_"];
/// Extensions that say how something looks.
const EXTENSIONS: [&str; 5] =
    ["KHR_materials_", "KHR_texture_", "EXT_texture_", "MSFT_texture_", "KHR_mesh_quantization"];
/// The extension of primitives that chooses between materials.
const VARIANTS: &str = "KHR_materials_variants";

/// What a file shows beside geometry, its data in one buffer.
pub struct Appearance {
    /// Members of the document: [`LOOKS`] and the extensions that belong to them.
    pub document: Map<String, Value>,
    pub data: Vec<u8>,
    /// In the order in which the vertices are numbered.
    pub parts: Vec<Part>,
}

/// A primitive of triangles as one node shows it.
pub struct Part {
    /// Its members: `attributes` that stay true wherever the vertices go, `material`, `extensions`.
    pub primitive: Map<String, Value>,
    /// Its vertices among those of the file.
    pub vertices: Range<usize>,
}

impl Appearance {
    /// The appearance of a file that was read; nothing where its data are packed in a way of their own.
    ///
    /// # Errors
    /// What is wrong with the file.
    pub fn of(bytes: &[u8]) -> Result<Option<Appearance>, Refusal> {
        let container = Container::open(bytes)?;
        let mut members = members(bytes)?;
        let (data, starts) = joined(&container);
        for view in objects(&mut members, "bufferViews") {
            let number = |name: &str| view.get(name).and_then(Value::as_u64).unwrap_or(0) as usize;
            let Some(start) = starts.get(number("buffer")).filter(|_| !view.contains_key("extensions")) else {
                return Ok(None);
            };
            let offset = start.saturating_add(number("byteOffset"));
            view.insert("buffer".into(), json!(0));
            view.insert("byteOffset".into(), json!(offset));
        }
        let parts = parts(&container, &members)?;
        let variants = members.remove("extensions").and_then(|all| Some(json!({ VARIANTS: all.get(VARIANTS)? })));
        let mut document: Map<String, Value> =
            LOOKS.iter().filter_map(|&name| Some((name.to_owned(), members.remove(name)?))).collect();
        document.extend(variants.map(|variants| ("extensions".to_owned(), variants)));
        for name in ["extensionsUsed", "extensionsRequired"] {
            let names = members.get(name).and_then(Value::as_array).into_iter().flatten();
            let names: Vec<&Value> = names.filter(|name| name.as_str().is_some_and(is_of_looks)).collect();
            if !names.is_empty() {
                document.insert(name.into(), json!(names));
            }
        }
        Ok(Some(Appearance { document, data, parts }))
    }
}

fn is_of_looks(extension: &str) -> bool {
    EXTENSIONS.iter().any(|known| extension.starts_with(known))
}

/// The bytes of all buffers, one after the other, and where each begins.
fn joined(container: &Container) -> (Vec<u8>, Vec<usize>) {
    let (mut data, mut starts) = (Vec::new(), Vec::new());
    for buffer in 0..container.document.buffers().len() {
        // Numbers stand at multiples of their size, at most four.
        data.resize(usize::next_multiple_of(data.len(), 4), 0);
        starts.push(data.len());
        data.extend_from_slice(container.buffer(buffer));
    }
    (data, starts)
}

/// The primitives of triangles in the order in which they were read.
fn parts(container: &Container, members: &Map<String, Value>) -> Result<Vec<Part>, Refusal> {
    let materials = members.get("materials").and_then(Value::as_array).map_or(0, Vec::len) as u64;
    let (mut parts, mut read): (Vec<Part>, usize) = (Vec::new(), 0);
    walk(container, |_, primitive, mesh| {
        if triangles_of(primitive.mode()).is_some() {
            let vertices = primitive.get(&Semantic::Positions).map_or(0, |positions| positions.count());
            let found = &members["meshes"][mesh.index()]["primitives"][primitive.index()];
            let vertices = read..read.saturating_add(vertices);
            read = vertices.end;
            parts.push(Part { primitive: kept(found, materials), vertices });
        }
        Ok(())
    })?;
    Ok(parts)
}

/// What is kept of a primitive.
fn kept(primitive: &Value, materials: u64) -> Map<String, Value> {
    let attributes = primitive["attributes"].as_object().into_iter().flatten();
    let attributes = attributes.filter(|(name, _)| STAYING.iter().any(|staying| name.starts_with(staying)));
    let attributes: Map<String, Value> = attributes.map(|(name, accessor)| (name.clone(), accessor.clone())).collect();
    let mut kept = Map::from_iter([("attributes".to_owned(), Value::from(attributes))]);
    if primitive["material"].as_u64().is_some_and(|material| material < materials) {
        kept.insert("material".into(), primitive["material"].clone());
    }
    if let Some(variants) = primitive["extensions"].get(VARIANTS) {
        kept.insert("extensions".into(), json!({ VARIANTS: variants }));
    }
    kept
}
