//! Which form of a resource a client wants, and whether it has it already.

use std::fmt::Display;
use std::future::Future;

use axum::extract::Request;
use axum::http::{HeaderMap, HeaderName, HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Response};
use bytes::Bytes;

use super::App;
use super::problem::{Fault, Problem};
use super::turns::Line;

/// What the compressing layer leaves behind in the name of a compressed body.
const COMPRESSED: &str = "gzip";

/// The form in which a client wants a resource, and what it has of it.
pub struct Wanted {
    media_type: &'static str,
    headers: HeaderMap,
    /// The entity tag, where it is known before the body is made.
    tag: Option<String>,
    keep: Keep,
    /// How long it takes to make the body.
    line: Line,
}

/// What is said of keeping a body.
#[derive(Clone, Copy)]
enum Keep {
    /// It is the same for ever.
    Forever,
    /// Another follows it.
    Never,
}

impl Wanted {
    /// As `media_type`, whatever the `Accept` header says.
    pub fn named(headers: HeaderMap, media_type: &'static str) -> Wanted {
        Wanted { media_type, headers, tag: None, keep: Keep::Forever, line: Line::Short }
    }

    /// As that of the media types `offered`, best first, which the `Accept` header likes best.
    ///
    /// # Errors
    /// 406 where it likes none.
    pub fn negotiated(headers: HeaderMap, offered: &[&'static str]) -> Result<Wanted, Problem> {
        let media_type = negotiated(&headers, offered)?;
        Ok(Wanted::named(headers, media_type))
    }

    /// The same of what another follows: not to be kept.
    pub fn passing(self) -> Wanted {
        Wanted { keep: Keep::Never, ..self }
    }

    /// The same of what may take tens of seconds to make.
    pub fn at_length(self) -> Wanted {
        Wanted { line: Line::Long, ..self }
    }

    pub fn media_type(&self) -> &'static str {
        self.media_type
    }

    /// The same of what is made of nothing but `source`, the form and `how`: its tag is known before it is made.
    ///
    /// # Errors
    /// 500 where no thread has been had to hash the source.
    async fn made_of(self, app: &App, source: Bytes, how: String) -> Result<Wanted, Problem> {
        let media_type = self.media_type;
        let hashed = app.off_runtime(move || {
            let mut hasher = blake3::Hasher::new();
            // Another version of the program may make something else of it.
            for part in [&source, env!("CARGO_PKG_VERSION").as_bytes(), media_type.as_bytes(), how.as_bytes()] {
                hasher.update(&(part.len() as u64).to_le_bytes()).update(part);
            }
            hasher.finalize()
        });
        Ok(Wanted { tag: Some(tag_of(hashed.await?)), ..self })
    }

    /// 304 where the client is known to have it before it is made.
    fn unchanged(&self) -> Option<Response> {
        let tag = self.tag.as_ref().filter(|tag| has(&self.headers, tag))?;
        Some((StatusCode::NOT_MODIFIED, said_of(tag, self.keep)).into_response())
    }

    /// The answer with the body that `write` makes in this form, off the threads that answer requests; 304 where the
    /// client has it.
    ///
    /// # Errors
    /// 500 where `write` fails.
    pub async fn answer<E: Display + Send + 'static>(
        self,
        app: &App,
        write: impl FnOnce(&'static str) -> Result<Bytes, E> + Send + 'static,
    ) -> Result<Response, Problem> {
        if let Some(unchanged) = self.unchanged() {
            return Ok(unchanged);
        }
        let written = app.in_line(self.line, move || write(self.media_type).map(|body| self.tagged(body)));
        written.await?.map_err(Problem::internal)
    }

    /// The answer to a call that sent what it is made of: with the body that `write` makes in this form, and nothing by which
    /// to keep it.
    ///
    /// # Errors
    /// 500 where `write` fails.
    pub async fn answer_once<E: Display + Send + 'static>(
        self,
        app: &App,
        write: impl FnOnce(&'static str) -> Result<Bytes, E> + Send + 'static,
    ) -> Result<Response, Problem> {
        let media_type = self.media_type;
        let body = app.in_line(self.line, move || write(media_type)).await?.map_err(Problem::internal)?;
        Ok(([(header::CONTENT_TYPE, media_type)], body).into_response())
    }

