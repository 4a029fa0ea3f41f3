//! Arrays in safetensors files, little-endian: what blobs of shapes and spectra are made of.

use std::collections::HashMap;

use safetensors::tensor::{Dtype, SafeTensorError, SafeTensors, TensorView};

/// One array to be written.
pub(super) struct Array {
    pub name: &'static str,
    pub kind: Dtype,
    pub shape: Vec<usize>,
    pub bytes: Vec<u8>,
}

impl Array {
    pub fn of_f64(name: &'static str, shape: Vec<usize>, values: impl Iterator<Item = f64>) -> Array {
        Array { name, kind: Dtype::F64, shape, bytes: values.flat_map(f64::to_le_bytes).collect() }
    }

    pub fn of_u32(name: &'static str, shape: Vec<usize>, values: impl Iterator<Item = u32>) -> Array {
        Array { name, kind: Dtype::U32, shape, bytes: values.flat_map(u32::to_le_bytes).collect() }
    }
}

/// The bytes of a safetensors file; `note` is a key and a value for its header.
pub(super) fn encode(arrays: &[Array], note: Option<(&str, &str)>) -> Result<Vec<u8>, SafeTensorError> {
    let views = arrays
        .iter()
        .map(|array| Ok((array.name, TensorView::new(array.kind, array.shape.clone(), &array.bytes)?)))
        .collect::<Result<Vec<_>, SafeTensorError>>()?;
    let header = note.map(|(key, value)| HashMap::from([(key.to_owned(), value.to_owned())]));
    safetensors::serialize(views, header)
}

/// A matrix of a file, row by row.
pub(super) struct Rows<'a, const SIZE: usize> {
    pub rows: usize,
    pub columns: usize,
    bytes: &'a [[u8; SIZE]],
}

impl<'a, const SIZE: usize> Rows<'a, SIZE> {
    pub fn at(&self, row: usize, column: usize) -> [u8; SIZE] {
        self.bytes[row * self.columns + column]
    }
}

/// The matrix called `name`, entries of `kind`, which has SIZE bytes; a vector is a matrix of one column.
pub(super) fn matrix<'a, const SIZE: usize>(
    file: &SafeTensors<'a>,
    name: &str,
    kind: Dtype,
) -> Result<Rows<'a, SIZE>, SafeTensorError> {
    let view = file.tensor(name)?;
    let (rows, columns) = match *view.shape() {
        [rows] => (rows, 1),
        [rows, columns] => (rows, columns),
        _ => return Err(SafeTensorError::TensorInvalidInfo),
    };
    let (bytes, rest) = view.data().as_chunks::<SIZE>();
    if view.dtype() != kind || !rest.is_empty() || bytes.len() != rows * columns {
        return Err(SafeTensorError::TensorInvalidInfo);
    }
    Ok(Rows { rows, columns, bytes })
}
