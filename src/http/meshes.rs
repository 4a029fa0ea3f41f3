//! Meshes: uploaded, looked at, listed.

use std::sync::Arc;

use axum::Json;
use axum::extract::State;
use axum::http::{HeaderMap, StatusCode};
use axum::response::Response;
use bytes::Bytes;
use serde::{Deserialize, Serialize};
use utoipa::{IntoParams, ToSchema};

use super::App;
use super::body::{JsonBody, Upload, unsupported};
use super::idempotency::IdempotencyKey;
use super::page::{Listing, PageQuery};
use super::problem::{Fault, Problem};
use super::query::{Id, Query};
use super::representation::{JSON, Wanted};
use super::shapes::{self, Renaming, ShapeDocument};
use crate::alignment::prepared::standing::{self, Up};
use crate::mesh::connectivity::{ComponentSummary, Summary, component_summaries, summary};
use crate::mesh::figure::Figure;
use crate::mesh::file_mesh::FileMesh;
use crate::mesh::formats::{Format, Limits, foreign};
use crate::mesh::refusal::{Refusal, Warning};
use crate::mesh::validation::{Imported, import};
use crate::store::{Kind, Source};

#[derive(Debug, Serialize, Deserialize, ToSchema)]
pub struct MeshMeasures {
    #[serde(flatten)]
    summary: Summary,
    /// What was mended, and what is to be known.
    #[serde(deserialize_with = "shapes::known_warnings")]
    warnings: Vec<Warning>,
    /// Which way is up on it: what matches take unless they say otherwise, where it is surer than even. None of meshes
    /// taken before this was told.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    up: Option<Up>,
}

#[derive(Debug, Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
#[into_params(parameter_in = Query)]
pub struct UploadQuery {
    /// The file format; by default what the content type, the file's name or its bytes tell.
    #[param(inline)]
    format: Option<Format>,
    /// A name to list the mesh under.
    #[param(max_length = 200)]
    name: Option<String>,
}

/// Bytes of memory per byte of a mesh file while it is read, about: STL and binary PLY, of few bytes a triangle, take most.
const MEMORY_OF_FILE: usize = 12;

/// Takes a mesh.
///
/// The file is the raw body, under its content type (`model/obj`, `model/stl`, `model/gltf-binary`) or
/// `application/octet-stream`, or the part `file` of a form. The same file, read the same way, is one mesh however
/// often it comes; a name that comes with it is the mesh's from then on.
#[utoipa::path(
    post, path = "/v1/meshes", operation_id = "upload_mesh", tag = "meshes",
    params(UploadQuery, ("Idempotency-Key" = Option<String>, Header, pattern = "^[!-~]{1,255}$", description = "the same key gets the same answer")),
    request_body(description = "OBJ, OFF, PLY, STL, GLB or glTF with its data in it", content(
        ("application/octet-stream"), ("multipart/form-data"),
    )),
    responses(
        (status = 201, description = "taken", body = ShapeDocument<MeshMeasures>, headers(("Location" = String))),
        (status = 200, description = "this very file is known already", body = ShapeDocument<MeshMeasures>, headers(("Location" = String))),
    ),
)]
pub async fn upload(
    State(app): State<App>,
    Query(query): Query<UploadQuery>,
    key: IdempotencyKey,
    upload: Upload,
) -> Result<Response, Problem> {
    let upload = Arc::new(upload);
    let asked = (upload.clone(), format!("{query:?}"));
    let answer = async {
        let name = shapes::name(query.name, upload.file_name.clone())?;
        let limits = Limits { triangles: app.config.max_triangles, bytes: app.config.max_upload_bytes };
        let memory = upload.bytes.len().saturating_mul(MEMORY_OF_FILE);
        let taken = app.with_memory(memory, move || {
            let Upload { bytes, media_type, file_name, .. } = &*upload;
            let format = format(bytes, query.format, media_type.as_deref(), file_name.as_deref())?;
            let (mesh, measures) = measured(imported(bytes, format, &limits)?, format);
            let media_type = format.media_type().to_owned();
            Ok::<_, Problem>((mesh, measures, Source { bytes: bytes.clone(), media_type, parameters: String::new() }))
        });
        let (mesh, measures, source) = taken.await??;
        let body = serde_json::to_value(&measures).map_err(Problem::internal)?;
        shapes::uploaded::<MeshMeasures>(app.store.insert_mesh(mesh, source, name.as_deref(), body).await?)
    };
    shapes::once(&app, Kind::Mesh, &key, asked, answer).await
}

/// The mesh beside its measures.
fn measured(Imported { mesh, warnings }: Imported, format: Format) -> (FileMesh, MeshMeasures) {
    let summary = summary(&mesh);
    let up = Some(standing::up(&Figure::largest(&mesh).mesh, format.up()));
    (mesh, MeshMeasures { summary, warnings, up })
}

