use std::path::PathBuf;

/// Why the store could not do what it was asked.
#[derive(Debug, thiserror::Error)]
pub enum StoreError {
    #[error("the data directory {} is in use by another process", data_dir.display())]
    Locked { data_dir: PathBuf },
    #[error("{} cannot be used: {source}", path.display())]
    Directory { path: PathBuf, source: std::io::Error },
    #[error("database: {0}")]
    Database(#[from] sqlx::Error),
    #[error("database migration: {0}")]
    Migration(#[from] sqlx::migrate::MigrateError),
    #[error("blobs: {0}")]
    Blob(#[from] object_store::Error),
    /// What was read is not what the store writes.
    #[error("{what} is damaged: {reason}")]
    Damaged { what: String, reason: String },
    /// The caller's mistake: `Page::after` is none of the cursors the store gave.
    #[error("no such cursor")]
    Cursor,
}

impl StoreError {
    pub(super) fn damaged(what: impl Into<String>, reason: impl ToString) -> StoreError {
        StoreError::Damaged { what: what.into(), reason: reason.to_string() }
    }
}
