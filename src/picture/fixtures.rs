//! Shapes for the tests of pictures.

use super::Matched;
use crate::geometry::frame::Frame;
use crate::mesh::TriangleMesh;
use crate::sketch::{Sketch, YAxis};

/// The cube from −1 to 1, wound outwards; vertices 4 to 7 have z = 1.
pub fn cube() -> TriangleMesh {
    let positions = (0..8).map(|i| [i & 1, i >> 1 & 1, i >> 2].map(|bit| 2.0 * f64::from(bit) - 1.0)).collect();
    let sides = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangles = sides.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    TriangleMesh::new(positions, triangles).unwrap()
}

/// A square of four vertices, and the vertices of a cube they are.
pub struct Square {
    pub sketch: Sketch,
    vertices: Vec<u32>,
}

/// The square that is the side z = 1 of the cube.
pub fn square_on(cube: &TriangleMesh) -> Square {
    let vertices = vec![4, 5, 7, 6];
    let flat = |&v: &u32| {
        let [x, y, _] = cube.positions()[v as usize];
        [x, y, 0.0]
    };
    let mesh = TriangleMesh::new(vertices.iter().map(flat).collect(), vec![[0, 1, 2], [0, 2, 3]]).unwrap();
    Square { sketch: Sketch::new(mesh, YAxis::Up).unwrap(), vertices }
}

impl Square {
    /// The match of the square with the cube, seen from the front and sure of itself.
    pub fn pair<'a>(&'a self, mesh: &'a TriangleMesh) -> Matched<'a> {
        let view = Some(Frame::looking_from([0.0, 0.0, 1.0]));
        Matched { sketch: &self.sketch, mesh, vertices: self.vertices.clone(), confidence: vec![1.0; 4], view }
    }
}
