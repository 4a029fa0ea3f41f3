//! The edge of the sheet where it is seen: the shade along the border of a scan, the rim of a page.

use super::Sheet;
use crate::raster::PixelBox;
use crate::raster::bitmap::Bitmap;
use crate::raster::neighbourhood::dilated;
use crate::raster::pieces::{Pieces, Run};

/// How far within the sheet its edge is seen, in parts of its longer side.
const WIDTH: f64 = 0.05;

/// The share of a side along which there is something in the band beside it, where that is the edge.
const ALONG: f64 = 0.6;

/// How far about it its soft rim reaches, in pixels.
const SOFT: f64 = 4.0;

/// What lies in the band along a side of the sheet, along most of it, and nowhere but in the bands along its sides. What lies
/// along all four is a frame, or the figure itself.
pub(super) fn edge(ink: &Bitmap, sheet: &Sheet) -> Bitmap {
    let pieces = Pieces::of(ink, true);
    let bands = Band::along(sheet.sides);
    let mut is_outer = vec![true; pieces.sizes.len()];
    for run in &pieces.runs {
        is_outer[run.piece] &= (run.from..run.to).all(|x| bands.iter().any(|band| band.holds([x, run.y])));
    }
    let outer: Vec<&Run> = pieces.runs.iter().filter(|run| is_outer[run.piece]).collect();
    let full: Vec<&Band> = bands.iter().filter(|band| band.is_full(&outer)).collect();
    if full.len() == bands.len() {
        return Bitmap::new(ink.width(), ink.height());
    }
    let lies_along = |run: &Run| full.iter().any(|band| band.within(run).next().is_some());
    let mut is_edge = vec![false; pieces.sizes.len()];
    outer.iter().filter(|run| lies_along(run)).for_each(|run| is_edge[run.piece] = true);
    dilated(&pieces.kept(ink, |piece| is_edge[piece]), SOFT)
}

/// A band along one side of a sheet.
struct Band {
    bounds: PixelBox,
    /// The axis along it.
    along: usize,
}

impl Band {
    /// Those along the four sides.
    fn along(PixelBox { low, high }: PixelBox) -> [Band; 4] {
        let width = (WIDTH * PixelBox { low, high }.side() as f64) as usize;
        [(0, false), (0, true), (1, false), (1, true)].map(|(along, far)| {
            let (across, mut bounds) = (1 - along, PixelBox { low, high });
            if far {
                bounds.low[across] = high[across].saturating_sub(width).max(low[across]);
            } else {
                bounds.high[across] = (low[across] + width).min(high[across]);
            }
            Band { bounds, along }
        })
    }

    fn holds(&self, at: [usize; 2]) -> bool {
        (0..2).all(|axis| (self.bounds.low[axis]..self.bounds.high[axis]).contains(&at[axis]))
    }

    /// The pixels of a run that lie in it.
    fn within(&self, run: &Run) -> impl Iterator<Item = [usize; 2]> {
        (run.from..run.to).map(|x| [x, run.y]).filter(|&at| self.holds(at))
    }

    /// Whether something lies in it along most of it.
    fn is_full(&self, runs: &[&Run]) -> bool {
        let (low, high) = (self.bounds.low[self.along], self.bounds.high[self.along]);
        let mut is_covered = vec![false; high - low];
        runs.iter().flat_map(|run| self.within(run)).for_each(|at| is_covered[at[self.along] - low] = true);
        is_covered.iter().filter(|is| **is).count() as f64 >= ALONG * is_covered.len() as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Which of these boxes, each [left, top, right, bottom] on a sheet of 200 × 100, are its edge.
    fn are_edge<const N: usize>(boxes: [[usize; 4]; N]) -> [bool; N] {
        let mut ink = Bitmap::new(200, 100);
        for [left, top, right, bottom] in boxes {
            (top..bottom).for_each(|y| ink.fill(y, left, right, true));
        }
        let edge = edge(&ink, &Sheet::whole(200, 100));
        boxes.map(|[left, top, ..]| edge.get(left, top))
    }

    #[test]
    fn what_lies_along_a_side_only_is_the_edge() {
        assert_eq!(are_edge([[190, 0, 196, 80]]), [true], "on the right");
        assert_eq!(are_edge([[20, 0, 90, 3], [100, 2, 160, 4]]), [true; 2], "above, in two pieces");
        assert_eq!(are_edge([[0, 94, 200, 97], [0, 10, 5, 94]]), [true; 2], "round a corner");
    }

    #[test]
    fn what_is_short_or_reaches_into_the_sheet_is_not() {
        assert_eq!(are_edge([[190, 0, 196, 50]]), [false], "half of the side");
        assert_eq!(are_edge([[0, 3, 200, 6], [90, 6, 100, 40]]), [false; 2], "a figure that hangs from it");
        assert_eq!(are_edge([[0, 20, 200, 23]]), [false], "a line across");
        assert_eq!(
            are_edge([[0, 0, 200, 3], [0, 97, 200, 100], [0, 3, 3, 97], [197, 3, 200, 97]]),
            [false; 4],
            "a frame"
        );
    }
}
