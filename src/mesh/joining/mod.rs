//! Parts of a body made one surface: everything that is closed in by them, as a grid sees it.

mod bridges;
pub(super) mod grid;

use fast_surface_nets::ndshape::RuntimeShape;
use fast_surface_nets::{SurfaceNetsBuffer, surface_nets};

use super::TriangleMesh;
use super::connectivity::largest_component;
use super::mending::mended;
use crate::numerics::distance_transform::squared_distances;
use crate::numerics::{Cancelled, Pace, Share, Watch};
use bridges::{EMPTY, bridges};
use grid::Grid;

/// Cells along the longest side: arms and legs are several cells thick.
const CELLS: usize = 128;
/// Gaps and holes of up to twice these widths, in cells, are closed; the first with which the parts hang together is taken, after
/// gaps that are wider are bridged.
const CLOSED: [f32; 3] = [1.5, 2.5, 3.5];
/// Rounds in which the steps of the grid are smoothed.
const ROUNDS: usize = 3;

/// The surface around triangles of several parts, closed and connected, about half a cell outside them; nothing where they
/// do not enclose any or are too many and large. `parts` are numbers of the parts, one per triangle.
///
/// # Errors
/// [`Cancelled`] by the watcher.
pub(super) fn joined(
    positions: &[[f64; 3]],
    triangles: &[[u32; 3]],
    parts: &[u32],
    watch: &dyn Watch,
) -> Result<Option<TriangleMesh>, Cancelled> {
    let corners = |t: &[u32; 3]| t.map(|v| positions[v as usize]);
    let Some(grid) = Grid::around(triangles.iter().flat_map(corners), CELLS) else { return Ok(None) };
    if !grid.can_hold(triangles.iter().map(corners)) {
        return Ok(None);
    }
    let mut part_in = vec![EMPTY; grid.cells()];
    let mut seeds: Vec<(u32, usize)> = Vec::new();
    let mut pace = Pace::new(watch, triangles.len());
    for (triangle, &part) in triangles.iter().zip(parts) {
        let (mut first, mut samples) = (None, 0);
        grid.cross(corners(triangle), |cell| {
            samples += 1;
            if part_in[cell] == EMPTY {
                part_in[cell] = part;
            }
            first.get_or_insert(cell);
        });
        seeds.extend(first.map(|cell| (part, cell)));
        pace.steps(samples)?;
    }
    seeds.sort_unstable();
    seeds.dedup_by_key(|(part, _)| *part);
    let share = |i: usize| Share::of(watch, i, CLOSED.len() + 1);
    let mut body = Body { is_surface: part_in.iter().map(|&part| part != EMPTY).collect(), seeds, grid };
    let Closed { depths, together } = body.closed(CLOSED[0], &share(0))?;
    if together {
        return surface(&body.grid, &depths, watch);
    }
    let count = parts.iter().max().map_or(0, |&last| last as usize + 1);
    for cell in bridges(&body.grid, &part_in, count, &share(0))? {
        body.is_surface[cell] = true;
    }
    for (i, closed) in CLOSED.into_iter().enumerate() {
        let Closed { depths, together } = body.closed(closed, &share(i + 1))?;
        if together || i + 1 == CLOSED.len() {
            return surface(&body.grid, &depths, watch);
        }
    }
    Ok(None)
}

/// A body as a grid sees it.
struct Body {
    grid: Grid,
    /// Flags of the cells that its surface passes through.
    is_surface: Vec<bool>,
    /// A cell of each part.
    seeds: Vec<(u32, usize)>,
}

/// Everything closed in by a body.
struct Closed {
    /// Per cell how far outside it is, about, in cells; less than 0 inside.
    depths: Vec<f32>,
    /// Whether all parts hang together.
    together: bool,
}

impl Body {
    /// What cannot be reached from outside through gaps of up to twice this width, in cells.
    fn closed(&self, width: f32, watch: &dyn Watch) -> Result<Closed, Cancelled> {
        let from_surface = squared_distances(&self.is_surface, self.grid.sizes, watch)?;
        let is_outside = self.grid.reached_from_the_border(|cell| from_surface[cell] > width * width, watch)?;
        let from_outside = squared_distances(&is_outside, self.grid.sizes, watch)?;
        let depths: Vec<f32> = from_outside.into_iter().map(|squared| width - squared.sqrt()).collect();
        let seeds = self.seeds.iter().map(|&(_, cell)| cell);
        let together = self.grid.hang_together(|cell| depths[cell] < 0.0, seeds, watch)?;
        Ok(Closed { depths, together })
    }
}

