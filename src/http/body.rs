//! Bodies of requests: read within their limits, before anything is made of them.

use std::time::Duration;

use axum::body::Body;
use axum::extract::{FromRequest, Multipart, Request};
use axum::http::{HeaderMap, StatusCode, header};
use bytes::{Bytes, BytesMut};
use futures::StreamExt;
use tokio::sync::OwnedSemaphorePermit;

use super::App;
use super::problem::{Fault, Problem};

/// The media type of a form with files.
const MULTIPART: &str = "multipart/form-data";

/// How long a body may take to arrive.
const PATIENCE: Duration = Duration::from_secs(120);

/// Bytes per permit of the memory set aside for bodies.
pub const MEMORY_GRAIN: usize = 1024;

/// The body of a request with a media type of its own, wherever it stood: a raw body or the part `file` of a form.
pub struct Upload {
    pub bytes: Bytes,
    /// Lower case, without parameters.
    pub media_type: Option<String>,
    /// The name of the file, where a form gives one.
    pub file_name: Option<String>,
    /// The share of the memory for bodies this one takes until it is dropped.
    _memory: OwnedSemaphorePermit,
}

impl FromRequest<App> for Upload {
    type Rejection = Problem;

    async fn from_request(request: Request, app: &App) -> Result<Upload, Problem> {
        let limit = app.config.max_upload_bytes;
        let media_type = media_type(request.headers());
        if media_type.as_deref() == Some(MULTIPART) {
            return form(request, app, limit).await;
        }
        let limit = if media_type.as_deref().is_some_and(is_json) { app.config.max_request_bytes } else { limit };
        let (bytes, memory) = read(request, app, limit).await?;
        Ok(Upload { bytes, media_type, file_name: None, _memory: memory })
    }
}

/// A body that has to be `application/json`, unread.
pub struct JsonBody {
    pub bytes: Bytes,
    /// The share of the memory for bodies this one takes until it is dropped.
    _memory: OwnedSemaphorePermit,
}

impl FromRequest<App> for JsonBody {
    type Rejection = Problem;

    async fn from_request(request: Request, app: &App) -> Result<JsonBody, Problem> {
        match media_type(request.headers()) {
            Some(media_type) if is_json(&media_type) => {
                let (bytes, memory) = read(request, app, app.config.max_request_bytes).await?;
                Ok(JsonBody { bytes, _memory: memory })
            }
            _ => Err(unsupported("this call takes application/json")),
        }
    }
}

/// `application/json` and its kin.
pub fn is_json(media_type: &str) -> bool {
    media_type == "application/json" || (media_type.starts_with("application/") && media_type.ends_with("+json"))
}

/// 415, naming what would do.
pub fn unsupported(detail: impl Into<String>) -> Problem {
    Problem::of_fault(StatusCode::UNSUPPORTED_MEDIA_TYPE, Fault::in_header("content-type", detail))
}

/// The content type in lower case without its parameters.
fn media_type(headers: &HeaderMap) -> Option<String> {
    let value = headers.get(header::CONTENT_TYPE)?.to_str().ok()?;
    let essence = value.split(';').next()?.trim().to_ascii_lowercase();
    (!essence.is_empty()).then_some(essence)
}

/// The whole body, which is not empty, at most `limit` bytes of it. Memory is set aside for the length announced, or the limit, before any
/// is taken; the permit holds it.
async fn read(request: Request, app: &App, limit: usize) -> Result<(Bytes, OwnedSemaphorePermit), Problem> {
    let headers = request.headers();
    let mut codings = headers.get_all(header::CONTENT_ENCODING).iter();
    if codings.any(|coding| !coding.as_bytes().eq_ignore_ascii_case(b"identity")) {
        let fault = Fault::in_header("content-encoding", "bodies are taken uncompressed");
        return Err(Problem::of_fault(StatusCode::UNSUPPORTED_MEDIA_TYPE, fault));
    }
    let announced = headers.get(header::CONTENT_LENGTH).and_then(|value| value.to_str().ok()?.parse::<usize>().ok());
    let length = announced.unwrap_or(limit);
    if length > limit {
        return Err(Problem::too_large(limit));
    }
    let memory = app.memory_for(length)?;
    let body = tokio::time::timeout(PATIENCE, collected(request.into_body(), limit));
    let late = || Problem::new(StatusCode::REQUEST_TIMEOUT, "the body took too long to arrive");
    let bytes = body.await.map_err(|_| late())??;
    if bytes.is_empty() {
        return Err(Problem::malformed(Fault::at_place("body", "the body is empty")));
    }
    Ok((bytes, memory))
}

async fn collected(body: Body, limit: usize) -> Result<Bytes, Problem> {
    let mut chunks = body.into_data_stream();
    let mut bytes = BytesMut::new();
    while let Some(chunk) = chunks.next().await {
        let chunk = chunk.map_err(|_| Problem::malformed(Fault::at_place("body", "the body broke off")))?;
        if bytes.len() + chunk.len() > limit {
            return Err(Problem::too_large(limit));
        }
        bytes.extend_from_slice(&chunk);
    }
    Ok(bytes.freeze())
}

/// The part `file` of a form, the only part there may be.
async fn form(request: Request, app: &App, limit: usize) -> Result<Upload, Problem> {
    let content_type = request.headers().get(header::CONTENT_TYPE).cloned();
    let (bytes, memory) = read(request, app, limit).await?;
    let mut form = Request::new(Body::from(bytes));
    form.headers_mut().extend(content_type.map(|value| (header::CONTENT_TYPE, value)));
    let broken = |error: String| Problem::malformed(Fault::at_place("body", error));
    let mut form = Multipart::from_request(form, &()).await.map_err(|error| broken(error.body_text()))?;
    let mut file = None;
    while let Some(part) = form.next_field().await.map_err(|error| broken(error.body_text()))? {
        let name = part.name().unwrap_or_default().to_owned();
        if name != "file" || file.is_some() {
            let fault = Fault::at_place(format!("part {name}"), "the form has one part, named `file`");
            return Err(Problem::refused("the form is not acceptable", vec![fault]));
        }
        let file_name = part.file_name().map(str::to_owned);
        let media_type = media_type(part.headers());
        let bytes = part.bytes().await.map_err(|error| broken(error.body_text()))?;
        file = Some((bytes, media_type, file_name));
    }
    let (bytes, media_type, file_name) = file.ok_or_else(|| broken("the form has no part named `file`".to_owned()))?;
    Ok(Upload { bytes, media_type, file_name, _memory: memory })
}

#[cfg(test)]
mod tests {
    use metrics_exporter_prometheus::PrometheusBuilder;
    use tokio_util::sync::CancellationToken;

    use super::*;
    use crate::http::Config;
    use crate::store::testing::fresh;

    #[tokio::test]
    async fn a_json_body_takes_memory_until_it_is_dropped() {
        let (_directory, store) = fresh().await;
        let measures = PrometheusBuilder::new().build_recorder().handle();
        let app = App::new(store, Config::default(), measures, CancellationToken::new());
        let all = app.memory.available_permits();
        let length = 3 * MEMORY_GRAIN;
        let request = Request::builder().header("content-type", "application/json").header("content-length", length);
        let body = JsonBody::from_request(request.body(Body::from(vec![b' '; length])).unwrap(), &app).await;
        let body = body.ok().unwrap();
        assert_eq!((body.bytes.len(), app.memory.available_permits()), (length, all - 3));
        drop(body);
        assert_eq!(app.memory.available_permits(), all);
    }
}