    /// The same of what is made of nothing but `source`, the form and `how`: for a client that has it nothing else is
    /// fetched and nothing made. `fetched` has whatever else `write` needs, and is it.
    ///
    /// # Errors
    /// Whatever `fetched` refuses; 500 where `write` fails.
    pub async fn answer_made_of<E: Display + Send + 'static, W>(
        self,
        app: &App,
        (source, how): (Bytes, String),
        fetched: impl Future<Output = Result<W, Problem>>,
    ) -> Result<Response, Problem>
    where
        W: FnOnce(&'static str) -> Result<Bytes, E> + Send + 'static,
    {
        let wanted = self.made_of(app, source, how).await?;
        match wanted.unchanged() {
            Some(unchanged) => Ok(unchanged),
            None => wanted.answer(app, fetched.await?).await,
        }
    }

    /// The answer with the body: with a strong entity tag, or 304 where the client has it.
    fn tagged(mut self, body: Bytes) -> Response {
        let tag = self.tag.get_or_insert_with(|| tag_of(blake3::hash(&body)));
        let answer = (said_of(tag, self.keep), [(header::CONTENT_TYPE, self.media_type)], body);
        self.unchanged().unwrap_or_else(|| answer.into_response())
    }
}

/// The media type among `offered`, best first, that the `Accept` header likes best.
fn negotiated(headers: &HeaderMap, offered: &[&'static str]) -> Result<&'static str, Problem> {
    let accept = joined(headers, header::ACCEPT).unwrap_or_default();
    let ranges: Vec<(&str, f64)> = accept.split(',').filter_map(range).collect();
    if ranges.is_empty() {
        return Ok(offered[0]);
    }
    let liking = |media_type: &str| {
        ranges.iter().filter_map(|&(range, q)| Some((fit(range, media_type)?, q))).max_by_key(|&(fit, _)| fit)
    };
    let mut best: Option<(&'static str, f64)> = None;
    for &media_type in offered {
        let q = liking(media_type).map_or(0.0, |(_, q)| q);
        if q > best.map_or(0.0, |(_, q)| q) {
            best = Some((media_type, q));
        }
    }
    best.map(|(media_type, _)| media_type).ok_or_else(|| {
        let fault = Fault::in_header("accept", format!("this resource comes as {}", offered.join(", ")));
        Problem::of_fault(StatusCode::NOT_ACCEPTABLE, fault)
    })
}

/// A media range and its quality.
fn range(part: &str) -> Option<(&str, f64)> {
    let mut parts = part.split(';').map(str::trim);
    let range = parts.next().filter(|range| !range.is_empty())?;
    let q = parts.find_map(|parameter| parameter.strip_prefix("q=")).map_or(Some(1.0), |q| q.parse().ok());
    Some((range, q.unwrap_or(0.0)))
}

/// How closely `range` names `media_type`; nothing where it does not.
fn fit(range: &str, media_type: &str) -> Option<u8> {
    if range.eq_ignore_ascii_case(media_type) {
        return Some(2);
    }
    match range.strip_suffix("/*")? {
        "*" => Some(0),
        family => media_type.split('/').next().is_some_and(|own| own.eq_ignore_ascii_case(family)).then_some(1),
    }
}

/// A strong entity tag.
fn tag_of(hash: blake3::Hash) -> String {
    format!("\"{}\"", &hash.to_hex()[..32])
}

/// The headers of a body of this tag.
fn said_of(tag: &str, keep: Keep) -> [(HeaderName, String); 3] {
    let keep = match keep {
        Keep::Forever => "private, max-age=31536000, immutable",
        Keep::Never => "no-store",
    };
    [
        (header::ETAG, tag.to_owned()),
        (header::CACHE_CONTROL, keep.to_owned()),
        (header::VARY, "accept, authorization".to_owned()),
    ]
}

/// Whether `If-None-Match` names the tag, be it of the body as it is or of a compressed copy.
fn has(request: &HeaderMap, tag: &str) -> bool {
    let values = request.get_all(header::IF_NONE_MATCH).iter().filter_map(|value| value.to_str().ok());
    values.flat_map(|value| value.split(',')).map(str::trim).any(|candidate| {
        let candidate = candidate.strip_prefix("W/").unwrap_or(candidate);
        candidate == "*" || candidate == tag || candidate == tagged(tag, COMPRESSED)
    })
}

/// The tag of the copy compressed by `coding`: another body, so another strong tag.
fn tagged(tag: &str, coding: &str) -> String {
    format!("{}-{coding}\"", tag.trim_end_matches('"'))
}

/// Lets an answer be sent as it is where its request forbids that: what was carried out is not answered as if it were not.
pub async fn admit_uncompressed(mut request: Request) -> Request {
    if let Some(accept) = joined(request.headers(), header::ACCEPT_ENCODING) {
        let accept = accept.to_ascii_lowercase();
        let forbids = |part: &&str| matches!(range(part), Some(("identity" | "*", 0.0)));
        let admitted = accept.split(',').filter(|part| !forbids(part)).collect::<Vec<_>>().join(",");
        let admitted = HeaderValue::try_from(admitted).unwrap_or(HeaderValue::from_static(""));
        request.headers_mut().insert(header::ACCEPT_ENCODING, admitted);
    }
    request
}

/// The values of a header that may be repeated, as one list; nothing where there is none.
fn joined(headers: &HeaderMap, name: HeaderName) -> Option<String> {
    let values = headers.get_all(name).iter().filter_map(|value| value.to_str().ok());
    values.map(str::to_owned).reduce(|list, value| format!("{list},{value}"))
}

/// Gives a compressed answer the tag of its compressed body.
pub async fn tag_compressed(mut response: Response) -> Response {
    let headers = response.headers_mut();
    let coding = headers.get(header::CONTENT_ENCODING).and_then(|value| value.to_str().ok());
    let tag = headers.get(header::ETAG).and_then(|value| value.to_str().ok());
    if let (Some(coding), Some(tag)) = (coding, tag)
        && let Ok(value) = HeaderValue::try_from(tagged(tag, coding))
    {
        headers.insert(header::ETAG, value);
    }
    response
}

#[cfg(test)]
mod tests {
    use std::convert::Infallible;

    use axum::body::Body;

    use super::*;
    use crate::http::Config;
    use crate::http::testing::app;
    use crate::store::testing::fresh;

    const OFFERED: [&str; 3] = ["application/json", "text/csv", "application/x-npy"];

    fn chosen(accept: &str) -> Option<&'static str> {
        let headers = HeaderMap::from_iter([(header::ACCEPT, HeaderValue::try_from(accept).unwrap())]);
        negotiated(&headers, &OFFERED).ok()
    }

    #[test]
    fn takes_the_best_liked_form() {
        assert_eq!(negotiated(&HeaderMap::new(), &OFFERED).ok(), Some("application/json"));
        assert_eq!(chosen("*/*"), Some("application/json"));
        assert_eq!(chosen("text/csv"), Some("text/csv"));
        assert_eq!(chosen("Text/*;q=0.5, application/x-npy;q=0.7"), Some("application/x-npy"));
        assert_eq!(chosen("*/*;q=0.1, application/json;q=0"), Some("text/csv"));
    }

    #[test]
    fn refuses_where_no_form_is_liked() {
        assert_eq!(chosen("image/png"), None);
        assert_eq!(chosen("text/csv;q=0"), None);
        assert_eq!(chosen("text/csv;q=much"), None);
    }

    #[tokio::test]
    async fn an_answer_may_always_be_sent_as_it_is() {
        for (asked, admitted) in [
            ("identity;q=0", ""),
            ("gzip, identity; q=0.0", "gzip"),
            ("*;q=0, zstd;q=0.5", " zstd;q=0.5"),
            ("gzip;q=0, identity", "gzip;q=0, identity"),
        ] {
            let request = Request::builder().header(header::ACCEPT_ENCODING, asked).body(Body::empty()).unwrap();
            assert_eq!(admit_uncompressed(request).await.headers()[header::ACCEPT_ENCODING], admitted, "{asked}");
        }
    }

    #[test]
    fn answers_304_for_a_known_tag() {
        let body = Bytes::from_static(b"{}");
        let answered = |headers, body| Wanted::named(headers, "application/json").tagged(body);
        let first = answered(HeaderMap::new(), body.clone());
        let tag = first.headers()[header::ETAG].clone();
        for known in [
            tag.to_str().unwrap().to_owned(),
            tagged(tag.to_str().unwrap(), "gzip"),
            format!("\"x\", W/{}", tag.to_str().unwrap()),
        ] {
            let headers = HeaderMap::from_iter([(header::IF_NONE_MATCH, HeaderValue::try_from(known).unwrap())]);
            assert_eq!(answered(headers, body.clone()).status(), StatusCode::NOT_MODIFIED);
        }
        let headers = HeaderMap::from_iter([(header::IF_NONE_MATCH, HeaderValue::from_static("\"other\""))]);
        assert_eq!(answered(headers, body).status(), StatusCode::OK);
    }

    #[tokio::test]
    async fn makes_nothing_for_a_client_that_has_it() {
        let (_directory, store) = fresh().await;
        let app = app(store, Config::default());
        let asked = async |headers, how: &str| {
            let wanted = Wanted::named(headers, "image/png");
            wanted.made_of(&app, Bytes::from_static(b"{}"), how.to_owned()).await.ok().unwrap()
        };
        let picture = |_| Ok::<_, Infallible>(Bytes::from_static(b"picture"));
        let made = asked(HeaderMap::new(), "wide").await.answer(&app, picture).await.ok().unwrap();
        let known = HeaderMap::from_iter([(header::IF_NONE_MATCH, made.headers()[header::ETAG].clone())]);
        let unmade = |_| -> Result<Bytes, Infallible> { unreachable!("it is made again") };
        let again = asked(known.clone(), "wide").await.answer(&app, unmade).await.ok().unwrap();
        assert_eq!(again.status(), StatusCode::NOT_MODIFIED);
        assert_eq!(again.headers()[header::ETAG], known[header::IF_NONE_MATCH]);
        assert!(asked(known, "narrow").await.unchanged().is_none());
    }
}
