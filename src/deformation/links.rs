//! What holds the places of a surface together: its edges, and threads by which the parts that hang on none of them follow
//! the nearest.

use kd_tree::KdIndexTree;
use sprs::{CsMat, TriMat};

use crate::mesh::TriangleMesh;
use crate::mesh::connectivity::components;
use crate::spectral::laplacian::stiffness;

/// Two vertices and how strongly they are held together.
pub type Link = (u32, u32, f64);

/// The least weight of an edge: across from obtuse angles the cotangents are negative, and energies without a minimum.
const LEAST: f64 = 1e-6;
/// And the most, the cotangent of a twentieth of a degree: needles are as good as rigid from there on.
const MOST: f64 = 1e3;

/// The weight of a thread.
const THREAD: f64 = 1.0;

/// The edges i < j of a mesh with half the sum of the cotangents opposite them, at least a little.
pub fn edges(mesh: &TriangleMesh) -> Vec<Link> {
    let stiffness = stiffness(mesh);
    let above = stiffness.iter().filter(|(_, (i, j))| i < j);
    above.map(|(value, (i, j))| (i as u32, j as u32, (-value).max(LEAST))).collect()
}

/// The edges of a mesh of any triangles, none so strong that nothing beside it counted, and a thread from every vertex that
/// no edges join to one of the `reached` to the nearest that they do.
pub fn joined(mesh: &TriangleMesh, reached: &[u32]) -> Vec<Link> {
    let held = |(i, j, weight): Link| (i, j, weight.min(MOST));
    let mut links: Vec<Link> = edges(mesh).into_iter().map(held).collect();
    let components = components(mesh);
    let of_vertices = components.of_vertices(mesh);
    // Vertices of no triangle are in a part of their own, which nothing reaches.
    let mut is_reached = vec![false; components.list.len() + 1];
    let on_a_surface = reached.iter().map(|&v| of_vertices[v as usize] as usize);
    on_a_surface.filter(|&part| part < components.list.len()).for_each(|part| is_reached[part] = true);
    let (near, far): (Vec<u32>, Vec<u32>) =
        (0..of_vertices.len() as u32).partition(|&v| is_reached[of_vertices[v as usize] as usize]);
    let places: Vec<[f64; 3]> = near.iter().map(|&v| mesh.positions()[v as usize]).collect();
    let tree = KdIndexTree::build_by_ordered_float(&places);
    links.extend(far.iter().filter_map(|&v| {
        let nearest = tree.nearest(&mesh.positions()[v as usize])?;
        Some((near[*nearest.item], v, THREAD))
    }));
    links
}

/// The Laplacian of links between `count` vertices: symmetric, row sums 0, both triangles and the diagonal stored.
pub fn laplacian(links: &[Link], count: usize) -> CsMat<f64> {
    let mut entries = TriMat::with_capacity((count, count), 4 * links.len());
    for &(i, j, w) in links {
        let (i, j) = (i as usize, j as usize);
        for (row, column, sign) in [(i, i, 1.0), (j, j, 1.0), (i, j, -1.0), (j, i, -1.0)] {
            entries.add_triplet(row, column, sign * w);
        }
    }
    entries.to_csr()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::solids::sheet;

    #[test]
    fn a_part_that_hangs_on_nothing_follows_the_nearest_vertex() {
        let flat = sheet(3, 3);
        let n = flat.positions().len() as u32;
        let above = flat.positions().iter().map(|&[x, y, _]| [x, y, 0.01]);
        let positions = flat.positions().iter().copied().chain(above).chain([[0.0, 0.0, 9.0]]).collect();
        let triangles = flat.triangles().iter().copied().chain(flat.triangles().iter().map(|t| t.map(|v| v + n)));
        let mesh = TriangleMesh::new(positions, triangles.collect()).unwrap();
        let (edges, links) = (edges(&mesh), joined(&mesh, &[2, 5]));
        assert_eq!(links[..edges.len()], edges);
        let threads: Vec<_> = (0..n).map(|v| (v, v + n, THREAD)).chain([(0, 2 * n, THREAD)]).collect();
        assert_eq!(links[edges.len()..], threads);
        assert_eq!(joined(&mesh, &[0, n + 1]).len(), edges.len() + 1);
    }
}
