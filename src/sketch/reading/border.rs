//! Lines that run over the border of a sheet: what they enclose goes on beyond it, and ends there. Straight ones that
//! enclose nothing are no part of a figure.

use std::ops::Range;

use super::Sheet;
use super::closing::{between, closing, stretches};
use crate::raster::PixelBox;
use crate::raster::bitmap::Bitmap;
use crate::raster::enclosed::parts;
use crate::raster::neighbourhood::dilated;

/// A line that runs over the border is no wider there, in parts of the sheet's side.
const WIDEST: f64 = 0.06;

/// How near to the border a line ends, in pixels.
const NEAR: usize = 2;

/// Most lines over one side that are looked at.
const MOST: usize = 24;

/// How wide a straight line is at most that is no part of a figure, and how far its pieces lie apart, in parts of the drawing's
/// size; and how far its pixels deviate from a straight line, in parts of its length, beside what its width makes.
const CREASE: f64 = 0.012;
const APART: f64 = 0.03;
const SWERVE: f64 = 0.02;
const PEN: f64 = 1.5;

/// One of the four sides of a box of pixels.
#[derive(Clone, Copy)]
struct Side {
    bounds: PixelBox,
    /// The axis along it.
    along: usize,
    /// Whether it is the side of large numbers.
    far: bool,
}

impl Side {
    fn all(bounds: PixelBox) -> [Side; 4] {
        [(0, false), (0, true), (1, false), (1, true)].map(|(along, far)| Side { bounds, along, far })
    }

    fn length(self) -> Range<usize> {
        self.bounds.low[self.along]..self.bounds.high[self.along]
    }

    /// The pixel at a place of the side, so many pixels within the border.
    fn pixel(self, at: usize, depth: usize) -> [usize; 2] {
        let across = 1 - self.along;
        let mut pixel = [at; 2];
        let [low, high] = [self.bounds.low[across], self.bounds.high[across]];
        pixel[across] = if self.far { high.saturating_sub(depth + 1).max(low) } else { (low + depth).min(high - 1) };
        pixel
    }

    /// The stretches where thin ink runs over it.
    fn crossings(self, ink: &Bitmap) -> Vec<Range<usize>> {
        let is_ink = |at: &usize| (0..=NEAR).map(|depth| self.pixel(*at, depth)).any(|[x, y]| ink.get(x, y));
        let mut crossings = stretches(self.length().filter(is_ink));
        let widest = WIDEST * self.bounds.side() as f64;
        crossings.retain(|crossing| crossing.len() as f64 <= widest);
        crossings.truncate(MOST);
        crossings
    }
}

/// The ink, closed along the sides of the sheet between lines that run over them, where the inside of the figure lies
/// between. A sheet that is no upright rectangle has no such sides.
pub(super) fn closed(ink: &Bitmap, sheet: &Sheet) -> Bitmap {
    match PixelBox::of(&sheet.area) {
        Some(bounds) if bounds.width() * bounds.height() == sheet.area.area() => {
            Side::all(bounds).into_iter().fold(ink.clone(), closed_along)
        }
        _ => ink.clone(),
    }
}

fn closed_along(ink: Bitmap, side: Side) -> Bitmap {
    let between = between(&side.crossings(&ink));
    if between.is_empty() {
        return ink;
    }
    let with = |stretches: &[Range<usize>]| {
        let mut with = ink.clone();
        for at in stretches.iter().cloned().flatten() {
            (0..=NEAR).map(|depth| side.pixel(at, depth)).for_each(|[x, y]| with.set(x, y));
        }
        with
    };
    with(&closing(&with(&between), &between, |at, depth| side.pixel(at, NEAR + depth)))
}

