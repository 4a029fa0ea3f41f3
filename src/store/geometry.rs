//! What was read of an upload, as a blob, and a name that tells its content.

use bytes::Bytes;
use safetensors::tensor::{Dtype, SafeTensorError, SafeTensors};

use super::tensors::{self, Array};
use super::{ShapeKind, StoreError};
use crate::mesh::TriangleMesh;
use crate::mesh::file_mesh::FileMesh;
use crate::mesh::sound::Sound;
use crate::sketch::{Line, Sketch, YAxis};

/// A geometry as it is stored.
pub(super) struct Encoded {
    /// The kind, an underscore and 32 hexadecimal digits of the content's hash.
    pub name: String,
    pub bytes: Bytes,
    pub vertices: usize,
    pub triangles: usize,
    /// Vertices of what is computed on in its place.
    pub matched: usize,
}

fn name(kind: ShapeKind, content: blake3::Hash) -> String {
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

/// The arrays of the lines within a sketch: all points, and how many each line has.
const STROKES: &str = "stroke_points";
const LENGTHS: &str = "stroke_lengths";

/// The arrays of a mesh that was mended, as [`Sound`] has them.
const SOUND: &str = "sound_triangles";
const ORIGINS: &str = "sound_origins";
const MERGED: &str = "merged";
/// One number, 0 or 1; blobs of before it was told have none.
const DECIMATED: &str = "decimated";

pub(super) fn of_mesh(mesh: &FileMesh) -> Result<Encoded, StoreError> {
    let (positions, triangles) = (mesh.positions(), mesh.triangles());
    let mut arrays = of_triangles(positions, triangles);
    let mends = mesh.mends();
    if let Some(Sound { triangles, origins, merged, decimated }) = &mends {
        arrays.push(Array::of_u32(SOUND, vec![triangles.len(), 3], triangles.iter().flatten().copied()));
        arrays.push(Array::of_u32(ORIGINS, vec![origins.len(), 1], origins.iter().copied()));
        arrays.push(Array::of_u32(MERGED, vec![merged.len(), 1], merged.iter().copied()));
        arrays.push(Array::of_u32(DECIMATED, vec![1, 1], std::iter::once(u32::from(*decimated))));
    }
    let (vertices, triangles) = (positions.len(), triangles.len());
    let (name, bytes) = encoded(name(ShapeKind::Mesh, mesh.content_hash()), &arrays, None)?;
    Ok(Encoded { name, bytes, vertices, triangles, matched: mesh.sound().positions().len() })
}

pub(super) fn of_sketch(sketch: &Sketch) -> Result<Encoded, StoreError> {
    let (positions, triangles) = (sketch.mesh().positions(), sketch.mesh().triangles());
    let mut arrays = of_triangles(positions, triangles);
    let strokes = sketch.strokes();
    if !strokes.is_empty() {
        let points = strokes.concat();
        arrays.push(Array::of_f64(STROKES, vec![points.len(), 2], points.into_iter().flatten()));
        arrays.push(Array::of_u32(LENGTHS, vec![strokes.len(), 1], strokes.iter().map(|line| line.len() as u32)));
    }
    let note = (Y_AXIS, y_axis_name(sketch.y_axis()));
    let (name, bytes) = encoded(name(ShapeKind::Sketch, sketch.content_hash()), &arrays, Some(note))?;
    let vertices = positions.len();
    Ok(Encoded { name, bytes, vertices, triangles: triangles.len(), matched: vertices })
}

fn of_triangles(positions: &[[f64; 3]], triangles: &[[u32; 3]]) -> Vec<Array> {
    vec![
        Array::of_f64("positions", vec![positions.len(), 3], positions.iter().flatten().copied()),
        Array::of_u32("triangles", vec![triangles.len(), 3], triangles.iter().flatten().copied()),
    ]
}

/// The name and the bytes of a blob with these arrays.
fn encoded(name: String, arrays: &[Array], note: Option<(&str, &str)>) -> Result<(String, Bytes), StoreError> {
    let bytes = tensors::encode(arrays, note).map_err(|error| StoreError::damaged(&name, error))?;
    Ok((name, bytes.into()))
}

/// The mesh in the blob of this name. It was checked before it was stored, and its name tells that it is the same: to
/// check it again would take longer than all else that is read for a match.
pub(super) fn mesh(geometry: &str, bytes: &[u8]) -> Result<FileMesh, String> {
    let (positions, triangles) = arrays(bytes).map_err(|error| error.to_string())?;
    let mends = mends(bytes).map_err(|error| error.to_string())?;
    let mesh = FileMesh::recognised(positions, triangles, mends, |content| name(ShapeKind::Mesh, content) == geometry);
    mesh.ok_or_else(|| UNRECOGNISED.to_owned())
}

/// What makes the sound mesh, where a blob has it.
fn mends(bytes: &[u8]) -> Result<Option<Sound>, SafeTensorError> {
    let file = SafeTensors::deserialize(bytes)?;
    if file.tensor(SOUND).is_err() {
        return Ok(None);
    }
    let triangles = tensors::matrix(&file, SOUND, Dtype::U32)?;
    let numbers = |name| -> Result<Vec<u32>, SafeTensorError> {
        let column = tensors::matrix(&file, name, Dtype::U32)?;
        Ok((0..column.rows).map(|i| u32::from_le_bytes(column.at(i, 0))).collect())
    };
    if triangles.columns != 3 {
        return Err(SafeTensorError::TensorInvalidInfo);
    }
    let triangle = |i| [0, 1, 2].map(|j| u32::from_le_bytes(triangles.at(i, j)));
    let triangles = (0..triangles.rows).map(triangle).collect();
    let decimated = file.tensor(DECIMATED).is_ok() && numbers(DECIMATED)? == [1];
    Ok(Some(Sound { triangles, origins: numbers(ORIGINS)?, merged: numbers(MERGED)?, decimated }))
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
    let sketch = sketch.with_strokes(strokes(bytes).map_err(|error| error.to_string())?);
    if name(ShapeKind::Sketch, sketch.content_hash()) == geometry { Ok(sketch) } else { Err(UNRECOGNISED.to_owned()) }
}

/// The lines within a sketch; none where a blob has none.
fn strokes(bytes: &[u8]) -> Result<Vec<Line>, SafeTensorError> {
    let file = SafeTensors::deserialize(bytes)?;
    if file.tensor(STROKES).is_err() {
        return Ok(Vec::new());
    }
    let points = tensors::matrix(&file, STROKES, Dtype::F64)?;
    let lengths = tensors::matrix(&file, LENGTHS, Dtype::U32)?;
    if points.columns != 2 || lengths.columns != 1 {
        return Err(SafeTensorError::TensorInvalidInfo);
    }
    let mut points = (0..points.rows).map(|i| [0, 1].map(|j| f64::from_le_bytes(points.at(i, j))));
    let length = |i| u32::from_le_bytes(lengths.at(i, 0)) as usize;
    Ok((0..lengths.rows).map(|i| points.by_ref().take(length(i)).collect()).collect())
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
