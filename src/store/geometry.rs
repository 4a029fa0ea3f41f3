//! What was read of an upload, as a blob. Its name tells the content, so that uploads of the same geometry share it.

use safetensors::tensor::{Dtype, SafeTensorError, SafeTensors};

use super::tensors::{self, Array};
use super::{Kind, StoreError};
use crate::mesh::TriangleMesh;
use crate::sketch::{Sketch, YAxis};

/// A geometry as it is stored.
pub(super) struct Encoded {
    /// The kind, an underscore and 32 hexadecimal digits of the content's hash.
    pub name: String,
    pub bytes: Vec<u8>,
}

/// The blob of the geometry of this name.
pub(super) fn blob(name: &str) -> String {
    format!("shapes/{name}.safetensors")
}

fn name(kind: Kind, content: blake3::Hash) -> String {
    format!("{}_{}", kind.as_str(), &content.to_hex()[..32])
}

/// Header key of a sketch's blob, and its two values.
const Y_AXIS: &str = "y_axis";

fn y_axis_name(y_axis: YAxis) -> &'static str {
    match y_axis {
        YAxis::Up => "up",
        YAxis::Down => "down",
    }
}

pub(super) fn of_mesh(mesh: &TriangleMesh) -> Result<Encoded, StoreError> {
    encoded(name(Kind::Mesh, mesh.content_hash()), mesh, None)
}

pub(super) fn of_sketch(sketch: &Sketch) -> Result<Encoded, StoreError> {
    let note = (Y_AXIS, y_axis_name(sketch.y_axis()));
    encoded(name(Kind::Sketch, sketch.content_hash()), sketch.mesh(), Some(note))
}

fn encoded(name: String, mesh: &TriangleMesh, note: Option<(&str, &str)>) -> Result<Encoded, StoreError> {
    let (positions, triangles) = (mesh.positions(), mesh.triangles());
    let arrays = [
        Array::of_f64("positions", vec![positions.len(), 3], positions.iter().flatten().copied()),
        Array::of_u32("triangles", vec![triangles.len(), 3], triangles.iter().flatten().copied()),
    ];
    let bytes = tensors::encode(&arrays, note).map_err(|error| StoreError::damaged(&name, error))?;
    Ok(Encoded { name, bytes })
}

/// The mesh in the blob of this name. It was checked before it was stored, and its name tells that it is the same: to
/// check it again would take longer than all else that is read for a match.
pub(super) fn mesh(geometry: &str, bytes: &[u8]) -> Result<TriangleMesh, String> {
    let (positions, triangles) = arrays(bytes).map_err(|error| error.to_string())?;
    let mesh = TriangleMesh::recognised(positions, triangles, |content| name(Kind::Mesh, content) == geometry);
    mesh.ok_or_else(|| UNRECOGNISED.to_owned())
}

/// The sketch in the blob of this name.
pub(super) fn sketch(geometry: &str, bytes: &[u8]) -> Result<Sketch, String> {
    let (_, header) = SafeTensors::read_metadata(bytes).map_err(|error| error.to_string())?;
    let y_axis = match header.metadata().as_ref().and_then(|notes| notes.get(Y_AXIS)).map(String::as_str) {
        Some("up") => YAxis::Up,
        Some("down") => YAxis::Down,
        _ => return Err("it does not say where y points".to_owned()),
    };
    let (positions, triangles) = arrays(bytes).map_err(|error| error.to_string())?;
    let mesh = TriangleMesh::new(positions, triangles).map_err(|refusal| refusal.to_string())?;
    let sketch = Sketch::new(mesh, y_axis).map_err(|refusal| refusal.to_string())?;
    if name(Kind::Sketch, sketch.content_hash()) == geometry { Ok(sketch) } else { Err(UNRECOGNISED.to_owned()) }
}

const UNRECOGNISED: &str = "its content is not that of its name";

type Arrays = (Vec<[f64; 3]>, Vec<[u32; 3]>);

fn arrays(bytes: &[u8]) -> Result<Arrays, SafeTensorError> {
    let file = SafeTensors::deserialize(bytes)?;
    let positions = tensors::matrix(&file, "positions", Dtype::F64)?;
    let triangles = tensors::matrix(&file, "triangles", Dtype::U32)?;
    if positions.columns != 3 || triangles.columns != 3 {
        return Err(SafeTensorError::TensorInvalidInfo);
    }
    let position = |i| [0, 1, 2].map(|j| f64::from_le_bytes(positions.at(i, j)));
    let triangle = |i| [0, 1, 2].map(|j| u32::from_le_bytes(triangles.at(i, j)));
    Ok(((0..positions.rows).map(position).collect(), (0..triangles.rows).map(triangle).collect()))
}
