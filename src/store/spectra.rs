use std::collections::BTreeMap;
use std::sync::Arc;

use faer::Mat;
use safetensors::tensor::{Dtype, SafeTensorError, SafeTensors};

use super::tensors::{self, Array};
use super::{Store, StoreError, blocking};
use crate::numerics::instruction_set;
use crate::spectral::{Boundary, SOLVER_VERSION, Spectrum, rung};

/// Which operator the cached eigenpairs belong to: cotangent stiffness, mass by mixed areas.
const OPERATOR: &str = "cotangent-mixed";

/// Rows of eigenfunctions that are decoded together.
const ROWS: usize = 64;

/// What a spectrum is of. Operator, version of the solver and instruction set are added where it is stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct SpectrumKey {
    /// Content of the mesh that was decomposed.
    pub shape_hash: blake3::Hash,
    pub boundary: Boundary,
}

impl SpectrumKey {
    /// Where those are that this process computes.
    fn folder(&self) -> String {
        format!("{}{}", self.folders(), instruction_set())
    }

    /// How the names of the folders begin that processes of all instruction sets keep them in.
    fn folders(&self) -> String {
        let boundary = match self.boundary {
            Boundary::Neumann => "neumann",
            Boundary::Dirichlet => "dirichlet",
        };
        format!("{}/{OPERATOR}-{boundary}-{SOLVER_VERSION}-", self.shape())
    }

    /// Where all are of this mesh.
    fn shape(&self) -> String {
        format!("spectra/{}", self.shape_hash.to_hex())
    }
}

impl Store {
    /// What the computation of at least `k` eigenpairs is claimed by.
    pub fn spectrum_name(&self, key: &SpectrumKey, k: usize) -> String {
        blob(&self.cached_as(&key.folder()), rung(k))
    }

    /// At least `k` eigenpairs where they are cached, and just those that would be computed: [`rung`] of them, or all
    /// there are. A longer spectrum cut short has other functions within repeated eigenvalues. Nothing where it is
    /// damaged, so that it is computed and written anew.
    ///
    /// # Errors
    /// What the disk said.
    pub async fn spectrum(&self, key: &SpectrumKey, k: usize) -> Result<Option<Spectrum>, StoreError> {
        let folder = self.cached_as(&key.folder());
        let cached = self.blobs.names(&folder).await?;
        match longest(&cached, k) {
            Some(length) => self.spectrum_in(&folder, length).await,
            None => Ok(None),
        }
    }

    /// The same for who looks at what others compute: where there is none of this process's instruction set that of another
    /// will do, of several the first by name. A process that waited for its own would wait for ever where none computes that has
    /// its instruction set.
    ///
    /// # Errors
    /// What the disk said.
    pub async fn spectrum_of_any(&self, key: &SpectrumKey, k: usize) -> Result<Option<Spectrum>, StoreError> {
        let (own, folders) = (self.cached_as(&key.folder()), self.cached_as(&key.folders()));
        let cached = self.blobs.names(&self.cached_as(&key.shape())).await?;
        let mut by_folder: BTreeMap<(bool, &str), Vec<&String>> = BTreeMap::new();
        for name in cached.iter().filter(|name| name.starts_with(&folders)) {
            let folder = name.rsplit_once('/').map_or("", |(folder, _)| folder);
            by_folder.entry((folder != own, folder)).or_default().push(name);
        }
        for ((_, folder), names) in by_folder {
            if let Some(length) = longest(names, k)
                && let Some(found) = self.spectrum_in(folder, length).await?
            {
                return Ok(Some(found));
            }
        }
        Ok(None)
    }

    /// The spectrum of this length in a folder; nothing where it is damaged.
    async fn spectrum_in(&self, folder: &str, length: usize) -> Result<Option<Spectrum>, StoreError> {
        self.cached(blob(folder, length), move |bytes| decode(bytes, length)).await
    }

