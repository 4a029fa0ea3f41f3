//! Shortest paths inside a picture between points of its outline.

use crate::numerics::lanes::vectorised;
use crate::raster::bitmap::Bitmap;
use crate::raster::silhouette::Mask;

/// Shortest paths between points.
pub struct InnerPaths {
    /// Blocks in a row; the last one may be filled up with points that nothing reaches.
    blocks: usize,
    /// From row to column, which is as far as back.
    lengths: Vec<[f32; BLOCK]>,
    /// The point that the path from row to column visits first.
    first: Vec<[u32; BLOCK]>,
    /// The point that the path from column to row visits first; of both, only those at or behind the block of the
    /// diagonal are kept up.
    back: Vec<[u32; BLOCK]>,
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
        let back = (0..n).flat_map(|i| std::iter::repeat_n([i as u32; BLOCK], blocks)).collect();
        let mut paths = InnerPaths { blocks, lengths: vec![[f32::INFINITY; BLOCK]; n * blocks], first, back };
        let room = Room::around(&inside.inside.widened());
        for i in 0..n {
            *paths.length_mut(i, i) = 0.0;
            for j in i + 1..n {
                let [x, y] = [0, 1].map(|axis| points[j][axis] - points[i][axis]);
                let length = (x * x + y * y).sqrt();
                let neighbours = j == i + 1 || (i == 0 && j == n - 1);
                if neighbours || room.sees(points[i], points[j], length) {
                    *paths.length_mut(i, j) = length as f32;
                    *paths.length_mut(j, i) = length as f32;
                }
            }
        }
        vectorised(
            #[inline(always)]
            || paths.shorten(),
        );
        paths
    }

    /// Length in pixels of the shortest path.
    pub fn length(&self, from: usize, to: usize) -> f32 {
        let (row, column) = (from.min(to), from.max(to));
        self.lengths[row * self.blocks + column / BLOCK][column % BLOCK]
    }

    /// The point that the path visits first.
    pub fn first(&self, from: usize, to: usize) -> usize {
        let (table, row, column) = if from <= to { (&self.first, from, to) } else { (&self.back, to, from) };
        table[row * self.blocks + column / BLOCK][column % BLOCK] as usize
    }

    fn length_mut(&mut self, from: usize, to: usize) -> &mut f32 {
        &mut self.lengths[from * self.blocks + to / BLOCK][to % BLOCK]
    }

    /// Floyd and Warshall's algorithm: allows one more point on the way at a time.
    #[inline(always)]
    fn shorten(&mut self) {
        let blocks = self.blocks;
        let n = self.lengths.len() / blocks.max(1);
        let (mut onward, mut toward) = (vec![[f32::INFINITY; BLOCK]; blocks], vec![[0; BLOCK]; blocks]);
        for k in 0..n {
            for j in 0..n {
                onward[j / BLOCK][j % BLOCK] = self.length(j, k);
                toward[j / BLOCK][j % BLOCK] = self.first(j, k) as u32;
            }
            let rows = self.lengths.chunks_exact_mut(blocks).zip(self.first.chunks_exact_mut(blocks));
            for (i, ((lengths, first), back)) in rows.zip(self.back.chunks_exact_mut(blocks)).enumerate() {
                let (length, step) = (onward[i / BLOCK][i % BLOCK], toward[i / BLOCK][i % BLOCK]);
                if length.is_infinite() {
                    continue;
                }
                let own = lengths.iter_mut().zip(first).zip(back);
                for (((lengths, first), back), (rest, toward)) in own.zip(onward.iter().zip(&toward)).skip(i / BLOCK) {
                    let through = std::array::from_fn(
                        #[inline(always)]
                        |lane| length + rest[lane],
                    );
                    // Few are, so that to look first is the quicker way.
                    if any_shorter(&through, lengths) {
                        for lane in 0..BLOCK {
                            let shorter = through[lane] < lengths[lane] - ROUNDING;
                            lengths[lane] = if shorter { through[lane] } else { lengths[lane] };
                            first[lane] = if shorter { step } else { first[lane] };
                            back[lane] = if shorter { toward[lane] } else { back[lane] };
                        }
                    }
                }
            }
        }
    }
}

/// Whether one of the paths through another point is shorter than that there is.
#[inline(always)]
fn any_shorter(through: &[f32; BLOCK], lengths: &[f32; BLOCK]) -> bool {
    let mut shorter = 0;
    for lane in 0..BLOCK {
        shorter |= u32::from(through[lane] < lengths[lane] - ROUNDING);
    }
    shorter != 0
}

/// Per pixel how far a ray goes on from it, at least, before it may leave the picture.
struct Room {
    side: usize,
    /// Pixels; 0 outside.
    steps: Vec<u8>,
}

/// Pixels to each side within which the surroundings of a pixel are looked at.
const SURROUNDINGS: [usize; 4] = [1, 3, 6, 12];

