//! Shadows that are drawn: beside a figure as another of its shape, or below it as a flat patch.

use crate::raster::PixelBox;
use crate::raster::bitmap::Bitmap;
use crate::raster::enclosed::{filled, parts};
use crate::raster::neighbourhood::{dilated, opened};

/// Half the width of the narrowest shadow, in pixels: soft edges are narrower.
const NARROWEST: f64 = 1.5;

/// A shadow takes this share of all ink at least, and of the figure's area at most.
const LEAST: f64 = 0.01;
const MOST: f64 = 0.7;

/// Share of a shadow that lies outside of its figure: what lines enclose is a fill.
const OUTSIDE: f64 = 0.9;

/// Share of what a figure and its shadow take that the figure takes when it is moved to where its shadow is.
const SAME_SHAPE: f64 = 0.97;

/// A patch on the floor is this many times as wide as high, and takes this part of the figure's width.
const FLAT: f64 = 2.5;
const WIDE: f64 = 0.33;

/// The part of the ink that is the shadow of the rest, of what is `faint` in it; none where nothing is.
pub(super) fn shadow(ink: &Bitmap, faint: &Bitmap) -> Option<Bitmap> {
    let patches = opened(faint, NARROWEST);
    if (patches.area() as f64) < LEAST * ink.area() as f64 {
        return None;
    }
    let shadow = dilated(&patches, NARROWEST + 1.0).and(faint);
    let rest = opened(&ink.without(&shadow), 1.0);
    let figure = filled(&rest);
    let is_outside = shadow.without(&figure).area() as f64 >= OUTSIDE * shadow.area() as f64;
    if !is_outside || shadow.area() as f64 > MOST * figure.area() as f64 {
        return None;
    }
    let figure = parts(&figure, 1).into_iter().next()?;
    (is_thrown(ink, &figure) || is_on_floor(&shadow, &figure)).then_some(shadow)
}

/// Whether all that is drawn is the figure and the same figure moved by as much as all reaches beyond it.
fn is_thrown(ink: &Bitmap, figure: &Bitmap) -> bool {
    let (Some(all), Some(own)) = (PixelBox::of(ink), PixelBox::of(figure)) else { return false };
    let step = [0, 1].map(|i| {
        let (before, behind) = (own.low[i] - all.low[i].min(own.low[i]), all.high[i].max(own.high[i]) - own.high[i]);
        behind as isize - before as isize
    });
    let both = figure.or(&moved(figure, step));
    let whole = filled(ink).or(figure);
    both.and(&whole).area() as f64 >= SAME_SHAPE * both.or(&whole).area() as f64
}

/// Whether every large piece of the shadow is flat, wide, and at the figure's feet.
fn is_on_floor(shadow: &Bitmap, figure: &Bitmap) -> bool {
    let Some(own) = PixelBox::of(figure) else { return false };
    let Some(patch) = PixelBox::of(shadow) else { return false };
    let is_flat = patch.width() as f64 >= FLAT * patch.height() as f64;
    let is_wide = patch.width() as f64 >= WIDE * own.width() as f64;
    is_flat && is_wide && patch.centre()[1] > own.high[1] as f64 - 0.1 * own.height() as f64
}

/// A picture moved by so many pixels.
fn moved(picture: &Bitmap, [right, down]: [isize; 2]) -> Bitmap {
    let (width, height) = (picture.width() as isize, picture.height() as isize);
    let mut moved = Bitmap::new(picture.width(), picture.height());
    for y in (0..height).filter(|y| (0..height).contains(&(y + down))) {
        for run in picture.runs(y as usize) {
            let [from, to] = [run.start, run.end].map(|x| (x as isize + right).clamp(0, width) as usize);
            moved.fill((y + down) as usize, from, to, true);
        }
    }
    moved
}
