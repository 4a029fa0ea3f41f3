use std::fs::{self, DirBuilder, File, Metadata, TryLockError};
use std::io;
use std::os::unix::fs::{DirBuilderExt, FileExt, MetadataExt};
use std::path::{Path, PathBuf};

use super::StoreError;

/// What every SQLite file begins with.
const MAGIC: &[u8; 16] = b"SQLite format 3\0";

/// The data directory of a process that has its database there: made and locked at the start, looked at again later, never
/// made again.
pub(super) struct Directory {
    path: PathBuf,
    /// Locked until the end, beside `_lock`: whoever takes that file away takes this one away with the data. Never
    /// closed before the database is, for that would end the locks SQLite holds on it.
    database: File,
    _lock: File,
}

/// Which file or directory something is, whatever it is called.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) struct Identity {
    device: u64,
    number: u64,
}

impl From<Metadata> for Identity {
    fn from(metadata: Metadata) -> Identity {
        Identity { device: metadata.dev(), number: metadata.ino() }
    }
}

impl Directory {
    /// The directory at `path`, with an empty database where there is none yet.
    ///
    /// # Errors
    /// [`StoreError::Locked`] when another process has it open, [`StoreError::Directory`] with what the disk said.
    pub fn open(path: &Path) -> Result<Directory, StoreError> {
        DirBuilder::new().recursive(true).mode(0o700).create(path).map_err(at(path))?;
        let path = path.canonicalize().map_err(at(path))?;
        let lock_path = path.join("lock");
        let lock_file = File::create(&lock_path).map_err(at(&lock_path))?;
        lock(&lock_file, &lock_path, &path)?;
        let database_file = path.join("sketchmatch.db");
        let database = File::options().read(true).write(true).create(true).truncate(false).open(&database_file);
        let database = database.map_err(at(&database_file))?;
        lock(&database, &database_file, &path)?;
        Ok(Directory { path, database, _lock: lock_file })
    }

    pub fn path(&self) -> &Path {
        &self.path
    }

    pub fn database(&self) -> PathBuf {
        self.path.join("sketchmatch.db")
    }

    /// Whether nothing was ever written to the database.
    ///
    /// # Errors
    /// What the disk said.
    pub fn database_is_empty(&self) -> Result<bool, StoreError> {
        Ok(self.database.metadata().map_err(at(&self.database()))?.len() == 0)
    }

    /// Ok while the database's file is the one there was at the start and begins as such files do.
    ///
    /// # Errors
    /// [`StoreError::Away`], [`StoreError::Damaged`], or what the disk said.
    pub fn database_present(&self) -> Result<(), StoreError> {
        let path = self.database();
        let ours = self.database.metadata().map(Identity::from).map_err(at(&path))?;
        if !fs::metadata(&path).is_ok_and(|found| Identity::from(found) == ours) {
            return Err(StoreError::Away { path });
        }
        let mut magic = [0; MAGIC.len()];
        match self.database.read_exact_at(&mut magic, 0) {
            Ok(()) if &magic == MAGIC => Ok(()),
            _ => Err(StoreError::damaged(path.display().to_string(), "it is no SQLite database any more")),
        }
    }
}

/// Bytes that can still be written to the disk that `path` is on.
///
/// # Errors
/// What the disk said.
pub(super) fn free_bytes(path: &Path) -> Result<u64, StoreError> {
    let disk = rustix::fs::statvfs(path).map_err(|error| at(path)(error.into()))?;
    Ok(disk.f_bavail.saturating_mul(disk.f_frsize))
}

/// Locks a file of the data directory until it is closed.
///
/// # Errors
/// [`StoreError::Locked`] where another process has it; what the disk said.
fn lock(file: &File, path: &Path, data_dir: &Path) -> Result<(), StoreError> {
    match file.try_lock() {
        Ok(()) => Ok(()),
        Err(TryLockError::WouldBlock) => Err(StoreError::Locked { data_dir: data_dir.to_owned() }),
        Err(TryLockError::Error(source)) => Err(at(path)(source)),
    }
}

/// What the disk said, with the path it said it of.
pub(super) fn at(path: &Path) -> impl Fn(io::Error) -> StoreError {
    move |source| StoreError::Directory { path: path.to_owned(), source }
}
