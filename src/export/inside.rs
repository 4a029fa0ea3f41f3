//! Everything a match was computed from and found, as arrays in one file.

use bytes::Bytes;
use faer::Mat;
use safetensors::tensor::{Dtype, TensorView};

use super::Unwritten;
use crate::pipeline::Inside;
use crate::pipeline::outcome::MatchResult;

/// `a` (k × q), `b` (l × q), `w` and `initial_c` (l × k), `c` as the result has it, `sketch_eigenvalues` and
/// `mesh_eigenvalues` at area 1, all in double precision; `points`, the mesh vertex of every vertex of the sketch, and
/// `sketch_regions` and `mesh_regions` as whole numbers.
///
/// # Errors
/// What the encoder reports.
pub fn safetensors(inside: &Inside, result: &MatchResult) -> Result<Bytes, Unwritten> {
    let found = &result.intermediate;
    let [w, c0, c] = [&found.weights, &found.initial_c, &result.c].map(|matrix| matrix.to_mat());
    let matrices = [("a", &inside.a), ("b", &inside.b), ("w", &w), ("initial_c", &c0), ("c", &c)];
    let mut tensors: Vec<(&str, Dtype, Vec<usize>, Vec<u8>)> = matrices
        .map(|(name, matrix)| (name, Dtype::F64, vec![matrix.nrows(), matrix.ncols()], by_rows(matrix)))
        .to_vec();
    for (name, values) in
        [("sketch_eigenvalues", &found.sketch_eigenvalues), ("mesh_eigenvalues", &found.mesh_eigenvalues)]
    {
        let bytes = values.iter().flat_map(|x| x.to_le_bytes()).collect();
        tensors.push((name, Dtype::F64, vec![values.len()], bytes));
    }
    let points: Vec<i32> = result.correspondences.iter().map(|point| point.mesh_vertex as i32).collect();
    for (name, values) in
        [("points", &points), ("sketch_regions", &found.regions.sketch), ("mesh_regions", &found.regions.mesh)]
    {
        let bytes = values.iter().flat_map(|x| x.to_le_bytes()).collect();
        tensors.push((name, Dtype::I32, vec![values.len()], bytes));
    }
    let views: Result<Vec<_>, _> = tensors
        .iter()
        .map(|(name, dtype, shape, bytes)| TensorView::new(*dtype, shape.clone(), bytes).map(|view| (*name, view)))
        .collect();
    Ok(safetensors::serialize(views?, None)?.into())
}

fn by_rows(matrix: &Mat<f64>) -> Vec<u8> {
    matrix.row_iter().flat_map(|row| row.iter().copied()).flat_map(f64::to_le_bytes).collect()
}
