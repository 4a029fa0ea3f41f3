//! Meshes: uploaded, looked at, listed.

use std::sync::Arc;

use axum::Json;
use axum::http::{HeaderMap, StatusCode};
use axum::response::Response;
use bytes::Bytes;
use serde::{Deserialize, Serialize};
use utoipa::{IntoParams, ToSchema};

use super::App;
use super::body::{JsonBody, Upload};
use super::idempotency::IdempotencyKey;
use super::media_types::JSON;
use super::page::{Listing, PageQuery};
use super::problem::Problem;
use super::query::{Id, Query};
use super::representation::Wanted;
use super::shapes::{self, Renaming, ShapeDocument};
use crate::intake::mesh::{self, MeshMeasures};
use crate::mesh::connectivity::{ComponentSummary, component_summaries};
use crate::mesh::formats::{Format, Limits};
use crate::store::{ShapeKind, Source};

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
    /// Lets the mesh go by itself within the hour, unless it is uploaded again without this.
    #[serde(default)]
    #[param(default = false)]
    temporary: bool,
}

/// Takes a mesh.
///
/// The file is the raw body, under its content type (`model/obj`, `model/stl`, `model/gltf-binary`) or
/// `application/octet-stream`, or the part `file` of a form. The same file, read the same way, is one mesh however
/// often it comes; a `name` that comes with it is the mesh's from then on, and a new one without is called as the file of the form.
#[utoipa::path(
    post, path = "/v1/meshes", operation_id = "upload_mesh", tag = "meshes",
    params(UploadQuery, ("Idempotency-Key" = Option<String>, Header, pattern = "^[!-~]{1,255}$", description = "the same key gets the same answer")),
    request_body(description = "OBJ, OFF, PLY, STL, GLB or glTF with its data in it", content(
        ("model/obj"), ("model/off"), ("model/ply"), ("model/stl"), ("model/gltf-binary"), ("model/gltf+json"),
        ("application/octet-stream"), ("multipart/form-data"),
    )),
    responses(
        (status = 201, description = "taken", body = ShapeDocument<MeshMeasures>, headers(("Location" = String))),
        (status = 200, description = "this very file is known already", body = ShapeDocument<MeshMeasures>, headers(("Location" = String))),
    ),
)]
pub async fn upload(
    app: App,
    Query(query): Query<UploadQuery>,
    key: IdempotencyKey,
    upload: Upload,
) -> Result<Response, Problem> {
    let upload = Arc::new(upload);
    let asked = (upload.clone(), format!("{query:?}"));
    let answer = async {
        let name = shapes::name(query.name)?;
        let limits = Limits { triangles: app.config.max_triangles, bytes: app.config.max_upload_bytes };
        let memory = upload.bytes.len().saturating_mul(mesh::MEMORY_OF_FILE);
        let taken = app.with_memory(memory, move || {
            let Upload { bytes, media_type, file_name, .. } = &*upload;
            let format = mesh::format(bytes, query.format, media_type.as_deref(), file_name.as_deref());
            let format = format.map_err(|untaken| upload.untaken(untaken))?;
            let imported = mesh::taken(bytes, format, &limits).map_err(|untaken| upload.untaken(untaken))?;
            let (measures, mesh) = (MeshMeasures::of(&imported, format), imported.mesh);
            let media_type = format.media_type().to_owned();
            let file_name = file_name.as_deref().map(shapes::shortened);
            let source = Source { bytes: bytes.clone(), media_type, parameters: String::new(), file_name };
            Ok::<_, Problem>((mesh, measures, source))
        });
        let (mesh, measures, source) = taken.await??;
        let body = serde_json::to_value(&measures).map_err(Problem::internal)?;
        let _turn = app.may_take(source.bytes.len(), 0).await?;
        let kept = app.store.insert_mesh(mesh, source, name.as_deref(), body).await?;
        shapes::uploaded::<MeshMeasures>(&app, kept, query.temporary).await
    };
    shapes::once(&app, ShapeKind::Mesh, &key, asked, answer).await
}

/// Lists the meshes, newest first.
#[utoipa::path(
    get, path = "/v1/meshes", operation_id = "list_meshes", tag = "meshes", params(PageQuery),
    responses((status = 200, description = "a page", body = Listing<ShapeDocument<MeshMeasures>>)),
)]
pub async fn list(app: App, Query(query): Query<PageQuery>) -> Result<Response, Problem> {
    shapes::listed::<MeshMeasures>(&app, ShapeKind::Mesh, &query).await
}

/// Answers what is known of a mesh.
#[utoipa::path(
    get, path = "/v1/meshes/{id}", operation_id = "read_mesh", tag = "meshes", params(("id" = String, Path)),
    responses((status = 200, description = "the mesh", body = ShapeDocument<MeshMeasures>)),
)]
pub async fn read(app: App, Id(id): Id) -> Result<Json<ShapeDocument<MeshMeasures>>, Problem> {
    Ok(Json(shapes::known(&app, ShapeKind::Mesh, &id).await?))
}

/// Renames a mesh.
#[utoipa::path(
    patch, path = "/v1/meshes/{id}", operation_id = "rename_mesh", tag = "meshes", params(("id" = String, Path)), request_body = Renaming,
    responses((status = 200, description = "the mesh, renamed", body = ShapeDocument<MeshMeasures>)),
)]
pub async fn rename(app: App, Id(id): Id, body: JsonBody) -> Result<Json<ShapeDocument<MeshMeasures>>, Problem> {
    Ok(Json(shapes::renamed(&app, ShapeKind::Mesh, &id, body).await?))
}

/// Deletes a mesh, its file and its triangles. Matches it was part of stay.
#[utoipa::path(
    delete, path = "/v1/meshes/{id}", operation_id = "delete_mesh", tag = "meshes", params(("id" = String, Path)),
    responses(
        (status = 204, description = "deleted"),
        (status = 409, description = "a match or spectrum that is not finished needs it"),
    ),
)]
pub async fn delete(app: App, Id(id): Id) -> Result<StatusCode, Problem> {
    shapes::deleted(&app, ShapeKind::Mesh, &id).await
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
pub async fn components(app: App, Id(id): Id, headers: HeaderMap) -> Result<Response, Problem> {
    let mesh = shapes::mesh(&app, &id, |_| 0).await?;
    let write = move |_| {
        let list = ComponentList { components: component_summaries(&mesh) };
        serde_json::to_vec(&list).map(Bytes::from)
    };
    Wanted::named(headers, JSON).answer(&app, write).await
}