/// The largest connected surface where `depths` changes its sign.
fn surface(grid: &Grid, depths: &[f32], watch: &dyn Watch) -> Result<Option<TriangleMesh>, Cancelled> {
    watch.proceed(1.0)?;
    let sizes = grid.sizes.map(|size| size as u32);
    let mut net = SurfaceNetsBuffer::default();
    surface_nets(depths, &RuntimeShape::<u32, 3>::new(sizes), [0; 3], sizes.map(|size| size - 1), &mut net);
    let triangles: Vec<[u32; 3]> = net.indices.as_chunks::<3>().0.to_vec();
    let mut positions: Vec<[f64; 3]> = net.positions.iter().map(|p| grid.place(p.map(f64::from))).collect();
    watch.proceed(1.0)?;
    let Some(sound) = mended(&positions, &triangles).0 else { return Ok(None) };
    positions = sound.origins.iter().map(|&v| positions[v as usize]).collect();
    (0..ROUNDS).for_each(|_| smooth(&mut positions, &sound.triangles));
    watch.proceed(1.0)?;
    let mesh = TriangleMesh::new(positions, sound.triangles).ok();
    Ok(mesh.map(|mesh| largest_component(&mesh).mesh))
}

/// Moves every vertex half way to the mean of its neighbours.
fn smooth(positions: &mut [[f64; 3]], triangles: &[[u32; 3]]) {
    let mut sums = vec![([0.0; 3], 0.0); positions.len()];
    for &[a, b, c] in triangles {
        for (vertex, neighbour) in [(a, b), (b, c), (c, a), (b, a), (c, b), (a, c)] {
            let (sum, count) = &mut sums[vertex as usize];
            *sum = std::array::from_fn(|i| sum[i] + positions[neighbour as usize][i]);
            *count += 1.0;
        }
    }
    for (p, (sum, count)) in positions.iter_mut().zip(sums).filter(|(_, (_, count))| *count > 0.0) {
        *p = std::array::from_fn(|i| 0.5 * (p[i] + sum[i] / count));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::edges::Edges;
    use crate::numerics::Unwatched;

    /// A box of these extents from this corner.
    fn cuboid(corner: [f64; 3], extent: [f64; 3]) -> (Vec<[f64; 3]>, Vec<[u32; 3]>) {
        let bit = |i: u32, axis: usize| f64::from(i >> axis & 1);
        let positions = (0..8).map(|i| [0, 1, 2].map(|axis| corner[axis] + extent[axis] * bit(i, axis))).collect();
        let sides = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        (positions, sides.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect())
    }

    fn together(boxes: &[([f64; 3], [f64; 3])]) -> TriangleMesh {
        let (mut positions, mut triangles, mut parts) = (Vec::new(), Vec::new(), Vec::new());
        for (part, &(corner, extent)) in (0..).zip(boxes) {
            let first = positions.len() as u32;
            let (corners, sides) = cuboid(corner, extent);
            positions.extend(corners);
            parts.extend(std::iter::repeat_n(part, sides.len()));
            triangles.extend(sides.iter().map(|t| t.map(|v| first + v)));
        }
        joined(&positions, &triangles, &parts, &Unwatched).unwrap().unwrap()
    }

    #[test]
    fn parts_that_overlap_touch_or_nearly_touch_are_one_closed_surface() {
        for gap in [-0.2, 0.0, 0.02, 0.04] {
            let mesh = together(&[([0.0; 3], [1.0; 3]), ([1.0 + gap, 0.2, 0.2], [1.0, 0.6, 0.6])]);
            assert_eq!(Edges::of(mesh.triangles()).boundary().count(), 0, "{gap}");
            let whole = 6.0 + 4.0 * 0.6 * (1.0 + gap.min(0.0));
            assert!((mesh.area() / whole - 1.0).abs() < 0.08, "{gap}: {} for {whole}", mesh.area());
        }
    }

    #[test]
    fn wide_gaps_are_bridged_where_they_are_narrowest() {
        // Two legs below a trunk, more than a twentieth of the height from it, and a tenth from each other.
        let leg = |x: f64| ([x, 0.0, 0.0], [0.15, 0.2, 0.5]);
        let mesh = together(&[leg(0.0), leg(0.25), ([0.0, 0.0, 0.56], [0.4, 0.2, 0.5])]);
        assert_eq!(Edges::of(mesh.triangles()).boundary().count(), 0);
        let trunk = 2.0 * (0.4 * 0.2 + 0.4 * 0.5 + 0.2 * 0.5) - 2.0 * 0.15 * 0.2;
        let legs = 2.0 * (2.0 * (0.15 + 0.2) * 0.56 + 0.15 * 0.2);
        assert!((mesh.area() / (trunk + legs) - 1.0).abs() < 0.1, "{} for {}", mesh.area(), trunk + legs);
    }

    #[test]
    fn what_is_inside_leaves_no_trace() {
        let mesh = together(&[([0.0; 3], [1.0; 3]), ([0.4; 3], [0.2; 3])]);
        assert!((mesh.area() - 6.0).abs() < 0.4, "{}", mesh.area());
    }
}