/// Of lines in a drawing of this size those that run straight over the border: a crease of the paper, a horizon.
pub(super) fn straight_over(lines: &Bitmap, border: &Bitmap, size: f64) -> Bitmap {
    let whole = parts(&dilated(lines, 0.5 * APART * size), 1).into_iter().map(|whole| whole.and(lines));
    let over = whole.filter(|line| line.and(border).area() > 0 && is_straight(line, CREASE * size));
    over.fold(Bitmap::new(lines.width(), lines.height()), |all, line| all.or(&line))
}

/// Whether pixels lie along a straight line of at most this width.
fn is_straight(line: &Bitmap, widest: f64) -> bool {
    let Some(bounds) = PixelBox::of(line) else { return false };
    let length = (bounds.width() as f64).hypot(bounds.height() as f64);
    let pixels = || (0..line.height()).flat_map(|y| line.runs(y).flatten().map(move |x| [x as f64, y as f64]));
    let n = line.area() as f64;
    let mean = [0, 1].map(|axis| pixels().map(|p| p[axis]).sum::<f64>() / n);
    let moment = |i: usize, j: usize| pixels().map(|p| (p[i] - mean[i]) * (p[j] - mean[j])).sum::<f64>() / n;
    let (xx, xy, yy) = (moment(0, 0), moment(0, 1), moment(1, 1));
    // The smaller eigenvalue of the pixels' covariance.
    let across = 0.5 * (xx + yy - ((xx - yy).powi(2) + 4.0 * xy * xy).sqrt());
    n <= widest * length && across.max(0.0).sqrt() <= SWERVE * length + PEN
}

#[cfg(test)]
mod tests {
    use super::*;

    fn picture(lines: &[[usize; 4]]) -> Bitmap {
        let mut picture = Bitmap::new(100, 100);
        for &[left, top, right, bottom] in lines {
            (top..bottom).for_each(|y| picture.fill(y, left, right, true));
        }
        picture
    }

    /// Where the last row is set that was not.
    fn added(ink: &Bitmap) -> Vec<[usize; 2]> {
        closed(ink, &Sheet::whole(100, 100)).without(ink).runs(99).map(|run| [run.start, run.end]).collect()
    }

    #[test]
    fn a_body_that_runs_over_the_border_ends_there() {
        let bust = picture(&[[30, 20, 33, 100], [60, 20, 63, 100], [30, 20, 63, 23]]);
        assert_eq!(added(&bust), [[33, 60]]);
        let open = picture(&[[30, 20, 33, 100], [60, 20, 63, 100]]);
        assert!(added(&open).is_empty());
    }

    #[test]
    fn what_is_between_legs_stays_open() {
        let body = [[20, 10, 83, 13], [20, 10, 23, 100], [80, 10, 83, 100]];
        let legs = [[40, 50, 63, 53], [40, 50, 43, 100], [60, 50, 63, 100]];
        assert_eq!(added(&picture(&[body, legs].concat())), [[23, 40], [63, 80]]);
    }

    #[test]
    fn an_arm_before_the_body_is_no_leg() {
        let body = [[20, 10, 83, 13], [20, 10, 23, 100], [80, 10, 83, 100]];
        let arms = [[40, 50, 43, 100], [60, 50, 63, 100]];
        assert_eq!(added(&picture(&[&body[..], &arms].concat())), [[23, 40], [43, 60], [63, 80]]);
    }

    #[test]
    fn a_straight_line_over_the_border_is_told_from_a_tail() {
        let border = Sheet::whole(100, 100).border(3.0);
        let kept = |line: &Bitmap| line.without(&straight_over(line, &border, 100.0)).area();
        let horizon = picture(&[[0, 50, 40, 51], [42, 50, 80, 51]]);
        assert_eq!(kept(&horizon), 0);
        let within = picture(&[[10, 50, 80, 51]]);
        assert_eq!(kept(&within), within.area());
        let tail = picture(&[[40, 50, 100, 51], [40, 50, 41, 90]]);
        assert_eq!(kept(&tail), tail.area());
        let leg = picture(&[[40, 50, 46, 100]]);
        assert_eq!(kept(&leg), leg.area());
    }
}
