//! The sheet a figure is drawn on: the picture, or a paper, a window, a frame in it.

use std::f64::consts::FRAC_PI_4;

use crate::raster::PixelBox;
use crate::raster::bitmap::Bitmap;
use crate::raster::enclosed::{filled, parts};
use crate::raster::neighbourhood::{dilated, eroded};

/// Least share of a sheet that a sheet on it takes.
const LEAST_SHARE: f64 = 0.2;

/// A sheet takes this share of its bounding box, or a quadrilateral takes this share of it.
const OF_BOX: f64 = 0.95;
const OF_QUADRILATERAL: f64 = 0.94;

/// How far the share that a disc takes of its bounding box is from π / 4.
const OFF_ROUND: f64 = 0.015;

/// The longer and the shorter side of a figure on a disc, in parts of the disc's, and the share of the disc that it takes;
/// eyes and a mouth take less.
const OF_DISC_SIDE: f64 = 0.5;
const OF_DISC_WIDTH: f64 = 0.3;
const OF_DISC: f64 = 0.08;

/// Share of its outline along which a sheet is seen to end.
const DRAWN_ROUND: f64 = 0.8;

/// What is cut off the edge of a sheet that lies on another, in parts of its side: edges are not sharp.
const EDGE: f64 = 0.015;

/// Corners of a hull beyond which it is round.
const MOST_CORNERS: usize = 120;

/// Where a figure is looked for.
#[derive(Clone, Debug)]
pub(super) struct Sheet {
    pub area: Bitmap,
}

/// A sheet on another.
pub(super) struct Upon {
    pub sheet: Sheet,
    pub bounds: PixelBox,
    /// A disc: it may be a figure itself, with a face on it.
    is_round: bool,
}

impl Upon {
    /// Whether what is drawn here is a figure on a sheet and not the features of a round figure.
    pub fn carries(&self, ink: &Bitmap) -> bool {
        let whole = filled(&ink.framed(1)).cropped(1);
        let Some(largest) = parts(&whole, 1).into_iter().next() else { return false };
        let Some(own) = PixelBox::of(&largest) else { return false };
        let narrow = own.width().min(own.height()) as f64;
        let is_apart = largest.and(&self.sheet.border(1.0)).area() == 0;
        !self.is_round
            || is_apart
                && own.side() as f64 >= OF_DISC_SIDE * self.bounds.side() as f64
                && narrow >= OF_DISC_WIDTH * self.bounds.side() as f64
                && largest.area() as f64 >= OF_DISC * self.sheet.area.area() as f64
    }
}

impl Sheet {
    /// The whole of a picture.
    pub fn whole(width: usize, height: usize) -> Sheet {
        let mut area = Bitmap::new(width, height);
        (0..height).for_each(|y| area.fill(y, 0, width, true));
        Sheet { area }
    }

    /// Its pixels within so many of its border.
    pub fn border(&self, width: f64) -> Bitmap {
        self.area.without(&eroded(&self.area.framed(2), width).cropped(2))
    }

    /// The sheet that what is drawn on this one may be: of four sides or round, large, and drawn all round.
    pub fn upon(&self, ink: &Bitmap) -> Option<Upon> {
        let largest = || parts(ink, 1).into_iter().next();
        self.within(ink).or_else(|| self.within(&largest()?))
    }

    fn within(&self, ink: &Bitmap) -> Option<Upon> {
        let bounds = PixelBox::of(ink)?;
        let corners = hull(ink);
        let shape = polygon(&corners, ink.width(), ink.height());
        let area = shape.area() as f64;
        let of_box = area / (bounds.width() * bounds.height()) as f64;
        let is_large = area >= LEAST_SHARE * self.area.area() as f64;
        let has_four_sides = of_box >= OF_BOX
            || corners.len() <= MOST_CORNERS && largest_quadrilateral(&corners) >= OF_QUADRILATERAL * area;
        let is_round = (of_box - FRAC_PI_4).abs() <= OFF_ROUND;
        if !is_large || !has_four_sides && !is_round {
            return None;
        }
        let edge = (EDGE * bounds.side() as f64).max(2.0);
        let rim = shape.without(&eroded(&shape.framed(2), 1.0).cropped(2));
        if (rim.and(&dilated(ink, edge)).area() as f64) < DRAWN_ROUND * rim.area() as f64 {
            return None;
        }
        let inner = eroded(&shape.framed(2), edge).cropped(2);
        (inner.area() > 0).then_some(Upon { sheet: Sheet { area: inner }, bounds, is_round: !has_four_sides })
    }
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

/// The convex hull of the pixels' corners, counter-clockwise as y points up.
fn hull(shape: &Bitmap) -> Vec<[f64; 2]> {
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
        if turn * cross(a, b, point) > 0.5 {
            break;
        }
        side.pop();
    }
    side.push(point);
}

/// Twice the area of the triangle of three points, positive where they turn right as y points down.
fn cross(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

/// The area of the largest quadrilateral of a convex ring's corners.
fn largest_quadrilateral(ring: &[[f64; 2]]) -> f64 {
    let mut largest: f64 = 0.0;
    for (i, &a) in ring.iter().enumerate() {
        for &c in &ring[i + 1..] {
            let (mut left, mut right): (f64, f64) = (0.0, 0.0);
            for &b in ring {
                let side = cross(a, c, b);
                (left, right) = (left.max(-side), right.max(side));
            }
            largest = largest.max(0.5 * (left + right));
        }
    }
    largest
}
