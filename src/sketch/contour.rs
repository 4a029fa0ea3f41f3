//! Figures in a field of brightness or opacity, and the lines round them.

use super::refusal::{Warning, WarningCode};
use super::ring::signed_area;

/// A picture in one channel, row by row from the top: figures are where it is above the threshold.
pub(super) struct Field {
    pub width: usize,
    pub height: usize,
    pub values: Vec<u8>,
    /// The contour runs half a step above it, so that it never meets a pixel's centre.
    pub threshold: u8,
}

/// A set of pixels above the threshold, joined by their sides.
pub(super) struct Figure {
    /// Per pixel whether it belongs to the figure.
    members: Vec<bool>,
    pub pixels: usize,
    /// Other figures larger than a speck.
    others: usize,
}

/// Figures of less than this part of the largest one are specks: left out without a word.
const SPECK: f64 = 1e-3;

/// Steps to the neighbours: right, down, left, up. A quarter turn is the next one.
const STEPS: [[isize; 2]; 4] = [[1, 0], [0, 1], [-1, 0], [0, -1]];
const LEFT: usize = 2;

/// The figure of the most pixels; of none in a field without figures.
pub(super) fn largest_figure(field: &Field) -> Figure {
    let mut seen: Vec<bool> = field.values.iter().map(|&value| value <= field.threshold).collect();
    let mut sizes = Vec::new();
    let (mut largest, mut seed) = (0, None);
    for start in 0..seen.len() {
        let size = flood(field, &mut seen, start, |_| {});
        if size > 0 {
            sizes.push(size);
        }
        if size > largest {
            (largest, seed) = (size, Some(start));
        }
    }
    let mut members = vec![false; seen.len()];
    if let Some(seed) = seed {
        let mut unseen: Vec<bool> = field.values.iter().map(|&value| value <= field.threshold).collect();
        flood(field, &mut unseen, seed, |pixel| members[pixel] = true);
    }
    let others = sizes.iter().filter(|&&size| size as f64 >= SPECK * largest as f64).count().saturating_sub(1);
    Figure { members, pixels: largest, others }
}

/// Visits the pixels not yet seen that `start` is joined with and returns their number.
fn flood(field: &Field, seen: &mut [bool], start: usize, mut visit: impl FnMut(usize)) -> usize {
    if seen[start] {
        return 0;
    }
    seen[start] = true;
    let mut front = vec![start];
    let mut size = 0;
    while let Some(pixel) = front.pop() {
        visit(pixel);
        size += 1;
        let (x, y) = (pixel % field.width, pixel / field.width);
        let neighbours = [
            (x + 1 < field.width).then_some(pixel + 1),
            (y + 1 < field.height).then_some(pixel + field.width),
            (x > 0).then(|| pixel - 1),
            (y > 0).then(|| pixel - field.width),
        ];
        for neighbour in neighbours.into_iter().flatten() {
            if !seen[neighbour] {
                seen[neighbour] = true;
                front.push(neighbour);
            }
        }
    }
    size
}

/// A crack between a pixel of the figure and the pixel outside that `toward` steps to.
#[derive(Clone, Copy, PartialEq, Eq)]
struct Crack {
    pixel: [isize; 2],
    toward: usize,
}

impl Figure {
    /// The outline and then the holes, by marching squares [LC87] on the field, interpolated between pixel centres at
    /// whole numbers and a half; along the picture's border where the figure is cut by it. None where they have more
    /// than `max_points` points together.
    ///
    /// Lines that pass the same square diagonally keep the figure apart there, so that no line meets another.
    pub fn contours(&self, field: &Field, max_points: usize) -> Option<Vec<Vec<[f64; 2]>>> {
        let mut visited = vec![false; self.members.len()];
        let mut rings = Vec::new();
        let mut points = 0;
        for pixel in 0..self.members.len() {
            let start = Crack { pixel: [pixel % field.width, pixel / field.width].map(|x| x as isize), toward: LEFT };
            // Every closed line has a crack that faces left.
            if !visited[pixel] && self.contains(field, start.pixel) && !self.contains(field, neighbour(start)) {
                let ring = self.trace(field, start, &mut visited, max_points - points)?;
                points += ring.len();
                rings.push(ring);
            }
        }
        let largest = (0..rings.len()).max_by(|&a, &b| extent(&rings[a]).total_cmp(&extent(&rings[b])))?;
        rings.swap(0, largest);
        Some(rings)
    }

