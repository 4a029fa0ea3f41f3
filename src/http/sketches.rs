//! Sketches: uploaded, looked at, listed.

use std::sync::Arc;

use axum::Json;
use axum::http::StatusCode;
use axum::response::Response;
use serde::Deserialize;
use utoipa::IntoParams;

use super::App;
use super::body::{JsonBody, Upload};
use super::idempotency::IdempotencyKey;
use super::page::{Listing, PageQuery};
use super::problem::{Fault, Problem};
use super::query::{Id, Query};
use super::shapes::{self, Renaming, ShapeDocument};
use crate::intake::Untaken;
use crate::intake::sketch::{self, SketchMeasures};
use crate::sketch::outline::OutlineRequest;
use crate::sketch::{Config, TARGET_VERTICES};
use crate::store::{ShapeKind, Source};

#[derive(Debug, Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
#[into_params(parameter_in = Query)]
pub struct UploadQuery {
    /// Vertices wanted; 800 where neither this nor the body says.
    #[param(minimum = 50, maximum = 20000)]
    target_vertices: Option<usize>,
    /// Which figure of the drawing to take, by its place among `figures`; 0, the largest, where it is not said.
    #[serde(default)]
    #[param(minimum = 0, default = 0)]
    figure: usize,
    /// A name to list the sketch under.
    #[param(max_length = 200)]
    name: Option<String>,
    /// Lets the sketch go by itself within the hour, unless it is uploaded again without this.
    #[serde(default)]
    #[param(default = false)]
    temporary: bool,
}

/// Takes a sketch: an outline as JSON (y up), an SVG, a PNG or a JPEG.
///
/// The drawing is the raw body, under its content type (`application/json`, `image/svg+xml`, `image/png`, `image/jpeg`) or
/// `application/octet-stream`, or the part `file` of a form. The same drawing, read the same way, is one sketch however
/// often it comes; a `name` that comes with it is the sketch's from then on, and a new one without is called as the file of the form.
#[utoipa::path(
    post, path = "/v1/sketches", operation_id = "upload_sketch", tag = "sketches",
    params(UploadQuery, ("Idempotency-Key" = Option<String>, Header, pattern = "^[!-~]{1,255}$", description = "the same key gets the same answer")),
    request_body(description = "the drawing", content(
        (OutlineRequest = "application/json"), ("image/svg+xml"), ("image/png"), ("image/jpeg"),
        ("application/octet-stream"), ("multipart/form-data"),
    )),
    responses(
        (status = 201, description = "taken", body = ShapeDocument<SketchMeasures>, headers(("Location" = String))),
        (status = 200, description = "this very drawing is known already", body = ShapeDocument<SketchMeasures>, headers(("Location" = String))),
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
        let target = target(query.target_vertices)?;
        let config = Config { max_document_bytes: app.config.max_request_bytes, ..Config::default() };
        let (looked_at, within) = (upload.clone(), config.clone());
        let known = app.off_runtime(move || {
            let kind = sketch::kind(&looked_at.bytes, looked_at.media_type.as_deref());
            let kind = kind.map_err(|untaken| looked_at.untaken(untaken))?;
            Ok::<_, Untaken>((kind, sketch::memory(&looked_at.bytes, kind, &within)?))
        });
        let (kind, memory) = known.await??;
        let (svg_reader, file, figure) = (app.config.svg_reader.clone(), upload.bytes.clone(), query.figure);
        let file_name = upload.file_name.as_deref().map(shapes::shortened);
        // The turn and the memory are of the work, which goes on where the client hangs up; so is the upload.
        let taken = app.with_memory(memory, move || {
            sketch::taken(&upload.bytes, kind, (target, figure), &config, svg_reader.as_deref())
                .map_err(|untaken| upload.untaken(untaken))
        });
        let imported = taken.await?.map_err(|untaken| Untaken { faults: of_query(untaken.faults), ..untaken })?;
        let (media_type, parameters) = (kind.media_type().to_owned(), asked_of(target, figure));
        let source = Source { bytes: file, media_type, parameters, file_name };
        let body = serde_json::to_value(SketchMeasures::of(&imported)).map_err(Problem::internal)?;
        let _turn = app.may_take(source.bytes.len(), 0).await?;
        let kept = app.store.insert_sketch(imported.sketch, source, name.as_deref(), body).await?;
        shapes::uploaded::<SketchMeasures>(&app, kept, query.temporary).await
    };
    shapes::once(&app, ShapeKind::Sketch, &key, asked, answer).await
}

