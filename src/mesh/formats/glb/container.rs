//! The JSON of a glTF file and the data it speaks of, out of a binary file or out of JSON with its data in it.

use std::collections::HashSet;

use base64::Engine;
use base64::engine::DecodePaddingMode;
use base64::engine::general_purpose::{GeneralPurpose, GeneralPurposeConfig};
use gltf::buffer::Source;
use gltf::json::Root;
use gltf::{Document, Glb};
use serde_json::{Map, Value, json};

use super::refusal;
use crate::mesh::refusal::Refusal;

const MAGIC: &[u8] = b"glTF";
/// Bytes of the file's header and of the first chunk's.
const PREAMBLE: usize = 20;
/// Most bytes of the JSON, the data in it aside: parsed it takes a hundred times the memory.
const LONGEST_JSON: usize = 4 << 20;
/// Bytes looked at to recognise JSON.
const HEAD: usize = 1 << 12;
/// How data begin that stand in the JSON.
const DATA: &str = "data:";
/// Whatever fills up the last of four characters may be left out.
const BASE64: GeneralPurpose = GeneralPurpose::new(
    &base64::alphabet::STANDARD,
    GeneralPurposeConfig::new().with_decode_padding_mode(DecodePaddingMode::Indifferent),
);

/// Required extensions that are read, or change no geometry.
const KNOWN: [&str; 12] = [
    "KHR_mesh_quantization",
    "KHR_lights_",
    "EXT_lights_",
    "KHR_materials_",
    "KHR_texture_",
    "EXT_texture_",
    "MSFT_texture_",
    "KHR_animation_",
    "KHR_node_",
    "KHR_audio",
    "KHR_xmp",
    "VRM",
];

/// Lists and members that nobody here reads, so that nothing in them is a reason against a file: textures whose pictures are
/// an extension's business, for one.
const UNREAD: [&str; 7] = ["animations", "cameras", "extensions", "images", "materials", "samplers", "textures"];
const UNREAD_OF_NODE: [&str; 3] = ["camera", "extensions", "extras"];
const UNREAD_OF_PRIMITIVE: [&str; 3] = ["material", "extensions", "extras"];

/// Required extensions that compress geometry, by their names among people.
const COMPRESSED: [(&str, &str); 3] = [
    ("KHR_draco_mesh_compression", "Draco"),
    ("EXT_meshopt_compression", "meshopt"),
    ("KHR_meshopt_compression", "meshopt"),
];

pub(super) fn looks_binary(bytes: &[u8]) -> bool {
    bytes.starts_with(MAGIC)
}

/// Whether the bytes are the beginning of a JSON object that names an asset, as every glTF file does.
pub(super) fn looks_like_json(bytes: &[u8]) -> bool {
    let head = &bytes[..bytes.len().min(HEAD)];
    let has = |key: &[u8]| head.windows(key.len()).any(|window| window == key);
    head.trim_ascii_start().starts_with(b"{")
        && [&b"\"asset\""[..], b"\"accessors\"", b"\"meshes\""].into_iter().any(has)
}

/// The extension by which a node is hidden.
const VISIBILITY: &str = "KHR_node_visibility";

/// A document whose JSON keeps to the schema, and the data it holds.
pub(super) struct Container {
    pub document: Document,
    /// The nodes that are not shown, nor what is below them.
    pub hidden: HashSet<usize>,
    /// Per buffer its bytes.
    buffers: Vec<Vec<u8>>,
}

impl Container {
    pub fn open(bytes: &[u8]) -> Result<Container, Refusal> {
        if looks_like_json(bytes) { Container::of_json(bytes) } else { Container::of_binary(bytes) }
    }

