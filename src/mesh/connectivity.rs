//! How a mesh hangs together: components, boundary, and the summary the user is shown.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::TriangleMesh;
use super::disjoint_sets::DisjointSets;
use super::edges::{self, Edges};
use super::file_mesh::FileMesh;
use crate::geometry::triangle_area;

/// What is told of a mesh in a few numbers.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = MeshSummary)]
pub struct Summary {
    /// Vertices of the user's file.
    pub vertices: usize,
    /// Triangles that the faces of the file are cut into.
    pub triangles: usize,
    /// Of the mended mesh, as all that follows; in squared units of the file.
    pub area: f64,
    /// Connected components; vertices of no triangle are none.
    pub components: usize,
    /// Edges with one triangle.
    pub boundary_edges: usize,
    /// Whether there is no boundary.
    pub closed: bool,
}

/// The summary of a file's mesh.
pub fn summary(mesh: &FileMesh) -> Summary {
    let sound = mesh.sound();
    let boundary_edges = Edges::of(&sound.triangles).boundary().count();
    Summary {
        vertices: mesh.positions().len(),
        triangles: mesh.triangles().len(),
        area: sound.area(),
        components: components(sound).list.len(),
        boundary_edges,
        closed: boundary_edges == 0,
    }
}

/// What is told of a component of a mesh.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
#[schema(as = MeshComponent)]
pub struct ComponentSummary {
    /// Its number, by which a match request names it.
    pub component: usize,
    /// The lowest vertex of the file on it.
    pub first_vertex: u32,
    /// Of the mended mesh, as all that follows.
    pub vertices: usize,
    pub triangles: usize,
    /// In squared units of the file.
    pub area: f64,
    pub boundary_edges: usize,
    pub closed: bool,
    /// The lowest and the highest corner of the box around it.
    #[schema(value_type = Vec<f64>, min_items = 3, max_items = 3)]
    pub low: [f64; 3],
    #[schema(value_type = Vec<f64>, min_items = 3, max_items = 3)]
    pub high: [f64; 3],
}

/// The summaries of a file's components, in order of their lowest vertex.
pub fn component_summaries(mesh: &FileMesh) -> Vec<ComponentSummary> {
    let sound = mesh.sound();
    let components = components(sound);
    let of_vertices = components.of_vertices(sound);
    let summary = |(component, extent): (usize, &Extent)| ComponentSummary {
        component,
        first_vertex: mesh.origins()[extent.first_vertex as usize],
        vertices: 0,
        triangles: extent.triangles,
        area: extent.area,
        boundary_edges: 0,
        closed: true,
        low: [f64::INFINITY; 3],
        high: [f64::NEG_INFINITY; 3],
    };
    let mut summaries: Vec<ComponentSummary> = components.list.iter().enumerate().map(summary).collect();
    for (&component, p) in of_vertices.iter().zip(&sound.positions) {
        if let Some(summary) = summaries.get_mut(component as usize) {
            summary.vertices += 1;
            summary.low = [0, 1, 2].map(|i: usize| summary.low[i].min(p[i]));
            summary.high = [0, 1, 2].map(|i: usize| summary.high[i].max(p[i]));
        }
    }
    for h in Edges::of(&sound.triangles).boundary() {
        let summary = &mut summaries[components.of_triangle[edges::triangle_of(h)] as usize];
        summary.boundary_edges += 1;
        summary.closed = false;
    }
    summaries
}

/// The edges that only one triangle has, each from corner to corner as that triangle runs.
pub fn boundary_edges(mesh: &TriangleMesh) -> Vec<[u32; 2]> {
    Edges::of(&mesh.triangles).boundary().map(|h| edges::ends(&mesh.triangles, h)).collect()
}

/// n flags: whether a vertex lies on the boundary.
pub fn boundary_vertices(mesh: &TriangleMesh) -> Vec<bool> {
    let mut on_boundary = vec![false; mesh.positions.len()];
    boundary_edges(mesh).into_iter().flatten().for_each(|v| on_boundary[v as usize] = true);
    on_boundary
}

/// A connected component of a mesh, or several, as a mesh of its own.
#[derive(Clone, Debug, PartialEq)]
pub struct Component {
    /// Every vertex is used.
    pub mesh: TriangleMesh,
    /// Per vertex of the component its id in the parent, ascending.
    pub vertices: Vec<u32>,
}

/// The component of largest area; of equals, the one with the smallest vertex. Vertices and triangles keep their order.
pub fn largest_component(mesh: &TriangleMesh) -> Component {
    let components = components(mesh);
    let number = components.largest();
    components.cut_out(mesh, &[number])
}

/// The connected components, in order of their smallest vertex.
pub struct Components {
    /// Per triangle the index of its component.
    pub of_triangle: Vec<u32>,
    pub list: Vec<Extent>,
}

/// What is measured of a component.
#[derive(Clone, Debug, PartialEq)]
pub struct Extent {
    pub first_vertex: u32,
    pub triangles: usize,
    /// In squared units of the file.
    pub area: f64,
}

impl Components {
    /// The number of the component of largest area; of equals, the first.
    pub fn largest(&self) -> usize {
        (1..self.list.len()).fold(0, |best, c| if self.list[c].area > self.list[best].area { c } else { best })
    }

