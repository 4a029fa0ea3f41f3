//! Points in time as they are told.

use std::time::{Duration, UNIX_EPOCH};

/// Milliseconds since 1970 as RFC 3339 in UTC.
pub fn timestamp(milliseconds: i64) -> String {
    let since = Duration::from_millis(u64::try_from(milliseconds).unwrap_or(0));
    humantime::format_rfc3339_millis(UNIX_EPOCH + since).to_string()
}
