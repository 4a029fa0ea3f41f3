//! Everything that can go wrong, as problem details (RFC 9457).

use std::any::Any;
use std::borrow::Cow;

use axum::body::to_bytes;
use axum::http::{HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Response};
use serde::Serialize;
use serde_json::Value;
use utoipa::ToSchema;

pub use crate::intake::Fault;
use crate::intake::{Cause, Untaken};
use crate::store::{Lack, StoreError};

/// Media type of every error.
pub const MEDIA_TYPE: &str = "application/problem+json";

/// The longest explanation taken over from a plain-text error of the framework.
const LONGEST_PLAIN_ERROR: usize = 4096;

/// Problem details: why a request was not carried out, and every place in it that is to blame.
#[derive(Clone, Debug, Serialize, ToSchema)]
pub struct Problem {
    /// `about:blank`: the title says all there is to the type.
    #[serde(rename = "type")]
    #[schema(value_type = String)]
    pub kind: Cow<'static, str>,
    /// The phrase of the status.
    #[schema(value_type = String)]
    pub title: Cow<'static, str>,
    /// The status of the answer.
    pub status: u16,
    /// What happened here.
    pub detail: String,
    /// Every fault found, with its place.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    #[schema(required = false)]
    pub errors: Vec<Fault>,
    #[serde(skip)]
    pub(super) retry_after: Option<u32>,
    /// Whether how the body is encoded is to blame.
    #[serde(skip)]
    pub(super) of_encoding: bool,
}

impl Problem {
    /// A problem of one status that names no place.
    pub fn new(status: StatusCode, detail: impl Into<String>) -> Problem {
        Problem {
            kind: Cow::Borrowed("about:blank"),
            title: Cow::Borrowed(status.canonical_reason().unwrap_or("Unknown Status")),
            status: status.as_u16(),
            detail: detail.into(),
            errors: Vec::new(),
            retry_after: None,
            of_encoding: false,
        }
    }

    /// 422: understood, but not acceptable.
    pub fn refused(detail: impl Into<String>, errors: Vec<Fault>) -> Problem {
        Problem { errors, ..Problem::new(StatusCode::UNPROCESSABLE_ENTITY, detail) }
    }

    /// A problem of one status and one fault.
    pub fn of_fault(status: StatusCode, fault: Fault) -> Problem {
        Problem { errors: vec![fault.clone()], ..Problem::new(status, fault.detail) }
    }

    /// 400: not understood.
    pub fn malformed(fault: Fault) -> Problem {
        Problem::of_fault(StatusCode::BAD_REQUEST, fault)
    }

    /// 404: no resource of this name; `what` is a noun phrase such as "mesh m".
    pub fn not_found(what: impl std::fmt::Display) -> Problem {
        Problem::new(StatusCode::NOT_FOUND, format!("there is no {what}"))
    }

    /// 415: of a kind that is not understood; says what would do.
    pub fn unsupported(detail: impl Into<String>) -> Problem {
        Problem::of_fault(StatusCode::UNSUPPORTED_MEDIA_TYPE, Fault::in_header("content-type", detail))
    }

    /// 415: encoded in a way that is not read.
    pub fn encoded() -> Problem {
        let fault = Fault::in_header("content-encoding", "bodies are taken uncompressed");
        let problem = Problem::of_fault(StatusCode::UNSUPPORTED_MEDIA_TYPE, fault);
        Problem { of_encoding: true, ..problem }
    }

    /// 404: the resource is there, and what the query asks of it is not; `fault` tells what there is.
    pub fn not_there(detail: impl Into<String>, fault: Fault) -> Problem {
        Problem { errors: vec![fault], ..Problem::new(StatusCode::NOT_FOUND, detail) }
    }

    /// 413: the body has more than `limit` bytes.
    pub fn too_large(limit: usize) -> Problem {
        Problem::new(StatusCode::PAYLOAD_TOO_LARGE, format!("the body is larger than the {limit} bytes allowed here"))
    }

    /// 429: the tenant has taken what it may; come back in `seconds`.
    pub fn too_many(detail: impl Into<String>, seconds: u32) -> Problem {
        Problem { retry_after: Some(seconds), ..Problem::new(StatusCode::TOO_MANY_REQUESTS, detail) }
    }

    /// 503: come back in `seconds`.
    pub fn busy(detail: impl Into<String>, seconds: u32) -> Problem {
        Problem { retry_after: Some(seconds), ..Problem::new(StatusCode::SERVICE_UNAVAILABLE, detail) }
    }

    /// 507 or 503: the server lacks what it takes, for now; `error` is for the log.
    pub fn lacking(lack: Lack, error: impl std::fmt::Display) -> Problem {
        tracing::error!(%error, "the server lacks what it takes");
        match lack {
            Lack::Space => Problem::new(StatusCode::INSUFFICIENT_STORAGE, "the disk of the server is full"),
            Lack::Means => Problem::busy("the server cannot use its store now", 5),
        }
    }

