//! Shortest paths inside a picture between points of its outline.

use super::silhouette::Mask;

/// Shortest paths between points, each from a row to a column.
pub(super) struct InnerPaths {
    /// Blocks in a row; the last one may be filled up with points that nothing reaches.
    blocks: usize,
    lengths: Vec<[f32; BLOCK]>,
    /// The point that the path visits first.
    first: Vec<[u32; BLOCK]>,
}

/// Columns worked on side by side.
const BLOCK: usize = 8;

/// A detour shorter by less is rounding, in pixels.
const ROUNDING: f32 = 1e-3;

impl InnerPaths {
    /// The shortest paths along straight segments between the points, in pixels, that stay inside the picture, widened
    /// by a pixel to each side because the points are on its edge. Neighbours in the closed sequence of points always
    /// see each other, so that every point is reached.
    pub fn between(points: &[[f64; 2]], inside: &Mask) -> InnerPaths {
        let n = points.len();
        let blocks = n.div_ceil(BLOCK);
        let columns = (0..blocks).map(|block| std::array::from_fn(|lane| (block * BLOCK + lane) as u32));
        let first = std::iter::repeat_n(columns, n).flatten().collect();
        let mut paths = InnerPaths { blocks, lengths: vec![[f32::INFINITY; BLOCK]; n * blocks], first };
        let widened = widened(inside);
        for i in 0..n {
            *paths.length_mut(i, i) = 0.0;
            for j in i + 1..n {
                let [x, y] = [0, 1].map(|axis| points[j][axis] - points[i][axis]);
                let length = (x * x + y * y).sqrt();
                let neighbours = j == i + 1 || (i == 0 && j == n - 1);
                if neighbours || sees(&widened, points[i], points[j], length) {
                    *paths.length_mut(i, j) = length as f32;
                    *paths.length_mut(j, i) = length as f32;
                }
            }
        }
        paths.shorten();
        paths
    }

    /// Length in pixels of the shortest path.
    pub fn length(&self, from: usize, to: usize) -> f32 {
        self.lengths[from * self.blocks + to / BLOCK][to % BLOCK]
    }

    /// The point that the path visits first.
    pub fn first(&self, from: usize, to: usize) -> usize {
        self.first[from * self.blocks + to / BLOCK][to % BLOCK] as usize
    }

    fn length_mut(&mut self, from: usize, to: usize) -> &mut f32 {
        &mut self.lengths[from * self.blocks + to / BLOCK][to % BLOCK]
    }

    /// Floyd and Warshall's algorithm: allows one more point on the way at a time.
    fn shorten(&mut self) {
        let blocks = self.blocks.max(1);
        for k in 0..self.lengths.len() / blocks {
            let onward = self.lengths[k * blocks..][..blocks].to_vec();
            for (lengths, first) in self.lengths.chunks_exact_mut(blocks).zip(self.first.chunks_exact_mut(blocks)) {
                let (length, toward) = (lengths[k / BLOCK][k % BLOCK], first[k / BLOCK][k % BLOCK]);
                if length.is_infinite() {
                    continue;
                }
                for ((lengths, first), rest) in lengths.iter_mut().zip(first).zip(&onward) {
                    (*lengths, *first) = shorter((*lengths, *first), length, toward, rest);
                }
            }
        }
    }
}

/// The paths of a block, or those through one more point where they are shorter. By value, so that all lanes are
/// written whatever is shorter, which a processor does at once.
#[inline(always)]
fn shorter(
    (mut lengths, mut first): ([f32; BLOCK], [u32; BLOCK]),
    length: f32,
    toward: u32,
    rest: &[f32; BLOCK],
) -> ([f32; BLOCK], [u32; BLOCK]) {
    for lane in 0..BLOCK {
        let through = length + rest[lane];
        let shorter = through < lengths[lane] - ROUNDING;
        lengths[lane] = if shorter { through } else { lengths[lane] };
        first[lane] = if shorter { toward } else { first[lane] };
    }
    (lengths, first)
}

/// The picture and every pixel beside it.
fn widened(mask: &Mask) -> Mask {
    let side = mask.side;
    let mut wide = mask.clone();
    for (y, row) in mask.inside.chunks_exact(side.max(1)).enumerate() {
        let own = &mut wide.inside[y * side..][..side];
        for x in 1..side {
            own[x] |= row[x - 1];
            own[x - 1] |= row[x];
        }
        for beside in [y.wrapping_sub(1), y + 1].into_iter().filter(|&y| y < side) {
            wide.inside[beside * side..][..side].iter_mut().zip(row).for_each(|(wide, &inside)| *wide |= inside);
        }
    }
    wide
}

/// Whether the segment between two points of this distance is inside, looked at in steps of a pixel or less.
fn sees(mask: &Mask, from: [f64; 2], to: [f64; 2], length: f64) -> bool {
    // In 2^−16 of a pixel; centres of pixels are at whole numbers.
    const ONE: f64 = 65536.0;
    let steps = length as i32 + 2;
    let [dx, dy] = [0, 1].map(|axis| ((to[axis] - from[axis]) / f64::from(steps) * ONE) as i32);
    let [mut x, mut y] = from.map(|x| ((x + 0.5) * ONE) as i32);
    (1..steps).all(|_| {
        (x, y) = (x + dx, y + dy);
        let pixel = (y >> 16) as usize * mask.side + (x >> 16) as usize;
        mask.inside.get(pixel) == Some(&true)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mask(inside: impl Fn(usize, usize) -> bool) -> Mask {
        Mask { side: 64, inside: (0..64 * 64).map(|p| inside(p % 64, p / 64)).collect(), low: [0.0; 2], scale: 1.0 }
    }

    #[test]
    fn a_path_goes_round_the_corner() {
        // An L: two bars of 20 pixels that meet in the lower left corner.
        let bars = mask(|x, y| (10..50).contains(&x) && (10..50).contains(&y) && (x < 30 || y < 30));
        let points = [[9.5, 9.5], [49.5, 9.5], [49.5, 29.5], [29.5, 29.5], [29.5, 49.5], [9.5, 49.5]];
        let paths = InnerPaths::between(&points, &bars);
        let length = |i: usize, j: usize| f64::from(paths.length(i, j));
        assert!((length(2, 5) - 20.0 - 20f64.hypot(20.0)).abs() < 1e-3);
        assert_eq!((paths.first(2, 5), paths.first(5, 2)), (3, 3));
        assert!((length(2, 4) - 40.0).abs() < 1e-3 && paths.first(2, 4) == 3);
        assert!((length(0, 3) - 20f64.hypot(20.0)).abs() < 1e-3 && paths.first(0, 3) == 3);
    }

    #[test]
    fn without_an_inside_paths_keep_to_the_outline() {
        let points: Vec<[f64; 2]> = (0..9).map(|k| [f64::from(k), 0.0]).collect();
        let paths = InnerPaths::between(&points, &mask(|_, _| false));
        assert_eq!(paths.length(1, 5), 4.0);
        assert_eq!((paths.first(1, 5), paths.length(0, 8)), (2, 8.0));
    }
}