    fn of_binary(bytes: &[u8]) -> Result<Container, Refusal> {
        let glb = binary(bytes)?;
        let (document, hidden) = document(&glb.json)?;
        let whole = glb.bin.unwrap_or_default().into_owned();
        let mut whole = Some(whole);
        let buffers = document.buffers().map(|buffer| match buffer.source() {
            Source::Bin => Ok(whole.take().unwrap_or_default()),
            Source::Uri(uri) => embedded(uri),
        });
        let buffers = buffers.collect::<Result<_, _>>()?;
        Ok(Container { document, hidden, buffers })
    }

    fn of_json(bytes: &[u8]) -> Result<Container, Refusal> {
        let (rest, data) = without_data(bytes);
        admit_json(rest.len())?;
        let (document, hidden) = document(&rest)?;
        let buffers = document.buffers().map(|buffer| match buffer.source() {
            Source::Uri(uri) => match uri.strip_prefix(DATA).and_then(|number| number.parse::<usize>().ok()) {
                Some(number) => data.get(number).map_or_else(|| Err(outside()), |data| decoded(data)),
                None => Err(outside()),
            },
            Source::Bin => Err(outside()),
        });
        let buffers = buffers.collect::<Result<_, _>>()?;
        Ok(Container { document, hidden, buffers })
    }

    /// The bytes of a buffer.
    pub fn buffer(&self, index: usize) -> &[u8] {
        self.buffers.get(index).map_or(&[], Vec::as_slice)
    }
}

/// The parts of a binary file.
pub(super) fn binary(bytes: &[u8]) -> Result<Glb<'_>, Refusal> {
    let word = |at: usize| bytes.get(at..at + 4).and_then(|w| w.try_into().ok()).map_or(0, u32::from_le_bytes) as usize;
    if bytes.len() < PREAMBLE || !looks_binary(bytes) || word(8) < PREAMBLE {
        return Err(refusal("it is no binary gltf file"));
    }
    admit_json(word(12))?;
    if word(4) == 1 {
        return Err(of_version_1());
    }
    // What follows the length that the header states is none of the file.
    Glb::from_slice(&bytes[..bytes.len().min(word(8))]).map_err(|error| unreadable(&error))
}

/// All members of a file's JSON.
pub(super) fn members(bytes: &[u8]) -> Result<Map<String, Value>, Refusal> {
    if looks_like_json(bytes) { parsed(bytes) } else { parsed(&binary(bytes)?.json) }
}

fn parsed(json: &[u8]) -> Result<Map<String, Value>, Refusal> {
    let json = json.strip_prefix(b"\xef\xbb\xbf").unwrap_or(json);
    serde_json::from_slice(json).map_err(|error| unreadable(&error))
}

fn admit_json(bytes: usize) -> Result<(), Refusal> {
    if bytes <= LONGEST_JSON {
        return Ok(());
    }
    Err(Refusal::TooLarge { unit: "bytes of gltf json", found: bytes as u64, limit: LONGEST_JSON as u64 })
}

fn unreadable(error: &dyn std::fmt::Display) -> Refusal {
    refusal(format!("the gltf file cannot be read: {error}"))
}

fn outside() -> Refusal {
    refusal(
        "its data are outside the file: pack the file and its .bin together as .glb, only self-contained files are taken",
    )
}

fn of_version_1() -> Refusal {
    refusal("this is glTF 1.0: bring it to 2.0, for example with `npx gltf-pipeline@2 -i old.gltf -o new.glb`")
}

