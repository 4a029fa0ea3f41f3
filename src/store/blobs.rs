use std::path::Path;
use std::sync::Arc;
use std::{fs, io};

use bytes::Bytes;
use futures::TryStreamExt;
use object_store::local::LocalFileSystem;
use object_store::path::Path as Name;
use object_store::{Error, ObjectStore, ObjectStoreExt, PutMode, PutPayload};

use super::directory::Directory;
use super::{StoreError, blocking, sealed};

/// Where blobs are put that nothing names any more.
const ASIDE: &str = "aside";

/// Byte strings under names that tell their content, each written whole or not at all, with a checksum behind it.
#[derive(Clone)]
pub(super) struct Blobs {
    files: Arc<dyn ObjectStore>,
    directory: Arc<Directory>,
}

impl Blobs {
    /// Files of the directory, on the disk before a write returns. What a killed process has left unfinished is removed.
    pub fn local(directory: Arc<Directory>) -> Result<Blobs, StoreError> {
        let folder = directory.blobs();
        remove_unfinished(&folder).map_err(|source| StoreError::Directory { path: folder.clone(), source })?;
        let files = LocalFileSystem::new_with_prefix(&folder)?.with_fsync(true).with_automatic_cleanup(true);
        Ok(Blobs { files: Arc::new(files), directory })
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
        let (bytes, directory) = (bytes.into(), self.directory.clone());
        let sealed = move || {
            directory.blobs_present()?;
            Ok(PutPayload::from_iter([bytes.clone(), sealed::seal(&bytes)]))
        };
        match self.files.put_opts(&Name::from(name), blocking(sealed).await?, mode.into()).await {
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

    /// The bytes of the file of this name, its checksum among them.
    async fn unopened(&self, name: &str) -> Result<Option<Bytes>, StoreError> {
        match self.files.get(&Name::from(name)).await {
            Ok(found) => Ok(Some(found.bytes().await?)),
            Err(Error::NotFound { .. }) => {
                let directory = self.directory.clone();
                blocking(move || directory.blobs_present()).await.map(|()| None)
            }
            Err(error) => Err(error.into()),
        }
    }

    /// Deletes a blob; one that is gone already is no error.
    pub async fn delete(&self, name: &str) -> Result<(), StoreError> {
        match self.files.delete(&Name::from(name)).await {
            Ok(()) | Err(Error::NotFound { .. }) => Ok(()),
            Err(error) => Err(error.into()),
        }
    }

    /// Puts a blob out of the way, for people to look at: where it is kept is told.
    pub async fn set_aside(&self, name: &str) -> Result<(), StoreError> {
        let aside = format!("{ASIDE}/{name}");
        tracing::warn!(name, aside, "nothing names this blob, it is set aside");
        Ok(self.files.rename(&Name::from(name), &Name::from(aside)).await?)
    }

    /// The names of all blobs in a folder, in no order.
    pub async fn names(&self, folder: &str) -> Result<Vec<String>, StoreError> {
        let found = self.files.list(Some(&Name::from(folder))).map_ok(|blob| blob.location.to_string());
        Ok(found.try_collect().await?)
    }
}

/// Deletes the files `object_store` writes to before it gives them their names, `NAME#NUMBER`; it never lists them.
fn remove_unfinished(directory: &Path) -> io::Result<()> {
    for entry in fs::read_dir(directory)? {
        let entry = entry?;
        if entry.file_type()?.is_dir() {
            remove_unfinished(&entry.path())?;
        } else if is_unfinished(&entry.file_name().to_string_lossy()) {
            fs::remove_file(entry.path())?;
        }
    }
    Ok(())
}

fn is_unfinished(name: &str) -> bool {
    name.rsplit_once('#')
        .is_some_and(|(_, number)| !number.is_empty() && number.bytes().all(|byte| byte.is_ascii_digit()))
}

#[cfg(test)]
mod tests {
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
    async fn a_folder_goes_with_its_last_blob() {
        let (directory, store) = fresh().await;
        store.blobs.put("results/job/1", "whole").await.unwrap();
        store.blobs.delete("results/job/1").await.unwrap();
        assert!(!directory.path().join("data/blobs/results").exists());
        assert!(directory.path().join("data/blobs").exists());
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
