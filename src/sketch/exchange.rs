//! A sketch on its way between processes: what it is made of, and proved again where it arrives.

use serde::{Deserialize, Serialize};

use super::{Line, Refusal, Sketch, YAxis};
use crate::mesh::TriangleMesh;

/// The parts of a sketch: its vertices, y up, its triangles, the direction of y in its upload, and the lines within it.
#[derive(Serialize, Deserialize)]
pub(super) struct Parts {
    vertices: Vec<[f64; 2]>,
    triangles: Vec<[u32; 3]>,
    y_axis: YAxis,
    strokes: Vec<Line>,
}

impl From<Sketch> for Parts {
    fn from(Sketch { mesh, y_axis, strokes }: Sketch) -> Parts {
        let vertices = mesh.positions().iter().map(|&[x, y, _]| [x, y]).collect();
        Parts { vertices, triangles: mesh.triangles().to_vec(), y_axis, strokes }
    }
}

impl TryFrom<Parts> for Sketch {
    type Error = Refusal;

    fn try_from(Parts { vertices, triangles, y_axis, strokes }: Parts) -> Result<Sketch, Refusal> {
        let positions = vertices.into_iter().map(|[x, y]| [x, y, 0.0]).collect();
        let mesh = TriangleMesh::new(positions, triangles).map_err(|error| Refusal::plain(error.to_string()))?;
        Ok(Sketch::new(mesh, y_axis)?.with_strokes(strokes))
    }
}
