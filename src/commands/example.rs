//! `sketchmatch example`: the example creatures, written to files.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::Context;
use clap::Args;

use super::printed;
use sketchmatch::example;

#[derive(Debug, Args)]
pub struct ExampleOptions {
    /// Directory to write to; made where it is missing.
    dir: PathBuf,
    /// Vertices of each creature's mesh, about: 2000 to 100000.
    #[arg(long, env = "SKETCHMATCH_VERTICES", default_value_t = example::VERTICES, value_parser = vertices)]
    vertices: usize,
}

pub(super) fn vertices(text: &str) -> Result<usize, String> {
    let vertices = text.parse().map_err(|error| format!("{error}"))?;
    let (least, most) = example::SIZES.into_inner();
    if (least..=most).contains(&vertices) { Ok(vertices) } else { Err(format!("from {least} to {most}")) }
}

/// Writes the example creatures under a directory and prints the names of the files.
///
/// # Errors
/// A file that cannot be written.
pub fn run(options: &ExampleOptions) -> anyhow::Result<()> {
    write(&options.dir, options.vertices)?.iter().try_for_each(|path| printed(&path.display().to_string()))
}

/// Writes the creatures of so many vertices under a directory; the files that were written.
///
/// # Errors
/// A file that cannot be written.
pub(super) fn write(dir: &Path, vertices: usize) -> anyhow::Result<Vec<PathBuf>> {
    let mut paths = Vec::new();
    for (name, bytes) in example::files(vertices)? {
        let path = dir.join(name);
        let dir = path.parent().unwrap_or(dir);
        fs::create_dir_all(dir).with_context(|| format!("making the directory {}", dir.display()))?;
        fs::write(&path, bytes).with_context(|| format!("writing {}", path.display()))?;
        paths.push(path);
    }
    Ok(paths)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn creatures_are_asked_for_in_sizes_they_come_in() {
        assert_eq!((vertices("2000"), vertices("100000")), (Ok(2000), Ok(100_000)));
        for vertices in ["1999", "100001", "many"].map(vertices) {
            assert!(vertices.is_err());
        }
    }
}
