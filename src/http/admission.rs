//! Who is let in: keys, what they open, and what is open without one.

use std::time::SystemTime;

use axum::extract::{MatchedPath, Request, State};
use axum::http::{HeaderMap, HeaderValue, Method, StatusCode, header};
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};

use super::problem::Problem;
use super::{App, links, open_requests};
use crate::access::{Grant, Key, Scope, Scopes, Tenant, WatchedFile};
use crate::store::StoreError;

/// Whom a server lets in.
#[derive(Clone, Debug, Default)]
pub enum Admission {
    /// Whoever reaches it, as the one tenant there is.
    #[default]
    Anybody,
    /// Who has a key that is in the database, or in this file.
    Keyholders(Option<WatchedFile>),
}

/// What stands at the door: it knows the keys by the app.
#[derive(Clone)]
pub(super) struct Door(pub App);

/// Paths that tell nothing of anybody: the page, the description of the interface, whether the server lives and takes
/// requests. All others need a key.
const OPEN: [&str; 7] = ["/", "/licences", "/assets/{name}", "/healthz", "/readyz", "/openapi.json", "/docs"];

/// Whether a route needs no key.
pub(super) fn is_open(route: &str) -> bool {
    OPEN.contains(&route) || route.starts_with("/docs/")
}

/// Lets a request through that may do what it asks for, with the [`Grant`] of its key or signature among its extensions; a
/// line in the log tells of every change.
pub(super) async fn checked(State(door): State<Door>, mut request: Request, next: Next) -> Response {
    let signature = links::taken_out(request.uri_mut());
    let Some(scope) = needed(request.extensions().get::<MatchedPath>(), request.method()) else {
        return next.run(request).await;
    };
    let grant = match door.grant(request.headers(), request.uri().path(), scope, signature).await {
        Ok(grant) => grant,
        Err(refused) => return refused.into_response(),
    };
    let (tenant, key) = (grant.tenant.clone(), grant.key.clone());
    request.extensions_mut().insert(grant);
    let pace = door.0.pace.as_ref();
    let (told, wait) = pace.map_or_else(Default::default, |pace| pace.count(&tenant));
    let mut response = match (pace, wait) {
        (Some(pace), Some(seconds)) => pace.exceeded(seconds).into_response(),
        _ => door.answered(&tenant, request, next).await,
    };
    response.headers_mut().extend(told);
    if scope == Scope::Write {
        // The request around it in the log has the method, the path and the identifier.
        tracing::info!(target: "sketchmatch::audit", %tenant, key, status = response.status().as_u16(), "a write");
    }
    response
}

/// What a call of this method needs on this route; nothing where it is open to all. There is nothing to protect at a path
/// that is no route.
fn needed(route: Option<&MatchedPath>, method: &Method) -> Option<Scope> {
    let route = route?.as_str();
    if is_open(route) {
        return None;
    }
    Some(match (route, method) {
        ("/metrics", _) => Scope::Admin,
        (_, &Method::GET | &Method::HEAD | &Method::OPTIONS) => Scope::Read,
        _ => Scope::Write,
    })
}

/// Why a request is not let through.
enum Refused {
    NoKey,
    /// A key that is not told to be one, or a way to be let in that is not known here.
    NotBearer,
    /// Or of a signature: which of these it is, is not told.
    UnknownRevokedOrExpired,
    Lacking(Scope),
    Store(StoreError),
}

impl Door {
    /// What a request may do, which is to be of this scope: by its key or, where it brings none, by the signature in its
    /// address.
    async fn grant(
        &self,
        headers: &HeaderMap,
        path: &str,
        scope: Scope,
        signature: Option<String>,
    ) -> Result<Grant, Refused> {
        let grant = match (&self.0.config.admission, signature) {
            (Admission::Anybody, _) => {
                Grant { tenant: Tenant::default(), scopes: Scopes::all(), key: "none".to_owned() }
            }
            (Admission::Keyholders(_), Some(signature)) if !headers.contains_key(header::AUTHORIZATION) => {
                self.by_signature(path, &signature).await?
            }
            (Admission::Keyholders(file), _) => self.by_key(file.as_ref(), bearer(headers)?).await?,
        };
        if grant.scopes.allow(scope) { Ok(grant) } else { Err(Refused::Lacking(scope)) }
    }

