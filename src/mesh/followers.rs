//! How the vertices of a file follow those of another mesh that answer for them, as where its surface was made coarser.

use super::TriangleMesh;
use crate::geometry::{length, nearest_on_triangle, subtract};

/// Where a vertex of the file is beside the mesh that it follows: at the point nearest to it of the triangles around the vertex
/// that answers for it. Neighbours in the file thus follow nearly the same, also where others answer for them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Follower {
    /// The triangle; of one vertex alone where the file's stands at it.
    pub corners: [u32; 3],
    /// Their weights at the point, which sum to 1.
    pub weights: [f64; 3],
}

impl Follower {
    /// The sum of what the corners have, by their weights.
    pub fn blended<const N: usize>(&self, of: impl Fn(usize) -> [f64; N]) -> [f64; N] {
        let weighed = self.corners.into_iter().zip(self.weights).filter(|(_, weight)| *weight != 0.0);
        weighed.fold([0.0; N], |sum, (corner, weight)| {
            let own = of(corner as usize);
            std::array::from_fn(|i| sum[i] + weight * own[i])
        })
    }
}

/// The followers of a mesh, per vertex of a file at these positions, `answering` being the vertices of the mesh that answer for them;
/// nothing where none does.
pub fn followers(
    mesh: &TriangleMesh,
    positions: &[[f64; 3]],
    answering: impl Iterator<Item = Option<usize>>,
) -> impl Iterator<Item = Option<Follower>> {
    let stars = Stars::of(mesh);
    let follower = move |(&p, own): (&[f64; 3], Option<usize>)| {
        let own = own?;
        let alone = Follower { corners: [own as u32; 3], weights: [1.0, 0.0, 0.0] };
        if mesh.positions[own] == p {
            return Some(alone);
        }
        let near = stars.around(own).iter().map(|&t| {
            let corners = mesh.triangles[t as usize];
            let places = corners.map(|v| mesh.positions[v as usize]);
            let nearest = Follower { corners, weights: nearest_on_triangle(p, places) };
            (length(subtract(p, nearest.blended(|v| mesh.positions[v]))), nearest)
        });
        Some(near.reduce(|a, b| if b.0 < a.0 { b } else { a }).map_or(alone, |(_, nearest)| nearest))
    };
    positions.iter().zip(answering).map(follower)
}

/// The triangles around each vertex.
struct Stars {
    /// Per vertex where its triangles begin, and where those of the last end.
    starts: Vec<u32>,
    triangles: Vec<u32>,
}

impl Stars {
    fn of(mesh: &TriangleMesh) -> Stars {
        let mut starts = vec![0; mesh.positions.len() + 1];
        mesh.triangles.as_flattened().iter().for_each(|&v| starts[v as usize] += 1);
        let mut sum = 0;
        for start in &mut starts {
            sum += *start;
            *start = sum;
        }
        let mut triangles = vec![0; sum as usize];
        // From the ends, which the sums are, to the starts.
        for (t, triangle) in mesh.triangles.iter().enumerate().rev() {
            for &v in triangle {
                starts[v as usize] -= 1;
                triangles[starts[v as usize] as usize] = t as u32;
            }
        }
        Stars { starts, triangles }
    }

    fn around(&self, vertex: usize) -> &[u32] {
        &self.triangles[self.starts[vertex] as usize..self.starts[vertex + 1] as usize]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::file_mesh::FileMesh;
    use crate::mesh::solids::sphere;

    #[test]
    fn a_vertex_follows_the_nearest_triangle_around_the_one_that_answers_for_it() {
        let corners = [[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]].map(|[x, y]| [x, y, 0.0]).to_vec();
        let square = TriangleMesh::new(corners, vec![[0, 1, 2], [0, 2, 3]]).unwrap();
        let positions = [[2.0, 0.0, 0.0], [0.5, 1.5, 7.0], [0.5, 1.5, 7.0], [9.0; 3]];
        let answering = [Some(1), Some(0), Some(1), None];
        let followers: Vec<Option<Follower>> = followers(&square, &positions, answering.into_iter()).collect();
        let expected = [
            Some(([1, 1, 1], [1.0, 0.0, 0.0])),
            Some(([0, 2, 3], [0.25, 0.25, 0.5])),
            Some(([0, 1, 2], [0.5, 0.0, 0.5])),
            None,
        ];
        assert_eq!(followers, expected.map(|found| found.map(|(corners, weights)| Follower { corners, weights })));
    }

    #[test]
    fn a_file_lies_near_the_coarser_surface_that_it_follows() {
        let ball = sphere(30, 60);
        let mesh = FileMesh::from(ball).decimated(500).unwrap();
        let answering = (0..mesh.positions().len() as u32).map(|v| mesh.sound_vertices(v).next().map(|v| v as usize));
        let followers = followers(mesh.sound(), mesh.positions(), answering);
        for (p, follower) in mesh.positions().iter().zip(followers) {
            let follower = follower.unwrap();
            let near = follower.blended(|v| mesh.sound().positions()[v]);
            // Equal triangles would be 0.07 wide.
            assert!(length(subtract(*p, near)) < 0.02, "{p:?} {near:?}");
        }
    }
}
