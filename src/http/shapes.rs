//! What meshes and sketches have in common as resources.

use std::future::Future;

use axum::http::StatusCode;
use axum::response::{IntoResponse, Response};
use bytes::Bytes;
use serde::Serialize;
use serde::de::DeserializeOwned;
use utoipa::ToSchema;

use super::App;
use super::idempotency::{Answer, IdempotencyKey, fingerprint};
use super::job_document::timestamp;
use super::page::PageQuery;
use super::problem::{Fault, Problem};
use crate::mesh::file_mesh::FileMesh;
use crate::sketch::Sketch;
use crate::store::{Kind, Shape, StoreError};

/// Characters of a name at most.
const LONGEST_NAME: usize = 200;

/// A stored shape: what every shape has, and the measures of its kind.
#[derive(Debug, Serialize, ToSchema)]
pub struct ShapeDocument<T> {
    pub id: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// RFC 3339.
    #[schema(format = DateTime)]
    pub created_at: String,
    #[serde(flatten)]
    pub measures: T,
}

/// The triangles of a shape: coordinates of its vertices, three of a mesh and two of a sketch, and triangles of their
/// numbers.
#[derive(Debug, Serialize, ToSchema)]
pub struct Geometry<'a> {
    #[schema(value_type = Vec<Vec<f64>>)]
    pub vertices: Coordinates<'a>,
    #[schema(value_type = Vec<Vec<u32>>)]
    pub triangles: &'a [[u32; 3]],
}

impl Geometry<'_> {
    pub fn json(&self) -> serde_json::Result<Bytes> {
        serde_json::to_vec(self).map(Bytes::from)
    }
}

#[derive(Debug, Serialize)]
#[serde(untagged)]
pub enum Coordinates<'a> {
    Space(&'a [[f64; 3]]),
    Plane(&'a [[f64; 2]]),
}

impl Kind {
    /// The noun in messages.
    pub(super) fn noun(self) -> &'static str {
        match self {
            Kind::Mesh => "mesh",
            Kind::Sketch => "sketch",
        }
    }

    /// Where the shapes of this kind are listed.
    pub(super) fn path(self) -> &'static str {
        match self {
            Kind::Mesh => "/v1/meshes",
            Kind::Sketch => "/v1/sketches",
        }
    }
}

/// What is known of the shape of this id, its measures stored as a `T`.
///
/// # Errors
/// 404 where there is none.
pub async fn known<T: DeserializeOwned>(app: &App, kind: Kind, id: &str) -> Result<ShapeDocument<T>, Problem> {
    document(app.store.shape(kind, id).await?.ok_or_else(|| missing(kind, id))?)
}

/// The geometry of a mesh.
///
/// # Errors
/// 404 where there is none.
pub async fn mesh(app: &App, id: &str) -> Result<FileMesh, Problem> {
    app.store.mesh(id).await?.ok_or_else(|| missing(Kind::Mesh, id))
}

/// The geometry of a sketch.
///
/// # Errors
/// 404 where there is none.
pub async fn sketch(app: &App, id: &str) -> Result<Sketch, Problem> {
    app.store.sketch(id).await?.ok_or_else(|| missing(Kind::Sketch, id))
}

fn missing(kind: Kind, id: &str) -> Problem {
    Problem::not_found(format_args!("{} {id}", kind.noun()))
}

/// The document of a shape whose measures were stored as a `T`.
fn document<T: DeserializeOwned>(shape: Shape) -> Result<ShapeDocument<T>, Problem> {
    let measures = serde_json::from_value(shape.body).map_err(Problem::internal)?;
    Ok(ShapeDocument { id: shape.id, name: shape.name, created_at: timestamp(shape.created_ms), measures })
}

/// Answers an upload of these bytes and this query, once under one key.
pub async fn once(
    app: &App,
    kind: Kind,
    key: &IdempotencyKey,
    (bytes, query): (Bytes, String),
    answer: impl Future<Output = Result<Answer, Problem>>,
) -> Result<Response, Problem> {
    let print = app.off_runtime(move || fingerprint(&[&bytes, query.as_bytes()])).await?;
    let route = format!("POST {}", kind.path());
    Ok(key.once(&app.store, &route, &print, answer).await?.into_response())
}

/// The answer to an upload: 201 for a new shape, 200 for one whose content was known.
pub fn uploaded<T: DeserializeOwned + Serialize>((shape, new): (Shape, bool)) -> Result<Answer, Problem> {
    let location = format!("{}/{}", shape.kind.path(), shape.id);
    let status = if new { StatusCode::CREATED } else { StatusCode::OK };
    Answer::json(status, Some(location), &document::<T>(shape)?)
}

/// A page of the shapes of one kind.
pub async fn listed<T>(app: &App, kind: Kind, query: &PageQuery) -> Result<Response, Problem>
where
    T: DeserializeOwned + Serialize,
{
    let shapes = app.store.shapes(kind, &query.page()?).await.map_err(cursor_fault)?;
    query.listing(kind.path(), shapes, Shape::cursor, document::<T>)
}

/// A cursor that is none of ours is the client's fault, everything else the store's.
pub fn cursor_fault(error: StoreError) -> Problem {
    match error {
        StoreError::Cursor => {
            let fault = Fault::in_query("after", "this is not where a page ended");
            Problem::refused("the page is not acceptable", vec![fault])
        }
        error => error.into(),
    }
}

/// The name to keep: the one given, else that of the file.
///
/// # Errors
/// 422 where the one given is longer than a name may be.
pub fn name(given: Option<String>, file_name: Option<String>) -> Result<Option<String>, Problem> {
    match given {
        Some(name) if name.chars().count() > LONGEST_NAME => {
            let fault = Fault::in_query("name", format!("a name has at most {LONGEST_NAME} characters"));
            Err(Problem::refused("the name is not acceptable", vec![fault]))
        }
        Some(name) => Ok(Some(name)),
        None => Ok(file_name.map(|name| name.chars().take(LONGEST_NAME).collect())),
    }
}
