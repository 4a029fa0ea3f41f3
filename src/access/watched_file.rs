//! A file of keys that is read again when it changes, so that keys come and go without a restart.

use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};
use std::sync::{Arc, PoisonError, RwLock};
use std::time::{Duration, SystemTime};

use blake3::Hash;
use tokio::time::sleep;
use tokio_util::sync::CancellationToken;

use super::Grant;
use super::key_file::{KeyFile, Unreadable};

/// How often the file is looked at: how long a key that was taken out may still be good.
const PAUSE: Duration = Duration::from_secs(1);

/// Bytes of a file of keys at most.
const LARGEST: u64 = 1 << 20;

/// The keys of a file as it was last when it could be read. Clones share them.
#[derive(Clone, Debug)]
pub struct WatchedFile {
    path: PathBuf,
    keys: Arc<RwLock<Arc<KeyFile>>>,
}

/// Why a file of keys cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum KeyFileError {
    #[error("the keys in {} cannot be read: {source}", path.display())]
    System { path: PathBuf, source: io::Error },
    #[error("{}, {unreadable}", path.display())]
    Content { path: PathBuf, unreadable: Unreadable },
    #[error("{} has no keys in it", path.display())]
    Empty { path: PathBuf },
}

impl WatchedFile {
    /// The file at this path, in which there is a key at least.
    ///
    /// # Errors
    /// What the system said; the first line that cannot be read.
    pub fn open(path: &Path) -> Result<WatchedFile, KeyFileError> {
        let keys = read(path)?;
        if keys.is_empty() {
            return Err(KeyFileError::Empty { path: path.to_owned() });
        }
        warn_of_guessable(path, &keys);
        Ok(WatchedFile { path: path.to_owned(), keys: Arc::new(RwLock::new(Arc::new(keys))) })
    }

    /// What the key of this hash opens at this time, if it is in the file.
    pub fn grant(&self, hash: &Hash, now: SystemTime) -> Option<Grant> {
        self.keys.read().unwrap_or_else(PoisonError::into_inner).grant(hash, now).cloned()
    }

    /// Reads the file again and again until `shutdown`. While it cannot be read the keys stay as they were; a file that
    /// is emptied lets nobody in.
    pub async fn watch(self, shutdown: CancellationToken) {
        // What is no file, such as a pipe, can be read once only.
        if !self.path.is_file() {
            return;
        }
        let mut failed = false;
        while shutdown.run_until_cancelled(sleep(PAUSE)).await.is_some() {
            let file = self.clone();
            let looked = tokio::task::spawn_blocking(move || file.look()).await;
            match looked {
                Ok(Ok(())) => failed = false,
                Ok(Err(error)) if !failed => {
                    failed = true;
                    tracing::error!(%error, "the keys stay as they were");
                }
                // It goes on being wrong, which was said; or the runtime ends.
                _ => {}
            }
        }
    }

    /// Takes the keys that are in the file now.
    fn look(&self) -> Result<(), KeyFileError> {
        let keys = read(&self.path)?;
        let mut kept = self.keys.write().unwrap_or_else(PoisonError::into_inner);
        if **kept != keys {
            tracing::info!(file = %self.path.display(), keys = keys.len(), "the keys have changed");
            warn_of_guessable(&self.path, &keys);
            *kept = Arc::new(keys);
        }
        Ok(())
    }
}

fn warn_of_guessable(path: &Path, keys: &KeyFile) {
    for place in &keys.guessable {
        tracing::warn!(file = %path.display(), place, "this key is short enough to be guessed: `sketchmatch keys` makes better ones");
    }
}

fn read(path: &Path) -> Result<KeyFile, KeyFileError> {
    let mut text = String::new();
    File::open(path)
        .and_then(|file| file.take(LARGEST + 1).read_to_string(&mut text))
        .and_then(|length| if length as u64 > LARGEST { Err(io::ErrorKind::FileTooLarge.into()) } else { Ok(()) })
        .map_err(|source| KeyFileError::System { path: path.to_owned(), source })?;
    KeyFile::read(&text).map_err(|unreadable| KeyFileError::Content { path: path.to_owned(), unreadable })
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;
    use crate::access::Key;

    fn opens(file: &WatchedFile, key: &str) -> bool {
        file.grant(&key.parse::<Key>().unwrap().hash(), SystemTime::UNIX_EPOCH).is_some()
    }

    #[test]
    fn a_file_that_cannot_be_used_is_named_with_its_line() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("keys.txt");
        let refusal = |path: &Path| WatchedFile::open(path).unwrap_err().to_string();
        assert!(refusal(&path).contains("keys.txt"));
        for (text, said) in [("# nobody", "has no keys"), ("a\nb c", "keys.txt, line 2: "), ("\u{0}", "line 1")] {
            fs::write(&path, text).unwrap();
            assert!(refusal(&path).contains(said), "{}", refusal(&path));
        }
        fs::write(&path, b"\xff").unwrap();
        assert!(refusal(&path).contains("UTF-8"), "{}", refusal(&path));
        fs::write(&path, "a".repeat(2 << 20)).unwrap();
        assert!(refusal(&path).contains("too large"), "{}", refusal(&path));
        assert!(refusal(directory.path()).contains("directory"));
    }

    #[test]
    fn keys_come_and_go_with_the_file() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("keys.txt");
        fs::write(&path, "first").unwrap();
        let file = WatchedFile::open(&path).unwrap();
        let after = |text: &str| {
            fs::write(&path, text).unwrap();
            let looked = file.look().is_ok();
            (looked, ["first", "second"].map(|key| opens(&file, key)))
        };
        assert_eq!(after("first\nsecond"), (true, [true, true]));
        // What cannot be read changes nothing.
        assert_eq!(after("second\nno key"), (false, [true, true]));
        assert_eq!(after("second"), (true, [false, true]));
        assert_eq!(after(""), (true, [false, false]));
        assert_eq!(after("first"), (true, [true, false]));
        fs::remove_file(&path).unwrap();
        assert!(file.look().is_err() && opens(&file, "first"));
    }
}