impl Room {
    fn around(picture: &Bitmap) -> Room {
        let side = picture.width();
        let mut steps = vec![0; side * picture.height()];
        let mut inside = picture.clone();
        let mut reach = 0;
        for next in SURROUNDINGS.into_iter().map(Some).chain([None]) {
            for (y, row) in steps.chunks_exact_mut(side.max(1)).enumerate() {
                inside.runs(y).for_each(|run| row[run].fill(reach as u8 + 1));
            }
            if let Some(next) = next {
                inside = inside.narrowed(next - reach);
                reach = next;
            }
        }
        Room { side, steps }
    }

    /// Whether the segment between two points of this distance is inside, looked at in steps of a pixel or less.
    fn sees(&self, from: [f64; 2], to: [f64; 2], length: f64) -> bool {
        // In 2^−16 of a pixel; centres of pixels are at whole numbers.
        const ONE: f64 = 65536.0;
        let steps = length as i32 + 2;
        let [dx, dy] = [0, 1].map(|axis| ((to[axis] - from[axis]) / f64::from(steps) * ONE) as i32);
        let [x, y] = from.map(|x| ((x + 0.5) * ONE) as i32);
        let room = |step: i32| {
            let (x, y) = ((x + step * dx) >> 16, (y + step * dy) >> 16);
            let pixel = (y as usize).wrapping_mul(self.side).wrapping_add(x as usize);
            i32::from(self.steps.get(pixel).copied().unwrap_or(0))
        };
        // Between limbs most are outside.
        if room(steps / 2) == 0 {
            return false;
        }
        // From both ends at once, which a processor can do side by side.
        let (mut low, mut high) = (1, steps - 1);
        while low <= high {
            let (ahead, back) = (room(low), room(high));
            if ahead == 0 || back == 0 {
                return false;
            }
            low += ahead;
            high -= back;
        }
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mask(inside: impl Fn(usize, usize) -> bool) -> Mask {
        let mut picture = Bitmap::new(64, 64);
        for (x, y) in (0..64 * 64).map(|pixel| (pixel % 64, pixel / 64)) {
            if inside(x, y) {
                picture.set(x, y);
            }
        }
        Mask { inside: picture, low: [0.0; 2], scale: 1.0 }
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

    /// As [`InnerPaths::between`], path by path.
    fn naive(points: &[[f64; 2]], inside: &Mask) -> Vec<Vec<(f32, usize)>> {
        let n = points.len();
        let wide = inside.inside.widened();
        let sees = |a: [f64; 2], b: [f64; 2], length: f64| {
            let steps = length as i32 + 2;
            let [dx, dy] = [0, 1].map(|axis| ((b[axis] - a[axis]) / f64::from(steps) * 65536.0) as i32);
            let [mut x, mut y] = a.map(|x| ((x + 0.5) * 65536.0) as i32);
            (1..steps).all(|_| {
                (x, y) = (x + dx, y + dy);
                wide.get((x >> 16) as usize, (y >> 16) as usize)
            })
        };
        let straight = |i: usize, j: usize| {
            let (a, b) = (points[i.min(j)], points[i.max(j)]);
            let [x, y] = [0, 1].map(|axis| b[axis] - a[axis]);
            let length = (x * x + y * y).sqrt();
            let neighbours = [1, n - 1].contains(&i.abs_diff(j));
            if i == j || neighbours || sees(a, b, length) { length as f32 } else { f32::INFINITY }
        };
        let mut paths: Vec<Vec<_>> = (0..n).map(|i| (0..n).map(|j| (straight(i, j), j)).collect()).collect();
        for k in 0..n {
            for i in 0..n {
                for j in 0..n {
                    let through = paths[i][k].0 + paths[k][j].0;
                    if through < paths[i][j].0 - ROUNDING {
                        paths[i][j] = (through, paths[i][k].1);
                    }
                }
            }
        }
        paths
    }

    #[test]
    fn paths_are_those_found_one_by_one() {
        for lobes in [2.0, 3.0, 7.0] {
            let radius = |angle: f64| 16.0 + 11.0 * (lobes * angle).cos();
            let figure = mask(|x, y| {
                let [x, y] = [x, y].map(|x| x as f64 - 32.0);
                x.hypot(y) < radius(y.atan2(x))
            });
            let angles = (0..61).map(|k| f64::from(k) * std::f64::consts::TAU / 61.0);
            let points: Vec<[f64; 2]> = angles.map(|a| [a.cos(), a.sin()].map(|x| 32.0 + radius(a) * x)).collect();
            let (paths, naive) = (InnerPaths::between(&points, &figure), naive(&points, &figure));
            for (i, j) in (0..61).flat_map(|i| (0..61).map(move |j| (i, j))) {
                assert_eq!((paths.length(i, j), paths.first(i, j)), naive[i][j], "{i} {j}");
            }
        }
    }
}
