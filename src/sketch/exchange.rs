//! A sketch on its way between processes: what it is made of, and proved again where it arrives.

use serde::{Deserialize, Serialize};

use super::{Refusal, Sketch, YAxis};
use crate::mesh::TriangleMesh;

/// The parts of a sketch: its vertices, y up, its triangles and the direction of y in its upload.
#[derive(Serialize, Deserialize)]
pub(super) struct Parts {
    vertices: Vec<[f64; 2]>,
    triangles: Vec<[u32; 3]>,
    y_axis: YAxis,
}

impl From<Sketch> for Parts {
    fn from(Sketch { mesh, y_axis }: Sketch) -> Parts {
        let vertices = mesh.positions().iter().map(|&[x, y, _]| [x, y]).collect();
        Parts { vertices, triangles: mesh.triangles().to_vec(), y_axis }
    }
}

impl TryFrom<Parts> for Sketch {
    type Error = Refusal;

    fn try_from(Parts { vertices, triangles, y_axis }: Parts) -> Result<Sketch, Refusal> {
        let positions = vertices.into_iter().map(|[x, y]| [x, y, 0.0]).collect();
        let mesh = TriangleMesh::new(positions, triangles).map_err(|error| Refusal::plain(error.to_string()))?;
        Sketch::new(mesh, y_axis)
    }
}
