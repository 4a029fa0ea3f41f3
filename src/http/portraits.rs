//! Pictures of shapes by themselves, for lists and previews.

use std::fmt::Display;
use std::future::ready;

use axum::http::HeaderMap;
use axum::response::Response;
use bytes::Bytes;
use serde::Deserialize;
use utoipa::IntoParams;

use super::media_types::SVG;
use super::pictures::{PictureFormat, wanted, width};
use super::problem::Problem;
use super::query::{Id, Query};
use super::{App, shapes};
use crate::intake::sketch::{SketchMeasures, canvas, kind, memory};
use crate::picture::{self, reading};
use crate::sketch::Config;
use crate::store::{ShapeKind, SourceFile};

/// The width of the picture of a shape where nobody asks for another, in pixels.
const WIDTH: u32 = 400;

/// How the picture of a shape is to be.
#[derive(Clone, Copy, Debug, Default, Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
#[into_params(parameter_in = Query)]
pub struct PortraitQuery {
    /// The form of the picture, whatever the `Accept` header says: an `<img>` cannot choose it.
    #[param(inline)]
    format: Option<PictureFormat>,
    /// Its width in pixels; 400 where it is not given.
    #[param(minimum = 100, maximum = 4000)]
    width: Option<u32>,
}

/// Answers a picture of a mesh: grey, y up, from its front right and a little above, up to as high as it is wide.
#[utoipa::path(
    get, path = "/v1/meshes/{id}/picture", operation_id = "draw_mesh", tag = "meshes",
    params(("id" = String, Path), PortraitQuery),
    responses(
        (status = 200, description = "the picture", content(("image/png"), ("image/svg+xml"), ("application/octet-stream"))),
        (status = 304, description = "unchanged"),
    ),
)]
pub async fn of_mesh(
    app: App,
    Id(id): Id,
    Query(query): Query<PortraitQuery>,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    let mesh = shapes::mesh(&app, &id, |_| 0).await?;
    let draw = move |media_type, width| match media_type {
        SVG => picture::mesh_svg(mesh.sound(), width).map(Bytes::from),
        _ => picture::mesh_png(mesh.sound(), width).map(Bytes::from),
    };
    drawn(&app, id, query, headers, draw).await
}

/// Answers what was read of a drawing: the drawing faded, over it the triangles and the outline of the figure, and a mark
/// for every warning that has a place.
#[utoipa::path(
    get, path = "/v1/sketches/{id}/picture", operation_id = "draw_sketch", tag = "sketches",
    params(("id" = String, Path), PortraitQuery),
    responses(
        (status = 200, description = "the picture", content(("image/png"), ("image/svg+xml"), ("application/octet-stream"))),
        (status = 304, description = "unchanged"),
    ),
)]
pub async fn of_sketch(
    app: App,
    Id(id): Id,
    Query(query): Query<PortraitQuery>,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    let known = shapes::known::<SketchMeasures>(&app, ShapeKind::Sketch, &id).await?;
    let limits = Config::default();
    let drawing = app.store.file(ShapeKind::Sketch, &id).await?.and_then(|SourceFile { bytes, media_type }| {
        let kind = kind(&bytes, Some(&media_type)).ok()?;
        let taken = memory(&bytes, kind, &limits).ok()?;
        Some((bytes, kind, taken))
    });
    let taken = drawing.as_ref().map_or(0, |&(_, _, taken)| taken);
    let sketch = shapes::sketch(&app, &id, |_| taken).await?;
    let draw = move |media_type, width| {
        let canvas = drawing.and_then(|(bytes, kind, _)| canvas(&bytes, kind, &limits));
        let read = reading::Read { canvas: canvas.as_ref(), sketch: &sketch, warnings: &known.measures.warnings };
        match media_type {
            SVG => reading::svg(&read, width).map(Bytes::from),
            _ => reading::png(&read, width).map(Bytes::from),
        }
    };
    drawn(&app, id, query, headers, draw).await
}

/// Answers the picture of a shape that `draw` makes in a form and a width. An id stands for one upload and one reading of
/// it: it tells pictures apart before they are drawn.
async fn drawn<E: Display + Send + 'static>(
    app: &App,
    id: String,
    query: PortraitQuery,
    headers: HeaderMap,
    draw: impl FnOnce(&'static str, u32) -> Result<Bytes, E> + Send + 'static,
) -> Result<Response, Problem> {
    let (wanted, width) = (wanted(query.format, headers)?, width(query.width, WIDTH)?);
    let draw = move |media_type| draw(media_type, width);
    wanted.at_length().answer_made_of(app, (id.into(), format!("portrait {width}")), ready(Ok(draw))).await
}
