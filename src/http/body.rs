//! Bodies of requests: read within their limits, before anything is made of them.

use std::time::Duration;

use axum::body::{Body, BodyDataStream};
use axum::extract::{DefaultBodyLimit, FromRequest, Multipart, Request};
use axum::http::{HeaderMap, StatusCode, header};
use bytes::Bytes;
use futures::StreamExt;
use tokio::sync::OwnedSemaphorePermit;
use tokio::time::timeout;

use super::problem::{Fault, Problem};
use super::{App, Service};
use crate::intake::Untaken;
use crate::intake::json::is_json;

/// The media type of a form without files.
const URL_ENCODED: &str = "application/x-www-form-urlencoded";

/// The media type of a form with files.
const MULTIPART: &str = "multipart/form-data";

/// Bytes per permit of the memory set aside for bodies.
pub const MEMORY_GRAIN: usize = 1024;

/// The body of a request with a media type of its own, wherever it stood: a raw body or the part `file` of a form.
pub struct Upload {
    pub bytes: Bytes,
    /// Lower case, without parameters.
    pub media_type: Option<String>,
    /// The name of the file without its folders, where a form gives one.
    pub file_name: Option<String>,
    /// The share of the memory for bodies this one takes until it is dropped.
    _memory: OwnedSemaphorePermit,
}

impl Upload {
    /// Why it is not taken, with the reason that is likeliest where it came as a form and is one line: so `curl -d` sends a file.
    pub fn untaken(&self, mut untaken: Untaken) -> Untaken {
        if self.media_type.as_deref() == Some(URL_ENCODED) && !self.bytes.contains(&b'\n') {
            let detail = "`curl -d` takes the ends of lines out of a file: send it by `--data-binary`";
            untaken.faults.push(Fault::in_header("content-type", detail));
        }
        untaken
    }
}

impl FromRequest<Service> for Upload {
    type Rejection = Problem;