/// What is asked of the reading, in words: nothing where nothing is.
fn asked_of(target: Option<usize>, figure: usize) -> String {
    let vertices = target.map(|vertices| format!("target_vertices={vertices}"));
    let figure = (figure > 0).then(|| format!("figure={figure}"));
    [vertices, figure].into_iter().flatten().collect::<Vec<_>>().join("&")
}

/// Faults of what is asked of the reading as those of the parameters that ask it.
fn of_query(faults: Vec<Fault>) -> Vec<Fault> {
    let of_query = |fault: Fault| match fault.place.as_deref() {
        Some(name @ ("figure" | "target_vertices")) => Fault::in_query(name, fault.detail),
        _ => fault,
    };
    faults.into_iter().map(of_query).collect()
}

/// The number of vertices the query asks for.
fn target(asked: Option<usize>) -> Result<Option<usize>, Problem> {
    if asked.is_none_or(|vertices| TARGET_VERTICES.contains(&vertices)) {
        return Ok(asked);
    }
    let (least, most) = TARGET_VERTICES.into_inner();
    let fault = Fault::in_query("target_vertices", format!("from {least} to {most} vertices can be asked for"));
    Err(Problem::refused("the sketch cannot be made as asked", vec![fault]))
}

/// Lists the sketches, newest first.
#[utoipa::path(
    get, path = "/v1/sketches", operation_id = "list_sketches", tag = "sketches", params(PageQuery),
    responses((status = 200, description = "a page", body = Listing<ShapeDocument<SketchMeasures>>)),
)]
pub async fn list(app: App, Query(query): Query<PageQuery>) -> Result<Response, Problem> {
    shapes::listed::<SketchMeasures>(&app, ShapeKind::Sketch, &query).await
}

/// Answers what is known of a sketch.
#[utoipa::path(
    get, path = "/v1/sketches/{id}", operation_id = "read_sketch", tag = "sketches", params(("id" = String, Path)),
    responses((status = 200, description = "the sketch", body = ShapeDocument<SketchMeasures>)),
)]
pub async fn read(app: App, Id(id): Id) -> Result<Json<ShapeDocument<SketchMeasures>>, Problem> {
    Ok(Json(shapes::known(&app, ShapeKind::Sketch, &id).await?))
}

/// Renames a sketch.
#[utoipa::path(
    patch, path = "/v1/sketches/{id}", operation_id = "rename_sketch", tag = "sketches", params(("id" = String, Path)), request_body = Renaming,
    responses((status = 200, description = "the sketch, renamed", body = ShapeDocument<SketchMeasures>)),
)]
pub async fn rename(app: App, Id(id): Id, body: JsonBody) -> Result<Json<ShapeDocument<SketchMeasures>>, Problem> {
    Ok(Json(shapes::renamed(&app, ShapeKind::Sketch, &id, body).await?))
}

/// Deletes a sketch, its file and its triangles. Matches it was part of stay.
#[utoipa::path(
    delete, path = "/v1/sketches/{id}", operation_id = "delete_sketch", tag = "sketches", params(("id" = String, Path)),
    responses(
        (status = 204, description = "deleted"),
        (status = 409, description = "a match or spectrum that is not finished needs it"),
    ),
)]
pub async fn delete(app: App, Id(id): Id) -> Result<StatusCode, Problem> {
    shapes::deleted(&app, ShapeKind::Sketch, &id).await
}