    /// Caches a spectrum under its number of eigenpairs, for as long as there is the shape it was made for.
    ///
    /// # Errors
    /// What the disk or the database said.
    pub async fn put_spectrum(
        &self,
        key: &SpectrumKey,
        spectrum: impl Into<Arc<Spectrum>>,
        shape: Option<&str>,
    ) -> Result<(), StoreError> {
        let spectrum = spectrum.into();
        let name = blob(&self.cached_as(&key.folder()), spectrum.len());
        let encoded = move || encode(&spectrum).map_err(|error| StoreError::damaged("the spectrum", error));
        self.put_cached(&name, blocking(encoded).await?, shape).await
    }
}

fn blob(folder: &str, length: usize) -> String {
    format!("{folder}/{length}.safetensors")
}

/// The length of the longest of these blobs that is what would be computed where `k` pairs are asked for.
fn longest<'a>(blobs: impl IntoIterator<Item = &'a String>, k: usize) -> Option<usize> {
    blobs.into_iter().filter_map(|name| length(name)).filter(|length| (k..=rung(k)).contains(length)).max()
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

/// The `k` pairs in the file.
fn decode(bytes: &[u8], k: usize) -> Result<Spectrum, SafeTensorError> {
    let file = SafeTensors::deserialize(bytes)?;
    let values = tensors::matrix(&file, "eigenvalues", Dtype::F64)?;
    let functions = tensors::matrix(&file, "eigenfunctions", Dtype::F64)?;
    let mass = tensors::matrix(&file, "mass", Dtype::F64)?;
    let n = mass.rows;
    if values.rows != k || functions.rows != n || functions.columns != values.rows {
        return Err(SafeTensorError::TensorInvalidInfo);
    }
    // The file goes row by row, the matrix column by column: some rows at a time, so that both stay in the cache.
    let mut eigenfunctions = Mat::zeros(n, k);
    for first in (0..n).step_by(ROWS) {
        for (j, column) in eigenfunctions.as_mut().subrows_mut(first, ROWS.min(n - first)).col_iter_mut().enumerate() {
            column.iter_mut().zip(first..).for_each(|(x, i)| *x = f64::from_le_bytes(functions.at(i, j)));
        }
    }
    Ok(Spectrum {
        eigenvalues: (0..k).map(|j| f64::from_le_bytes(values.at(j, 0))).collect(),
        eigenfunctions,
        mass: (0..n).map(|i| f64::from_le_bytes(mass.at(i, 0))).collect(),
    })
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;
    use crate::store::testing::{damaged, fresh, open};

    const KEY: SpectrumKey = SpectrumKey { shape_hash: blake3::Hash::from_bytes([7; 32]), boundary: Boundary::Neumann };

    /// Numbers that tell their place; no shape's.
    fn numbered(n: usize, k: usize) -> Spectrum {
        Spectrum {
            eigenvalues: (0..k).map(|j| j as f64 / 3.0).collect(),
            eigenfunctions: Mat::from_fn(n, k, |i, j| (i * 100 + j) as f64 / 7.0),
            mass: (0..n).map(|i| 1.0 / (i + 1) as f64).collect(),
        }
    }

    #[tokio::test]
    async fn a_spectrum_survives_bit_for_bit() {
        let (directory, store) = fresh().await;
        store.put_spectrum(&KEY, numbered(9, 4), None).await.unwrap();
        drop(store);
        let found = open(&directory).await.spectrum(&KEY, 4).await.unwrap();
        assert_eq!(found, Some(numbered(9, 4)));
    }

    #[tokio::test]
    async fn all_there_are_serve_any_request_on_their_rung() {
        let (_directory, store) = fresh().await;
        assert_eq!(store.spectrum(&KEY, 1).await.unwrap(), None);
        store.put_spectrum(&KEY, numbered(9, 5), None).await.unwrap();
        assert_eq!(store.spectrum(&KEY, 3).await.unwrap(), Some(numbered(9, 5)));
        assert_eq!(store.spectrum(&KEY, 6).await.unwrap(), None);
    }

    #[tokio::test]
    async fn what_is_served_does_not_depend_on_what_else_is_cached() {
        let (_directory, store) = fresh().await;
        store.put_spectrum(&KEY, numbered(70, 60), None).await.unwrap();
        assert_eq!(store.spectrum(&KEY, 20).await.unwrap(), None);
        assert_eq!(store.spectrum(&KEY, 21).await.unwrap(), Some(numbered(70, 60)));
        store.put_spectrum(&KEY, numbered(70, 20), None).await.unwrap();
        assert_eq!(store.spectrum(&KEY, 7).await.unwrap(), Some(numbered(70, 20)));
        assert_eq!(store.spectrum(&KEY, 60).await.unwrap(), Some(numbered(70, 60)));
    }

    #[tokio::test]
    async fn boundary_and_mesh_are_told_apart() {
        let (_directory, store) = fresh().await;
        store.put_spectrum(&KEY, numbered(9, 5), None).await.unwrap();
        let fixed = SpectrumKey { boundary: Boundary::Dirichlet, ..KEY };
        let other = SpectrumKey { shape_hash: blake3::Hash::from_bytes([8; 32]), ..KEY };
        assert_eq!(store.spectrum(&fixed, 5).await.unwrap(), None);
        assert_eq!(store.spectrum(&other, 5).await.unwrap(), None);
    }

    #[tokio::test]
    async fn who_looks_at_it_takes_what_another_instruction_set_has_kept() {
        let (_directory, store) = fresh().await;
        let keep = async |folder: &str, factor: f64| {
            let mut spectrum = numbered(9, 5);
            spectrum.mass[0] = factor;
            store.blobs.put(&blob(folder, 5), encode(&spectrum).unwrap()).await.unwrap();
        };
        let of_any = async || store.spectrum_of_any(&KEY, 5).await.unwrap().map(|spectrum| spectrum.mass[0]);
        let others = ["b", "a"].map(|instructions| format!("{}{instructions}", KEY.folders()));
        // Neither another boundary nor another version of the solver.
        keep(&SpectrumKey { boundary: Boundary::Dirichlet, ..KEY }.folder(), 1.0).await;
        keep(&format!("{}/{OPERATOR}-neumann-{SOLVER_VERSION}0-a", KEY.shape()), 2.0).await;
        assert_eq!(of_any().await, None);
        keep(&others[0], 3.0).await;
        assert_eq!((of_any().await, store.spectrum(&KEY, 5).await.unwrap()), (Some(3.0), None));
        keep(&others[1], 4.0).await;
        assert_eq!(of_any().await, Some(4.0));
        store.blobs.put(&blob(&others[1], 5), b"no tensors".to_vec()).await.unwrap();
        assert_eq!(of_any().await, Some(3.0));
        keep(&KEY.folder(), 5.0).await;
        assert_eq!(of_any().await, Some(5.0));
    }

    #[tokio::test]
    async fn a_damaged_spectrum_is_written_anew() {
        let (directory, store) = fresh().await;
        store.put_spectrum(&KEY, numbered(700, 5), None).await.unwrap();
        let file = directory.path().join("data/blobs").join(blob(&KEY.folder(), 5));
        let whole = fs::read(&file).unwrap();
        for damaged in damaged(&whole) {
            fs::write(&file, damaged).unwrap();
            assert_eq!(store.spectrum(&KEY, 5).await.unwrap(), None);
            store.put_spectrum(&KEY, numbered(700, 5), None).await.unwrap();
            assert_eq!(store.spectrum(&KEY, 5).await.unwrap(), Some(numbered(700, 5)));
        }
    }

    #[tokio::test]
    async fn what_is_no_spectrum_of_its_length_is_none() {
        let (_directory, store) = fresh().await;
        let shorter = encode(&numbered(9, 4)).unwrap();
        for other in [b"no tensors".to_vec(), shorter] {
            store.blobs.put(&blob(&KEY.folder(), 5), other).await.unwrap();
            assert_eq!(store.spectrum(&KEY, 5).await.unwrap(), None);
        }
    }
}