    async fn from_request(request: Request, Service(app): &Service) -> Result<Upload, Problem> {
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

impl FromRequest<Service> for JsonBody {
    type Rejection = Problem;

    async fn from_request(request: Request, Service(app): &Service) -> Result<JsonBody, Problem> {
        match media_type(request.headers()) {
            Some(media_type) if is_json(&media_type) => {
                let (bytes, memory) = read(request, app, app.config.max_request_bytes).await?;
                Ok(JsonBody { bytes, _memory: memory })
            }
            _ => Err(Problem::unsupported("this call takes application/json")),
        }
    }
}

/// The content type in lower case without its parameters.
fn media_type(headers: &HeaderMap) -> Option<String> {
    let value = headers.get(header::CONTENT_TYPE)?.to_str().ok()?;
    let essence = value.split(';').next()?.trim().to_ascii_lowercase();
    (!essence.is_empty()).then_some(essence)
}

/// The whole body, which is not empty, at most `limit` bytes of it. The permit holds the memory it takes.
async fn read(request: Request, app: &App, limit: usize) -> Result<(Bytes, OwnedSemaphorePermit), Problem> {
    let headers = request.headers();
    let mut codings = headers.get_all(header::CONTENT_ENCODING).iter();
    if codings.any(|coding| !coding.as_bytes().eq_ignore_ascii_case(b"identity")) {
        return Err(Problem::encoded());
    }
    let announced = headers.get(header::CONTENT_LENGTH).and_then(|value| value.to_str().ok()?.parse::<usize>().ok());
    if announced.is_some_and(|length| length > limit) {
        return Err(Problem::too_large(limit));
    }
    let (bytes, memory) = collected(request.into_body(), app, limit).await?;
    if bytes.is_empty() {
        return Err(Problem::malformed(Fault::at_place("body", "the body is empty")));
    }
    Ok((bytes, memory))
}

/// The body and a hold on its memory, both growing as it arrives: what was announced and never comes keeps nobody out.
async fn collected(body: Body, app: &App, limit: usize) -> Result<(Bytes, OwnedSemaphorePermit), Problem> {
    let mut chunks = body.into_data_stream();
    let (mut bytes, mut memory) = (Vec::new(), app.memory_for(0)?);
    while let Some(chunk) = next(&mut chunks, app.config.idle_timeout).await? {
        let length = bytes.len() + chunk.len();
        if length > limit {
            return Err(Problem::too_large(limit));
        }
        if length > bytes.capacity() {
            let room = (2 * bytes.capacity()).clamp(length, limit);
            app.enlarge(&mut memory, room)?;
            bytes.reserve_exact(room - bytes.len());
        }
        bytes.extend_from_slice(&chunk);
    }
    Ok((bytes.into(), memory))
}

/// The next piece of a body, for which the client may take as long as `patience`; nothing at its end.
async fn next(chunks: &mut BodyDataStream, patience: Duration) -> Result<Option<Bytes>, Problem> {
    let chunk = timeout(patience, chunks.next()).await;
    let chunk =
        chunk.map_err(|_| Problem::new(StatusCode::REQUEST_TIMEOUT, "nothing of the body came for too long"))?;
    chunk.transpose().map_err(|_| Problem::malformed(Fault::at_place("body", "the body broke off")))
}

/// The part `file` of a form, the only part there may be.
async fn form(request: Request, app: &App, limit: usize) -> Result<Upload, Problem> {
    let content_type = request.headers().get(header::CONTENT_TYPE).cloned();
    let (bytes, mut memory) = read(request, app, limit).await?;
    // The part is taken out by copying it.
    app.enlarge(&mut memory, 2 * bytes.len())?;
    let mut form = Request::new(Body::from(bytes));
    form.headers_mut().extend(content_type.map(|value| (header::CONTENT_TYPE, value)));
    // The limit has been kept; the extractor's own is 2 MB.
    DefaultBodyLimit::disable().apply(&mut form);
    let broken = |error: String| Problem::malformed(Fault::at_place("body", error));
    let mut form = Multipart::from_request(form, &()).await.map_err(|error| broken(error.body_text()))?;
    let mut file = None;
    while let Some(part) = form.next_field().await.map_err(|error| broken(error.body_text()))? {
        let name = part.name().unwrap_or_default().to_owned();
        if name != "file" || file.is_some() {
            let fault = Fault::at_place(format!("part {name}"), "the form has one part, named `file`");
            return Err(Problem::refused("the form is not acceptable", vec![fault]));
        }
        // Some clients send where the file lies, of which nobody else needs to know.
        let file_name = part.file_name().and_then(|path| path.rsplit(['/', '\\']).next());
        let file_name = file_name.filter(|name| !name.is_empty()).map(str::to_owned);
        let media_type = media_type(part.headers());
        let bytes = part.bytes().await.map_err(|error| broken(error.body_text()))?;
        file = Some((bytes, media_type, file_name));
    }
    let (bytes, media_type, file_name) = file.ok_or_else(|| broken("the form has no part named `file`".to_owned()))?;
    Ok(Upload { bytes, media_type, file_name, _memory: memory })
}

#[cfg(test)]
mod tests {
    use std::io;

    use super::*;
    use crate::http::Config;
    use crate::http::testing::app;
    use crate::store::testing::fresh;

    #[tokio::test]
    async fn a_body_takes_as_much_memory_as_has_arrived() {
        let (_directory, store) = fresh().await;
        let config = Config { max_upload_bytes: 10_000, max_uploads_bytes: 20_480, ..Config::default() };
        let app = app(store, config);
        let service = Service(app.clone());
        let pieces = |length: usize| {
            let pieces: Vec<_> =
                vec![b'#'; length].chunks(700).map(|piece| Ok::<_, io::Error>(piece.to_vec())).collect();
            Request::new(Body::from_stream(futures::stream::iter(pieces)))
        };
        let first = Upload::from_request(pieces(10_000), &service).await.ok().unwrap();
        assert_eq!((first.bytes.len(), app.memory.available_permits()), (10_000, 10));
        let second = Upload::from_request(pieces(9_000), &service).await.ok().unwrap();
        assert_eq!(Upload::from_request(pieces(700), &service).await.err().unwrap().status, 503);
        drop((first, second));
        assert_eq!(Upload::from_request(pieces(10_001), &service).await.err().unwrap().status, 413);
        assert_eq!(app.memory.available_permits(), 20);
    }

    #[tokio::test]
    async fn a_json_body_takes_memory_until_it_is_dropped() {
        let (_directory, store) = fresh().await;
        let app = app(store, Config::default());
        let service = Service(app.clone());
        let all = app.memory.available_permits();
        let length = 3 * MEMORY_GRAIN;
        let request = Request::builder().header("content-type", "application/json").header("content-length", length);
        let body = JsonBody::from_request(request.body(Body::from(vec![b' '; length])).unwrap(), &service).await;
        let body = body.ok().unwrap();
        assert_eq!((body.bytes.len(), app.memory.available_permits()), (length, all - 3));
        drop(body);
        assert_eq!(app.memory.available_permits(), all);
    }
}
