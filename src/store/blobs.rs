use std::path::Path;
use std::sync::Arc;
use std::{fs, io};

use bytes::Bytes;
use futures::TryStreamExt;
use object_store::local::LocalFileSystem;
use object_store::path::Path as Name;
use object_store::{Error, ObjectStore, ObjectStoreExt, PutMode};

/// Immutable byte strings under names, each written whole or not at all.
#[derive(Clone)]
pub(super) struct Blobs(Arc<dyn ObjectStore>);

impl Blobs {
    /// Files under `directory`, on the disk before a write returns. To be opened by one process at a time: what a killed
    /// one has left unfinished is removed.
    pub fn local(directory: &Path) -> Result<Blobs, Error> {
        remove_unfinished(directory).map_err(|error| Error::Generic { store: "blobs", source: error.into() })?;
        Ok(Blobs(Arc::new(LocalFileSystem::new_with_prefix(directory)?.with_fsync(true))))
    }

    /// Writes a blob unless its name is taken: names tell the content, so what is there is the same.
    pub async fn put(&self, name: &str, bytes: impl Into<Bytes>) -> Result<(), Error> {
        let payload = bytes.into().into();
        match self.0.put_opts(&Name::from(name), payload, PutMode::Create.into()).await {
            Ok(_) | Err(Error::AlreadyExists { .. }) => Ok(()),
            Err(error) => Err(error),
        }
    }

    pub async fn read(&self, name: &str) -> Result<Option<Bytes>, Error> {
        match self.0.get(&Name::from(name)).await {
            Ok(found) => found.bytes().await.map(Some),
            Err(Error::NotFound { .. }) => Ok(None),
            Err(error) => Err(error),
        }
    }

    /// Deletes a blob; one that is gone already is no error.
    pub async fn delete(&self, name: &str) -> Result<(), Error> {
        match self.0.delete(&Name::from(name)).await {
            Ok(()) | Err(Error::NotFound { .. }) => Ok(()),
            Err(error) => Err(error),
        }
    }

    /// The names of all blobs in a folder, in no order.
    pub async fn names(&self, folder: &str) -> Result<Vec<String>, Error> {
        self.0.list(Some(&Name::from(folder))).map_ok(|blob| blob.location.to_string()).try_collect().await
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

    #[tokio::test]
    async fn what_a_killed_process_left_unfinished_is_removed() {
        let directory = tempfile::tempdir().unwrap();
        let blobs = Blobs::local(directory.path()).unwrap();
        blobs.put("results/job/1", "whole").await.unwrap();
        let unfinished = directory.path().join("results/job/2#17");
        fs::write(&unfinished, "half").unwrap();
        let blobs = Blobs::local(directory.path()).unwrap();
        assert!(!unfinished.exists());
        assert_eq!(blobs.read("results/job/1").await.unwrap().unwrap(), "whole");
    }
}
