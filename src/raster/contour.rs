//! The lines round a set of pixels.

use super::bitmap::Bitmap;

/// Steps to the neighbours: right, down, left, up. A quarter turn is the next one.
const STEPS: [[isize; 2]; 4] = [[1, 0], [0, 1], [-1, 0], [0, -1]];
const LEFT: usize = 2;

/// Between a pixel of the figure and its neighbour in this direction, which is not.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Crack {
    pixel: [isize; 2],
    toward: usize,
}

/// A set of pixels, and how much of a pixel at its rim it covers.
pub struct Covered<'a> {
    pub figure: &'a Bitmap,
    /// The share of each pixel that is covered, row by row, in 255ths.
    pub shares: &'a [u8],
}

impl Covered<'_> {
    /// The closed lines round the figure, the longest first, outlines and holes alike; none where they have more than
    /// `max_points` points. Pixel centres are at whole numbers and a half.
    ///
    /// A line passes between a pixel of the figure and its neighbour where half of a pixel would be covered. Pixels that
    /// touch by corners only are apart.
    pub fn rings(&self, max_points: usize) -> Option<Vec<Vec<[f64; 2]>>> {
        let (width, height) = (self.figure.width(), self.figure.height());
        let mut visited = Bitmap::new(width, height);
        let mut rings: Vec<Vec<[f64; 2]>> = Vec::new();
        let mut points = 0;
        for y in 0..height {
            for run in self.figure.runs(y) {
                // Every closed line has a crack that faces left.
                let start = Crack { pixel: [run.start as isize, y as isize], toward: LEFT };
                if !visited.get(run.start, y) {
                    let ring = self.trace(start, &mut visited, max_points - points)?;
                    points += ring.len();
                    rings.push(ring);
                }
            }
        }
        rings.sort_by_key(|ring| std::cmp::Reverse(ring.len()));
        Some(rings)
    }

    /// The closed line through `start`, a point per crack; none above `max_points`. Pixels left of which it passes are
    /// marked.
    fn trace(&self, start: Crack, visited: &mut Bitmap, max_points: usize) -> Option<Vec<[f64; 2]>> {
        let mut ring = Vec::new();
        let mut crack = start;
        loop {
            if ring.len() >= max_points {
                return None;
            }
            if crack.toward == LEFT {
                visited.set(crack.pixel[0] as usize, crack.pixel[1] as usize);
            }
            ring.push(self.crossing(crack));
            crack = self.following(crack);
            if crack == start {
                return Some(ring);
            }
        }
    }

    /// The next crack along the figure, across the square of four pixels ahead.
    fn following(&self, crack: Crack) -> Crack {
        let ahead = (crack.toward + 1) % 4;
        let inner = Crack { toward: ahead, ..crack };
        let beside = neighbour(inner);
        let opposite = neighbour(Crack { pixel: neighbour(crack), toward: ahead });
        if !self.contains(beside) {
            inner
        } else if !self.contains(opposite) {
            Crack { pixel: beside, ..crack }
        } else {
            Crack { pixel: opposite, toward: (ahead + 2) % 4 }
        }
    }

    /// Where the share that is covered passes a half between the two centres beside a crack.
    fn crossing(&self, crack: Crack) -> [f64; 2] {
        let share = |pixel| self.index(pixel).map_or(0.0, |index| f64::from(self.shares[index]) / 255.0);
        // Never on a centre, so that no line meets another.
        let inside = (share(crack.pixel) - 0.5).max(0.05);
        let outside = (0.5 - share(neighbour(crack))).max(0.05);
        let t = inside / (inside + outside);
        [0, 1].map(|axis| crack.pixel[axis] as f64 + 0.5 + t * STEPS[crack.toward][axis] as f64)
    }

    fn contains(&self, pixel: [isize; 2]) -> bool {
        self.index(pixel).is_some_and(|index| {
            let width = self.figure.width();
            self.figure.get(index % width, index / width)
        })
    }

    fn index(&self, [x, y]: [isize; 2]) -> Option<usize> {
        let (x, y) = (usize::try_from(x).ok()?, usize::try_from(y).ok()?);
        (x < self.figure.width() && y < self.figure.height()).then(|| y * self.figure.width() + x)
    }
}

/// The pixel on the other side of a crack.
fn neighbour(Crack { pixel, toward }: Crack) -> [isize; 2] {
    [0, 1].map(|axis| pixel[axis] + STEPS[toward][axis])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_square_with_a_hole_has_two_lines() {
        let mut figure = Bitmap::new(12, 12);
        (2..10).for_each(|y| figure.fill(y, 2, 10, true));
        (5..7).for_each(|y| figure.fill(y, 5, 7, false));
        let shares: Vec<u8> = (0..144).map(|i| if figure.get(i % 12, i / 12) { 255 } else { 0 }).collect();
        let rings = Covered { figure: &figure, shares: &shares }.rings(1000).unwrap();
        assert_eq!(rings.iter().map(Vec::len).collect::<Vec<_>>(), [32, 8]);
        let low = |ring: &[[f64; 2]]| ring.iter().map(|p| p[0]).fold(f64::INFINITY, f64::min);
        assert_eq!([low(&rings[0]), low(&rings[1])], [2.0, 5.0]);
        assert!(Covered { figure: &figure, shares: &shares }.rings(39).is_none());
    }

    #[test]
    fn a_line_passes_where_half_of_a_pixel_is_covered() {
        let mut figure = Bitmap::new(5, 5);
        (1..4).for_each(|y| figure.fill(y, 1, 4, true));
        let mut shares: Vec<u8> = (0..25).map(|i| if figure.get(i % 5, i / 5) { 255 } else { 0 }).collect();
        // The last column of the figure is covered by three quarters.
        (1..4).for_each(|y| shares[y * 5 + 3] = 191);
        let ring = &Covered { figure: &figure, shares: &shares }.rings(100).unwrap()[0];
        let right = ring.iter().map(|p| p[0]).fold(0.0, f64::max);
        assert!((right - 3.83).abs() < 0.01, "{right}");
    }
}
