//! The functional map of a match as an array and as a heat map.

use bytes::Bytes;
use serde::Deserialize;

use super::{Unwritten, npy};
use crate::picture::heat_map;

/// What is read of a result.
#[derive(Deserialize)]
struct Map {
    c: Matrix,
}

#[derive(Deserialize)]
struct Matrix {
    rows: usize,
    columns: usize,
    values: Vec<Vec<f64>>,
}

fn matrix(result: &[u8]) -> serde_json::Result<Matrix> {
    serde_json::from_slice(result).map(|Map { c }| c)
}

/// C of a result as an array, mesh by sketch.
///
/// # Errors
/// A result that cannot be read.
pub fn npy(result: &[u8]) -> Result<Bytes, Unwritten> {
    let Matrix { rows, columns, values } = matrix(result)?;
    Ok(npy::file(rows, columns, values.into_iter().flatten()).into())
}

/// C of a result as a heat map, in PNG.
///
/// # Errors
/// A result that cannot be read; what the encoder reports.
pub fn png(result: &[u8]) -> Result<Bytes, Unwritten> {
    Ok(heat_map::png(&matrix(result)?.values)?.into())
}

/// The same as SVG.
///
/// # Errors
/// As of [`png`].
pub fn svg(result: &[u8]) -> Result<Bytes, Unwritten> {
    Ok(heat_map::svg(&matrix(result)?.values)?.into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lays_out_c_by_rows() {
        let file = npy(br#"{"c": {"rows": 2, "columns": 1, "values": [[1], [2]]}}"#).unwrap();
        assert_eq!(file[file.len() - 16..], [1f64.to_le_bytes(), 2f64.to_le_bytes()].concat());
    }
}
