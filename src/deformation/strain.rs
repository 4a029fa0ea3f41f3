//! What a deformation did to a mesh.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use crate::geometry::{cross, dot, length, subtract};
use crate::mesh::TriangleMesh;
use crate::mesh::edges::Edges;

/// How a deformation changed a mesh, as shares of what was before.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct Strain {
    /// Volume after by volume before, less 1; nothing where the mesh is not closed.
    pub volume_change: Option<f64>,
    /// |length after by length before, less 1|, mean over the edges.
    pub mean_edge_change: f64,
    /// The largest of them.
    pub max_edge_change: f64,
    /// Triangles turned over against those around them that were not before.
    pub flipped_triangles: usize,
}

/// What became of a mesh whose vertices went to other places.
///
/// # Panics
/// Where there are fewer places than vertices.
pub fn strain(mesh: &TriangleMesh, places: &[[f64; 3]]) -> Strain {
    let (mut closed, mut count, mut sum, mut most) = (true, 0usize, 0.0, 0.0f64);
    let before = mesh.positions();
    for edge in Edges::of(mesh.triangles()).iter() {
        closed &= edge.half_edges().len() == 2;
        let [a, b] = edge.ends().map(|v| v as usize);
        let was = length(subtract(before[a], before[b]));
        if was > 0.0 {
            let change = (length(subtract(places[a], places[b])) / was - 1.0).abs();
            (count, sum, most) = (count + 1, sum + change, most.max(change));
        }
    }
    let flips = facing(mesh, before).into_iter().zip(facing(mesh, places));
    Strain {
        volume_change: closed.then(|| volume(mesh, places) / volume(mesh, before) - 1.0).filter(|x| x.is_finite()),
        mean_edge_change: sum / count.max(1) as f64,
        max_edge_change: most,
        flipped_triangles: flips.filter(|&(before, after)| before > 0.0 && after < 0.0).count(),
    }
}

/// Signed, about the first vertex.
fn volume(mesh: &TriangleMesh, places: &[[f64; 3]]) -> f64 {
    let around = places[0];
    let six = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|v| subtract(places[v as usize], around));
        dot(a, cross(b, c))
    };
    mesh.triangles().iter().map(six).sum::<f64>() / 6.0
}

/// For every triangle whether it faces as those around its corners do, which is positive, or against them.
fn facing(mesh: &TriangleMesh, places: &[[f64; 3]]) -> Vec<f64> {
    let normal = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|v| places[v as usize]);
        cross(subtract(b, a), subtract(c, a))
    };
    let mut around = vec![[0.0; 3]; places.len()];
    for triangle in mesh.triangles() {
        let normal = normal(triangle);
        triangle.iter().for_each(|&v| (0..3).for_each(|i| around[v as usize][i] += normal[i]));
    }
    let against = |t: &[u32; 3]| {
        let own = normal(t);
        // What is around without the triangle itself, which is in the sum of each corner.
        let others: [f64; 3] =
            std::array::from_fn(|i| t.iter().map(|&v| around[v as usize][i]).sum::<f64>() - 3.0 * own[i]);
        dot(own, others)
    };
    mesh.triangles().iter().map(against).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::solids::{sheet, sphere, turned};

    #[test]
    fn a_motion_strains_nothing_and_scaling_everything_alike() {
        let mesh = sphere(12, 24);
        let moved: Vec<[f64; 3]> = mesh.positions().iter().map(|&p| turned(p, [0.4, 1.1]).map(|x| x + 2.0)).collect();
        let found = strain(&mesh, &moved);
        assert!(found.volume_change.unwrap().abs() < 1e-12 && found.max_edge_change < 1e-12);
        let larger: Vec<[f64; 3]> = mesh.positions().iter().map(|p| p.map(|x| 1.1 * x)).collect();
        let found = strain(&mesh, &larger);
        assert!((found.volume_change.unwrap() - 0.331).abs() < 1e-12);
        assert!((found.mean_edge_change - 0.1).abs() < 1e-12 && (found.max_edge_change - 0.1).abs() < 1e-12);
        assert_eq!(found.flipped_triangles, 0);
    }

    #[test]
    fn a_vertex_pushed_past_its_neighbours_turns_triangles_over() {
        let mesh = sheet(6, 6);
        let mut places = mesh.positions().to_vec();
        let side = places[1][0];
        places[3 * 7 + 3][0] += 1.5 * side;
        let found = strain(&mesh, &places);
        assert_eq!(found.volume_change, None);
        // The two to its right turn over; it takes more to tell which of the others do.
        assert!((2..=4).contains(&found.flipped_triangles), "{}", found.flipped_triangles);
        assert_eq!(strain(&mesh, mesh.positions()).flipped_triangles, 0);
    }
}
