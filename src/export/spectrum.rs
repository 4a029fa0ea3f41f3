//! The spectrum of a shape as arrays.

use bytes::Bytes;
use safetensors::tensor::{Dtype, TensorView};

use super::{Unwritten, npy};
use crate::mesh::figure::Figure;
use crate::spectral::Spectrum;

/// The rows of the first `k` eigenfunctions, one per vertex of the uploaded file; not a number where a vertex is none of
/// those decomposed.
fn rows(spectrum: &Spectrum, k: usize, figure: &Figure) -> impl Iterator<Item = f64> {
    let eigenfunctions = spectrum.eigenfunctions.as_ref();
    figure
        .of_file()
        .flat_map(move |row| (0..k).map(move |column| row.map_or(f64::NAN, |row| eigenfunctions[(row, column)])))
}

/// The first `k` eigenfunctions as an array, a row per vertex of the file; not a number where a vertex is none of those
/// decomposed.
pub fn npy(spectrum: &Spectrum, k: usize, figure: &Figure) -> Bytes {
    npy::file(figure.of_file().len(), k, rows(spectrum, k, figure)).into()
}

/// `eigenvalues` (k), `eigenfunctions` (vertices × k) and `mass` (vertices, 0 outside the part decomposed and where a lower
/// vertex is the same one).
///
/// # Errors
/// What the encoder reports.
pub fn safetensors(spectrum: &Spectrum, k: usize, figure: &Figure) -> Result<Bytes, Unwritten> {
    let bytes = |values: &mut dyn Iterator<Item = f64>| values.flat_map(f64::to_le_bytes).collect::<Vec<u8>>();
    let vertices = figure.of_file().len();
    let mut mass = vec![0.0; vertices];
    for (row, &vertex) in figure.vertices.iter().enumerate() {
        mass[vertex as usize] += spectrum.mass[row];
    }
    let eigenvalues = bytes(&mut spectrum.eigenvalues.iter().copied().take(k));
    let eigenfunctions = bytes(&mut rows(spectrum, k, figure));
    let mass = bytes(&mut mass.into_iter());
    let views = [
        ("eigenvalues", TensorView::new(Dtype::F64, vec![k], &eigenvalues)?),
        ("eigenfunctions", TensorView::new(Dtype::F64, vec![vertices, k], &eigenfunctions)?),
        ("mass", TensorView::new(Dtype::F64, vec![vertices], &mass)?),
    ];
    Ok(safetensors::serialize(views, None)?.into())
}
