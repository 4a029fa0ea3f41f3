//! Addresses signed for a while, for an `EventSource`, an `<img>` or a viewer, which can send no key.

use std::collections::BTreeMap;
use std::time::{Duration, SystemTime};

use axum::Json;
use axum::http::{Uri, header};
use axum::response::{IntoResponse, Response};
use serde::Serialize;
use serde_json::Value;
use utoipa::ToSchema;

use super::paths::{MATCHES, POSES, of_shapes};
use super::problem::Problem;
use super::query::Id;
use super::resource::{self, Resource, address};
use super::timestamp::timestamp;
use super::{App, paths, shapes};
use crate::access::Signer;
use crate::access::key_file::milliseconds;
use crate::jobs::Posing;
use crate::pipeline::Settings;
use crate::store::{ShapeKind, StoreError};

/// How long a signature is good: as long as it takes to look at something.
const LIFETIME: Duration = Duration::from_secs(15 * 60);

/// The name of the secret that signs addresses.
const SECRET: &str = "links";

/// The query parameter that a signature stands in.
const PARAMETER: &str = "signature";

/// Where resources are whose addresses can be signed, and the last part of the address that signs them: it asks for a key, or
/// a signature could be made to last.
const RESOURCES: [&str; 4] = [MATCHES, POSES, of_shapes(ShapeKind::Mesh), of_shapes(ShapeKind::Sketch)];
const LAST: &str = "links";

/// The signature in the query of an address, which is taken out: what answers it knows of none.
pub fn taken_out(uri: &mut Uri) -> Option<String> {
    let (mine, others): (Vec<&str>, Vec<&str>) =
        uri.query()?.split('&').partition(|pair| pair.split('=').next() == Some(PARAMETER));
    let signature = mine.first()?.split_once('=').map(|(_, value)| value.to_owned());
    let path = uri.path();
    let rest = if others.is_empty() { path.to_owned() } else { format!("{path}?{}", others.join("&")) };
    *uri = rest.parse().ok()?;
    signature
}

/// The address of the resource that a path is at or below, where its addresses can be signed.
pub fn resource(path: &str) -> Option<&str> {
    let list = RESOURCES.into_iter().find(|list| path.starts_with(list))?;
    let id = path[list.len()..].strip_prefix('/')?;
    let (id, below) = id.split_once('/').unwrap_or((id, ""));
    (!id.is_empty() && below != LAST).then(|| &path[..list.len() + 1 + id.len()])
}

impl App {
    /// What signs addresses and knows its signatures again.
    ///
    /// # Errors
    /// What the store said.
    pub(super) async fn signer(&self) -> Result<&Signer, StoreError> {
        let signer = async { self.store.secret(SECRET).await.map(Signer::new) };
        self.signer.get_or_try_init(|| signer).await
    }
}

/// Addresses that need no key until they end.
#[derive(Debug, Serialize, ToSchema)]
pub struct SignedLinks {
    /// RFC 3339.
    #[schema(format = DateTime)]
    expires_at: String,
    /// The value of the query parameter `signature`: it lets in to every GET at this resource and below.
    signature: String,
    /// The addresses of the resource with the signature in them.
    links: BTreeMap<String, String>,
}

/// Signs the addresses of a match.
#[utoipa::path(
    get, path = "/v1/matches/{id}/links", operation_id = "sign_match", tag = "matches", params(("id" = String, Path)),
    responses((status = 200, description = "the addresses", body = SignedLinks)),
)]
pub async fn of_match(app: App, Id(id): Id) -> Result<Response, Problem> {
    of_job::<Settings>(&app, &id).await
}

/// Signs the addresses of a pose.
#[utoipa::path(
    get, path = "/v1/poses/{id}/links", operation_id = "sign_pose", tag = "poses", params(("id" = String, Path)),
    responses((status = 200, description = "the addresses", body = SignedLinks)),
)]
pub async fn of_pose(app: App, Id(id): Id) -> Result<Response, Problem> {
    of_job::<Posing>(&app, &id).await
}

