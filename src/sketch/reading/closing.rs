//! Where a line that lines end on closes the figure that they are drawn round, and where it closes what is between its legs.

use std::ops::Range;

use crate::raster::bitmap::Bitmap;
use crate::raster::enclosed::{filled, parts};
use crate::raster::neighbourhood::dilated;

/// Half the width of gaps in lines through which nothing is seen, in parts of the picture's longer side.
const HALF_GAP: f64 = 0.008;

/// The stretches that places make that follow each other, the places in ascending order.
pub(super) fn stretches(places: impl Iterator<Item = usize>) -> Vec<Range<usize>> {
    let mut stretches: Vec<Range<usize>> = Vec::new();
    for at in places {
        match stretches.last_mut() {
            Some(last) if last.end == at => last.end = at + 1,
            _ => stretches.push(at..at + 1),
        }
    }
    stretches
}

/// What lies between each of the lines and the next.
pub(super) fn between(lines: &[Range<usize>]) -> Vec<Range<usize>> {
    lines.windows(2).map(|pair| pair[0].end..pair[1].start).collect()
}

/// Of the stretches between lines that end on another, in order, those with the figure's inside behind them. `closed` is the ink
/// with the line they end on, and `behind` the pixel that lies so far behind a place of it.
///
/// From its first line to the second a figure is inside, from the second to the third it is not, and so on; unless one gets
/// from one to the other without crossing a line. Where a line is missing the inside is the largest.
pub(super) fn closing(
    closed: &Bitmap,
    stretches: &[Range<usize>],
    behind: impl Fn(usize, usize) -> [usize; 2],
) -> Vec<Range<usize>> {
    let reach = HALF_GAP * closed.width().max(closed.height()) as f64;
    let lines = dilated(closed, reach);
    let insides = parts(&filled(&lines).without(&lines), 1);
    let depth = reach as usize + 2;
    let inside_of = |stretch: &Range<usize>| {
        let is_seen = |inside: &Bitmap| stretch.clone().map(|at| behind(at, depth)).any(|[x, y]| inside.get(x, y));
        insides.iter().position(is_seen)
    };
    let found: Vec<Option<usize>> = stretches.iter().map(inside_of).collect();
    let own: Vec<usize> = if found.len() % 2 == 1 {
        found.iter().step_by(2).flatten().copied().collect()
    } else {
        found.iter().flatten().copied().min().into_iter().collect()
    };
    let is_own = |inside: &Option<usize>| inside.is_some_and(|inside| own.contains(&inside));
    stretches.iter().zip(&found).filter(|(_, inside)| is_own(inside)).map(|(stretch, _)| stretch.clone()).collect()
}