/// The document of a JSON, and which of its nodes are hidden.
fn document(json: &[u8]) -> Result<(Document, HashSet<usize>), Refusal> {
    let mut members = parsed(json)?;
    // Of version 1.0 all lists are objects.
    if members.get("meshes").is_some_and(Value::is_object) {
        return Err(of_version_1());
    }
    let hidden = hidden(&members);
    leave_out_unread(&mut members);
    let mut root: Root = serde_json::from_value(members.into()).map_err(|error| unreadable(&error))?;
    root.extensions_required.retain(|name| !KNOWN.iter().any(|known| name.starts_with(known)));
    if let Some(name) = root.extensions_required.first() {
        return Err(match COMPRESSED.iter().find(|(compressed, _)| name == compressed) {
            Some((_, method)) => refusal(format!(
                "its geometry is compressed with {method} ({name}): unpack it first, for example with \
                 `npx @gltf-transform/cli copy compressed.glb unpacked.glb`"
            )),
            None => refusal(format!("it requires the extension {name:?}, which is not supported")),
        });
    }
    // The crate's own validation takes these indices for granted.
    let mut attributes = root.meshes.iter().flat_map(|mesh| &mesh.primitives).flat_map(|p| p.attributes.values());
    if attributes.any(|accessor| accessor.value() >= root.accessors.len()) {
        return Err(refusal("a primitive names an accessor that does not exist"));
    }
    // It insists on bounds, which many a tool leaves out and nobody here reads.
    for accessor in &mut root.accessors {
        [accessor.min, accessor.max] = [Some(json!([0, 0, 0])), Some(json!([0, 0, 0]))];
    }
    let document = Document::from_json(root).map_err(|error| unreadable(&error))?;
    Ok((document, hidden))
}

/// The nodes that an extension hides.
fn hidden(document: &Map<String, Value>) -> HashSet<usize> {
    let nodes = document.get("nodes").and_then(Value::as_array).into_iter().flatten().enumerate();
    nodes.filter(|(_, node)| node["extensions"][VISIBILITY]["visible"] == false).map(|(number, _)| number).collect()
}

/// Takes out of a document what nobody here reads.
fn leave_out_unread(document: &mut Map<String, Value>) {
    UNREAD.iter().for_each(|name| drop(document.remove(*name)));
    for node in objects(document, "nodes") {
        UNREAD_OF_NODE.iter().for_each(|name| drop(node.remove(*name)));
    }
    for primitive in objects(document, "meshes").flat_map(|mesh| objects(mesh, "primitives")) {
        UNREAD_OF_PRIMITIVE.iter().for_each(|name| drop(primitive.remove(*name)));
    }
}

/// The objects in a list.
pub(super) fn objects<'a>(
    of: &'a mut Map<String, Value>,
    name: &str,
) -> impl Iterator<Item = &'a mut Map<String, Value>> {
    let list = of.get_mut(name).and_then(Value::as_array_mut);
    list.into_iter().flatten().filter_map(Value::as_object_mut)
}

/// The JSON with the number of the data in place of all data that stand in it, and those data.
fn without_data(bytes: &[u8]) -> (Vec<u8>, Vec<&[u8]>) {
    let opening = [b"\"", DATA.as_bytes()].concat();
    let (mut rest, mut data) = (Vec::new(), Vec::new());
    let mut unread = bytes;
    while let Some(start) = unread.windows(opening.len()).position(|window| window == opening) {
        let content = start + opening.len();
        let length = unread[content..].iter().position(|&b| b == b'"').unwrap_or(unread.len() - content);
        rest.extend_from_slice(&unread[..content]);
        rest.extend_from_slice(data.len().to_string().as_bytes());
        data.push(&unread[content..content + length]);
        unread = &unread[content + length..];
    }
    rest.extend_from_slice(unread);
    (rest, data)
}

/// The bytes of a data URI.
fn embedded(uri: &str) -> Result<Vec<u8>, Refusal> {
    uri.strip_prefix(DATA).map_or_else(|| Err(outside()), |data| decoded(data.as_bytes()))
}

/// The bytes of a data URI after its `data:`.
fn decoded(data: &[u8]) -> Result<Vec<u8>, Refusal> {
    let unreadable = || refusal("data in the gltf file are no base64");
    let comma = data.iter().position(|&b| b == b',').ok_or_else(unreadable)?;
    // JSON may write a slash with a backslash before it.
    let text: Vec<u8> = data[comma + 1..].iter().copied().filter(|b| *b != b'\\' && !b.is_ascii_whitespace()).collect();
    BASE64.decode(text).map_err(|_| unreadable())
}
