//! The example creatures: made by code when they are first asked for, and kept.

use std::convert::Infallible;
use std::sync::Arc;

use axum::Json;
use axum::http::HeaderMap;
use axum::response::Response;
use bytes::Bytes;
use serde::Serialize;
use tokio::sync::OnceCell;
use utoipa::ToSchema;

use super::App;
use super::media_types::{JSON, OBJ, OCTETS, PNG, SVG};
use super::problem::Problem;
use super::query::Id;
use super::representation::Wanted;
use crate::example::{Creature, Unmade, VERTICES, drawing, obj};
use crate::sketch::outline::OutlineRequest;

/// A creature to try the service with.
#[derive(Debug, Serialize, ToSchema)]
pub struct ExampleDocument {
    #[schema(example = "quadruped")]
    name: &'static str,
    description: &'static str,
    links: ExampleLinks,
}

#[derive(Debug, Serialize, ToSchema)]
pub struct ExampleLinks {
    /// Its mesh as OBJ, as it can be uploaded.
    mesh: String,
    /// A sketch of it, as it can be uploaded.
    sketch: String,
}

/// The files of every creature that was asked for.
#[derive(Clone, Debug, Default)]
pub struct Examples(Arc<[OnceCell<Files>; Creature::ALL.len()]>);

/// The files of a creature.
#[derive(Clone, Debug)]
struct Files {
    mesh: Bytes,
    outline: Bytes,
    svg: Bytes,
    png: Bytes,
}

impl Files {
    fn of(creature: Creature) -> Result<Files, Unmade> {
        let mesh = creature.mesh(VERTICES)?;
        let silhouette = creature.silhouette(&mesh)?;
        Ok(Files {
            mesh: obj(&mesh).into(),
            outline: drawing::json(&silhouette).into(),
            svg: drawing::svg(&silhouette).into(),
            png: drawing::png(&silhouette)?.into(),
        })
    }
}

/// The files of the creature of this name.
///
/// # Errors
/// 404 where there is none.
async fn files(app: &App, name: &str) -> Result<Files, Problem> {
    let found = Creature::ALL.into_iter().zip(app.examples.0.iter()).find(|(creature, _)| creature.name() == name);
    let (creature, kept) = found.ok_or_else(|| Problem::not_found(format_args!("example {name}")))?;
    let make = || async { app.off_runtime(move || Files::of(creature)).await?.map_err(Problem::internal) };
    kept.get_or_try_init(make).await.cloned()
}

/// Lists the example creatures.
#[utoipa::path(
    get, path = "/v1/examples", operation_id = "list_examples", tag = "examples",
    responses((status = 200, description = "every creature", body = Vec<ExampleDocument>)),
)]
pub async fn list() -> Json<Vec<ExampleDocument>> {
    let document = |creature: Creature| {
        let name = creature.name();
        let [mesh, sketch] = ["mesh", "sketch"].map(|file| format!("/v1/examples/{name}/{file}"));
        ExampleDocument { name, description: creature.description(), links: ExampleLinks { mesh, sketch } }
    };
    Json(Creature::ALL.map(document).into())
}

/// Answers the mesh of a creature as OBJ.
#[utoipa::path(
    get, path = "/v1/examples/{name}/mesh", operation_id = "read_example_mesh", tag = "examples",
    params(("name" = String, Path, description = "the name of a creature", example = "quadruped")),
    responses(
        (status = 200, description = "the mesh", content(("model/obj"), ("application/octet-stream"))),
        (status = 304, description = "unchanged"),
    ),
)]
pub async fn mesh(app: App, Id(name): Id, headers: HeaderMap) -> Result<Response, Problem> {
    let wanted = Wanted::negotiated(headers, &[OBJ, OCTETS])?;
    let files = files(&app, &name).await?;
    wanted.answer(&app, move |_| Ok::<_, Infallible>(files.mesh)).await
}

/// Answers a sketch of a creature.
///
/// JSON holds the outline. By `Accept`, `image/svg+xml` and `image/png` answer the same drawing as a picture.
#[utoipa::path(
    get, path = "/v1/examples/{name}/sketch", operation_id = "read_example_sketch", tag = "examples",
    params(("name" = String, Path, description = "the name of a creature", example = "quadruped")),
    responses(
        (status = 200, description = "the sketch", content(
            (OutlineRequest = "application/json"), (String = "image/svg+xml"), ("image/png"),
        )),
        (status = 304, description = "unchanged"),
    ),
)]
pub async fn sketch(app: App, Id(name): Id, headers: HeaderMap) -> Result<Response, Problem> {
    let wanted = Wanted::negotiated(headers, &[JSON, SVG, PNG])?;
    let files = files(&app, &name).await?;
    let write = move |media_type| match media_type {
        SVG => Ok::<_, Infallible>(files.svg),
        PNG => Ok(files.png),
        _ => Ok(files.outline),
    };
    wanted.answer(&app, write).await
}
