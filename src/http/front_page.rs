//! The page at `/`, built from `web/` and embedded in the program.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::convert::Infallible;
use std::fmt;
use std::sync::Arc;

use axum::Router;
use axum::extract::State;
use axum::http::{HeaderMap, HeaderName, HeaderValue, header};
use axum::response::Response;
use axum::routing::get;
use bytes::Bytes;
use rust_embed::Embed;

use super::media_types::{OCTETS, SVG};
use super::problem::Problem;
use super::query::Id;
use super::representation::Wanted;
use super::{App, Service};

/// What `make web` builds, read from there by programs of the profile `dev`. Where it was not built, there is no page.
#[derive(Embed)]
#[folder = "web/dist"]
#[allow_missing = true]
struct Built;

const INDEX: &str = "index.html";

/// The licences of what the page is made of, as `vite build` lists them.
const LICENCES: &str = "licences.md";

const TEXT: &str = "text/plain; charset=utf-8";

/// What is answered where the program has no page.
const NO_PAGE: &str =
    "sketchmatch is running. Its page is not built into this program: `make web` builds it, with Node 20.19 or later,
and `make run` does so by itself where Node is there. The interface is described at /docs.
";

/// The page loads nothing but what this server answers, and no script or style that is written into it; drawings are
/// shown from memory (`blob:`).
const HEADERS: [(HeaderName, &str); 4] = [
    (
        header::CONTENT_SECURITY_POLICY,
        "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob:; connect-src 'self'; \
         base-uri 'none'; form-action 'none'; frame-ancestors 'none'",
    ),
    (header::X_CONTENT_TYPE_OPTIONS, "nosniff"),
    (header::REFERRER_POLICY, "no-referrer"),
    (HeaderName::from_static("cross-origin-opener-policy"), "same-origin"),
];

/// The files of the page by their paths. Clones share them.
#[derive(Clone)]
pub struct FrontPage(Arc<BTreeMap<String, Bytes>>);

/// How many files there are: what they hold is not for the log, which tells the configuration at the start.
impl fmt::Debug for FrontPage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("FrontPage").field("files", &self.0.len()).finish()
    }
}

impl FrontPage {
    /// The page that is built into the program; of no files where none is.
    pub fn built() -> FrontPage {
        let bytes = |path: &str| match Built::get(path)?.data {
            Cow::Borrowed(bytes) => Some(Bytes::from_static(bytes)),
            Cow::Owned(bytes) => Some(bytes.into()),
        };
        FrontPage::of(Built::iter().filter_map(|path| Some((path.to_string(), bytes(&path)?))))
    }

    /// The page of these files, by their paths.
    pub fn of(files: impl IntoIterator<Item = (String, Bytes)>) -> FrontPage {
        FrontPage(Arc::new(files.into_iter().collect()))
    }

    fn file(&self, path: &str) -> Option<Bytes> {
        self.0.get(path).cloned()
    }
}

pub(super) fn routes() -> Router<Service> {
    Router::new().route("/", get(page)).route("/licences", get(licences)).route("/assets/{name}", get(asset))
}

/// Answers the page, or how to get it.
async fn page(State(Service(app)): State<Service>, headers: HeaderMap) -> Result<Response, Problem> {
    match app.config.front_page.file(INDEX) {
        Some(page) => changing(&app, headers, "text/html; charset=utf-8", page).await,
        None => changing(&app, headers, TEXT, Bytes::from_static(NO_PAGE.as_bytes())).await,
    }
}

/// Answers the licences of what the page is made of.
async fn licences(State(Service(app)): State<Service>, headers: HeaderMap) -> Result<Response, Problem> {
    let licences = app.config.front_page.file(LICENCES);
    changing(&app, headers, TEXT, licences.ok_or_else(|| Problem::not_found("page in this program"))?).await
}

/// What another version of the program has otherwise at the same address.
async fn changing(app: &App, headers: HeaderMap, media_type: &'static str, body: Bytes) -> Result<Response, Problem> {
    let mut answer = sent(app, headers, media_type, body).await?;
    answer.headers_mut().insert(header::CACHE_CONTROL, HeaderValue::from_static("no-cache"));
    Ok(answer)
}

/// Answers a file that the page is made of; its name changes with its content.
async fn asset(State(Service(app)): State<Service>, Id(name): Id, headers: HeaderMap) -> Result<Response, Problem> {
    let body = app.config.front_page.file(&format!("assets/{name}"));
    let body = body.ok_or_else(|| Problem::not_found(format_args!("file {name} of the page")))?;
    sent(&app, headers, media_type(&name), body).await
}

fn media_type(name: &str) -> &'static str {
    match name.rsplit_once('.').map(|(_, ending)| ending) {
        Some("js") => "text/javascript; charset=utf-8",
        Some("css") => "text/css; charset=utf-8",
        Some("svg") => SVG,
        _ => OCTETS,
    }
}

/// The answer with what keeps the page to itself.
async fn sent(app: &App, headers: HeaderMap, media_type: &'static str, body: Bytes) -> Result<Response, Problem> {
    let mut answer = Wanted::named(headers, media_type).answer(app, move |_| Ok::<_, Infallible>(body)).await?;
    for (name, value) in HEADERS {
        answer.headers_mut().insert(name, HeaderValue::from_static(value));
    }
    Ok(answer)
}
