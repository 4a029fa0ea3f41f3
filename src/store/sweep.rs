//! What processes that died left behind.

use std::collections::BTreeSet;

use super::geometry;
use super::{Store, StoreError};

impl Store {
    /// Sets aside the blobs that no row names: those of uploads and attempts that died between the blob and the row.
    pub(super) async fn sweep(&self) -> Result<(), StoreError> {
        let geometries = self.names_in("SELECT DISTINCT geometry FROM shapes").await?;
        let geometries = geometries.iter().map(|name| geometry::blob(name)).collect();
        let files = self.names_in("SELECT DISTINCT file FROM shapes WHERE file IS NOT NULL").await?;
        let results = self.names_in("SELECT result FROM jobs WHERE result IS NOT NULL").await?;
        for (folder, named) in [("shapes", geometries), ("files", files), ("results", results)] {
            for name in self.blobs.names(folder).await? {
                if !named.contains(&name) {
                    self.blobs.set_aside(&name).await?;
                }
            }
        }
        self.forget_checks().await
    }

    async fn names_in(&self, sql: &'static str) -> Result<BTreeSet<String>, StoreError> {
        Ok(sqlx::query_scalar::<_, String>(sql).fetch_all(&self.pool).await?.into_iter().collect())
    }
}
