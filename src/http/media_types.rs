//! Media types of answers.

use crate::mesh::formats::Format;

pub const JSON: &str = "application/json";
pub const CSV: &str = "text/csv";
pub const NPY: &str = "application/x-npy";
pub const SAFETENSORS: &str = "application/vnd.safetensors";
pub const PNG: &str = "image/png";
pub const SVG: &str = "image/svg+xml";
pub const GLB: &str = Format::Glb.media_type();
pub const GLTF: &str = Format::Gltf.media_type();
pub const OBJ: &str = Format::Obj.media_type();

/// Bytes of no said type, for clients that know no other kind of file; what they are is what the resource is first of all.
pub const OCTETS: &str = "application/octet-stream";
