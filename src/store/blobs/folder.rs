use std::fs::{self, DirBuilder};
use std::io::{self, ErrorKind};
use std::os::unix::fs::DirBuilderExt;
use std::path::{Path, PathBuf};
use std::time::Duration;

use object_store::local::LocalFileSystem;

use crate::store::StoreError;
use crate::store::directory::{self, Identity, at};

/// A folder of blobs as it was at the start: looked at again later, never made again.
pub(super) struct Folder {
    path: PathBuf,
    identity: Identity,
}

impl Folder {
    /// The folder at `path`, made where it is missing.
    pub fn open(path: &Path) -> Result<Folder, StoreError> {
        DirBuilder::new().recursive(true).mode(0o700).create(path).map_err(at(path))?;
        let path = path.canonicalize().map_err(at(path))?;
        let identity = fs::metadata(&path).map(Identity::from).map_err(at(&path))?;
        Ok(Folder { path, identity })
    }

    /// Its files, on the disk before a write returns. A delete leaves the folder it empties: `object_store` opens that folder
    /// again after it gave a file its name, and a write would fail where another deletes the same blob meanwhile.
    pub fn objects(&self) -> Result<LocalFileSystem, StoreError> {
        Ok(LocalFileSystem::new_with_prefix(&self.path)?.with_fsync(true))
    }

    /// Removes what a killed process has left unfinished.
    ///
    /// # Errors
    /// What the disk said.
    pub fn remove_unfinished(&self) -> Result<(), StoreError> {
        remove_unfinished(&self.path).map_err(at(&self.path))
    }

    /// Removes the empty folders in one of its folders that nothing was put into or taken out of for so long.
    ///
    /// # Errors
    /// What the disk said.
    pub fn prune(&self, name: &str, age: Duration) -> Result<(), StoreError> {
        let path = self.path.join(name);
        match prune(&path, age) {
            Err(error) if error.kind() != ErrorKind::NotFound => Err(at(&path)(error)),
            _ => Ok(()),
        }
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

/// Removes empty folders below `directory`, those in them first. One that is filled or gone by now is left to whoever did that.
fn prune(directory: &Path, age: Duration) -> io::Result<()> {
    for entry in fs::read_dir(directory)? {
        let entry = entry?;
        if !entry.file_type()?.is_dir() {
            continue;
        }
        let pruned = entry.metadata().and_then(|found| {
            let unchanged = found.modified()?.elapsed().unwrap_or_default();
            prune(&entry.path(), age)?;
            if unchanged >= age { fs::remove_dir(entry.path()) } else { Ok(()) }
        });
        match pruned.map_err(|error| error.kind()) {
            Ok(()) | Err(ErrorKind::NotFound | ErrorKind::DirectoryNotEmpty) => {}
            Err(kind) => return Err(kind.into()),
        }
    }
    Ok(())
}
