//! Vertices and triangles of shapes, as text and as bytes.

use bytes::Bytes;
use safetensors::tensor::{Dtype, TensorView};
use serde::Serialize;
use utoipa::ToSchema;

use super::{Unwritten, npy};
use crate::sketch::Line;

/// The triangles of a shape: coordinates of its vertices, three of a mesh and two of a sketch, and triangles of their
/// numbers.
#[derive(Debug, Serialize, ToSchema)]
pub struct Geometry<'a> {
    #[schema(value_type = Vec<Vec<f64>>)]
    pub vertices: Coordinates<'a>,
    #[schema(value_type = Vec<Vec<u32>>)]
    pub triangles: &'a [[u32; 3]],
    /// The lines drawn within a sketch, longest first, each as its points: an eye, an ear, a leg before a leg.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(value_type = Option<Vec<Vec<Vec<f64>>>>)]
    pub strokes: Option<Vec<Line>>,
}

/// Coordinates of vertices.
#[derive(Debug, Serialize)]
#[serde(untagged)]
pub enum Coordinates<'a> {
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

impl Geometry<'_> {
    /// Both as JSON.
    ///
    /// # Errors
    /// What the encoder reports.
    pub fn json(&self) -> Result<Bytes, Unwritten> {
        Ok(serde_json::to_vec(self)?.into())
    }

    /// The vertices as an array, a row of coordinates each.
    pub fn npy(&self) -> Bytes {
        let [rows, columns] = self.vertices.shape();
        npy::file(rows, columns, self.vertices.flat().iter().copied()).into()
    }

    /// `vertices` (a row of coordinates each) and `triangles` (rows of three numbers of vertices).
    ///
    /// # Errors
    /// What the encoder reports.
    pub fn safetensors(&self) -> Result<Bytes, Unwritten> {
        let vertices: Vec<u8> = self.vertices.flat().iter().flat_map(|x| x.to_le_bytes()).collect();
        let triangles: Vec<u8> = self.triangles.as_flattened().iter().flat_map(|v| v.to_le_bytes()).collect();
        let views = [
            ("vertices", TensorView::new(Dtype::F64, self.vertices.shape().to_vec(), &vertices)?),
            ("triangles", TensorView::new(Dtype::U32, vec![self.triangles.len(), 3], &triangles)?),
        ];
        Ok(safetensors::serialize(views, None)?.into())
    }
}
