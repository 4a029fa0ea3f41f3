use std::sync::Arc;

use faer::Mat;
use safetensors::tensor::{Dtype, SafeTensorError, SafeTensors};

use super::tensors::{self, Array};
use super::{Store, StoreError, blocking};
use crate::deformation::biharmonic_weights::{WEIGHTS_VERSION, Weights};
use crate::numerics::instruction_set;

impl Store {
    /// The weights of a drawing that is held so, where they are cached; nothing where they are damaged, so that they are
    /// computed and written anew.
    ///
    /// # Errors
    /// What the disk said.
    pub async fn weights(&self, held: &blake3::Hash) -> Result<Option<Weights>, StoreError> {
        self.cached(self.weights_name(held), decode).await
    }

    /// Caches the weights of a drawing that is held so, for as long as there is the shape they were made for.
    ///
    /// # Errors
    /// What the disk or the database said.
    pub async fn put_weights(
        &self,
        held: &blake3::Hash,
        weights: impl Into<Arc<Weights>>,
        shape: Option<&str>,
    ) -> Result<(), StoreError> {
        let weights = weights.into();
        let encoded = move || encode(&weights).map_err(|error| StoreError::damaged("the weights", error));
        self.put_cached(&self.weights_name(held), blocking(encoded).await?, shape).await
    }

    /// What the computation of the weights is claimed by.
    pub fn weights_name(&self, held: &blake3::Hash) -> String {
        self.cached_as(&blob(held))
    }
}

fn blob(held: &blake3::Hash) -> String {
    format!("weights/{}/{WEIGHTS_VERSION}-{}", held.to_hex(), instruction_set())
}

fn encode(Weights { values, extrema }: &Weights) -> Result<Vec<u8>, SafeTensorError> {
    let entries = (0..values.nrows()).flat_map(|i| (0..values.ncols()).map(move |j| values[(i, j)]));
    let extrema = u32::try_from(*extrema).unwrap_or(u32::MAX);
    let arrays = [
        Array::of_f64("values", vec![values.nrows(), values.ncols()], entries),
        Array::of_u32("extrema", vec![1], [extrema].into_iter()),
    ];
    tensors::encode(&arrays, None)
}

fn decode(bytes: &[u8]) -> Result<Weights, SafeTensorError> {
    let file = SafeTensors::deserialize(bytes)?;
    let values = tensors::matrix(&file, "values", Dtype::F64)?;
    let extrema = tensors::matrix(&file, "extrema", Dtype::U32)?;
    if extrema.rows != 1 || extrema.columns != 1 {
        return Err(SafeTensorError::TensorInvalidInfo);
    }
    let entry = |i: usize, j: usize| f64::from_le_bytes(values.at(i, j));
    let extrema = u32::from_le_bytes(extrema.at(0, 0)) as usize;
    Ok(Weights { values: Mat::from_fn(values.rows, values.columns, entry), extrema })
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;
    use crate::store::testing::{damaged, fresh, open};

    #[tokio::test]
    async fn weights_survive_bit_for_bit_and_damaged_ones_are_written_anew() {
        let (directory, store) = fresh().await;
        let held = blake3::hash(b"held");
        let weights = Weights { values: Mat::from_fn(60, 3, |i, j| (i * 3 + j) as f64 / 7.0), extrema: 2 };
        assert_eq!(store.weights(&held).await.unwrap(), None);
        store.put_weights(&held, weights.clone(), None).await.unwrap();
        drop(store);
        let store = open(&directory).await;
        assert_eq!(store.weights(&held).await.unwrap().as_ref(), Some(&weights));
        assert_eq!(store.weights(&blake3::hash(b"otherwise")).await.unwrap(), None);
        let file = directory.path().join("data/blobs").join(blob(&held));
        let whole = fs::read(&file).unwrap();
        for damaged in damaged(&whole) {
            fs::write(&file, damaged).unwrap();
            assert_eq!(store.weights(&held).await.unwrap(), None);
            store.put_weights(&held, weights.clone(), None).await.unwrap();
            assert_eq!(fs::read(&file).unwrap(), whole);
        }
    }
}
