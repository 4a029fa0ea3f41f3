//! The results of poses.

use std::convert::Infallible;

use axum::http::{HeaderMap, StatusCode};
use axum::response::Response;
use bytes::Bytes;
use serde::Deserialize;
use serde::de::IgnoredAny;
use utoipa::IntoParams;

use super::media_types::{GLB, GLTF, JSON, OBJ, OCTETS, PNG, SAFETENSORS};
use super::pictures::width;
use super::problem::{Fault, Problem};
use super::query::{Id, Query};
use super::representation::Wanted;
use super::{App, memory, resource, shapes};
use crate::export::pose;
use crate::jobs::Posing;
use crate::picture::WIDTH;
use crate::pipeline::Settings;
use crate::posing::basis as of_handles;
use crate::posing::outcome::{HandleWeights, PoseResult};
use crate::store::ShapeKind;

/// Which frame is answered.
#[derive(Clone, Copy, Debug, Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
#[into_params(parameter_in = Query)]
pub struct FrameQuery {
    /// Counted from 0; the first where it is not given. JSON and GLB hold all.
    #[param(maximum = 1000)]
    frame: Option<usize>,
}

/// Answers the result of a pose.
///
/// JSON holds all of it. By `Accept`, `model/obj` answers one frame as the file that was uploaded, if it was an OBJ, with its
/// vertices in their new places, and `model/gltf-binary` all of them: one as the mesh, several as morph targets with an
/// animation, with the texture coordinates, materials and textures of the file where that was glTF.
#[utoipa::path(
    get, path = "/v1/poses/{id}/result", operation_id = "read_pose_result", tag = "poses",
    params(("id" = String, Path), FrameQuery),
    responses(
        (status = 200, description = "the result; a frame as the mesh's file, or all frames", content(
            (PoseResult = "application/json"), (String = "model/obj"), ("model/gltf-binary"),
        )),
        (status = 304, description = "unchanged"),
        (status = 409, description = "not finished, or finished without a result"),
    ),
)]
pub async fn read(
    app: App,
    Id(id): Id,
    Query(query): Query<FrameQuery>,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    let wanted = Wanted::negotiated(headers, &[JSON, OBJ, GLB])?;
    let Posed { result, contents } = Posed::of(&app, &id).await?;
    let frame = contents.frame(query.frame)?;
    if wanted.media_type() == JSON {
        return wanted.answer(&app, move |_| Ok::<_, Infallible>(result)).await;
    }
    let made_of = (result.clone(), format!("frame {frame}"));
    let fetched = async {
        let mesh = shapes::mesh(&app, &contents.mesh, |_| 0).await?;
        let file = app.store.file(ShapeKind::Mesh, &contents.mesh).await?;
        Ok(move |media_type| {
            let of = |kinds: &[&str]| {
                file.as_ref().filter(|file| kinds.contains(&file.media_type.as_str())).map(|file| file.bytes.as_ref())
            };
            match media_type {
                OBJ => pose::obj(&result, frame, &mesh, of(&[OBJ])),
                _ => pose::glb(&result, &mesh, of(&[GLB, GLTF])),
            }
        })
    };
    wanted.answer_made_of(&app, made_of, fetched).await
}

/// Numbers of the largest basis that is answered: 24 MB, which is 40 handles and 50,000 vertices.
const LARGEST_BASIS: usize = 6_000_000;

/// Answers the basis in which a pose is linear in the maps of its handles, for a page that drags them.
///
/// `basis` has a row for every vertex of the file and three numbers for every handle, of a cage for every corner. With
/// (a b c / d e f) the maps, in the coordinates of the sketch's upload, vertex v is at rest[v] + (X − places[v, 0]) axes[0] +
/// (Y − places[v, 1]) axes[1], X being the sum of its numbers times (a b c) and Y that times (d e f). All are of single
/// precision.
#[utoipa::path(
    get, path = "/v1/poses/{id}/basis", operation_id = "read_pose_basis", tag = "poses", params(("id" = String, Path)),
    responses(
        (status = 200, description = "`basis`, `rest`, `places` and `axes`", content(("application/vnd.safetensors"), ("application/octet-stream"))),
        (status = 304, description = "unchanged"),
        (status = 409, description = "not finished, or finished without a result; or of no handles; or its match was deleted"),
        (status = 413, description = "too large"),
    ),
)]
pub async fn basis(app: App, Id(id): Id, headers: HeaderMap) -> Result<Response, Problem> {
    let wanted = Wanted::negotiated(headers, &[SAFETENSORS, OCTETS])?;
    let Posed { result, contents } = Posed::of(&app, &id).await?;
    let fetched = async {
        let body = basis_of(&app, contents).await?;
        Ok(move |_| Ok::<_, Infallible>(body))
    };
    wanted.answer_made_of(&app, (result, "basis".to_owned()), fetched).await
}

