//! Files the program writes to.

use std::fs::{self, File, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use anyhow::{Context, ensure};

/// A file that is to be written once there is something to write. It is opened before the work, so that nobody waits
/// for an answer that has nowhere to go, and keeps what it holds until then.
#[derive(Debug)]
pub struct Output {
    path: PathBuf,
    file: File,
    /// Whether it was made here: then it goes again where nothing is written.
    made: bool,
}

impl Output {
    /// The file at `path`, which is none of those `taken`.
    ///
    /// # Errors
    /// A file that cannot be opened for writing, or that is taken.
    pub fn open(path: &Path, taken: &[&Path]) -> anyhow::Result<Output> {
        let writing = || format!("writing {}", path.display());
        if let Ok(there) = fs::canonicalize(path) {
            let taken = taken.iter().any(|taken| fs::canonicalize(taken).is_ok_and(|taken| taken == there));
            ensure!(!taken, "{} is read or written already, another file is wanted", path.display());
        }
        let (file, made) = match File::create_new(path) {
            Ok(file) => (file, true),
            Err(_) => (OpenOptions::new().write(true).open(path).with_context(writing)?, false),
        };
        Ok(Output { path: path.to_owned(), file, made })
    }

    /// Replaces what the file holds.
    ///
    /// # Errors
    /// What the system says.
    pub fn write(mut self, bytes: &[u8]) -> anyhow::Result<()> {
        replace(&mut self.file, bytes).with_context(|| format!("writing {}", self.path.display()))?;
        self.made = false;
        Ok(())
    }
}

fn replace(file: &mut File, bytes: &[u8]) -> io::Result<()> {
    // A device or a pipe has no length.
    if file.metadata()?.is_file() {
        file.set_len(0)?;
    }
    file.write_all(bytes)
}

impl Drop for Output {
    fn drop(&mut self) {
        if self.made {
            // An empty file that stays does no harm.
            let _ = fs::remove_file(&self.path);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_holds_what_it_held_until_it_is_written() {
        let dir = tempfile::tempdir().unwrap();
        let (old, new) = (dir.path().join("old"), dir.path().join("new"));
        fs::write(&old, "a long text").unwrap();
        let outputs = [&old, &new].map(|path| Output::open(path, &[]).unwrap());
        assert!(new.exists());
        drop(outputs);
        assert_eq!((fs::read_to_string(&old).unwrap().as_str(), new.exists()), ("a long text", false));

        for path in [&old, &new] {
            Output::open(path, &[]).unwrap().write(b"short").unwrap();
            assert_eq!(fs::read_to_string(path).unwrap(), "short");
        }
    }

    #[test]
    fn devices_are_written_to() {
        Output::open(Path::new("/dev/null"), &[]).unwrap().write(b"gone").unwrap();
    }

    #[test]
    fn what_cannot_be_written_is_refused_at_once() {
        let dir = tempfile::tempdir().unwrap();
        let (input, missing) = (dir.path().join("mesh.obj"), dir.path().join("missing/result.json"));
        fs::write(&input, "v 0 0 0").unwrap();
        let refusal = |path: &Path| format!("{:#}", Output::open(path, &[&input]).unwrap_err());
        assert!(refusal(&input).contains("another file is wanted"));
        assert!(refusal(&missing).contains("writing"));
        assert!(refusal(dir.path()).contains("writing"));
        assert_eq!(fs::read_to_string(&input).unwrap(), "v 0 0 0");
    }
}