    /// The answer to a request, which counts as under way until that is read to its end.
    async fn answered(&self, tenant: &Tenant, request: Request, next: Next) -> Response {
        let Some(open) = &self.0.open_requests else { return next.run(request).await };
        match open.place(tenant) {
            Some(place) => open_requests::keeping(next.run(request).await, place),
            None => open.exceeded().into_response(),
        }
    }

    async fn by_key(&self, file: Option<&WatchedFile>, key: Key) -> Result<Grant, Refused> {
        let hash = key.hash();
        match file.and_then(|file| file.grant(&hash, SystemTime::now())) {
            Some(grant) => Ok(grant),
            None => self.0.store.grant(&hash).await.map_err(Refused::Store)?.ok_or(Refused::UnknownRevokedOrExpired),
        }
    }

    async fn by_signature(&self, path: &str, signature: &str) -> Result<Grant, Refused> {
        let resource = links::resource(path).ok_or(Refused::UnknownRevokedOrExpired)?;
        let signer = self.0.signer().await.map_err(Refused::Store)?;
        let tenant = signer.opened(signature, resource, SystemTime::now()).ok_or(Refused::UnknownRevokedOrExpired)?;
        Ok(Grant { tenant, scopes: Scopes::of(Scope::Read), key: "signature".to_owned() })
    }
}

/// The key a request brings.
fn bearer(headers: &HeaderMap) -> Result<Key, Refused> {
    let mut values = headers.get_all(header::AUTHORIZATION).iter();
    let value = values.next().ok_or(Refused::NoKey)?;
    let value = value.to_str().ok().filter(|_| values.next().is_none()).ok_or(Refused::UnknownRevokedOrExpired)?;
    let (scheme, key) = value.split_once(' ').unwrap_or((value, ""));
    if !scheme.eq_ignore_ascii_case("bearer") {
        return Err(Refused::NotBearer);
    }
    key.trim().parse().map_err(|_| Refused::UnknownRevokedOrExpired)
}

impl IntoResponse for Refused {
    /// 401 or 403 with a challenge as RFC 6750 has it.
    fn into_response(self) -> Response {
        const REALM: &str = "Bearer realm=\"sketchmatch\"";
        let (status, detail, challenge) = match self {
            Refused::NoKey => {
                let detail = "this server asks for a key, in the header `Authorization: Bearer KEY`";
                (StatusCode::UNAUTHORIZED, detail.to_owned(), REALM.to_owned())
            }
            Refused::NotBearer => {
                let detail = "before the key `Bearer ` is missing: the header is `Authorization: Bearer KEY`";
                (StatusCode::UNAUTHORIZED, detail.to_owned(), format!("{REALM}, error=\"invalid_token\""))
            }
            Refused::UnknownRevokedOrExpired => {
                let detail = "this key or signature is not known here, was revoked, or has expired";
                (StatusCode::UNAUTHORIZED, detail.to_owned(), format!("{REALM}, error=\"invalid_token\""))
            }
            Refused::Lacking(scope) => {
                let scope = scope.as_str();
                let challenge = format!("{REALM}, error=\"insufficient_scope\", scope=\"{scope}\"");
                (StatusCode::FORBIDDEN, format!("the call needs a key of the scope {scope}"), challenge)
            }
            Refused::Store(error) => return Problem::from(error).into_response(),
        };
        let mut response = Problem::new(status, detail).into_response();
        let challenge = HeaderValue::try_from(challenge).unwrap_or(HeaderValue::from_static(REALM));
        response.headers_mut().insert(header::WWW_AUTHENTICATE, challenge);
        response
    }
}
