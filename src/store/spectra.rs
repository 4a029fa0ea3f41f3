use faer::Mat;
use safetensors::tensor::{Dtype, SafeTensorError, SafeTensors};

use super::tensors::{self, Array};
use super::{Store, StoreError, blocking};
use crate::spectral::{Boundary, SOLVER_VERSION, Spectrum};

/// Which operator the cached eigenpairs belong to: cotangent stiffness, mass by mixed areas.
const OPERATOR: &str = "cotangent-mixed";

/// What a spectrum is of. Operator and version of the solver are added where it is stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct SpectrumKey {
    /// Content of the mesh that was decomposed.
    pub shape_hash: blake3::Hash,
    pub boundary: Boundary,
}

impl SpectrumKey {
    fn folder(&self) -> String {
        let boundary = match self.boundary {
            Boundary::Neumann => "neumann",
            Boundary::Dirichlet => "dirichlet",
        };
        format!("spectra/{}/{OPERATOR}-{boundary}-{SOLVER_VERSION}", self.shape_hash.to_hex())
    }
}

impl Store {
    /// The first `k` eigenpairs where at least as many are cached.
    ///
    /// # Errors
    /// What the disk said.
    pub async fn spectrum(&self, key: &SpectrumKey, k: usize) -> Result<Option<Spectrum>, StoreError> {
        let folder = key.folder();
        let cached = self.blobs.names(&folder).await?;
        let Some(length) = cached.iter().filter_map(|name| length(name)).filter(|&length| length >= k).min() else {
            return Ok(None);
        };
        let name = blob(&folder, length);
        let Some(bytes) = self.blobs.read(&name).await? else { return Ok(None) };
        blocking(move || decode(&bytes, k).map(Some).map_err(|error| StoreError::damaged(name, error))).await
    }

    /// Caches a spectrum under its number of eigenpairs.
    ///
    /// # Errors
    /// What the disk said.
    pub async fn put_spectrum(&self, key: &SpectrumKey, spectrum: &Spectrum) -> Result<(), StoreError> {
        let name = blob(&key.folder(), spectrum.len());
        let bytes = encode(spectrum).map_err(|error| StoreError::damaged("the spectrum", error))?;
        Ok(self.blobs.put(&name, bytes).await?)
    }
}

fn blob(folder: &str, length: usize) -> String {
    format!("{folder}/{length}.safetensors")
}

fn length(blob: &str) -> Option<usize> {
    blob.rsplit('/').next()?.strip_suffix(".safetensors")?.parse().ok()
}

fn encode(spectrum: &Spectrum) -> Result<Vec<u8>, SafeTensorError> {
    let (n, k) = (spectrum.vertices(), spectrum.len());
    let functions = &spectrum.eigenfunctions;
    let entries = (0..n).flat_map(|i| (0..k).map(move |j| functions[(i, j)]));
    let arrays = [
        Array::of_f64("eigenvalues", vec![k], spectrum.eigenvalues.iter().copied()),
        Array::of_f64("eigenfunctions", vec![n, k], entries),
        Array::of_f64("mass", vec![n], spectrum.mass.iter().copied()),
    ];
    tensors::encode(&arrays, None)
}

/// The first `k` of the pairs in the file.
fn decode(bytes: &[u8], k: usize) -> Result<Spectrum, SafeTensorError> {
    let file = SafeTensors::deserialize(bytes)?;
    let values = tensors::matrix(&file, "eigenvalues", Dtype::F64)?;
    let functions = tensors::matrix(&file, "eigenfunctions", Dtype::F64)?;
    let mass = tensors::matrix(&file, "mass", Dtype::F64)?;
    let n = mass.rows;
    if values.rows < k || functions.rows != n || functions.columns != values.rows {
        return Err(SafeTensorError::TensorInvalidInfo);
    }
    Ok(Spectrum {
        eigenvalues: (0..k).map(|j| f64::from_le_bytes(values.at(j, 0))).collect(),
        eigenfunctions: Mat::from_fn(n, k, |i, j| f64::from_le_bytes(functions.at(i, j))),
        mass: (0..n).map(|i| f64::from_le_bytes(mass.at(i, 0))).collect(),
    })
}
