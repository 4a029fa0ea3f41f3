//! Lines that run over the border of a sheet: what they enclose goes on beyond it, and ends there.

use std::ops::Range;

use super::Sheet;
use super::closing::{between, closing, stretches};
use crate::raster::PixelBox;
use crate::raster::bitmap::Bitmap;

/// A line that runs over the border is no wider there, in parts of the sheet's side.
const WIDEST: f64 = 0.06;

/// How near to the border a line ends, in pixels.
const NEAR: usize = 2;

/// Most lines over one side that are looked at.
const MOST: usize = 24;

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
}
