//! Limbs that lie against the body: a line is drawn between the two, and the figure ends there on both sides of it.

use super::strokes::{self, SOFT_EDGE};
use crate::raster::PixelBox;
use crate::raster::bitmap::Bitmap;
use crate::raster::distance::squared;
use crate::raster::enclosed::parts;
use crate::raster::neighbourhood::dilated;

/// A limb is so many times as long as it is wide at least, and so long in parts of the figure's longer side.
const SLENDER: f64 = 2.5;
const LEAST_LENGTH: f64 = 0.1;

/// How much nearer to the outline the line beside it begins than it ends, in parts of the way it ends from it.
const OPEN: f64 = 0.6;

/// How far from the outline's own line it begins at most where it is not joined with it, in pixels; and the share of the way
/// between that is drawn where it is.
const MOUTH: f64 = 6.0;
const JOINED: f64 = 0.8;

/// Half the width of a slit, in pixels.
const HALF_WIDTH: f64 = 1.0;

/// Share of the figure that lies in the way of a slit at most; what takes more parts the figure.
const IN_THE_WAY: f64 = 0.02;

/// The figure without those of the lines within it that run inwards from its outline along a limb. The line round the figure
/// reaches `outline_depth` pixels into it; lines are drawn in what is `marked`.
pub(super) fn slit(figure: &Bitmap, marked: &Bitmap, lines: &[Vec<[usize; 2]>], outline_depth: f64) -> Bitmap {
    let least = LEAST_LENGTH * PixelBox::of(figure).map_or(0, PixelBox::side) as f64;
    let long: Vec<&Vec<[usize; 2]>> = lines.iter().filter(|line| strokes::length(line) >= least).collect();
    if long.is_empty() {
        return figure.clone();
    }
    let depths = squared(&figure.complement());
    let depth = |[x, y]: [usize; 2]| f64::from(depths[y * figure.width() + x]).sqrt();
    let mut slit = figure.clone();
    for line in long {
        let [Some(&first), Some(&last)] = [line.first(), line.last()] else { continue };
        let [mouth, end] = if depth(first) <= depth(last) { [first, last] } else { [last, first] };
        let width = line.iter().map(|&at| depth(at)).fold(0.0, f64::max);
        let way_out: Vec<[usize; 2]> = way_out(mouth, depth).collect();
        let drawn = way_out.iter().filter(|&&[x, y]| marked.get(x, y)).count();
        let is_joined = drawn as f64 >= JOINED * way_out.len() as f64;
        let opens = is_joined || depth(mouth) <= outline_depth + SOFT_EDGE + MOUTH;
        if !opens || depth(mouth) > OPEN * depth(end) || strokes::length(line) < SLENDER * width {
            continue;
        }
        let mut way = Bitmap::new(figure.width(), figure.height());
        line.iter().chain(&way_out).for_each(|&[x, y]| way.set(x, y));
        let without = slit.without(&dilated(&way, HALF_WIDTH));
        let whole = parts(&without, 1).first().map_or(0, Bitmap::area);
        if whole as f64 >= (1.0 - IN_THE_WAY) * slit.area() as f64 {
            slit = without;
        }
    }
    slit
}

/// The pixels on the way from one within a figure to its outline.
fn way_out(from: [usize; 2], depth: impl Fn([usize; 2]) -> f64) -> impl Iterator<Item = [usize; 2]> {
    std::iter::successors(Some(from), move |&[x, y]| {
        let around = (y - 1..=y + 1).flat_map(|y| (x - 1..=x + 1).map(move |x| [x, y]));
        around.min_by(|&a, &b| depth(a).total_cmp(&depth(b))).filter(|&next| depth(next) < depth([x, y]))
    })
}
