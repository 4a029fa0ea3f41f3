//! A grid of cubes about a body.

use crate::geometry::{cross, length, subtract};
use crate::numerics::{Cancelled, Pace, Watch};

/// Cells between the body and the border of the grid: more than any gap that is closed.
const MARGIN: usize = 6;
/// Most samples of all triangles.
const SAMPLES: f64 = 3e8;

/// Cells in the order of their places, x fastest.
pub struct Grid {
    low: [f64; 3],
    spacing: f64,
    pub sizes: [usize; 3],
}

impl Grid {
    /// The grid about points with so many cells along their longest side; nothing where they have no extent.
    pub fn around(points: impl Iterator<Item = [f64; 3]>, cells: usize) -> Option<Grid> {
        let (low, high) = points.fold(([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]), |(low, high), p| {
            ([0, 1, 2].map(|i: usize| p[i].min(low[i])), [0, 1, 2].map(|i: usize| p[i].max(high[i])))
        });
        let extent = subtract(high, low);
        let spacing = extent.into_iter().fold(0.0, f64::max) / cells as f64;
        if spacing.is_nan() || spacing <= 0.0 {
            return None;
        }
        let sizes = extent.map(|x| (x / spacing).ceil() as usize + 1 + 2 * MARGIN);
        Some(Grid { low: low.map(|x| x - MARGIN as f64 * spacing), spacing, sizes })
    }

    /// Whether the triangles can be sampled in a second or so.
    pub fn can_hold(&self, triangles: impl Iterator<Item = [[f64; 3]; 3]>) -> bool {
        let samples = |t| {
            let [rows, columns] = self.samples(t);
            (rows * columns) as f64
        };
        triangles.map(samples).sum::<f64>() <= SAMPLES
    }

    pub fn cells(&self) -> usize {
        self.sizes.iter().product()
    }

    /// Where a place counted in cells from the first is.
    pub fn place(&self, cells: [f64; 3]) -> [f64; 3] {
        [0, 1, 2].map(|i: usize| self.low[i] + self.spacing * cells[i])
    }

    fn cell(&self, p: [f64; 3]) -> usize {
        let at = |i: usize| (((p[i] - self.low[i]) / self.spacing).round() as usize).min(self.sizes[i] - 1);
        (at(2) * self.sizes[1] + at(1)) * self.sizes[0] + at(0)
    }

    /// Steps along the first side and along what is across it, half a cell each at most.
    fn samples(&self, [a, b, c]: [[f64; 3]; 3]) -> [usize; 2] {
        let (u, v) = (subtract(b, a), subtract(c, a));
        let along = length(u);
        // Across a side of no length is along the other.
        let across = if along > 0.0 {
            (length(cross(u, v)) / along).max(length(v).min(length(subtract(c, b))))
        } else {
            length(v)
        };
        [along, across].map(|x| (2.0 * x / self.spacing).ceil() as usize + 1)
    }

    /// Calls `visit` with the cells that a triangle passes through, some of them several times.
    pub fn cross(&self, triangle: [[f64; 3]; 3], mut visit: impl FnMut(usize)) {
        let [a, b, c] = triangle;
        let [columns, rows] = self.samples(triangle);
        for row in 0..=rows {
            let t = row as f64 / rows as f64;
            // Rows are as much shorter as they are nearer to the tip.
            let steps = ((1.0 - t) * columns as f64).ceil().max(1.0) as usize;
            for step in 0..=steps {
                let s = (1.0 - t) * step as f64 / steps as f64;
                visit(self.cell([0, 1, 2].map(|i: usize| a[i] + s * (b[i] - a[i]) + t * (c[i] - a[i]))));
            }
        }
    }

    /// Flags of the cells that can be reached from the first through cells that are `open`, across their sides.
    ///
    /// # Errors
    /// [`Cancelled`] by the watcher.
    pub fn reached_from_the_border(
        &self,
        open: impl Fn(usize) -> bool,
        watch: &dyn Watch,
    ) -> Result<Vec<bool>, Cancelled> {
        self.reached(0, open, watch)
    }

    /// Whether these cells can be reached from each other through cells that are `inside`.
    ///
    /// # Errors
    /// [`Cancelled`] by the watcher.
    pub fn hang_together(
        &self,
        inside: impl Fn(usize) -> bool,
        mut cells: impl Iterator<Item = usize>,
        watch: &dyn Watch,
    ) -> Result<bool, Cancelled> {
        let Some(first) = cells.next() else { return Ok(true) };
        let reached = self.reached(first, inside, watch)?;
        Ok(cells.all(|cell| reached[cell]))
    }

    fn reached(&self, start: usize, open: impl Fn(usize) -> bool, watch: &dyn Watch) -> Result<Vec<bool>, Cancelled> {
        let mut pace = Pace::new(watch, self.cells());
        let mut reached = vec![false; self.cells()];
        let mut pending = vec![start];
        reached[start] = true;
        while let Some(cell) = pending.pop() {
            pace.step()?;
            for next in self.beside(cell) {
                if !reached[next] && open(next) {
                    reached[next] = true;
                    pending.push(next);
                }
            }
        }
        Ok(reached)
    }

    /// The cells that share a side, an edge or a corner with a cell of which none lies on the border.
    pub fn around_cell(&self, cell: usize) -> impl Iterator<Item = usize> + use<> {
        let [nx, ny, _] = self.sizes.map(|size| size as isize);
        let offsets = (0..27).map(|i| [i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1]).filter(|offset| *offset != [0; 3]);
        offsets.map(move |[x, y, z]| cell.wrapping_add_signed((z * ny + y) * nx + x))
    }

    /// The squared distance of two cells.
    pub fn squared_distance(&self, [a, b]: [usize; 2]) -> usize {
        let (a, b) = (self.coordinates(a), self.coordinates(b));
        (0..3).map(|i| a[i].abs_diff(b[i]).pow(2)).sum()
    }

    /// Calls `visit` with the cells on the straight way between two, some of them several times.
    pub fn between(&self, [a, b]: [usize; 2], mut visit: impl FnMut(usize)) {
        let (a, b) = (self.coordinates(a), self.coordinates(b));
        let steps = 2 * (0..3).map(|i| a[i].abs_diff(b[i])).max().unwrap_or(0);
        for step in 0..=steps {
            // Half a cell at a step, rounded.
            let [x, y, z] = [0, 1, 2].map(|i: usize| (a[i] * (steps - step) + b[i] * step + steps / 2) / steps.max(1));
            visit((z * self.sizes[1] + y) * self.sizes[0] + x);
        }
    }

    fn coordinates(&self, cell: usize) -> [usize; 3] {
        let [nx, ny, _] = self.sizes;
        [cell % nx, cell / nx % ny, cell / (nx * ny)]
    }

    /// The cells that share a side with a cell.
    pub fn beside(&self, cell: usize) -> impl Iterator<Item = usize> + use<> {
        let [nx, ny, nz] = self.sizes;
        let [x, y, z] = self.coordinates(cell);
        let steps = [(x > 0, -1), (x + 1 < nx, 1), (y > 0, -(nx as isize)), (y + 1 < ny, nx as isize)];
        let slice = (nx * ny) as isize;
        let steps = steps.into_iter().chain([(z > 0, -slice), (z + 1 < nz, slice)]);
        steps.filter(|(exists, _)| *exists).map(move |(_, step)| cell.wrapping_add_signed(step))
    }
}
