//! The colour of a ground where it is seen, and behind what is drawn on it.

use crate::raster::bitmap::Bitmap;

/// Side of the blocks for which the colour of the ground is told, in pixels.
pub(super) const BLOCK: usize = 16;

/// The mean colour of the ground by blocks; where none is seen what those around lead to.
pub(super) struct Blocks {
    columns: usize,
    colours: Vec<[u8; 3]>,
}

/// Blocks of one size: how many pixels of ground each has, and the sums of their colours.
struct Level {
    columns: usize,
    rows: usize,
    sums: Vec<[u64; 4]>,
}

impl Blocks {
    /// Larger blocks fill in for smaller ones without ground, smoothly [GGSC96, pull and push].
    pub fn of(colours: &[[u8; 3]], seen: &Bitmap) -> Blocks {
        let (width, height) = (seen.width(), seen.height());
        let (columns, rows) = (width.div_ceil(BLOCK), height.div_ceil(BLOCK));
        let mut finest = Level { columns, rows, sums: vec![[0; 4]; columns * rows] };
        for y in 0..height {
            for run in seen.runs(y) {
                for x in run {
                    finest.add(x / BLOCK, y / BLOCK, 1, colours[y * width + x].map(u64::from));
                }
            }
        }
        let mut levels = vec![finest];
        while let Some(fine) = levels.last().filter(|level| level.sums.len() > 1) {
            let (columns, rows) = (fine.columns.div_ceil(2), fine.rows.div_ceil(2));
            let mut coarse = Level { columns, rows, sums: vec![[0; 4]; columns * rows] };
            for (i, &[r, g, b, n]) in fine.sums.iter().enumerate() {
                coarse.add(i % fine.columns / 2, i / fine.columns / 2, n, [r, g, b]);
            }
            levels.push(coarse);
        }
        // White where no ground is seen at all.
        let (mut wider, mut filled) = (1, vec![[255.0; 3]]);
        for level in levels.iter().rev() {
            filled = level.filled(wider, &filled);
            wider = level.columns;
        }
        Blocks { columns, colours: filled.into_iter().map(|colour| colour.map(|value| value.round() as u8)).collect() }
    }

    /// The colour of the ground about a pixel.
    pub fn colour(&self, x: usize, y: usize) -> [u8; 3] {
        self.colours[y / BLOCK * self.columns + x / BLOCK]
    }
}

impl Level {
    fn add(&mut self, column: usize, row: usize, pixels: u64, [r, g, b]: [u64; 3]) {
        debug_assert!(row < self.rows);
        let sums = &mut self.sums[row * self.columns + column];
        for (sum, value) in sums.iter_mut().zip([r, g, b, pixels]) {
            *sum += value;
        }
    }

    /// The mean colour of each block; where it has none, between those of the larger blocks about it, in so many columns.
    fn filled(&self, columns: usize, larger: &[[f32; 3]]) -> Vec<[f32; 3]> {
        let rows = larger.len() / columns;
        let between = |column: usize, row: usize| {
            // A block lies a quarter of a larger one's side off its middle.
            let beside = |at: usize, count: usize| {
                if at.is_multiple_of(2) { (at / 2).saturating_sub(1) } else { (at / 2 + 1).min(count - 1) }
            };
            let (near, far) = ([column / 2, row / 2], [beside(column, columns), beside(row, rows)]);
            let at = |x: usize, y: usize, channel: usize| larger[y * columns + x][channel];
            std::array::from_fn(|channel| {
                let along = |y: usize| 0.75 * at(near[0], y, channel) + 0.25 * at(far[0], y, channel);
                0.75 * along(near[1]) + 0.25 * along(far[1])
            })
        };
        let mean = |(i, &[r, g, b, n]): (usize, &[u64; 4])| match n {
            0 => between(i % self.columns, i / self.columns),
            n => [r, g, b].map(|sum| (sum / n) as f32),
        };
        self.sums.iter().enumerate().map(mean).collect()
    }
}