    /// Per vertex of the mesh its component; of a vertex of no triangle the number of components.
    pub fn of_vertices(&self, mesh: &TriangleMesh) -> Vec<u32> {
        let mut of_vertices = vec![self.list.len() as u32; mesh.positions.len()];
        for (triangle, &component) in mesh.triangles.iter().zip(&self.of_triangle) {
            triangle.iter().for_each(|&v| of_vertices[v as usize] = component);
        }
        of_vertices
    }

    /// Components of the mesh, by their ascending numbers, as a mesh of their own; vertices and triangles keep their order.
    pub fn cut_out(&self, mesh: &TriangleMesh, numbers: &[usize]) -> Component {
        let inside = |t: &usize| numbers.binary_search(&(self.of_triangle[*t] as usize)).is_ok();
        let triangles: Vec<[u32; 3]> = (0..mesh.triangles.len()).filter(inside).map(|t| mesh.triangles[t]).collect();
        let mut used = vec![false; mesh.positions.len()];
        triangles.iter().flatten().for_each(|&v| used[v as usize] = true);
        let vertices: Vec<u32> = (0..used.len() as u32).filter(|&v| used[v as usize]).collect();
        let mut compact = vec![0; used.len()];
        vertices.iter().zip(0..).for_each(|(&v, id)| compact[v as usize] = id);
        // A whole component of a valid mesh is valid: nothing that is guaranteed looks beyond it but the area, and of
        // components without any the largest is not asked for.
        let mesh = TriangleMesh {
            positions: vertices.iter().map(|&v| mesh.positions[v as usize]).collect(),
            triangles: triangles.iter().map(|t| t.map(|v| compact[v as usize])).collect(),
        };
        Component { mesh, vertices }
    }
}

/// The components of a mesh; O(n).
pub fn components(mesh: &TriangleMesh) -> Components {
    let mut sets = DisjointSets::new(mesh.positions.len());
    for &[a, b, c] in &mesh.triangles {
        sets.join(a, b);
        sets.join(a, c);
    }
    let mut firsts: Vec<u32> = mesh.triangles.iter().map(|t| sets.representative(t[0])).collect();
    firsts.sort_unstable();
    firsts.dedup();
    let mut list: Vec<Extent> =
        firsts.into_iter().map(|first_vertex| Extent { first_vertex, triangles: 0, area: 0.0 }).collect();
    let mut index = vec![0; mesh.positions.len()];
    list.iter().zip(0..).for_each(|(extent, c)| index[extent.first_vertex as usize] = c);

    let of_triangle: Vec<u32> = mesh.triangles.iter().map(|t| index[sets.representative(t[0]) as usize]).collect();
    for (triangle, &c) in mesh.triangles.iter().zip(&of_triangle) {
        list[c as usize].triangles += 1;
        list[c as usize].area += triangle_area(triangle.map(|v| mesh.positions[v as usize]));
    }
    Components { of_triangle, list }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A strip of three unit squares along x with a small triangle apart and a vertex of no triangle at the front.
    fn strip() -> TriangleMesh {
        let mut positions = vec![[50.0; 3]];
        positions.extend((0..4).flat_map(|x| [[f64::from(x), 0.0, 0.0], [f64::from(x), 1.0, 0.0]]));
        positions.extend([[9.0, 0.0, 0.0], [9.1, 0.0, 0.0], [9.0, 0.1, 0.0]]);
        let squares = [1, 3, 5].into_iter().flat_map(|a| [[a, a + 2, a + 3], [a, a + 3, a + 1]]);
        TriangleMesh::new(positions, [[9, 10, 11]].into_iter().chain(squares).collect()).unwrap()
    }

    fn tetrahedron() -> TriangleMesh {
        let positions = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        TriangleMesh::new(positions, vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]).unwrap()
    }

    #[test]
    fn sums_up() {
        let summary = summary(&strip().into());
        assert_eq!((summary.vertices, summary.triangles), (12, 7));
        assert_eq!((summary.components, summary.boundary_edges, summary.closed), (2, 11, false));
        assert!((summary.area - 3.005).abs() < 1e-12);
        assert!(super::summary(&tetrahedron().into()).closed);
    }

    #[test]
    fn finds_the_boundary() {
        let on_boundary = boundary_vertices(&strip());
        assert!(!on_boundary[0] && on_boundary[1..].iter().all(|&on| on));
        assert!(!boundary_vertices(&tetrahedron()).contains(&true));
    }

    #[test]
    fn takes_the_largest_component_compactly() {
        let component = largest_component(&strip());
        assert_eq!(component.vertices, [1, 2, 3, 4, 5, 6, 7, 8]);
        assert_eq!(component.mesh.positions()[2], [1.0, 0.0, 0.0]);
        assert_eq!(component.mesh.triangles()[0], [0, 2, 3]);
        let (positions, triangles) = (component.mesh.positions.clone(), component.mesh.triangles.clone());
        assert_eq!(TriangleMesh::new(positions, triangles).as_ref(), Ok(&component.mesh));
        assert_eq!(largest_component(&component.mesh).mesh, component.mesh);
    }

    #[test]
    fn takes_the_first_of_equal_components() {
        let positions =
            [0.0, 5.0].into_iter().flat_map(|x| [[x, 0.0, 0.0], [x + 1.0, 0.0, 0.0], [x, 1.0, 0.0]]).collect();
        let mesh = TriangleMesh::new(positions, vec![[3, 4, 5], [0, 1, 2]]).unwrap();
        assert_eq!(largest_component(&mesh).vertices, [0, 1, 2]);
    }
}
