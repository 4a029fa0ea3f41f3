//! Which of the parts of a mesh may make up a figure.

use super::TriangleMesh;
use super::connectivity::Components;
use super::disjoint_sets::DisjointSets;
use super::joining::grid::Grid;

/// Share of the area from which a component is the figure, whatever else there is.
pub(super) const NEARLY_ALL: f64 = 0.97;
/// Share of the area of the largest component from which another one may be the figure by itself.
const SIZEABLE: f64 = 0.1;
/// Cells along the longest side of the mesh: parts that are in one of them or in neighbours may be parts of one body, which
/// are gaps of up to an eighteenth, and some of twice as much.
const CELLS: usize = 18;

/// The sets of components, ascending, that may be the figure of a mesh, the likeliest first: where one has nearly all the
/// area, it alone; else the one of most triangles, all that nearly touch the largest, the largest, and what is left of all
/// without it, which may be a plate or a garment.
pub fn figures(mesh: &TriangleMesh, components: &Components) -> Vec<Vec<usize>> {
    let list = &components.list;
    let largest = components.largest();
    if list[largest].area >= NEARLY_ALL * list.iter().map(|c| c.area).sum::<f64>() {
        return vec![vec![largest]];
    }
    let sizeable = (0..list.len()).filter(|&c| list[c].area >= SIZEABLE * list[largest].area);
    let finest = sizeable.fold(largest, |best, c| if list[c].triangles > list[best].triangles { c } else { best });
    let neighbourhood = Neighbourhood::of(mesh, components);
    let whole = neighbourhood.group(largest, |_| true);
    let beside = whole.iter().copied().filter(|&c| c != largest);
    let next = beside.reduce(|best, c| if list[c].area > list[best].area { c } else { best });
    let rest = next.map(|next| neighbourhood.group(next, |c| c != largest)).unwrap_or_default();
    let triangles: usize = whole.iter().map(|&c| list[c].triangles).sum();
    // A body that has most of the detail is the figure, what is on it or below it an accessory.
    let mut likeliest = [vec![finest], whole];
    if 2 * list[finest].triangles <= triangles {
        likeliest.reverse();
    }
    let mut figures: Vec<Vec<usize>> = Vec::new();
    for set in likeliest.into_iter().chain([vec![largest], rest]) {
        if !set.is_empty() && !figures.contains(&set) {
            figures.push(set);
        }
    }
    figures
}

/// Which cells of a coarse grid the components are in.
struct Neighbourhood {
    grid: Option<Grid>,
    /// Cells and the components in them, each pair once.
    presences: Vec<(usize, u32)>,
    components: usize,
}

impl Neighbourhood {
    fn of(mesh: &TriangleMesh, components: &Components) -> Neighbourhood {
        let corners = |t: &[u32; 3]| t.map(|v| mesh.positions()[v as usize]);
        let all = || mesh.triangles().iter().map(corners);
        let grid = Grid::around(all().flatten(), CELLS).filter(|grid| grid.can_hold(all()));
        let mut presences = Vec::new();
        if let Some(grid) = &grid {
            for (triangle, &component) in all().zip(&components.of_triangle) {
                grid.cross(triangle, |cell| {
                    if presences.last() != Some(&(cell, component)) {
                        presences.push((cell, component));
                    }
                });
            }
        }
        presences.sort_unstable();
        presences.dedup();
        Neighbourhood { grid, presences, components: components.list.len() }
    }

    /// Those of the components that belong which hang together with one of them, ascending.
    fn group(&self, of: usize, belongs: impl Fn(usize) -> bool) -> Vec<usize> {
        let Some(grid) = &self.grid else { return vec![of] };
        let mut sets = DisjointSets::new(self.components + grid.cells());
        let mut is_occupied = vec![false; grid.cells()];
        let node = |cell: usize| (self.components + cell) as u32;
        for &(cell, component) in self.presences.iter().filter(|(_, c)| belongs(*c as usize)) {
            sets.join(component, node(cell));
            is_occupied[cell] = true;
        }
        for cell in (0..is_occupied.len()).filter(|&cell| is_occupied[cell]) {
            for next in grid.around_cell(cell).filter(|&next| is_occupied[next]) {
                sets.join(node(cell), node(next));
            }
        }
        let group = sets.representative(of as u32);
        (0..self.components).filter(|&c| belongs(c) && sets.representative(c as u32) == group).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::connectivity::components;

    /// Tetrahedra of these sizes at these places along x.
    fn tetrahedra(parts: &[(f64, f64)]) -> Vec<Vec<usize>> {
        let corners = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let positions =
            parts.iter().flat_map(|&(x, size)| corners.map(|p| [x + size * p[0], size * p[1], size * p[2]]));
        let sides = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
        let triangles = (0..parts.len() as u32).flat_map(|part| sides.map(|t| t.map(|v| 4 * part + v)));
        let mesh = TriangleMesh::new(positions.collect(), triangles.collect()).unwrap();
        figures(&mesh, &components(&mesh))
    }

    #[test]
    fn what_has_nearly_all_the_area_is_the_figure() {
        assert_eq!(tetrahedra(&[(0.0, 0.1), (2.0, 1.0)]), [[1]]);
        assert_eq!(tetrahedra(&[(0.0, 1.0)]), [[0]]);
    }

    #[test]
    fn parts_that_nearly_touch_may_be_one_figure() {
        let figures = tetrahedra(&[(0.0, 1.0), (1.02, 0.8), (9.0, 0.9)]);
        assert_eq!(figures, [vec![0, 1], vec![0], vec![1]]);
    }
}
