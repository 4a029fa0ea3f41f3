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
    /// The geometry or the file of a shape is not as it was written; `shape` names the upload.
    #[error("{shape} is damaged: {reason}")]
    DamagedShape { shape: String, reason: String },
    /// The result of a job is not as it was written.
    #[error("the result of job {job} is lost: {reason}")]
    LostResult { job: String, reason: String },
    /// The caller's mistake: `Page::after` is none of the cursors the store gave.
    #[error("no such cursor")]
    Cursor,
}

impl StoreError {
    /// What to tell a client who can set it right.
    pub fn remedy(&self) -> Option<String> {
        match self {
            StoreError::DamagedShape { shape, .. } => {
                Some(format!("{shape} is damaged on the server's disk: upload the same file again, and it is mended"))
            }
            StoreError::LostResult { job, .. } => Some(format!(
                "the result of match {job} is lost, for it is damaged on the server's disk: ask for the match again"
            )),
            _ => None,
        }
    }

    pub(super) fn damaged(what: impl Into<String>, reason: impl ToString) -> StoreError {
        StoreError::Damaged { what: what.into(), reason: reason.to_string() }
    }
}
