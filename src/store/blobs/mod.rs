//! Byte strings under names, in a folder or a bucket.

mod bucket;
mod folder;

use std::sync::Arc;
use std::time::Duration;

use bytes::Bytes;
use futures::TryStreamExt;
use object_store::path::Path as Name;
use object_store::{Error, ObjectMeta, ObjectStore, ObjectStoreExt, PutMode, PutPayload};

use super::measures::{Operation, timed};
use super::{BlobUrl, StoreError, blocking, sealed};
use folder::Folder;

/// Where blobs are put that nothing names any more.
const ASIDE: &str = "aside";

/// Byte strings under names, each written whole or not at all, with a checksum behind it.
#[derive(Clone)]
pub(super) struct Blobs {
    objects: Arc<dyn ObjectStore>,
    /// Where they are files.
    folder: Option<Arc<Folder>>,
    place: Arc<BlobUrl>,
}

impl Blobs {
    /// The blobs at a place.
    ///
    /// # Errors
    /// What the disk said, or what is wrong with the place.
    pub async fn open(place: BlobUrl) -> Result<Blobs, StoreError> {
        let (objects, folder): (Arc<dyn ObjectStore>, _) = match place.clone() {
            BlobUrl::Folder(path) => {
                let folder = Arc::new(blocking(move || Folder::open(&path)).await?);
                (Arc::new(folder.objects()?), Some(folder))
            }
            BlobUrl::Bucket { bucket, prefix } => (bucket::objects(&bucket, &prefix)?, None),
        };
        Ok(Blobs { objects, folder, place: Arc::new(place) })
    }

    /// Where they are.
    pub fn place(&self) -> &BlobUrl {
        &self.place
    }

    /// Writes a blob. What is there under its name is written over: it is the same, or damaged.
    pub async fn put(&self, name: &str, bytes: impl Into<Bytes>) -> Result<(), StoreError> {
        self.put_as(PutMode::Overwrite, name, bytes).await
    }

    /// Writes a blob unless its name is taken.
    pub async fn put_once(&self, name: &str, bytes: impl Into<Bytes>) -> Result<(), StoreError> {
        self.put_as(PutMode::Create, name, bytes).await
    }

    async fn put_as(&self, mode: PutMode, name: &str, bytes: impl Into<Bytes>) -> Result<(), StoreError> {
        let (bytes, folder) = (bytes.into(), self.folder.clone());
        let sealed = move || {
            folder.map_or(Ok(()), |folder| folder.present())?;
            Ok(PutPayload::from_iter([bytes.clone(), sealed::seal(&bytes)]))
        };
        let (name, sealed) = (Name::from(name), blocking(sealed).await?);
        match timed(Operation::WriteBlob, self.objects.put_opts(&name, sealed, mode.into())).await {
            Ok(_) | Err(Error::AlreadyExists { .. }) => Ok(()),
            Err(error) => Err(error.into()),
        }
    }

    /// The blob of this name, if there is one.
    ///
    /// # Errors
    /// [`StoreError::Damaged`] where its checksum is not that of its bytes; what the disk said.
    pub async fn read(&self, name: &str) -> Result<Option<Bytes>, StoreError> {
        let Some(sealed) = self.unopened(name).await? else { return Ok(None) };
        let what = name.to_owned();
        let opened = move || sealed::opened(sealed).ok_or_else(|| StoreError::damaged(what, "its checksum is wrong"));
        blocking(opened).await.map(Some)
    }

    /// The blob of this name if it is there and whole: what is damaged can be made anew.
    pub async fn read_cached(&self, name: &str) -> Result<Option<Bytes>, StoreError> {
        match self.read(name).await {
            Err(error @ StoreError::Damaged { .. }) => {
                tracing::warn!(%error, "it is made anew");
                Ok(None)
            }
            read => read,
        }
    }

    /// Puts a checksum behind a blob of a version that wrote none, if `sound` finds nothing wrong with it; one that has
    /// its checksum stays as it is.
    pub async fn seal(&self, name: &str, sound: fn(&[u8]) -> bool) -> Result<(), StoreError> {
        let Some(bytes) = self.unopened(name).await? else { return Ok(()) };
        let judged = move || Ok((sealed::opened(bytes.clone()).is_none() && sound(&bytes)).then_some(bytes));
        match blocking(judged).await? {
            Some(bytes) => self.put(name, bytes).await,
            None => Ok(()),
        }
    }

    /// The bytes under this name, their checksum among them.
    async fn unopened(&self, name: &str) -> Result<Option<Bytes>, StoreError> {
        let name = Name::from(name);
        match timed(Operation::ReadBlob, async { self.objects.get(&name).await?.bytes().await }).await {
            Ok(bytes) => Ok(Some(bytes)),
            Err(Error::NotFound { .. }) => {
                let Some(folder) = self.folder.clone() else { return Ok(None) };
                blocking(move || folder.present()).await.map(|()| None)
            }
            Err(error) => Err(error.into()),
        }
    }

    /// Deletes a blob; one that is gone already is no error.
    pub async fn delete(&self, name: &str) -> Result<(), StoreError> {
        match self.objects.delete(&Name::from(name)).await {
            Ok(()) | Err(Error::NotFound { .. }) => Ok(()),
            Err(error) => Err(error.into()),
        }
    }

