//! What meshes and sketches have in common as resources.

use std::future::Future;
use std::sync::Arc;

use axum::http::StatusCode;
use axum::response::{IntoResponse, Response};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::body::{JsonBody, Upload};
use super::held::Held;
use super::idempotency::{Answer, IdempotencyKey, fingerprint};
use super::page::{PageQuery, cursor_fault};
use super::problem::{Fault, Problem};
use super::timestamp::timestamp;
use super::{App, memory, paths};
use crate::intake::json;
use crate::mesh::file_mesh::FileMesh;
use crate::sketch::Sketch;
use crate::store::{Deletion, NUL, Shape, ShapeKind, is_text};

/// Characters of a name at most.
const LONGEST_NAME: usize = 200;

const NO_NAME: &str = "a name has at most 200 characters, none of them U+0000";

/// A stored shape: what every shape has, and the measures of its kind.
#[derive(Debug, Serialize, ToSchema)]
pub struct ShapeDocument<T> {
    pub id: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// RFC 3339.
    #[schema(format = DateTime)]
    pub created_at: String,
    /// When it goes by itself, of an upload that is temporary.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(format = DateTime)]
    pub expires_at: Option<String>,
    #[serde(flatten)]
    pub measures: T,
}

/// What is known of the shape of this id, its measures stored as a `T`.
///
/// # Errors
/// 404 where there is none.
pub async fn known<T: DeserializeOwned>(app: &App, kind: ShapeKind, id: &str) -> Result<ShapeDocument<T>, Problem> {
    document(stored(app, kind, id).await?)
}

/// Ok where there is a shape of this id.
///
/// # Errors
/// 404 where there is none.
pub async fn there(app: &App, kind: ShapeKind, id: &str) -> Result<(), Problem> {
    stored(app, kind, id).await.map(drop)
}

/// The shape of this id without its geometry.
///
/// # Errors
/// 404 where there is none.
pub async fn stored(app: &App, kind: ShapeKind, id: &str) -> Result<Shape, Problem> {
    app.store.shape(kind, id).await?.ok_or_else(|| missing(kind, id))
}

/// The geometry of a mesh, with room for it and for so many bytes besides. Who holds it reads no other.
///
/// # Errors
/// 404 where there is none.
pub async fn mesh(app: &App, id: &str, besides: impl FnOnce(&Shape) -> usize) -> Result<Held<FileMesh>, Problem> {
    let shape = stored(app, ShapeKind::Mesh, id).await?;
    let room = app.room_for(memory::of_shape(&shape).saturating_add(besides(&shape))).await?;
    Ok(Held::new(mesh_read(app, id).await?, room))
}

/// The geometry of a sketch, likewise.
///
/// # Errors
/// 404 where there is none.
pub async fn sketch(app: &App, id: &str, besides: impl FnOnce(&Shape) -> usize) -> Result<Held<Sketch>, Problem> {
    let shape = stored(app, ShapeKind::Sketch, id).await?;
    let room = app.room_for(memory::of_shape(&shape).saturating_add(besides(&shape))).await?;
    Ok(Held::new(sketch_read(app, id).await?, room))
}

/// The geometries of a sketch and a mesh, with room for both and for so many bytes besides, as the mesh tells.
///
/// # Errors
/// 404 where there is one of them not.
pub async fn both(
    app: &App,
    (sketch, mesh): (&str, &str),
    besides: impl FnOnce(&Shape) -> usize,
) -> Result<Held<(Sketch, FileMesh)>, Problem> {
    let (flat, solid) = (stored(app, ShapeKind::Sketch, sketch).await?, stored(app, ShapeKind::Mesh, mesh).await?);
    let bytes = [memory::of_shape(&flat), memory::of_shape(&solid), besides(&solid)];
    let room = app.room_for(bytes.into_iter().fold(0, usize::saturating_add)).await?;
    Ok(Held::new((sketch_read(app, sketch).await?, mesh_read(app, mesh).await?), room))
}

async fn mesh_read(app: &App, id: &str) -> Result<FileMesh, Problem> {
    app.store.mesh(id).await?.ok_or_else(|| missing(ShapeKind::Mesh, id))
}

async fn sketch_read(app: &App, id: &str) -> Result<Sketch, Problem> {
    app.store.sketch(id).await?.ok_or_else(|| missing(ShapeKind::Sketch, id))
}

fn missing(kind: ShapeKind, id: &str) -> Problem {
    Problem::not_found(format_args!("{} {id}", kind.as_str()))
}

