//! The lines within a figure: an eye, an ear, a leg before a leg.

use super::FRAME;
use super::canvas::Canvas;
use crate::geometry::distance_to_segment;
use crate::raster::PixelBox;
use crate::raster::bitmap::Bitmap;
use crate::raster::neighbourhood::{dilated, eroded, opened};
use crate::raster::pieces::without_specks;
use crate::raster::skeleton::middle_lines;
use crate::sketch::Line;

/// Half the width of the widest inner line, in parts of the figure's longer side; what is wider is a patch of colour.
const HALF_WIDEST: f64 = 0.03;

/// Pieces of fewer pixels are dust.
const LEAST_PIXELS: usize = 6;

/// How far within the outline's own line another begins, in pixels.
pub(super) const SOFT_EDGE: f64 = 2.5;

/// Most lines that are kept, longest first, and how far they may be simplified, in pixels.
const MOST: usize = 200;
const TOLERANCE: f64 = 1.0;

/// Share of the places so far within a figure that are dark where the line round it reaches as far.
const OUTLINED: f64 = 0.5;

/// How far the line round a figure reaches into it, in pixels; not at all where the figure is dark all through.
pub(super) fn outline_depth(area: &Bitmap, dark: &Bitmap) -> f64 {
    let deepest = 2.0 * HALF_WIDEST * PixelBox::of(area).map_or(0, PixelBox::side) as f64;
    let mut outer = area.clone();
    for depth in 0..=deepest as usize {
        let inner = eroded(area, depth as f64 + 1.0);
        let ring = outer.without(&inner);
        if (ring.and(dark).area() as f64) < OUTLINED * ring.area() as f64 {
            return depth as f64;
        }
        outer = inner;
    }
    0.0
}

/// What lines within a figure are drawn in. `dark` is what differs from the ground by much; the line round the figure reaches
/// `depth` pixels into it.
pub(super) fn marked(area: &Bitmap, dark: &Bitmap, depth: f64) -> Bitmap {
    let inside = eroded(area, depth + SOFT_EDGE);
    // On a figure that is dark itself the lines are what is left out.
    if 2 * inside.and(dark).area() > inside.area() { area.without(dark) } else { area.and(dark) }
}

/// The inner lines of a figure, longest first, pixel by pixel; those round it reach `depth` pixels into it.
pub(super) fn within(area: &Bitmap, marked: &Bitmap, depth: f64) -> Vec<Vec<[usize; 2]>> {
    let marked = eroded(area, depth + SOFT_EDGE).and(marked);
    let half_widest = HALF_WIDEST * PixelBox::of(area).map_or(0, PixelBox::side) as f64;
    let patches = dilated(&opened(&marked, half_widest), SOFT_EDGE);
    let thin = without_specks(&marked.without(&patches), LEAST_PIXELS);
    let mut lines = middle_lines(&thin);
    lines.sort_by(|a, b| length(b).total_cmp(&length(a)));
    lines.truncate(MOST);
    lines
}

/// Lines with as few points as show them, in the coordinates of the upload.
pub(super) fn placed(canvas: &Canvas, lines: &[Vec<[usize; 2]>]) -> Vec<Line> {
    let middle = |&[x, y]: &[usize; 2]| [x as f64 + 0.5, y as f64 + 0.5];
    let placed = |point: [f64; 2]| canvas.upload_point(point.map(|x| x - FRAME as f64));
    let line = |line: &Vec<[usize; 2]>| simplified(&line.iter().map(middle).collect::<Vec<_>>());
    lines.iter().map(|pixels| line(pixels).into_iter().map(placed).collect()).collect()
}

/// The length of a line, in pixels.
pub(super) fn length(line: &[[usize; 2]]) -> f64 {
    let step = |ends: &[[usize; 2]]| [0, 1].map(|i| ends[0][i].abs_diff(ends[1][i]) as f64);
    line.windows(2).map(step).map(|[x, y]| x.hypot(y)).sum()
}

/// The line with as few of its points as keep all others within [`TOLERANCE`] [Douglas and Peucker 1973].
fn simplified(line: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let Some(last) = line.len().checked_sub(1) else { return Vec::new() };
    let mut kept = vec![false; line.len()];
    (kept[0], kept[last]) = (true, true);
    let mut stretches = vec![(0, last)];
    while let Some((from, to)) = stretches.pop() {
        let off = |&k: &usize| distance_to_segment(line[k], [line[from], line[to]]);
        let farthest = (from + 1..to).max_by(|a, b| off(a).total_cmp(&off(b)));
        if let Some(farthest) = farthest.filter(|k| off(k) > TOLERANCE) {
            kept[farthest] = true;
            stretches.extend([(from, farthest), (farthest, to)]);
        }
    }
    line.iter().zip(kept).filter_map(|(&point, kept)| kept.then_some(point)).collect()
}
