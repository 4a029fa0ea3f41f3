//! Pages of other sites: the origins they may call from.
//!
//! A browser asks before a script sends what a form could not; of forms it asks nothing, and where no key is needed a page of any
//! site could have it upload files to a server on the same machine. It tells, though, that another site is behind it.

use std::str::FromStr;
use std::sync::Arc;
use std::time::Duration;

use axum::extract::{Request, State};
use axum::http::{HeaderMap, HeaderName, HeaderValue, Method, StatusCode, Uri, header};
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};
use tower_http::cors::{AllowHeaders, Any, CorsLayer};

use super::preference::PREFERENCE_APPLIED;
use super::problem::{Fault, Problem};

/// Where a browser says how far the page behind a request is from what it asks.
const SITE: HeaderName = HeaderName::from_static("sec-fetch-site");

/// How long a browser need not ask again whether a script may call.
const ALLOWED_FOR: Duration = Duration::from_secs(3600);

/// An origin as browsers write it, or any. It can only be built such that a browser can send it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Origin {
    Any,
    Of(HeaderValue),
}

/// A text that no browser sends as the origin of a script.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "an origin is * or scheme://host, in small letters, with a port that is not the usual one, and without a path{0}"
)]
pub struct NoOrigin(String);

impl FromStr for Origin {
    type Err = NoOrigin;

    fn from_str(text: &str) -> Result<Origin, NoOrigin> {
        if text == "*" {
            return Ok(Origin::Any);
        }
        let written = written(text);
        match (&written, HeaderValue::try_from(text)) {
            (Some(origin), Ok(value)) if origin == text => Ok(Origin::Of(value)),
            _ => Err(NoOrigin(written.map(|origin| format!(": {origin}")).unwrap_or_default())),
        }
    }
}

/// The origin of an address as browsers write it.
fn written(address: &str) -> Option<String> {
    let uri: Uri = address.parse().ok()?;
    let (scheme, authority) = (uri.scheme_str()?.to_ascii_lowercase(), uri.authority()?);
    let usual = match scheme.as_str() {
        "http" => Some(80),
        "https" => Some(443),
        _ => None,
    };
    let port = authority.port_u16().filter(|&port| Some(port) != usual).map(|port| format!(":{port}"));
    Some(format!("{scheme}://{}{}", authority.host().to_ascii_lowercase(), port.unwrap_or_default()))
}

/// The layer that lets scripts call from these origins.
pub fn layer(origins: &[Origin]) -> CorsLayer {
    let exposed = [header::ETAG, header::LOCATION, header::LINK, header::RETRY_AFTER, header::WWW_AUTHENTICATE];
    let exposed =
        exposed.into_iter().chain(["x-request-id", "ratelimit", "ratelimit-policy"].map(HeaderName::from_static));
    let exposed = exposed.chain([PREFERENCE_APPLIED]);
    // Those that are asked for, one by one: browsers do not take * to mean `Authorization`.
    let headers = AllowHeaders::mirror_request();
    let layer = CorsLayer::new().allow_methods(Any).allow_headers(headers).expose_headers(exposed.collect::<Vec<_>>());
    let layer = layer.max_age(ALLOWED_FOR);
    let listed = origins.iter().map(|origin| match origin {
        Origin::Any => None,
        Origin::Of(value) => Some(value.clone()),
    });
    match listed.collect::<Option<Vec<HeaderValue>>>() {
        Some(listed) => layer.allow_origin(listed),
        None => layer.allow_origin(Any),
    }
}

/// Lets a request through unless it would change something and comes from a page of another site that may not call.
pub async fn checked(State(origins): State<Arc<[Origin]>>, request: Request, next: Next) -> Response {
    if is_stray(&origins, request.method(), request.headers()) {
        let detail = "pages of other sites do not change anything here: --cors-origin names those that may";
        return Problem::of_fault(StatusCode::FORBIDDEN, Fault::in_header("origin", detail)).into_response();
    }
    next.run(request).await
}

fn is_stray(origins: &[Origin], method: &Method, headers: &HeaderMap) -> bool {
    let may_call = |origin: &Origin| match origin {
        Origin::Any => true,
        Origin::Of(value) => headers.get(header::ORIGIN) == Some(value),
    };
    let is_foreign = headers.get(SITE).is_some_and(|site| site == "cross-site");
    !method.is_safe() && is_foreign && !origins.iter().any(may_call)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pages_of_other_sites_change_nothing_unless_they_may_call() {
        let headers = |site: &'static str| {
            HeaderMap::from_iter([
                (SITE, HeaderValue::from_static(site)),
                (header::ORIGIN, HeaderValue::from_static("https://a.example")),
            ])
        };
        let [listed, other]: [Origin; 2] = ["https://a.example", "https://b.example"].map(|text| text.parse().unwrap());
        assert!(is_stray(&[], &Method::POST, &headers("cross-site")));
        assert!(is_stray(std::slice::from_ref(&other), &Method::DELETE, &headers("cross-site")));
        assert!(!is_stray(&[other, listed], &Method::POST, &headers("cross-site")));
        assert!(!is_stray(&[Origin::Any], &Method::POST, &headers("cross-site")));
        for (method, site) in [(Method::GET, "cross-site"), (Method::POST, "same-site"), (Method::POST, "same-origin")]
        {
            assert!(!is_stray(&[], &method, &headers(site)), "{method} {site}");
        }
        assert!(!is_stray(&[], &Method::POST, &HeaderMap::new()));
    }

    #[test]
    fn takes_what_browsers_send() {
        assert_eq!("*".parse(), Ok(Origin::Any));
        for text in ["https://a.example", "http://localhost:3000", "http://[::1]:8080", "chrome-extension://abcdef"] {
            assert_eq!(text.parse(), Ok(Origin::Of(HeaderValue::from_static(text))));
        }
    }

    #[test]
    fn names_the_origin_that_was_meant() {
        for (text, meant) in [
            ("https://a.example/", "https://a.example"),
            ("https://a.example/app", "https://a.example"),
            ("HTTPS://A.example", "https://a.example"),
            ("https://a.example:443", "https://a.example"),
            ("http://u@a.example:80", "http://a.example"),
        ] {
            assert_eq!(text.parse::<Origin>(), Err(NoOrigin(format!(": {meant}"))), "{text}");
        }
        for text in ["", "a.example", "null", "https://", "https://*.example.com extra"] {
            assert!(text.parse::<Origin>().is_err(), "{text}");
        }
    }
}
