use std::sync::Arc;
use std::time::Duration;

use object_store::aws::{AmazonS3Builder, AmazonS3ConfigKey};
use object_store::prefix::PrefixStore;
use object_store::{ClientConfigKey, ObjectStore, RetryConfig};

use crate::store::StoreError;
use crate::tls;

/// How long a connection may take to be made.
const CONNECTING: &str = "5 seconds";

/// How long one request may take, its body included: the largest blobs are some hundred megabytes.
const LONGEST: &str = "120 seconds";

/// How long a request that failed in passing is repeated. Whoever has it longer without an answer hears of it: a client gets
/// 503, a job is tried again later.
const REPEATING: Duration = Duration::from_secs(10);

/// The objects of a bucket whose names begin with `prefix`. Keys, region and endpoint are read from the environment, from the
/// variables `AWS_…` that every program for S3 knows.
pub(super) fn objects(bucket: &str, prefix: &str) -> Result<Arc<dyn ObjectStore>, StoreError> {
    let retry = RetryConfig { retry_timeout: REPEATING, max_retries: 5, ..RetryConfig::default() };
    let builder = AmazonS3Builder::from_env()
        .with_config(AmazonS3ConfigKey::Client(ClientConfigKey::ConnectTimeout), CONNECTING)
        .with_config(AmazonS3ConfigKey::Client(ClientConfigKey::Timeout), LONGEST)
        .with_retry(retry)
        .with_bucket_name(bucket);
    tls::provide();
    let objects = builder.build()?;
    Ok(if prefix.is_empty() { Arc::new(objects) } else { Arc::new(PrefixStore::new(objects, prefix)) })
}