/// The format named, else that which the media type, the file's name or the bytes tell.
///
/// # Errors
/// 415 where nothing tells it.
pub fn format(
    bytes: &[u8],
    named: Option<Format>,
    media_type: Option<&str>,
    file_name: Option<&str>,
) -> Result<Format, Problem> {
    if let Some(foreign) = foreign::name(bytes) {
        return Err(unsupported(format!("this is {}: {}", foreign.kind, foreign.instead)));
    }
    let by_name = || Format::from_name(file_name?.rsplit_once('.')?.1);
    let format = named.or_else(|| media_type.and_then(Format::from_media_type)).or_else(by_name);
    format.or_else(|| Format::sniff(bytes)).ok_or_else(|| {
        unsupported("neither the content type nor the bytes tell the format: say ?format=obj|off|ply|stl|glb|gltf")
    })
}

/// The mesh in a file of this format.
///
/// # Errors
/// 413 beyond the limits, 422 with every fault of a mesh that cannot be matched.
pub fn imported(bytes: &[u8], format: Format, limits: &Limits) -> Result<Imported, Problem> {
    import(bytes, format, limits).map_err(refused)
}

/// The problem of a mesh that is not taken.
fn refused(refusal: Refusal) -> Problem {
    match refusal {
        Refusal::TooLarge { .. } => Problem::new(StatusCode::PAYLOAD_TOO_LARGE, refusal.to_string()),
        Refusal::Invalid(faults) => {
            let unlisted = match faults.unlisted {
                0 => String::new(),
                more => format!("; {more} more faults are not listed"),
            };
            let faults = faults.listed.into_iter().map(|fault| Fault::at_place(fault.place.to_string(), fault.detail));
            Problem::refused(format!("the file is not a mesh that can be matched{unlisted}"), faults.collect())
        }
    }
}

/// Lists the meshes, newest first.
#[utoipa::path(
    get, path = "/v1/meshes", operation_id = "list_meshes", tag = "meshes", params(PageQuery),
    responses((status = 200, description = "a page", body = Listing<ShapeDocument<MeshMeasures>>)),
)]
pub async fn list(State(app): State<App>, Query(query): Query<PageQuery>) -> Result<Response, Problem> {
    shapes::listed::<MeshMeasures>(&app, Kind::Mesh, &query).await
}

/// Answers what is known of a mesh.
#[utoipa::path(
    get, path = "/v1/meshes/{id}", operation_id = "read_mesh", tag = "meshes", params(("id" = String, Path)),
    responses((status = 200, description = "the mesh", body = ShapeDocument<MeshMeasures>)),
)]
pub async fn read(State(app): State<App>, Id(id): Id) -> Result<Json<ShapeDocument<MeshMeasures>>, Problem> {
    Ok(Json(shapes::known(&app, Kind::Mesh, &id).await?))
}

/// Renames a mesh.
#[utoipa::path(
    patch, path = "/v1/meshes/{id}", operation_id = "rename_mesh", tag = "meshes", params(("id" = String, Path)), request_body = Renaming,
    responses((status = 200, description = "the mesh, renamed", body = ShapeDocument<MeshMeasures>)),
)]
pub async fn rename(
    State(app): State<App>,
    Id(id): Id,
    body: JsonBody,
) -> Result<Json<ShapeDocument<MeshMeasures>>, Problem> {
    Ok(Json(shapes::renamed(&app, Kind::Mesh, &id, body).await?))
}

/// Deletes a mesh, its file and its triangles. Matches it was part of stay.
#[utoipa::path(
    delete, path = "/v1/meshes/{id}", operation_id = "delete_mesh", tag = "meshes", params(("id" = String, Path)),
    responses(
        (status = 204, description = "deleted"),
        (status = 409, description = "a match or spectrum that is not finished needs it"),
    ),
)]
pub async fn delete(State(app): State<App>, Id(id): Id) -> Result<StatusCode, Problem> {
    shapes::deleted(&app, Kind::Mesh, &id).await
}

/// The components of a mesh.
#[derive(Debug, Serialize, ToSchema)]
struct ComponentList {
    components: Vec<ComponentSummary>,
}

/// Lists the components of a mesh, which a match request may name.
#[utoipa::path(
    get, path = "/v1/meshes/{id}/components", operation_id = "read_mesh_components", tag = "meshes", params(("id" = String, Path)),
    responses(
        (status = 200, description = "the components", body = ComponentList),
        (status = 304, description = "unchanged"),
    ),
)]
pub async fn components(State(app): State<App>, Id(id): Id, headers: HeaderMap) -> Result<Response, Problem> {
    let mesh = shapes::mesh(&app, &id).await?;
    let write = move |_| {
        let list = ComponentList { components: component_summaries(&mesh) };
        serde_json::to_vec(&list).map(Bytes::from)
    };
    Wanted::named(headers, JSON).answer(&app, write).await
}
