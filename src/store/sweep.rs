//! What processes that died left behind.

use std::collections::BTreeSet;
use std::time::Duration;

use super::{Store, StoreError};

/// The folders of blobs in which every shape, job or cache has a folder of its own; tenants have such folders of their own.
const FOLDERS: [&str; 7] = ["shapes", "files", "results", "spectra", "preparations", "weights", "tenants"];

impl Store {
    /// Sets aside the blobs that were written so long ago and no row names: those of uploads and attempts that died between
    /// the blob and the row. Returns how many. Caches of shapes that are gone go, and folders that deletes have emptied. `age` is more than an upload or the
    /// report of a result takes, or nothing where nobody else is at work.
    ///
    /// # Errors
    /// What the database or the disk said.
    pub async fn sweep(&self, age: Duration) -> Result<usize, StoreError> {
        let mut swept = 0;
        for (folder, naming) in [
            ("shapes", "SELECT geometry_blob FROM shapes"),
            ("files", "SELECT file FROM shapes WHERE file IS NOT NULL"),
            ("results", "SELECT result FROM jobs WHERE result IS NOT NULL"),
        ] {
            // Names first, for a row may come while they are looked through.
            let blobs = self.blobs.names_older_than(folder, age).await?;
            let named = self.names_in(naming).await?;
            for name in blobs.iter().filter(|name| !named.contains(*name)) {
                self.blobs.set_aside(name).await?;
                swept += 1;
            }
        }
        self.free_caches_left().await?;
        for folder in FOLDERS {
            self.blobs.prune(folder, age).await?;
        }
        self.forget_checks(age).await?;
        Ok(swept)
    }

    async fn names_in(&self, sql: &'static str) -> Result<BTreeSet<String>, StoreError> {
        Ok(sqlx::query_scalar::<_, String>(sql).fetch_all(&self.pool).await?.into_iter().collect())
    }
}
