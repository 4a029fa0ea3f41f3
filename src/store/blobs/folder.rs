use std::fs::{self, DirBuilder};
use std::io;
use std::os::unix::fs::DirBuilderExt;
use std::path::{Path, PathBuf};

use object_store::local::LocalFileSystem;

use crate::store::StoreError;
use crate::store::directory::{self, Identity, at};

/// A folder of blobs as it was at the start: looked at again later, never made again.
pub(super) struct Folder {
    path: PathBuf,
    identity: Identity,
}

impl Folder {
    /// The folder at `path`, made where it is missing. Where nobody else is at it, what a killed process has left unfinished
    /// is removed.
    pub fn open(path: &Path, alone: bool) -> Result<Folder, StoreError> {
        DirBuilder::new().recursive(true).mode(0o700).create(path).map_err(at(path))?;
        let path = path.canonicalize().map_err(at(path))?;
        if alone {
            remove_unfinished(&path).map_err(at(&path))?;
        }
        let identity = fs::metadata(&path).map(Identity::from).map_err(at(&path))?;
        Ok(Folder { path, identity })
    }

    /// Its files, on the disk before a write returns.
    pub fn objects(&self) -> Result<LocalFileSystem, StoreError> {
        Ok(LocalFileSystem::new_with_prefix(&self.path)?.with_fsync(true).with_automatic_cleanup(true))
    }

    /// Ok while the folder is the one there was at the start: nothing is to be made in its place.
    ///
    /// # Errors
    /// [`StoreError::Away`].
    pub fn present(&self) -> Result<(), StoreError> {
        if fs::metadata(&self.path).is_ok_and(|found| Identity::from(found) == self.identity) {
            return Ok(());
        }
        Err(StoreError::Away { path: self.path.clone() })
    }

    /// Bytes that can still be written to its disk.
    ///
    /// # Errors
    /// What the disk said.
    pub fn free_bytes(&self) -> Result<u64, StoreError> {
        directory::free_bytes(&self.path)
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
