use std::error::Error;
use std::io;
use std::path::PathBuf;

/// Why the store could not do what it was asked.
#[derive(Debug, thiserror::Error)]
pub enum StoreError {
    #[error("the data directory {} is in use by another process", data_dir.display())]
    Locked { data_dir: PathBuf },
    #[error(
        "{} has blobs, but its database is missing or empty: put sketchmatch.db back, or move the blobs away to start anew",
        data_dir.display()
    )]
    Unnamed { data_dir: PathBuf },
    /// The tables are those of another version of this program, which is running.
    #[error("the server that has the data directory open is of another version than this program")]
    OtherVersion,
    /// Blobs and database were never used together: what one says of the other is not true.
    #[error("the blobs at {place} are those of another database")]
    Foreign { place: String },
    /// The database has blobs, and they are in another place.
    #[error(
        "the blobs of this database are not at {place}: name the place that they are at by --blob-url, the same for all nodes, \
         or restore them there"
    )]
    Elsewhere { place: String },
    /// What was there at the start is not there now.
    #[error("{} is away", path.display())]
    Away { path: PathBuf },
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
            StoreError::LostResult { job, .. } => {
                Some(format!("the result of {job} is lost, for it is damaged on the server's disk: ask for it again"))
            }
            _ => None,
        }
    }

    /// What the process lacks where the error is nobody's fault and may pass.
    pub fn lack(&self) -> Option<Lack> {
        match self {
            StoreError::Away { .. } => Some(Lack::Means),
            StoreError::Database(error) => of_database(error).or_else(|| of_causes(error)),
            StoreError::Blob(error) => of_blobs(error),
            StoreError::Directory { source, .. } => of_system(source),
            _ => None,
        }
    }

    pub(crate) fn damaged(what: impl Into<String>, reason: impl ToString) -> StoreError {
        StoreError::Damaged { what: what.into(), reason: reason.to_string() }
    }
}

/// What a process may lack for a time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Lack {
    /// Space on the disk.
    Space,
    /// Descriptors, memory, the directory itself, its turn at the database, the servers of database or blobs.
    Means,
}

/// By what the system said at the bottom of an error.
fn of_causes(error: &(dyn Error + 'static)) -> Option<Lack> {
    let mut cause = Some(error);
    while let Some(error) = cause {
        if let Some(lack) = error.downcast_ref().and_then(of_system) {
            return Some(lack);
        }
        cause = error.source();
    }
    None
}

fn of_system(error: &io::Error) -> Option<Lack> {
    let number = error.raw_os_error().map(rustix::io::Errno::from_raw_os_error);
    match (error.kind(), number) {
        (io::ErrorKind::StorageFull | io::ErrorKind::QuotaExceeded, _) => Some(Lack::Space),
        (io::ErrorKind::OutOfMemory, _) | (_, Some(rustix::io::Errno::MFILE | rustix::io::Errno::NFILE)) => {
            Some(Lack::Means)
        }
        _ => None,
    }
}

/// By what a server of blobs said: all it says of itself may be otherwise in a moment, its keys included.
fn of_blobs(error: &object_store::Error) -> Option<Lack> {
    use object_store::Error::{Generic, PermissionDenied, Unauthenticated};
    match error {
        PermissionDenied { .. } | Unauthenticated { .. } => Some(Lack::Means),
        Generic { store, .. } if *store == S3 => Some(Lack::Means),
        _ => of_causes(error),
    }
}

/// What `object_store` calls a bucket in its errors.
const S3: &str = "S3";

fn of_database(error: &sqlx::Error) -> Option<Lack> {
    match error {
        sqlx::Error::Io(_) | sqlx::Error::Tls(_) | sqlx::Error::Protocol(_) => Some(Lack::Means),
        sqlx::Error::PoolTimedOut | sqlx::Error::PoolClosed => Some(Lack::Means),
        sqlx::Error::Database(error) => {
            let code = error.code()?;
            if code.len() == SQLSTATE { of_postgres(&code) } else { of_sqlite(&code) }
        }
        _ => None,
    }
}

/// Characters of a SQLSTATE, by which it is told from SQLite's numbers.
const SQLSTATE: usize = 5;

/// By the class of a SQLSTATE, <https://www.postgresql.org/docs/current/errcodes-appendix.html>.
fn of_postgres(code: &str) -> Option<Lack> {
    const DISK_FULL: &str = "53100";
    const READ_ONLY: &str = "25006";
    match code {
        DISK_FULL => Some(Lack::Space),
        READ_ONLY => Some(Lack::Means),
        // Connections, deadlocks, resources, the operator's intervention, the system.
        _ => matches!(&code[..2], "08" | "40" | "53" | "57" | "58").then_some(Lack::Means),
    }
}

/// By SQLite's primary result codes, <https://sqlite.org/rescode.html>.
fn of_sqlite(code: &str) -> Option<Lack> {
    const BUSY: i32 = 5;
    const LOCKED: i32 = 6;
    const OUT_OF_MEMORY: i32 = 7;
    const READ_ONLY: i32 = 8;
    const FULL: i32 = 13;
    const CANNOT_OPEN: i32 = 14;
    match code.parse::<i32>().ok()? & 0xff {
        FULL => Some(Lack::Space),
        BUSY | LOCKED | OUT_OF_MEMORY | READ_ONLY | CANNOT_OPEN => Some(Lack::Means),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use std::fs;
    use std::io::Write;

    use super::*;

    #[test]
    fn what_the_process_lacks_is_told_from_what_is_broken() {
        let full = fs::File::options().write(true).open("/dev/full").unwrap().write_all(b"x").unwrap_err();
        let blob = |source: io::Error| {
            StoreError::Blob(object_store::Error::Generic { store: "blobs", source: Box::new(source) })
        };
        assert_eq!(blob(full).lack(), Some(Lack::Space));
        let none_left = || io::Error::from_raw_os_error(rustix::io::Errno::MFILE.raw_os_error());
        assert_eq!(blob(none_left()).lack(), Some(Lack::Means));
        assert_eq!(StoreError::Database(sqlx::Error::Io(none_left())).lack(), Some(Lack::Means));
        assert_eq!(StoreError::Database(sqlx::Error::PoolTimedOut).lack(), Some(Lack::Means));
        assert_eq!(blob(io::ErrorKind::InvalidData.into()).lack(), None);
        assert_eq!(StoreError::damaged("a blob", "cut short").lack(), None);
    }

    #[test]
    fn servers_that_are_away_are_told_from_what_they_refuse() {
        let of_bucket = |store| StoreError::Blob(object_store::Error::Generic { store, source: "503".into() });
        assert_eq!((of_bucket(S3).lack(), of_bucket("LocalFileSystem").lack()), (Some(Lack::Means), None));
        let answers = ["53100", "25006", "57P01", "08006", "40001", "53300", "23505", "42601"].map(of_postgres);
        let means = Some(Lack::Means);
        assert_eq!(answers, [Some(Lack::Space), means, means, means, means, means, None, None]);
    }

    #[tokio::test]
    async fn a_database_that_may_not_grow_lacks_space() {
        let (_directory, store) = crate::store::testing::fresh().await;
        let mut connection = store.pool.acquire().await.unwrap();
        sqlx::query("PRAGMA max_page_count = 1").execute(&mut *connection).await.unwrap();
        let insert = "INSERT INTO shapes (id, kind, body, created_ms) VALUES ('mesh', 'mesh', $1, 0)";
        let error = sqlx::query(insert).bind("x".repeat(1 << 20)).execute(&mut *connection).await.unwrap_err();
        assert_eq!(StoreError::from(error).lack(), Some(Lack::Space));
    }
}
