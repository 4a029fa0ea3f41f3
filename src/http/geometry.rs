//! Vertices and triangles of shapes, as text and as bytes.

use axum::http::HeaderMap;
use axum::response::Response;
use bytes::Bytes;

use super::media_types::{GLB, JSON, NPY, SAFETENSORS};
use super::problem::Problem;
use super::query::Id;
use super::representation::Wanted;
use super::{App, shapes};
use crate::export::Unwritten;
use crate::export::geometry::{Coordinates, Geometry};
use crate::picture;

/// A geometry in one of the forms every shape has.
fn written(geometry: &Geometry<'_>, media_type: &str) -> Result<Bytes, Unwritten> {
    match media_type {
        NPY => Ok(geometry.npy()),
        SAFETENSORS => geometry.safetensors(),
        _ => geometry.json(),
    }
}

/// Answers the triangles of a mesh.
///
/// JSON holds `vertices` and `triangles`. By `Accept`, `application/vnd.safetensors` answers both as arrays,
/// `application/x-npy` the vertices, and `model/gltf-binary` the mesh in single precision.
#[utoipa::path(
    get, path = "/v1/meshes/{id}/mesh", operation_id = "read_mesh_geometry", tag = "meshes", params(("id" = String, Path)),
    responses(
        (status = 200, description = "the triangles", content(
            (Geometry = "application/json"), ("application/vnd.safetensors"), ("application/x-npy"), ("model/gltf-binary"),
        )),
        (status = 304, description = "unchanged"),
    ),
)]
pub async fn of_mesh(app: App, Id(id): Id, headers: HeaderMap) -> Result<Response, Problem> {
    let wanted = Wanted::negotiated(headers, &[JSON, SAFETENSORS, NPY, GLB])?;
    let mesh = shapes::mesh(&app, &id, |_| 0).await?;
    let write = move |media_type| match media_type {
        GLB => Ok(picture::mesh_glb(&mesh)?.into()),
        _ => {
            let vertices = Coordinates::Space(mesh.positions());
            written(&Geometry { vertices, triangles: mesh.triangles(), strokes: None }, media_type)
        }
    };
    wanted.answer(&app, write).await
}

/// Answers the triangles of a sketch, in the coordinates it was uploaded in.
///
/// JSON holds `vertices`, `triangles` and `strokes`, the lines drawn within the figure. By `Accept`,
/// `application/vnd.safetensors` answers vertices and triangles as arrays, and `application/x-npy` the vertices.
#[utoipa::path(
    get, path = "/v1/sketches/{id}/mesh", operation_id = "read_sketch_geometry", tag = "sketches",
    params(("id" = String, Path)),
    responses(
        (status = 200, description = "the triangles", content(
            (Geometry = "application/json"), ("application/vnd.safetensors"), ("application/x-npy"),
        )),
        (status = 304, description = "unchanged"),
    ),
)]
pub async fn of_sketch(app: App, Id(id): Id, headers: HeaderMap) -> Result<Response, Problem> {
    let wanted = Wanted::negotiated(headers, &[JSON, SAFETENSORS, NPY])?;
    let sketch = shapes::sketch(&app, &id, |_| 0).await?;
    let write = move |media_type| {
        let vertices = sketch.points();
        let vertices = Coordinates::Plane(&vertices);
        let (triangles, strokes) = (sketch.mesh().triangles(), Some(sketch.drawn_strokes()));
        written(&Geometry { vertices, triangles, strokes }, media_type)
    };
    wanted.answer(&app, write).await
}
