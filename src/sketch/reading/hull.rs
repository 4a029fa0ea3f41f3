//! The convex hull of a shape, and whether it has four sides.

use crate::geometry::doubled_area;
use crate::raster::bitmap::Bitmap;

/// A quadrilateral takes this share of a shape of four sides.
const OF_QUADRILATERAL: f64 = 0.94;

/// Corners of a hull beyond which it is round.
const MOST_CORNERS: usize = 120;

/// The convex hull of a shape.
pub(super) struct Hull {
    corners: Vec<[f64; 2]>,
    /// The pixels in it.
    pub area: Bitmap,
}

impl Hull {
    pub fn of(shape: &Bitmap) -> Hull {
        let corners = corners(shape);
        Hull { area: polygon(&corners, shape.width(), shape.height()), corners }
    }

    /// Whether it has four sides, rounded off or not.
    pub fn has_four_sides(&self) -> bool {
        self.corners.len() <= MOST_CORNERS
            && largest_quadrilateral(&self.corners) >= OF_QUADRILATERAL * self.area.area() as f64
    }
}

/// The convex hull of the pixels' corners, counter-clockwise as y points up.
fn corners(shape: &Bitmap) -> Vec<[f64; 2]> {
    let mut sides: [Vec<[f64; 2]>; 2] = [Vec::new(), Vec::new()];
    for y in 0..shape.height() {
        let mut runs = shape.runs(y);
        let Some(first) = runs.next() else { continue };
        let end = runs.last().map_or(first.end, |last| last.end);
        for y in [y, y + 1] {
            push_convex(&mut sides[0], [first.start as f64, y as f64], -1.0);
            push_convex(&mut sides[1], [end as f64, y as f64], 1.0);
        }
    }
    let [left, mut right] = sides;
    right.extend(left.into_iter().rev());
    right
}

/// Adds a point below the others, taking out what is no corner of the hull on the one side of it.
fn push_convex(side: &mut Vec<[f64; 2]>, point: [f64; 2], turn: f64) {
    while let [.., a, b] = side[..] {
        if turn * doubled_area([a, b, point]) > 0.5 {
            break;
        }
        side.pop();
    }
    side.push(point);
}

/// The area of the largest quadrilateral of a convex ring's corners.
fn largest_quadrilateral(ring: &[[f64; 2]]) -> f64 {
    let mut largest: f64 = 0.0;
    for (i, &a) in ring.iter().enumerate() {
        for &c in &ring[i + 1..] {
            let (mut left, mut right): (f64, f64) = (0.0, 0.0);
            for &b in ring {
                let side = doubled_area([a, c, b]);
                (left, right) = (left.max(-side), right.max(side));
            }
            largest = largest.max(0.5 * (left + right));
        }
    }
    largest
}

/// The pixels whose centres lie in a convex ring, which runs down one side and up the other.
fn polygon(ring: &[[f64; 2]], width: usize, height: usize) -> Bitmap {
    let mut area = Bitmap::new(width, height);
    for y in 0..height {
        let level = y as f64 + 0.5;
        let edges = ring.iter().zip(ring.iter().cycle().skip(1));
        let crossings = edges.filter(|(p, q)| (p[1] > level) != (q[1] > level));
        let places = crossings.map(|(p, q)| p[0] + (level - p[1]) / (q[1] - p[1]) * (q[0] - p[0]));
        let (low, high) = places.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (x.min(low), x.max(high)));
        if low < high {
            area.fill(y, low.round() as usize, (high.round() as usize).min(width), true);
        }
    }
    area
}