    /// What beside the figure, or of it, is missing.
    pub fn warnings(&self, field: &Field) -> Vec<Warning> {
        let mut warnings = Vec::new();
        if self.others > 0 {
            let detail = format!("{} smaller figures beside the largest one were left out", self.others);
            warnings.push(Warning::new(WarningCode::SmallerFigures, detail));
        }
        let (width, height) = (field.width, field.height);
        let on_border = |pixel: usize| {
            let (x, y) = (pixel % width, pixel / width);
            x == 0 || y == 0 || x + 1 == width || y + 1 == height
        };
        if (0..self.members.len()).any(|pixel| self.members[pixel] && on_border(pixel)) {
            let detail = "the figure runs into the border of the picture and was closed along it";
            warnings.push(Warning::new(WarningCode::CutByBorder, detail));
        }
        warnings
    }

    fn contains(&self, field: &Field, pixel: [isize; 2]) -> bool {
        field.index(pixel).is_some_and(|index| self.members[index])
    }

    /// The closed line through `start`, a point per crack; none above `max_points`. Cracks that face left are marked.
    fn trace(&self, field: &Field, start: Crack, visited: &mut [bool], max_points: usize) -> Option<Vec<[f64; 2]>> {
        let mut ring = Vec::new();
        let mut crack = start;
        loop {
            if ring.len() >= max_points {
                return None;
            }
            if let (LEFT, Some(index)) = (crack.toward, field.index(crack.pixel)) {
                visited[index] = true;
            }
            ring.push(self.crossing(field, crack));
            crack = self.following(field, crack);
            if crack == start {
                return Some(ring);
            }
        }
    }

    /// The next crack along the figure, across the square of four pixels ahead.
    fn following(&self, field: &Field, crack: Crack) -> Crack {
        let ahead = (crack.toward + 1) % 4;
        let inner = Crack { toward: ahead, ..crack };
        let beside = neighbour(inner);
        let opposite = neighbour(Crack { pixel: neighbour(crack), toward: ahead });
        if !self.contains(field, beside) {
            inner
        } else if !self.contains(field, opposite) {
            Crack { pixel: beside, ..crack }
        } else {
            Crack { pixel: opposite, toward: (ahead + 2) % 4 }
        }
    }

    /// Where the field passes the threshold between the two centres beside a crack.
    fn crossing(&self, field: &Field, crack: Crack) -> [f64; 2] {
        let level = f64::from(field.threshold) + 0.5;
        let height = |pixel| field.index(pixel).map(|index| f64::from(field.values[index]) - level);
        let inside = height(crack.pixel).unwrap_or(1.0);
        // Beyond the border, and where another figure touches diagonally, the field is mirrored: half-way between.
        let outside = height(neighbour(crack)).filter(|&value| value < 0.0).unwrap_or(-inside);
        let t = inside / (inside - outside);
        [0, 1].map(|axis| crack.pixel[axis] as f64 + 0.5 + t * STEPS[crack.toward][axis] as f64)
    }
}

impl Field {
    fn index(&self, [x, y]: [isize; 2]) -> Option<usize> {
        let (x, y) = (usize::try_from(x).ok()?, usize::try_from(y).ok()?);
        (x < self.width && y < self.height).then(|| y * self.width + x)
    }
}

/// The pixel on the other side of a crack.
fn neighbour(Crack { pixel, toward }: Crack) -> [isize; 2] {
    [0, 1].map(|axis| pixel[axis] + STEPS[toward][axis])
}

fn extent(ring: &[[f64; 2]]) -> f64 {
    signed_area(ring).abs()
}
