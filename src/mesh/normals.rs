//! The directions a surface faces.

use super::TriangleMesh;
use crate::geometry::{cross, length, subtract};

/// A direction of length 1 for every vertex: the mean of its triangles', weighted by area; along z where there is none.
pub fn vertex_normals(mesh: &TriangleMesh) -> Vec<[f64; 3]> {
    normals(mesh.positions(), mesh.triangles())
}

/// As [`vertex_normals`], with the vertices at any positions.
pub fn normals(positions: &[[f64; 3]], triangles: &[[u32; 3]]) -> Vec<[f64; 3]> {
    let mut sums = vec![[0.0; 3]; positions.len()];
    for triangle in triangles {
        let [a, b, c] = triangle.map(|v| positions[v as usize]);
        let normal = cross(subtract(b, a), subtract(c, a));
        for &v in triangle {
            (0..3).for_each(|i| sums[v as usize][i] += normal[i]);
        }
    }
    let unit = |sum: [f64; 3]| {
        let length = length(sum);
        if length > 0.0 { sum.map(|x| x / length) } else { [0.0, 0.0, 1.0] }
    };
    sums.into_iter().map(unit).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::dot;
    use crate::geometry::unit;
    use crate::mesh::solids::sphere;

    #[test]
    fn a_sphere_faces_outward() {
        let mesh = sphere(20, 40);
        for (normal, &position) in vertex_normals(&mesh).into_iter().zip(mesh.positions()) {
            assert!((length(normal) - 1.0).abs() < 1e-12 && dot(normal, unit(position)) > 0.99);
        }
    }

    #[test]
    fn a_vertex_of_no_triangle_faces_somewhere() {
        let positions = vec![[0.0; 3], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [9.0; 3]];
        let mesh = TriangleMesh::new(positions, vec![[0, 1, 2]]).unwrap();
        assert_eq!(vertex_normals(&mesh), [[1.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]);
    }
}