    /// 500: the fault is ours; what is known of it goes to the log, not to the client.
    pub fn internal(error: impl std::fmt::Display) -> Problem {
        tracing::error!(%error, "internal error");
        Problem::new(StatusCode::INTERNAL_SERVER_ERROR, "the server failed; the request identifier finds it in the log")
    }

    /// The same problem, to be asked again in `seconds`.
    pub fn retry_after(self, seconds: u32) -> Problem {
        Problem { retry_after: Some(seconds), ..self }
    }

    /// The problem a job that failed left behind.
    pub fn of_job(error: Option<&Value>) -> Problem {
        let text = |field: &str| error.and_then(|error| error.get(field)?.as_str()).map(str::to_owned);
        let status = error.and_then(|error| error.get("status")?.as_u64());
        let status = status.and_then(|status| StatusCode::from_u16(u16::try_from(status).ok()?).ok());
        let problem = Problem::new(
            status.unwrap_or(StatusCode::INTERNAL_SERVER_ERROR),
            text("detail").unwrap_or_else(|| "the computation failed".to_owned()),
        );
        let errors = error.and_then(|error| serde_json::from_value(error.get("errors")?.clone()).ok());
        Problem {
            kind: text("type").map_or(problem.kind, Cow::Owned),
            title: text("title").map_or(problem.title, Cow::Owned),
            errors: errors.unwrap_or_default(),
            ..problem
        }
    }

    /// The answer for a handler that panicked.
    pub fn of_panic(panic: Box<dyn Any + Send + 'static>) -> Response {
        let message = panic.downcast_ref::<String>().map(String::as_str);
        let message = message.or_else(|| panic.downcast_ref::<&str>().copied()).unwrap_or("no message");
        Problem::internal(format_args!("panic: {message}")).into_response()
    }
}

impl From<Untaken> for Problem {
    fn from(Untaken { cause, detail, faults }: Untaken) -> Problem {
        let of_status = |status| Problem { errors: faults.clone(), ..Problem::new(status, &detail) };
        match cause {
            Cause::Unsupported => {
                let problem = Problem::unsupported(detail);
                Problem { errors: problem.errors.into_iter().chain(faults).collect(), ..problem }
            }
            Cause::TooLarge => of_status(StatusCode::PAYLOAD_TOO_LARGE),
            Cause::Malformed => of_status(StatusCode::BAD_REQUEST),
            Cause::Unacceptable => of_status(StatusCode::UNPROCESSABLE_ENTITY),
            Cause::Failed => Problem::internal(detail),
        }
    }
}

impl From<StoreError> for Problem {
    fn from(error: StoreError) -> Problem {
        match (error.remedy(), error.lack()) {
            (Some(remedy), _) => Problem { detail: remedy, ..Problem::internal(error) },
            (None, Some(lack)) => Problem::lacking(lack, error),
            (None, None) => Problem::internal(error),
        }
    }
}

impl IntoResponse for Problem {
    fn into_response(self) -> Response {
        let status = StatusCode::from_u16(self.status).unwrap_or(StatusCode::INTERNAL_SERVER_ERROR);
        let (retry_after, of_encoding) = (self.retry_after, self.of_encoding);
        let mut response = (status, axum::Json(self)).into_response();
        response.headers_mut().insert(header::CONTENT_TYPE, HeaderValue::from_static(MEDIA_TYPE));
        if let Some(seconds) = retry_after {
            response.headers_mut().insert(header::RETRY_AFTER, HeaderValue::from(seconds));
        }
        if of_encoding {
            response.headers_mut().insert(header::ACCEPT_ENCODING, HeaderValue::from_static("identity"));
        }
        response
    }
}

/// An error the framework answered by itself (no such route, no such method), dressed as a problem; its headers stay.
pub async fn dressed(response: Response) -> Response {
    let status = response.status();
    let content_type = response.headers().get(header::CONTENT_TYPE);
    let is_problem = content_type.is_some_and(|value| value == MEDIA_TYPE);
    if is_problem || !(status.is_client_error() || status.is_server_error()) {
        return response;
    }
    let (mut parts, body) = response.into_parts();
    let text = to_bytes(body, LONGEST_PLAIN_ERROR).await.unwrap_or_default();
    let detail = match std::str::from_utf8(&text) {
        Ok(text) if !text.is_empty() => text.to_owned(),
        _ => described(status).to_owned(),
    };
    let (problem, body) = Problem::new(status, detail).into_response().into_parts();
    parts.headers.remove(header::CONTENT_LENGTH);
    parts.headers.extend(problem.headers);
    Response::from_parts(parts, body)
}

/// What a bare status of the framework means here.
fn described(status: StatusCode) -> &'static str {
    match status {
        StatusCode::NOT_FOUND => "there is nothing at this path",
        StatusCode::METHOD_NOT_ALLOWED => "this path does not know the method; the Allow header names those it knows",
        StatusCode::SERVICE_UNAVAILABLE => "the request took longer than a request may",
        _ => "the request was not carried out",
    }
}