/// The basis of a pose, written.
///
/// # Errors
/// 409 where the pose is by no handles or its match has no result, 413 where the basis is too large, 404 where a shape was
/// deleted.
async fn basis_of(app: &App, contents: Contents) -> Result<Bytes, Problem> {
    let Some(weights) = contents.weights else {
        return Err(Problem::new(StatusCode::CONFLICT, "the pose is by no handles"));
    };
    let numbers = 3 * weights.values.first().map_or(0, Vec::len);
    let vertices = shapes::stored(app, ShapeKind::Mesh, &contents.mesh).await?.vertices;
    if numbers.saturating_mul(vertices) > LARGEST_BASIS {
        let detail = format!("a basis has at most {LARGEST_BASIS} numbers: use fewer handles");
        return Err(Problem::new(StatusCode::PAYLOAD_TOO_LARGE, detail));
    }
    let matched = resource::result::<Settings>(app, &contents.matching).await?;
    let shapes = (contents.sketch.as_str(), contents.mesh.as_str());
    let shapes = shapes::both(app, shapes, |mesh| memory::of_pose(mesh.vertices)).await?;
    let write = move || {
        let (sketch, mesh) = &*shapes;
        let matched = serde_json::from_slice(&matched).map_err(Problem::internal)?;
        let basis = of_handles(sketch, mesh, &matched, &weights).map_err(Problem::internal)?;
        pose::basis(&basis, mesh).map_err(Problem::internal)
    };
    app.off_runtime(write).await?
}

/// How the picture of a pose is to be.
#[derive(Clone, Copy, Debug, Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
#[into_params(parameter_in = Query)]
pub struct PosePictureQuery {
    /// Counted from 0; the first where it is not given.
    #[param(maximum = 1000)]
    frame: Option<usize>,
    /// Its width in pixels; 1600 where it is not given.
    #[param(minimum = 100, maximum = 4000)]
    width: Option<u32>,
}

/// Answers a picture of a pose: the sketch as it was moved, the mesh as it is seen in it, and the mesh from 60° beside, in
/// the colours of the match.
#[utoipa::path(
    get, path = "/v1/poses/{id}/picture", operation_id = "draw_pose", tag = "poses",
    params(("id" = String, Path), PosePictureQuery),
    responses(
        (status = 200, description = "the picture", content(("image/png"), ("application/octet-stream"))),
        (status = 304, description = "unchanged"),
        (status = 409, description = "not finished, or finished without a result; or its match was deleted"),
    ),
)]
pub async fn picture(
    app: App,
    Id(id): Id,
    Query(query): Query<PosePictureQuery>,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    let wanted = Wanted::negotiated(headers, &[PNG, OCTETS])?;
    let width = width(query.width, WIDTH)?;
    let Posed { result, contents } = Posed::of(&app, &id).await?;
    let frame = contents.frame(query.frame)?;
    let made_of = (result.clone(), format!("picture of {frame}, {width}"));
    let fetched = async {
        let matched = resource::result::<Settings>(&app, &contents.matching).await?;
        let shapes = shapes::both(&app, (&contents.sketch, &contents.mesh), |_| 0).await?;
        Ok(move |_| pose::png(&result, frame, &matched, &shapes.0, &shapes.1, width))
    };
    wanted.answer_made_of(&app, made_of, fetched).await
}

/// The result of a pose, as it was written and read.
struct Posed {
    result: Bytes,
    contents: Contents,
}

impl Posed {
    /// # Errors
    /// 404 where there is no such pose, 409 where it has no result.
    async fn of(app: &App, id: &str) -> Result<Posed, Problem> {
        let result = resource::result::<Posing>(app, id).await?;
        let read = result.clone();
        let contents = app.off_runtime(move || serde_json::from_slice(&read)).await?.map_err(Problem::internal)?;
        Ok(Posed { result, contents })
    }
}

/// What a result is of, and how many frames it has.
#[derive(Deserialize)]
struct Contents {
    #[serde(rename = "match")]
    matching: String,
    sketch: String,
    mesh: String,
    weights: Option<HandleWeights>,
    frames: Vec<IgnoredAny>,
}

impl Contents {
    /// The frame asked for, the first by default.
    ///
    /// # Errors
    /// 404 where there is no such frame.
    fn frame(&self, asked: Option<usize>) -> Result<usize, Problem> {
        let frame = asked.unwrap_or(0);
        if frame < self.frames.len() {
            return Ok(frame);
        }
        let fault = Fault::in_query("frame", format!("the result has {} frames, counted from 0", self.frames.len()));
        Err(Problem::not_there("there is no such frame", fault))
    }
}