/// The document of a shape whose measures were stored as a `T`.
fn document<T: DeserializeOwned>(shape: Shape) -> Result<ShapeDocument<T>, Problem> {
    let measures = serde_json::from_value(shape.body).map_err(Problem::internal)?;
    let (created_at, expires_at) = (timestamp(shape.created_ms), shape.expires_ms.map(timestamp));
    Ok(ShapeDocument { id: shape.id, name: shape.name, created_at, expires_at, measures })
}

/// Answers an upload with this query, once under one key.
pub async fn once(
    app: &App,
    kind: ShapeKind,
    key: &IdempotencyKey,
    (upload, query): (Arc<Upload>, String),
    answer: impl Future<Output = Result<Answer, Problem>>,
) -> Result<Response, Problem> {
    let call = format!("POST {}", paths::of_shapes(kind));
    let print = app.off_runtime(move || fingerprint(&call, &[&upload.bytes, query.as_bytes()])).await?;
    Ok(key.once(&app.store, &print, answer).await?.into_response())
}

/// The answer to an upload, which stays or goes within the hour: 201 for a new shape, 200 for one whose content was known.
pub async fn uploaded<T: DeserializeOwned + Serialize>(
    app: &App,
    (shape, new): (Shape, bool),
    temporary: bool,
) -> Result<Answer, Problem> {
    let shape = match (temporary, shape.expires_ms) {
        (true, _) if new || shape.expires_ms.is_some() => app.store.make_temporary(shape, new).await?,
        (false, Some(_)) => app.store.make_lasting(shape).await?,
        _ => shape,
    };
    let location = paths::of_shape(shape.kind, &shape.id);
    let status = if new { StatusCode::CREATED } else { StatusCode::OK };
    Answer::json(status, Some(location), &document::<T>(shape)?)
}

/// A page of the shapes of one kind.
pub async fn listed<T>(app: &App, kind: ShapeKind, query: &PageQuery) -> Result<Response, Problem>
where
    T: DeserializeOwned + Serialize,
{
    let shapes = app.store.shapes(kind, &query.page()?).await.map_err(cursor_fault)?;
    query.listing(paths::of_shapes(kind), shapes, Shape::cursor, document::<T>)
}

/// What a shape is to be called.
#[derive(Debug, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct Renaming {
    /// The name, or null for none.
    #[serde(deserialize_with = "Option::deserialize")]
    #[schema(max_length = 200, required = true)]
    name: Option<String>,
}

/// The document of a shape, renamed as the body says.
///
/// # Errors
/// 404 where there is none; whatever is wrong with the body.
pub async fn renamed<T: DeserializeOwned>(
    app: &App,
    kind: ShapeKind,
    id: &str,
    body: JsonBody,
) -> Result<ShapeDocument<T>, Problem> {
    let Renaming { name } = json::parsed(&body.bytes)?;
    if !name.as_deref().is_none_or(is_name) {
        let fault = Fault::at_pointer("/name", NO_NAME);
        return Err(Problem::refused("the name is not acceptable", vec![fault]));
    }
    document(app.store.rename(kind, id, name.as_deref()).await?.ok_or_else(|| missing(kind, id))?)
}

/// Deletes a shape.
///
/// # Errors
/// 404 where there is none, 409 while an unfinished job needs it.
pub async fn deleted(app: &App, kind: ShapeKind, id: &str) -> Result<StatusCode, Problem> {
    match app.store.delete_shape(kind, id).await? {
        Deletion::Done => Ok(StatusCode::NO_CONTENT),
        Deletion::Needed => {
            let detail = format!("{} {id} is needed by a job that has not ended", kind.as_str());
            Err(Problem::new(StatusCode::CONFLICT, detail).retry_after(1))
        }
        Deletion::Missing => Err(missing(kind, id)),
    }
}

/// The name given.
///
/// # Errors
/// 422 where it is longer than a name may be.
pub fn name(given: Option<String>) -> Result<Option<String>, Problem> {
    if given.as_deref().is_none_or(is_name) {
        return Ok(given);
    }
    Err(Problem::refused("the name is not acceptable", vec![Fault::in_query("name", NO_NAME)]))
}

fn is_name(name: &str) -> bool {
    name.chars().count() <= LONGEST_NAME && is_text(name)
}

/// What of a text can be a name.
pub(super) fn shortened(text: &str) -> String {
    text.chars().filter(|&character| character != NUL).take(LONGEST_NAME).collect()
}
