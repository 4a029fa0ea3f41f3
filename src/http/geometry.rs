//! Vertices and triangles of shapes, as text and as bytes.

use axum::extract::State;
use axum::http::HeaderMap;
use axum::response::Response;
use bytes::Bytes;
use safetensors::tensor::{Dtype, SafeTensorError, TensorView};
use serde::Serialize;
use utoipa::ToSchema;

use super::pictures::GLB;
use super::problem::Problem;
use super::query::Id;
use super::representation::{JSON, NPY, SAFETENSORS, Wanted};
use super::{App, npy, shapes};
use crate::picture;

/// The triangles of a shape: coordinates of its vertices, three of a mesh and two of a sketch, and triangles of their
/// numbers.
#[derive(Debug, Serialize, ToSchema)]
pub struct Geometry<'a> {
    #[schema(value_type = Vec<Vec<f64>>)]
    vertices: Coordinates<'a>,
    #[schema(value_type = Vec<Vec<u32>>)]
    triangles: &'a [[u32; 3]],
}

#[derive(Debug, Serialize)]
#[serde(untagged)]
enum Coordinates<'a> {
    Space(&'a [[f64; 3]]),
    Plane(&'a [[f64; 2]]),
}

impl Coordinates<'_> {
    /// How many vertices there are, and how many coordinates each has.
    fn shape(&self) -> [usize; 2] {
        match self {
            Coordinates::Space(points) => [points.len(), 3],
            Coordinates::Plane(points) => [points.len(), 2],
        }
    }

    /// All of them, vertex by vertex.
    fn flat(&self) -> &[f64] {
        match self {
            Coordinates::Space(points) => points.as_flattened(),
            Coordinates::Plane(points) => points.as_flattened(),
        }
    }
}

/// Why a geometry was not written.
#[derive(Debug, thiserror::Error)]
enum Unwritten {
    #[error(transparent)]
    Json(#[from] serde_json::Error),
    #[error(transparent)]
    Tensors(#[from] SafeTensorError),
    #[error(transparent)]
    Mesh(#[from] gltf::Error),
}

impl Geometry<'_> {
    /// The geometry in one of the forms every shape has.
    fn written(&self, media_type: &str) -> Result<Bytes, Unwritten> {
        let [rows, columns] = self.vertices.shape();
        Ok(match media_type {
            NPY => npy::file(rows, columns, self.vertices.flat().iter().copied()).into(),
            SAFETENSORS => self.tensors()?.into(),
            _ => serde_json::to_vec(self)?.into(),
        })
    }

    /// `vertices` (a row of coordinates each) and `triangles` (rows of three numbers of vertices).
    fn tensors(&self) -> Result<Vec<u8>, SafeTensorError> {
        let vertices: Vec<u8> = self.vertices.flat().iter().flat_map(|x| x.to_le_bytes()).collect();
        let triangles: Vec<u8> = self.triangles.as_flattened().iter().flat_map(|v| v.to_le_bytes()).collect();
        let views = [
            ("vertices", TensorView::new(Dtype::F64, self.vertices.shape().to_vec(), &vertices)?),
            ("triangles", TensorView::new(Dtype::U32, vec![self.triangles.len(), 3], &triangles)?),
        ];
        safetensors::serialize(views, None)
    }
}

/// Answers the triangles of a mesh.
///
/// JSON holds `vertices` and `triangles`. By `Accept`, `application/vnd.safetensors` answers both as arrays,
/// `application/x-npy` the vertices, and `model/gltf-binary` the mesh in single precision.
#[utoipa::path(
    get, path = "/v1/meshes/{id}/mesh", operation_id = "read_mesh_geometry", tag = "meshes", params(("id" = String, Path)),
    responses(
        (status = 200, description = "the triangles", body = Geometry),
        (status = 304, description = "unchanged"),
    ),
)]
pub async fn of_mesh(State(app): State<App>, Id(id): Id, headers: HeaderMap) -> Result<Response, Problem> {
    let wanted = Wanted::negotiated(headers, &[JSON, SAFETENSORS, NPY, GLB])?;
    let mesh = shapes::mesh(&app, &id).await?;
    let write = move |media_type| match media_type {
        GLB => Ok(picture::mesh_glb(&mesh)?.into()),
        _ => {
            Geometry { vertices: Coordinates::Space(mesh.positions()), triangles: mesh.triangles() }.written(media_type)
        }
    };
    wanted.answer(&app, write).await
}

/// Answers the triangles of a sketch, in the coordinates it was uploaded in.
///
/// JSON holds `vertices` and `triangles`. By `Accept`, `application/vnd.safetensors` answers both as arrays, and
/// `application/x-npy` the vertices.
#[utoipa::path(
    get, path = "/v1/sketches/{id}/mesh", operation_id = "read_sketch_geometry", tag = "sketches",
    params(("id" = String, Path)),
    responses(
        (status = 200, description = "the triangles", body = Geometry),
        (status = 304, description = "unchanged"),
    ),
)]
pub async fn of_sketch(State(app): State<App>, Id(id): Id, headers: HeaderMap) -> Result<Response, Problem> {
    let wanted = Wanted::negotiated(headers, &[JSON, SAFETENSORS, NPY])?;
    let sketch = shapes::sketch(&app, &id).await?;
    let write = move |media_type| {
        let vertices: Vec<[f64; 2]> = (0..sketch.mesh().positions().len()).map(|vertex| sketch.point(vertex)).collect();
        Geometry { vertices: Coordinates::Plane(&vertices), triangles: sketch.mesh().triangles() }.written(media_type)
    };
    wanted.answer(&app, write).await
}
