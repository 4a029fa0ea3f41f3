//! Stretches of a line that are fainter than the rest: what a pencil leaves where it was hardly pressed. One sees them because
//! they go on, though no pixel of them differs from the paper by more than its grain does here and there.

use super::ground::Ground;
use crate::raster::bitmap::Bitmap;
use crate::raster::neighbourhood::dilated;
use crate::raster::pieces::Pieces;

/// How far a line is followed to either side of a pixel, in pixels, and in how many directions of the half circle.
const ALONG: isize = 4;
const DIRECTIONS: usize = 8;

/// How far beside its crest a line is compared with what it lies on, in pixels, and how many times as strong it is as that.
const BESIDE: f64 = 3.0;
const STRONGER: u32 = 2;

/// A pixel is looked at where its own contrast is one in so many parts at least of what a line has on average.
const OWN: u8 = 2;

/// How far stretches may be from each other and from the ink they continue, in pixels.
const REACH: f64 = 1.5;

/// How far any of this looks over the border, in pixels.
const MARGIN: usize = 8;

/// The ink with those of the stretches that continue it.
pub(super) fn continued(ink: &Bitmap, stretches: &Bitmap) -> Bitmap {
    let pieces = Pieces::of(&dilated(stretches, REACH), true);
    let mut continues = vec![false; pieces.sizes.len()];
    for run in &pieces.runs {
        continues[run.piece] |= ink.next(run.y, run.from, true) < run.to;
    }
    ink.or(&pieces.kept(ink, |piece| continues[piece]).and(stretches))
}

/// The pixels outside of the ink that lie on a line whose contrast is `least` on average, and half as much on either side.
pub(super) fn stretches(ground: &Ground, ink: &Bitmap, least: u8) -> Bitmap {
    let (width, height) = (ink.width(), ink.height());
    let padded = width + 2 * MARGIN;
    let within = |at: usize, size: usize| at.saturating_sub(MARGIN).min(size - 1);
    let contrast: Vec<u8> = (0..height + 2 * MARGIN)
        .flat_map(|y| (0..padded).map(move |x| (x, y)))
        .map(|(x, y)| ground.contrast[within(y, height) * width + within(x, width)])
        .collect();
    let ways: Vec<[Vec<isize>; 3]> = (0..DIRECTIONS).map(|k| ways(k, padded as isize)).collect();
    let mut stretches = Bitmap::new(width, height);
    for y in 0..height {
        for x in 0..width {
            if ground.contrast[y * width + x] < least / OWN || ink.get(x, y) {
                continue;
            }
            let at = ((y + MARGIN) * padded + x + MARGIN) as isize;
            let sum = |way: &[isize]| way.iter().map(|step| u32::from(contrast[(at + step) as usize])).sum::<u32>();
            let is_line = |[line, left, right]: &[Vec<isize>; 3]| {
                let own = sum(line);
                own >= u32::from(least) * line.len() as u32
                    && STRONGER * sum(left) <= own
                    && STRONGER * sum(right) <= own
            };
            if ways.iter().any(is_line) {
                stretches.set(x, y);
            }
        }
    }
    stretches
}

/// The steps from a pixel to those of a straight line through it, and to those of its parallels on both sides, in rows of so
/// many pixels.
fn ways(direction: usize, row: isize) -> [Vec<isize>; 3] {
    let (sin, cos) = (std::f64::consts::PI * direction as f64 / DIRECTIONS as f64).sin_cos();
    [0.0, -BESIDE, BESIDE].map(|aside| {
        let step = |k: isize| {
            let [x, y] = [k as f64 * cos - aside * sin, k as f64 * sin + aside * cos].map(|d| d.round() as isize);
            y * row + x
        };
        (-ALONG..=ALONG).map(step).collect()
    })
}
