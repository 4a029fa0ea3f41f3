//! The binding of a sketchbook: rings, or the holes they go through, in a row along one side of the sheet.

use std::ops::Range;

use super::Sheet;
use crate::numerics::median;
use crate::raster::PixelBox;
use crate::raster::bitmap::Bitmap;
use crate::raster::neighbourhood::dilated;
use crate::raster::pieces::Pieces;

/// How far within the sheet a binding lies, and the most a ring of it takes of the side it lies along, in parts of the sheet's
/// side.
const BAND: f64 = 0.12;
const RING: f64 = 0.05;

/// Rings there are at least, and the share of the side that they take with what is between them.
const FEWEST: usize = 8;
const ALONG: f64 = 0.6;

/// How far the distance of a ring from the next is from what it mostly is, in parts of that, and the share of rings of which it
/// is no farther.
const OFF_STEP: f64 = 0.3;
const REGULAR: f64 = 0.75;

/// How far about a ring its shadow and its soft edge reach, in pixels.
const SHADOW: f64 = 4.0;

/// What belongs to the binding of the sheet.
pub(super) fn binding(ink: &Bitmap, sheet: &Sheet) -> Bitmap {
    let pieces = Pieces::of(ink, true);
    let boxes = pieces.boxes();
    let mut rings = Bitmap::new(ink.width(), ink.height());
    for (axis, far) in [(0, false), (0, true), (1, false), (1, true)] {
        let is_ring: Vec<bool> = boxes.iter().map(|own| lies_along(own, sheet.sides, axis, far)).collect();
        let spans = boxes.iter().zip(&is_ring).filter(|(_, is)| **is).map(|(own, _)| own.low[axis]..own.high[axis]);
        if is_row(&apart(spans.collect()), (sheet.sides.high[axis] - sheet.sides.low[axis]) as f64) {
            rings = rings.or(&pieces.kept(ink, |piece| is_ring[piece]));
        }
    }
    dilated(&rings, SHADOW)
}

/// Whether a piece lies near one side of the sheet, and takes little of it.
fn lies_along(own: &PixelBox, sheet: PixelBox, axis: usize, far: bool) -> bool {
    let (side, across) = (sheet.side() as f64, 1 - axis);
    let reach = if far {
        sheet.high[across].saturating_sub(own.low[across])
    } else {
        own.high[across] - sheet.low[across].min(own.high[across])
    };
    reach as f64 <= BAND * side && (own.high[axis] - own.low[axis]) as f64 <= RING * side
}

/// The spans with those that overlap as one, in order.
fn apart(mut spans: Vec<Range<usize>>) -> Vec<Range<usize>> {
    spans.sort_unstable_by_key(|span| span.start);
    let mut apart: Vec<Range<usize>> = Vec::new();
    for span in spans {
        match apart.last_mut() {
            Some(last) if span.start <= last.end => last.end = last.end.max(span.end),
            _ => apart.push(span),
        }
    }
    apart
}

/// Whether spans lie at equal steps along most of a side of this length.
fn is_row(spans: &[Range<usize>], side: f64) -> bool {
    if spans.len() < FEWEST {
        return false;
    }
    let middle = |span: &Range<usize>| 0.5 * (span.start + span.end) as f64;
    let steps: Vec<f64> = spans.windows(2).map(|pair| middle(&pair[1]) - middle(&pair[0])).collect();
    let step = median(steps.clone());
    let regular = steps.iter().filter(|&&own| (own - step).abs() <= OFF_STEP * step).count() as f64;
    regular >= REGULAR * steps.len() as f64 && regular * step >= ALONG * side
}

#[cfg(test)]
mod tests {
    use super::*;

    /// How many of the marks of 4 × 6 pixels at these places are a binding of a sheet of 200 × 200.
    fn bound(marks: &[[usize; 2]]) -> usize {
        let mut ink = Bitmap::new(200, 200);
        for &[x, y] in marks {
            (y..y + 6).for_each(|y| ink.fill(y, x, x + 4, true));
        }
        let binding = binding(&ink, &Sheet::whole(200, 200));
        marks.iter().filter(|&&[x, y]| binding.get(x, y)).count()
    }

    #[test]
    fn marks_at_equal_steps_along_a_side_are_a_binding() {
        for at in [3, 190] {
            assert_eq!(bound(&(0..12).map(|k| [at, 5 + 16 * k]).collect::<Vec<_>>()), 12);
            assert_eq!(bound(&(0..12).map(|k| [5 + 16 * k, at]).collect::<Vec<_>>()), 12);
        }
        // A ring that is not seen, and one that is seen in two pieces.
        let partly: Vec<[usize; 2]> = (0..12).filter(|&k| k != 5).map(|k| [3, 5 + 16 * k]).chain([[12, 69]]).collect();
        assert_eq!(bound(&partly), 12);
    }

    #[test]
    fn other_marks_are_none() {
        assert_eq!(bound(&(0..12).map(|k| [100, 5 + 16 * k]).collect::<Vec<_>>()), 0, "in the middle");
        assert_eq!(bound(&(0..7).map(|k| [3, 5 + 26 * k]).collect::<Vec<_>>()), 0, "few");
        assert_eq!(bound(&(0..12).map(|k| [3, 5 + 8 * k]).collect::<Vec<_>>()), 0, "half of the side");
        assert_eq!(bound(&(0..12).map(|k| [3, 5 + k * k + 4 * k]).collect::<Vec<_>>()), 0, "at unequal steps");
    }
}
