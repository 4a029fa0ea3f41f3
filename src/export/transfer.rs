//! What was taken from one shape to the other, as a coloured mesh and as an array.

use bytes::Bytes;

use super::{Unwritten, npy};
use crate::mesh::file_mesh::FileMesh;
use crate::picture::paint::Paint;
use crate::picture::painted_glb;
use crate::transfer::request::Moved;

/// The shape in the colours of what came to its vertices, as glTF 2.0 binary: a function red above 0 and blue below, a colour
/// for each label, colours as they are; light grey where nothing corresponds.
///
/// # Errors
/// What the encoder reports.
pub fn glb(moved: &Moved, to: &FileMesh) -> Result<Bytes, Unwritten> {
    Ok(match moved {
        Moved::Function { values } => painted_glb(to, &Paint::Values(&numbers(values)))?,
        Moved::Labels { values } => painted_glb(to, &Paint::Labels(values))?,
        Moved::Colours { values } => painted_glb(to, &Paint::Colours(values))?,
    }
    .into())
}

/// A function as an array, a row per vertex, not a number where nothing corresponds; empty for what is no function.
pub fn npy(moved: &Moved) -> Bytes {
    let values = if let Moved::Function { values } = moved { numbers(values) } else { Vec::new() };
    npy::file(values.len(), 1, values).into()
}

fn numbers(values: &[Option<f64>]) -> Vec<f64> {
    values.iter().map(|value| value.unwrap_or(f64::NAN)).collect()
}
