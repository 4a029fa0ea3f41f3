//! What is drawn on a sheet: all that differs from its ground.

use super::Sheet;
use super::ground::Ground;
use crate::raster::bitmap::Bitmap;
use crate::raster::neighbourhood::{dilated, opened};
use crate::raster::pieces::Pieces;

/// Least difference from the ground that is seen, in 255ths: a light skin on white paper differs by 30.
const LEAST_CONTRAST: u8 = 18;

/// And in multiples of what equal pixels differ by.
const NOISES: u8 = 6;

/// Where so many lines run over the border of the sheet they are its own pattern: squares, rules, a grain.
const PATTERN: usize = 8;

/// The contrast to which a pattern is taken for the ground's own.
const STRONGEST_PATTERN: u8 = 128;

/// A line is drawn with a tenth at least of the contrast that most of the ink has; fainter ones are seams between shapes.
const FAINTEST_LINE: f64 = 0.25;

/// A line round a fill has this share of the strongest difference in brightness.
const DARK: f64 = 0.6;

/// Half the width of lines that can be seams, in pixels.
const SEAM: f64 = 1.5;

/// Ink pieces of a smaller side than this part of the sheet's are dust.
const DUST: f64 = 0.004;

/// Width of the band along the border in which a scene is told, in parts of the sheet's side, and the share of it that the
/// ink of a figure may take; a scene takes more.
const BAND: f64 = 0.02;
const SCENE: f64 = 0.45;

/// What is drawn on a sheet.
pub(super) enum Drawn {
    Nothing,
    /// The ink runs over most of the border: there is no ground round it.
    Scene(Ink),
    Ink(Ink),
}

/// What differs from the ground, and of that what is darker or lighter by much.
pub(super) struct Ink {
    pub all: Bitmap,
    pub dark: Bitmap,
}

pub(super) fn drawn(ground: &Ground, sheet: &Sheet) -> Drawn {
    let border = sheet.border(1.0);
    let mut least = LEAST_CONTRAST.max(ground.noise.saturating_mul(NOISES));
    let mut ink = above(ground, sheet, least);
    let band = sheet.border(BAND * sheet.area.width().max(sheet.area.height()) as f64);
    // Lines that run over the border are squares or rules, which are no scene.
    let is_scene = opened(&ink, SEAM).and(&band).area() as f64 > SCENE * band.area() as f64;
    while crossings(&ink, &border) > PATTERN && least < STRONGEST_PATTERN {
        least += least / 3;
        ink = above(ground, sheet, least);
    }
    let all = without_dust(&without_seams(ground, ink));
    if all.area() == 0 {
        return Drawn::Nothing;
    }
    let dark = dark(ground, &all);
    let ink = Ink { all, dark };
    if is_scene { Drawn::Scene(ink) } else { Drawn::Ink(ink) }
}

/// The ink that differs from the ground in brightness by more than half of what most of it does.
fn dark(ground: &Ground, ink: &Bitmap) -> Bitmap {
    let width = ink.width();
    let pixels = || (0..ink.height()).flat_map(|y| ink.runs(y).flatten().map(move |x| (x, y)));
    let mut counts = [0usize; 256];
    pixels().for_each(|(x, y)| counts[usize::from(ground.shade[y * width + x])] += 1);
    let (mut passed, few) = (0, ink.area() / 20);
    let darkest = (0..256).rev().find(|&shade| {
        passed += counts[shade];
        passed > few
    });
    let least = DARK * darkest.unwrap_or(0) as f64;
    let mut dark = Bitmap::new(width, ink.height());
    pixels().filter(|&(x, y)| f64::from(ground.shade[y * width + x]) >= least).for_each(|(x, y)| dark.set(x, y));
    dark
}

/// The pixels of the sheet that are not joined with its corners and differ from the ground by more than `least`.
fn above(ground: &Ground, sheet: &Sheet, least: u8) -> Bitmap {
    let width = sheet.area.width();
    let mut ink = Bitmap::new(width, sheet.area.height());
    for y in 0..ink.height() {
        for run in sheet.area.runs(y) {
            for x in run.filter(|x| ground.contrast[y * width + x] > least) {
                ink.set(x, y);
            }
        }
    }
    let ink = ink.without(&ground.seen);
    // Of the pixels at its rim those that are covered by half.
    let mut kept = ink.clone();
    for y in 1..ink.height().saturating_sub(1) {
        let rim = ink.runs(y).flat_map(|run| [run.start, run.end - 1]).chain(exposed(&ink, y));
        for x in rim.filter(|&x| x > 0 && x + 1 < width) {
            let around = [y - 1, y, y + 1].map(|y| &ground.contrast[y * width + x - 1..][..3]);
            let most = around.into_iter().flatten().copied().max().unwrap_or(0);
            if 2 * u32::from(ground.contrast[y * width + x]) < u32::from(most) {
                kept.fill(y, x, x + 1, false);
            }
        }
    }
    kept
}

/// The pixels of a row that are set while that above or below is not.
fn exposed(ink: &Bitmap, y: usize) -> impl Iterator<Item = usize> {
    ink.runs(y).flatten().filter(move |&x| !ink.get(x, y - 1) || !ink.get(x, y + 1))
}

/// How many pieces of ink lie on the border.
fn crossings(ink: &Bitmap, border: &Bitmap) -> usize {
    Pieces::of(&dilated(&ink.and(border), 1.0), true).sizes.len()
}

/// The ink without lines so faint beside the rest that no pen has drawn them.
fn without_seams(ground: &Ground, ink: Bitmap) -> Bitmap {
    let width = ink.width();
    let mut counts = [0usize; 256];
    let each = |counts: &mut [usize; 256]| {
        for y in 0..ink.height() {
            ink.runs(y).flatten().for_each(|x| counts[usize::from(ground.contrast[y * width + x])] += 1);
        }
    };
    each(&mut counts);
    let (mut passed, quarter) = (0, ink.area() / 4);
    let strong = (0..256).rev().find(|&value| {
        passed += counts[value];
        passed > quarter
    });
    let faintest = (FAINTEST_LINE * strong.unwrap_or(0) as f64) as u8;
    let areas = dilated(&opened(&ink, SEAM), SEAM);
    let mut kept = ink.clone();
    for y in 0..ink.height() {
        for x in ink.runs(y).flatten() {
            if ground.contrast[y * width + x] < faintest && !areas.get(x, y) {
                kept.fill(y, x, x + 1, false);
            }
        }
    }
    kept
}

/// The ink without pieces of a few pixels.
fn without_dust(ink: &Bitmap) -> Bitmap {
    let side = DUST * ink.width().max(ink.height()) as f64;
    let pieces = Pieces::of(ink, true);
    let mut clean = Bitmap::new(ink.width(), ink.height());
    let runs = pieces.runs.iter().filter(|run| pieces.sizes[run.piece] as f64 > side * side);
    runs.for_each(|run| clean.fill(run.y, run.from, run.to, true));
    clean
}
