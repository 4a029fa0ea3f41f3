//! The lines within a figure: an eye, an ear, a leg before a leg.

use super::FRAME;
use super::canvas::Canvas;
use crate::raster::PixelBox;
use crate::raster::bitmap::Bitmap;
use crate::raster::neighbourhood::{dilated, eroded, opened};
use crate::raster::pieces::Pieces;
use crate::raster::skeleton::middle_lines;

/// Half the width of the widest inner line, in parts of the figure's longer side; what is wider is a patch of colour.
const HALF_WIDEST: f64 = 0.03;

/// Pieces of fewer pixels are dust.
const LEAST_PIXELS: usize = 6;

/// How far within the outline a line begins beside the half of the outline's own that lies inside, in pixels.
const SOFT_EDGE: f64 = 2.5;

/// Most lines that are kept, longest first, and how far they may be simplified, in pixels.
const MOST: usize = 200;
const TOLERANCE: f64 = 1.0;

/// The inner lines of a figure, longest first, in the coordinates of the upload. `dark` is what differs from the ground by
/// much; `rim` is how far the line round the figure reaches into it, in pixels.
pub(super) fn strokes(canvas: &Canvas, area: &Bitmap, dark: &Bitmap, rim: f64) -> Vec<Vec<[f64; 2]>> {
    let inside = eroded(area, rim + SOFT_EDGE);
    let marked = inside.and(dark);
    // On a figure that is dark itself the lines are what is left out.
    let marked = if 2 * marked.area() > inside.area() { inside.without(dark) } else { marked };
    let half_widest = HALF_WIDEST * PixelBox::of(area).map_or(0, PixelBox::side) as f64;
    let patches = dilated(&opened(&marked, half_widest), SOFT_EDGE);
    let thin = without_dust(&marked.without(&patches));
    let mut lines: Vec<Vec<[f64; 2]>> =
        middle_lines(&thin).into_iter().map(|line| simplified(&line.iter().map(middle).collect::<Vec<_>>())).collect();
    lines.sort_by(|a, b| length(b).total_cmp(&length(a)));
    lines.truncate(MOST);
    let placed = |point: [f64; 2]| canvas.upload_point(point.map(|x| x - FRAME as f64));
    lines.into_iter().map(|line| line.into_iter().map(placed).collect()).collect()
}

fn without_dust(marked: &Bitmap) -> Bitmap {
    let pieces = Pieces::of(marked, true);
    let mut clean = Bitmap::new(marked.width(), marked.height());
    let runs = pieces.runs.iter().filter(|run| pieces.sizes[run.piece] >= LEAST_PIXELS);
    runs.for_each(|run| clean.fill(run.y, run.from, run.to, true));
    clean
}

/// The middle of a pixel.
fn middle(&[x, y]: &[usize; 2]) -> [f64; 2] {
    [x as f64 + 0.5, y as f64 + 0.5]
}

fn length(line: &[[f64; 2]]) -> f64 {
    line.windows(2).map(|ends| (ends[1][0] - ends[0][0]).hypot(ends[1][1] - ends[0][1])).sum()
}

/// The line with as few of its points as keep all others within [`TOLERANCE`] [Douglas and Peucker 1973].
fn simplified(line: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let Some(last) = line.len().checked_sub(1) else { return Vec::new() };
    let mut kept = vec![false; line.len()];
    (kept[0], kept[last]) = (true, true);
    let mut stretches = vec![(0, last)];
    while let Some((from, to)) = stretches.pop() {
        let off = |&k: &usize| distance(line[k], line[from], line[to]);
        let farthest = (from + 1..to).max_by(|a, b| off(a).total_cmp(&off(b)));
        if let Some(farthest) = farthest.filter(|k| off(k) > TOLERANCE) {
            kept[farthest] = true;
            stretches.extend([(from, farthest), (farthest, to)]);
        }
    }
    line.iter().zip(kept).filter_map(|(&point, kept)| kept.then_some(point)).collect()
}

/// The distance of a point from a stretch.
fn distance(p: [f64; 2], a: [f64; 2], b: [f64; 2]) -> f64 {
    let (along, to) = ([b[0] - a[0], b[1] - a[1]], [p[0] - a[0], p[1] - a[1]]);
    let squared = along[0] * along[0] + along[1] * along[1];
    let t = if squared > 0.0 { ((to[0] * along[0] + to[1] * along[1]) / squared).clamp(0.0, 1.0) } else { 0.0 };
    (to[0] - t * along[0]).hypot(to[1] - t * along[1])
}
