//! `Prefer: wait=N` (RFC 7240): how long a client is ready to wait for a finished answer.

use std::convert::Infallible;
use std::time::Duration;

use axum::extract::FromRequestParts;
use axum::http::request::Parts;
use axum::http::{HeaderMap, HeaderName};

const HEADER: HeaderName = HeaderName::from_static("prefer");
pub const PREFERENCE_APPLIED: HeaderName = HeaderName::from_static("preference-applied");

/// The longest wait granted.
pub const LONGEST_WAIT: Duration = Duration::from_secs(60);

/// The wait granted, in whole seconds; a preference that cannot be read is none, as the RFC has it.
#[derive(Debug, PartialEq, Eq)]
pub struct Wait(pub Option<u64>);

impl Wait {
    pub fn duration(&self) -> Option<Duration> {
        self.0.map(Duration::from_secs)
    }
}

impl<S: Send + Sync> FromRequestParts<S> for Wait {
    type Rejection = Infallible;

    async fn from_request_parts(parts: &mut Parts, _: &S) -> Result<Wait, Infallible> {
        Ok(wait(&parts.headers))
    }
}

fn wait(headers: &HeaderMap) -> Wait {
    let values = headers.get_all(HEADER).iter().filter_map(|value| value.to_str().ok());
    let mut preferences =
        values.flat_map(|value| value.split([',', ';'])).filter_map(|preference| preference.split_once('='));
    let seconds = preferences.find(|(name, _)| name.trim().eq_ignore_ascii_case("wait"));
    Wait(
        seconds
            .and_then(|(_, value)| value.trim().trim_matches('"').parse::<u64>().ok())
            .map(|n| n.min(LONGEST_WAIT.as_secs())),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reads_the_wait_among_other_preferences() {
        let with = |value: &'static str| wait(&HeaderMap::from_iter([(HEADER, value.parse().unwrap())])).0;
        assert_eq!(with("wait=5"), Some(5));
        assert_eq!(with("respond-async, Wait=10"), Some(10));
        assert_eq!(with("wait=3600"), Some(60));
        assert_eq!(with("wait=soon"), None);
        assert_eq!(with("handling=strict"), None);
    }
}
