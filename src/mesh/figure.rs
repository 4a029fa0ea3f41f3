//! The part of a mesh that is matched.

use kd_tree::KdIndexTree;

use super::TriangleMesh;
use super::connectivity::{Component, Components, components};
use super::file_mesh::FileMesh;
use super::joining::joined;
use crate::numerics::{Cancelled, Pace, Watch};

/// Marks a vertex of the file that is not on the figure.
const ELSEWHERE: u32 = u32::MAX;

/// A connected surface that is matched, and the way between its vertices and those of the file.
#[derive(Clone, Debug, PartialEq)]
pub struct Figure {
    /// Every vertex is used.
    pub mesh: TriangleMesh,
    /// Per vertex of the figure the vertex of the file that answers for it.
    pub vertices: Vec<u32>,
    /// Per vertex of the file its vertex of the figure, or [`ELSEWHERE`].
    places: Vec<u32>,
    /// The numbers of the components it is made of, ascending.
    pub components: Vec<usize>,
}

impl Figure {
    /// The component of largest area; of equals, the first.
    pub fn largest(mesh: &FileMesh) -> Figure {
        let components = components(mesh.sound());
        Figure::of_component(mesh, &components, components.largest())
    }

    /// One component of the mesh.
    pub fn of_component(mesh: &FileMesh, components: &Components, number: usize) -> Figure {
        let Component { mesh: own, vertices } = components.cut_out(mesh.sound(), &[number]);
        let mut by_origin = vec![ELSEWHERE; mesh.positions().len()];
        for (own, &v) in vertices.iter().enumerate().rev() {
            by_origin[mesh.origins()[v as usize] as usize] = own as u32;
        }
        Figure {
            mesh: own,
            vertices: vertices.into_iter().map(|v| mesh.origins()[v as usize]).collect(),
            places: mesh.merged().iter().map(|&lowest| by_origin[lowest as usize]).collect(),
            components: vec![number],
        }
    }

    /// The figure of these components, ascending: itself where it is one, the surface around all where they are more, whose
    /// vertices answer with the nearest of the file; nothing where there is none around them.
    ///
    /// # Errors
    /// [`Cancelled`] by the watcher.
    pub fn of_components(
        mesh: &FileMesh,
        components: &Components,
        numbers: &[usize],
        watch: &dyn Watch,
    ) -> Result<Option<Figure>, Cancelled> {
        if let &[number] = numbers {
            return Ok(Some(Figure::of_component(mesh, components, number)));
        }
        let sound = mesh.sound();
        let mut chosen = vec![false; components.list.len()];
        numbers.iter().for_each(|&number| chosen[number] = true);
        let belongs = |t: &usize| chosen[components.of_triangle[*t] as usize];
        let (triangles, parts): (Vec<[u32; 3]>, Vec<u32>) = (0..sound.triangles().len())
            .filter(belongs)
            .map(|t| (sound.triangles()[t], components.of_triangle[t]))
            .unzip();
        let Some(around) = joined(sound.positions(), &triangles, &parts, watch)? else { return Ok(None) };
        let mut vertices = triangles.into_flattened();
        vertices.sort_unstable();
        vertices.dedup();
        let own = nearest(sound.positions(), &vertices, around.positions(), watch)?;
        let each: Vec<u32> = (0..around.positions().len() as u32).collect();
        let corners: Vec<[f64; 3]> = vertices.iter().map(|&v| sound.positions()[v as usize]).collect();
        let places = nearest(around.positions(), &each, &corners, watch)?;
        let mut by_origin = vec![ELSEWHERE; mesh.positions().len()];
        for (&v, place) in vertices.iter().zip(places).rev() {
            by_origin[mesh.origins()[v as usize] as usize] = place;
        }
        Ok(Some(Figure {
            mesh: around,
            vertices: own.into_iter().map(|v| mesh.origins()[v as usize]).collect(),
            places: mesh.merged().iter().map(|&lowest| by_origin[lowest as usize]).collect(),
            components: numbers.to_vec(),
        }))
    }

    /// The vertex of the figure that a vertex of the file names, where it is on it.
    pub fn at(&self, vertex: u32) -> Option<usize> {
        self.places.get(vertex as usize).filter(|&&own| own != ELSEWHERE).map(|&own| own as usize)
    }

    /// Per vertex of the file its vertex of the figure, none where it is not on it.
    pub fn of_file(&self) -> impl ExactSizeIterator<Item = Option<usize>> {
        self.places.iter().map(|&own| (own != ELSEWHERE).then_some(own as usize))
    }
}

/// For every point the nearest of the `candidates`, which are numbers of positions.
fn nearest(
    positions: &[[f64; 3]],
    candidates: &[u32],
    points: &[[f64; 3]],
    watch: &dyn Watch,
) -> Result<Vec<u32>, Cancelled> {
    let places: Vec<[f64; 3]> = candidates.iter().map(|&v| positions[v as usize]).collect();
    let tree = KdIndexTree::build_by_ordered_float(&places);
    let mut pace = Pace::new(watch, points.len());
    let nearest = |p| {
        pace.step()?;
        Ok(tree.nearest(p).map_or(ELSEWHERE, |nearest| candidates[*nearest.item]))
    };
    points.iter().map(nearest).collect()
}
