use serde::de::IgnoredAny;
use sqlx::AnyPool;

use super::StoreError;
use super::blobs::Blobs;
use super::database::Engine;
use super::directory::Directory;

/// The first migration of a version that puts a checksum behind every blob.
const SEALED: i64 = 3;

/// The first migration of a version that knows for which shapes caches were made.
const CACHES_OF_SHAPES: i64 = 9;

/// Brings the tables of a file, and blobs of an earlier version, up to the present. Ended in the middle, it goes on at the next start.
///
/// # Errors
/// [`StoreError::Unnamed`] where there are blobs and the database has no tables; what the disk or the database said.
pub(super) async fn run(pool: &AnyPool, blobs: &Blobs, directory: &Directory) -> Result<(), StoreError> {
    let version = Engine::Sqlite.version(pool).await?;
    if version == 0 && blobs.any().await? {
        return Err(StoreError::Unnamed { data_dir: directory.path().to_owned() });
    }
    if (1..SEALED).contains(&version) {
        tracing::info!("checksums are put behind the blobs of the version before");
        seal(blobs).await?;
    }
    if (1..CACHES_OF_SHAPES).contains(&version) {
        // They would never be freed, and are computed anew.
        forget_caches(blobs).await?;
    }
    Engine::Sqlite.migrate(pool).await
}

/// Puts checksums behind what cannot be made anew.
async fn seal(blobs: &Blobs) -> Result<(), StoreError> {
    for name in blobs.names("shapes").await? {
        // Whether it is whole is told by its name when it is read.
        blobs.seal(&name, |_| true).await?;
    }
    for name in blobs.names("results").await? {
        blobs.seal(&name, |bytes| serde_json::from_slice::<IgnoredAny>(bytes).is_ok()).await?;
    }
    Ok(())
}

async fn forget_caches(blobs: &Blobs) -> Result<(), StoreError> {
    for folder in ["spectra", "preparations"] {
        for name in blobs.names(folder).await? {
            blobs.delete(&name).await?;
        }
    }
    Ok(())
}
