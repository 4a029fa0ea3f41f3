//! Where everything is kept, as it is told by addresses.

use std::fmt;
use std::path::PathBuf;
use std::str::FromStr;

use url::Url;

/// Where everything is kept.
#[derive(Clone, Debug)]
pub struct Config {
    /// Directory of the lock, the database (`sketchmatch.db`) and the blobs (`blobs/`), as far as these are not elsewhere;
    /// made when it is needed and missing.
    pub data_dir: PathBuf,
    /// The PostgreSQL database that many nodes share; without one, SQLite in the data directory, for one process.
    pub database_url: Option<DatabaseUrl>,
    /// Where blobs are instead of in the data directory.
    pub blob_url: Option<BlobUrl>,
}

impl Config {
    /// All of it in one directory, for one process.
    pub fn local(data_dir: impl Into<PathBuf>) -> Config {
        Config { data_dir: data_dir.into(), database_url: None, blob_url: None }
    }

    /// Where the blobs are.
    pub(super) fn blobs(&self) -> BlobUrl {
        self.blob_url.clone().unwrap_or_else(|| BlobUrl::Folder(self.data_dir.join("blobs")))
    }
}

/// The address of a PostgreSQL database. What is shown of it has no password.
#[derive(Clone, PartialEq, Eq)]
pub struct DatabaseUrl(Url);

impl FromStr for DatabaseUrl {
    type Err = String;

    fn from_str(text: &str) -> Result<DatabaseUrl, String> {
        let url = Url::parse(text).map_err(|error| error.to_string())?;
        match url.scheme() {
            "postgres" | "postgresql" => Ok(DatabaseUrl(url)),
            _ => {
                Err("an address that begins with postgres:// is wanted; without one the database is SQLite".to_owned())
            }
        }
    }
}

impl DatabaseUrl {
    /// The address for a program that calls itself `name` at the database.
    pub(super) fn called(&self, name: &str) -> String {
        let mut url = self.0.clone();
        url.query_pairs_mut().append_pair("application_name", name);
        url.into()
    }
}

/// Host and database: neither name, password nor what else may be in the address.
impl fmt::Display for DatabaseUrl {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let host = self.0.host_str().unwrap_or_default();
        write!(
            out,
            "postgres://{host}{}{}",
            self.0.port().map(|port| format!(":{port}")).unwrap_or_default(),
            self.0.path()
        )
    }
}

impl fmt::Debug for DatabaseUrl {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "{self}")
    }
}

/// The address of a place for blobs.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum BlobUrl {
    /// `file:///path`: a folder, which nodes may share.
    Folder(PathBuf),
    /// `s3://bucket/prefix`: a bucket of S3 or what speaks like it, and what all names begin with.
    Bucket { bucket: String, prefix: String },
}

impl FromStr for BlobUrl {
    type Err = String;

    fn from_str(text: &str) -> Result<BlobUrl, String> {
        let url = Url::parse(text).map_err(|error| error.to_string())?;
        match (url.scheme(), url.host_str()) {
            ("file", _) => {
                let folder = url.to_file_path().map_err(|()| "it names no folder of this machine".to_owned())?;
                Ok(BlobUrl::Folder(folder))
            }
            ("s3", Some(bucket)) if !bucket.is_empty() => {
                let prefix = url.path().trim_matches('/').to_owned();
                Ok(BlobUrl::Bucket { bucket: bucket.to_owned(), prefix })
            }
            _ => Err("an address such as s3://bucket/prefix or file:///folder is wanted".to_owned()),
        }
    }
}

impl fmt::Display for BlobUrl {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            BlobUrl::Folder(folder) => write!(out, "{}", folder.display()),
            BlobUrl::Bucket { bucket, prefix } if prefix.is_empty() => write!(out, "s3://{bucket}"),
            BlobUrl::Bucket { bucket, prefix } => write!(out, "s3://{bucket}/{prefix}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn databases_are_those_of_postgresql_and_keep_their_password_to_themselves() {
        let url: DatabaseUrl = "postgres://me:secret@db.example:5433/sketches?sslmode=require".parse().unwrap();
        assert_eq!(
            (url.to_string(), format!("{url:?}")),
            ("postgres://db.example:5433/sketches".into(), url.to_string())
        );
        let called = url.called("node 1");
        assert_eq!(
            called, "postgres://me:secret@db.example:5433/sketches?sslmode=require&application_name=node+1",
            "{called}"
        );
        for other in ["mysql://localhost/x", "sqlite://x", "postgres", ""] {
            assert!(other.parse::<DatabaseUrl>().is_err(), "{other}");
        }
    }

    #[test]
    fn blobs_are_in_folders_and_buckets() {
        let bucket =
            |bucket: &str, prefix: &str| BlobUrl::Bucket { bucket: bucket.to_owned(), prefix: prefix.to_owned() };
        for (text, place) in [
            ("file:///srv/a%20b", BlobUrl::Folder("/srv/a b".into())),
            ("s3://sketches", bucket("sketches", "")),
            ("s3://sketches/of/us/", bucket("sketches", "of/us")),
        ] {
            assert_eq!(text.parse(), Ok(place), "{text}");
        }
        for other in ["s3://", "s3:///x", "https://sketches/x", "blobs", "file://elsewhere/x", ""] {
            assert!(other.parse::<BlobUrl>().is_err(), "{other}");
        }
    }
}
