//! What is known of every request: its identifier, its trace, its log line and its metrics.

use std::sync::Arc;
use std::time::Instant;

use axum::extract::{MatchedPath, Request};
use axum::http::{HeaderMap, HeaderName, HeaderValue, Method};
use axum::middleware::Next;
use axum::response::Response;
use tracing::Instrument;
use uuid::Uuid;

use crate::traces;

const REQUEST_ID: HeaderName = HeaderName::from_static("x-request-id");
const TRACE_PARENT: HeaderName = HeaderName::from_static("traceparent");

/// The longest identifier taken over from a client.
const LONGEST_REQUEST_ID: usize = 128;

const REQUESTS: &str = "sketchmatch_http_requests_total";
const SECONDS: &str = "sketchmatch_http_request_seconds";

/// The trace that a request is part of, for what it asks for.
#[derive(Clone)]
pub(super) struct Trace(pub Arc<str>);

/// Says what is measured here.
pub(super) fn describe() {
    metrics::describe_counter!(REQUESTS, "Requests that were answered, by method, route and status.");
    metrics::describe_histogram!(SECONDS, "Seconds from the head of a request to its answer, by method and route.");
}

/// Answers with `X-Request-Id` (the client's, or a new one) and the client's `traceparent`, and logs and counts.
pub async fn observed(mut request: Request, next: Next) -> Response {
    let started = Instant::now();
    let request_id = request_id(request.headers());
    let trace = trace_parent(request.headers());
    let method = label(request.method());
    let route = request.extensions().get::<MatchedPath>().map_or("none", MatchedPath::as_str).to_owned();
    let parent = trace.as_ref().and_then(|value| value.to_str().ok());
    let span = tracing::info_span!(
        "request",
        method,
        path = request.uri().path(),
        request_id = request_id.to_str().unwrap_or_default(),
        trace = parent,
    );
    if let Some(parent) = parent {
        traces::join(&span, parent);
    }
    if let Some(within) = traces::of(&span).or_else(|| parent.map(str::to_owned)) {
        request.extensions_mut().insert(Trace(within.into()));
    }
    let mut response = next.run(request).instrument(span.clone()).await;
    let (status, seconds) = (response.status().as_u16(), started.elapsed().as_secs_f64());
    span.in_scope(|| tracing::info!(status, seconds, "answered"));
    let status = status.to_string();
    metrics::counter!(REQUESTS, "method" => method, "route" => route.clone(), "status" => status).increment(1);
    metrics::histogram!(SECONDS, "method" => method, "route" => route).record(seconds);
    response.headers_mut().insert(REQUEST_ID, request_id);
    response.headers_mut().extend(trace.map(|value| (TRACE_PARENT, value)));
    response
}

/// The method as it is counted and logged: what HTTP does not define has one name, for whoever asks may think of any number of
/// them, and every one that is counted is kept.
fn label(method: &Method) -> &'static str {
    match *method {
        Method::GET => "GET",
        Method::HEAD => "HEAD",
        Method::POST => "POST",
        Method::PUT => "PUT",
        Method::PATCH => "PATCH",
        Method::DELETE => "DELETE",
        Method::OPTIONS => "OPTIONS",
        Method::TRACE => "TRACE",
        Method::CONNECT => "CONNECT",
        _ => "other",
    }
}

fn request_id(headers: &HeaderMap) -> HeaderValue {
    let fits = |value: &&HeaderValue| {
        let length = value.len();
        (1..=LONGEST_REQUEST_ID).contains(&length) && value.as_bytes().iter().all(u8::is_ascii_graphic)
    };
    // Unwrap safety: a hyphenated UUID is ASCII, so the fallback is never taken.
    let new = || HeaderValue::try_from(Uuid::now_v7().to_string()).unwrap_or(HeaderValue::from_static("none"));
    headers.get(REQUEST_ID).filter(fits).cloned().unwrap_or_else(new)
}

/// The trace context of the client where it has the form of W3C Trace Context: four fields of hexadecimal digits.
fn trace_parent(headers: &HeaderMap) -> Option<HeaderValue> {
    let value = headers.get(TRACE_PARENT)?;
    let fields: Vec<&str> = value.to_str().ok()?.split('-').collect();
    let hexadecimal = |field: &&str| field.bytes().all(|byte| matches!(byte, b'0'..=b'9' | b'a'..=b'f'));
    let lengths: Vec<usize> = fields.iter().map(|field| field.len()).collect();
    (lengths == [2, 32, 16, 2] && fields.iter().all(hexadecimal)).then(|| value.clone())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn methods_that_clients_think_of_are_counted_as_one() {
        let invented = |name: &str| Method::from_bytes(name.as_bytes()).unwrap();
        assert_eq!((label(&invented("DELETE")), label(&Method::GET)), ("DELETE", "GET"));
        assert_eq!((label(&invented("A0001")), label(&invented("get"))), ("other", "other"));
    }

    #[test]
    fn takes_over_only_decent_identifiers() {
        let with = |value: &str| HeaderMap::from_iter([(REQUEST_ID, HeaderValue::try_from(value).unwrap())]);
        assert_eq!(request_id(&with("abc-1")), "abc-1");
        assert_ne!(request_id(&with("a b")), "a b");
        assert_ne!(request_id(&with(&"a".repeat(129))), "a".repeat(129).as_str());
        assert_ne!(request_id(&HeaderMap::new()), request_id(&HeaderMap::new()));
    }

    #[test]
    fn takes_over_only_well_formed_traces() {
        let with = |value: &'static str| HeaderMap::from_iter([(TRACE_PARENT, HeaderValue::from_static(value))]);
        let trace = "00-4bf92f3577b34da6a3ce929d0e0e4736-00f067aa0ba902b7-01";
        assert_eq!(trace_parent(&with(trace)).unwrap(), trace);
        assert_eq!(trace_parent(&with("00-4bf9-00f0-01")), None);
        assert_eq!(trace_parent(&with("00-4BF92F3577B34DA6A3CE929D0E0E4736-00f067aa0ba902b7-01")), None);
    }
}