/// Signs the addresses of a mesh.
#[utoipa::path(
    get, path = "/v1/meshes/{id}/links", operation_id = "sign_mesh", tag = "meshes", params(("id" = String, Path)),
    responses((status = 200, description = "the addresses", body = SignedLinks)),
)]
pub async fn of_mesh(app: App, Id(id): Id) -> Result<Response, Problem> {
    of_shape(&app, ShapeKind::Mesh, &id).await
}

/// Signs the addresses of a sketch.
#[utoipa::path(
    get, path = "/v1/sketches/{id}/links", operation_id = "sign_sketch", tag = "sketches", params(("id" = String, Path)),
    responses((status = 200, description = "the addresses", body = SignedLinks)),
)]
pub async fn of_sketch(app: App, Id(id): Id) -> Result<Response, Problem> {
    of_shape(&app, ShapeKind::Sketch, &id).await
}

async fn of_job<T: Resource>(app: &App, id: &str) -> Result<Response, Problem> {
    let job = resource::found::<T>(app, id).await?;
    let document = serde_json::to_value(T::document(job, None)).map_err(Problem::internal)?;
    let links = document.get("links").and_then(Value::as_object).into_iter().flatten();
    let links = links.filter_map(|(name, link)| Some((name.clone(), link.as_str()?.to_owned())));
    signed(app, &address::<T>(id), links.collect()).await
}

async fn of_shape(app: &App, kind: ShapeKind, id: &str) -> Result<Response, Problem> {
    shapes::there(app, kind, id).await?;
    let itself = paths::of_shape(kind, id);
    let below = ["mesh", "picture", "spectrum"].map(|part| (part.to_owned(), format!("{itself}/{part}")));
    let links = below.into_iter().chain([("self".to_owned(), itself.clone())]).collect();
    signed(app, &itself, links).await
}

/// The addresses of a resource with one signature for all.
async fn signed(app: &App, resource: &str, mut links: BTreeMap<String, String>) -> Result<Response, Problem> {
    let end = SystemTime::now() + LIFETIME;
    let signature = app.signer().await?.sign(app.store.tenant(), resource, end);
    links.values_mut().for_each(|link| *link = format!("{link}?{PARAMETER}={signature}"));
    let document = SignedLinks { expires_at: timestamp(milliseconds(end)), signature, links };
    Ok(([(header::CACHE_CONTROL, "no-store")], Json(document)).into_response())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_signature_is_taken_out_of_an_address() {
        for (address, signature, rest) in [
            ("/v1/matches/1/picture?signature=a.b&width=400", Some("a.b"), "/v1/matches/1/picture?width=400"),
            ("/v1/matches/1?width=400&signature=a", Some("a"), "/v1/matches/1?width=400"),
            ("/v1/matches/1?signature=a&signature=b", Some("a"), "/v1/matches/1"),
            ("/v1/matches/1?signature", None, "/v1/matches/1"),
            ("/v1/matches/1?signatures=a", None, "/v1/matches/1?signatures=a"),
            ("/v1/matches/1", None, "/v1/matches/1"),
        ] {
            let mut uri: Uri = address.parse().unwrap();
            assert_eq!((taken_out(&mut uri).as_deref(), uri.to_string().as_str()), (signature, rest), "{address}");
        }
    }

    #[test]
    fn a_signature_is_for_a_resource_and_what_is_below() {
        for (path, expected) in [
            ("/v1/matches/1", Some("/v1/matches/1")),
            ("/v1/matches/1/mesh.glb", Some("/v1/matches/1")),
            ("/v1/meshes/mesh_1/picture", Some("/v1/meshes/mesh_1")),
            ("/v1/matches/1/links", None),
            ("/v1/matches", None),
            ("/v1/matches/", None),
            ("/v1/matchesx/1", None),
            ("/v1/examples/biped/mesh", None),
            ("/metrics", None),
        ] {
            assert_eq!(resource(path), expected, "{path}");
        }
    }
}