    /// Puts a blob out of the way, for people to look at: where it is kept is told. One that is gone already is no error.
    pub async fn set_aside(&self, name: &str) -> Result<(), StoreError> {
        let aside = format!("{ASIDE}/{name}");
        tracing::warn!(name, aside, "nothing names this blob, it is set aside");
        match self.objects.rename(&Name::from(name), &Name::from(aside)).await {
            Ok(()) | Err(Error::NotFound { .. }) => Ok(()),
            Err(error) => Err(error.into()),
        }
    }

    /// The names of all blobs in a folder, in no order.
    pub async fn names(&self, folder: &str) -> Result<Vec<String>, StoreError> {
        self.names_older_than(folder, Duration::ZERO).await
    }

    /// The names of the blobs in a folder that were written so long ago by the clock of where they are, in no order.
    pub async fn names_older_than(&self, folder: &str, age: Duration) -> Result<Vec<String>, StoreError> {
        let old = move |blob: &ObjectMeta| {
            age.is_zero() || std::time::SystemTime::from(blob.last_modified).elapsed().is_ok_and(|passed| passed >= age)
        };
        let found = self.objects.list(Some(&Name::from(folder)));
        let names = found.try_filter_map(async |blob| Ok(old(&blob).then(|| blob.location.to_string())));
        Ok(names.try_collect().await?)
    }

    /// Removes what a killed process has left unfinished, where nobody else is at the place and it is known to be this database's.
    ///
    /// # Errors
    /// What the disk said.
    pub async fn remove_unfinished(&self) -> Result<(), StoreError> {
        let Some(folder) = self.folder.clone() else { return Ok(()) };
        blocking(move || folder.remove_unfinished()).await
    }

    /// Removes the folders within one that deletes have emptied, where nothing is new in them for so long.
    ///
    /// # Errors
    /// What the disk said.
    pub async fn prune(&self, name: &'static str, age: Duration) -> Result<(), StoreError> {
        let Some(folder) = self.folder.clone() else { return Ok(()) };
        blocking(move || folder.prune(name, age)).await
    }

    /// Whether there is any blob at all.
    pub async fn any(&self) -> Result<bool, StoreError> {
        Ok(self.objects.list(None).try_next().await?.is_some())
    }

    /// Bytes that can still be written, where that is known.
    pub async fn free_bytes(&self) -> Result<Option<u64>, StoreError> {
        let Some(folder) = self.folder.clone() else { return Ok(None) };
        blocking(move || folder.free_bytes().map(Some)).await
    }
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;
    use crate::store::testing::{fresh, open};

    #[tokio::test]
    async fn what_a_killed_process_left_unfinished_is_removed() {
        let (directory, store) = fresh().await;
        store.blobs.put("spectra/1", "whole").await.unwrap();
        let unfinished = directory.path().join("data/blobs/spectra/2#17");
        fs::write(&unfinished, "half").unwrap();
        drop(store);
        let store = open(&directory).await;
        assert!(!unfinished.exists());
        assert_eq!(store.blobs.read("spectra/1").await.unwrap().unwrap(), "whole");
    }

    #[tokio::test]
    async fn what_others_are_writing_in_a_folder_that_is_shared_is_left_alone() {
        let folder = tempfile::tempdir().unwrap();
        let unfinished = folder.path().join("spectra#17");
        fs::write(&unfinished, "half").unwrap();
        let blobs = Blobs::open(BlobUrl::Folder(folder.path().to_owned())).await.unwrap();
        assert!(unfinished.exists() && !blobs.any().await.unwrap());
    }

    #[tokio::test]
    async fn a_folder_without_blobs_goes_with_the_sweep() {
        let (directory, store) = fresh().await;
        let folder = directory.path().join("data/blobs");
        for name in ["results/job/1", "results/other/2"] {
            store.blobs.put(name, "whole").await.unwrap();
        }
        store.blobs.delete("results/job/1").await.unwrap();
        // Whoever writes there at this moment finds it, and no other process's sweep takes it meanwhile.
        store.sweep(Duration::from_secs(3600)).await.unwrap();
        assert!(folder.join("results/job").exists());
        store.blobs.prune("results", Duration::ZERO).await.unwrap();
        assert!(!folder.join("results/job").exists());
        assert_eq!(store.blobs.read("results/other/2").await.unwrap().unwrap(), "whole");
        // What somebody else keeps beside them is not looked at.
        fs::create_dir_all(folder.join("lost+found/empty")).unwrap();
        store.blobs.delete("results/other/2").await.unwrap();
        store.sweep(Duration::ZERO).await.unwrap();
        assert!(!folder.join("results/other").exists() && folder.join("lost+found/empty").exists());
    }

    #[tokio::test]
    async fn a_directory_that_is_away_is_not_made_anew() {
        let (directory, store) = fresh().await;
        store.blobs.put("results/job/1", "whole").await.unwrap();
        let (data, elsewhere) = (directory.path().join("data"), directory.path().join("elsewhere"));
        fs::rename(&data, &elsewhere).unwrap();
        assert!(matches!(store.blobs.put("results/job/2", "new").await, Err(StoreError::Away { .. })));
        assert!(matches!(store.blobs.read("results/job/1").await, Err(StoreError::Away { .. })));
        assert!(!data.exists());
        fs::create_dir_all(data.join("blobs")).unwrap();
        assert!(matches!(store.blobs.put("results/job/2", "new").await, Err(StoreError::Away { .. })));
        fs::remove_dir_all(&data).unwrap();
        fs::rename(&elsewhere, &data).unwrap();
        store.blobs.put("results/job/2", "new").await.unwrap();
        assert_eq!(store.blobs.read("results/job/1").await.unwrap().unwrap(), "whole");
    }
}
