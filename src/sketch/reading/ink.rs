//! What is drawn on a sheet: all that differs from its ground.

use super::Sheet;
use super::binding::binding;
use super::border;
use super::edge::edge;
use super::faint;
use super::floor::floor;
use super::ground::{Ground, exceeded};
use super::rules::without_rules;
use super::shadow::shadow;
use crate::raster::bitmap::Bitmap;
use crate::raster::neighbourhood::{dilated, opened};
use crate::raster::pieces::{Pieces, without_specks};

/// Least difference from the ground that is seen, in 255ths: a light skin on white paper differs by 30.
const LEAST_CONTRAST: u8 = 18;

/// And in multiples of what equal pixels differ by, or of the ground's own grain where that is less.
const NOISES: u8 = 6;
const GRAINS: u8 = 3;

/// Where it continues what is surely drawn, a line is seen from this contrast on, in 255ths.
const FAINTEST_STRETCH: u8 = 6;

/// The widest edge, in pixels: that of a small picture made larger; and the least rise of its contrast a pixel, in 255ths.
const SOFTEST_EDGE: usize = 8;
const STEEP: u8 = 8;

/// Where so many lines run over the border of the sheet they are its own pattern: squares, rules, a grain.
const PATTERN: usize = 8;

/// The contrast to which a pattern is taken for the ground's own.
const STRONGEST_PATTERN: u8 = 128;

/// A line is drawn with this share at least of the contrast that most of the ink has; fainter ones are seams between shapes.
const FAINTEST_LINE: f64 = 0.25;

/// A shadow has less than this share of that contrast, and its own differs from what it is in brightness by no more.
const FAINT: f64 = 0.6;
const COLOURLESS: u8 = 12;

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

/// What differs from the ground, and of that what is darker or lighter by much; and what is no part of a figure, though it
/// is seen: a shadow, rules of the paper, a line to stand on.
pub(super) struct Ink {
    pub all: Bitmap,
    pub dark: Bitmap,
    pub aside: Bitmap,
    /// Whether lines all over the sheet were taken for its own.
    pub patterned: bool,
}

impl Ink {
    /// The ink without the line that all else stands on.
    pub fn without_floor(self) -> Ink {
        let Some(floor) = floor(&self.all) else { return self };
        Ink { all: self.all.without(&floor), dark: self.dark.without(&floor), aside: self.aside.or(&floor), ..self }
    }

    /// The ink with the sides of the sheet where they end the figure.
    pub fn closed_along(self, sheet: &Sheet) -> Ink {
        Ink { all: border::closed(&self.all, sheet), ..self }
    }
}

pub(super) fn drawn(ground: &Ground, sheet: &Sheet) -> Drawn {
    let border = sheet.border(1.0);
    let noise = ground.noise.saturating_mul(NOISES).min(ground.grain.saturating_mul(GRAINS));
    let faintest = LEAST_CONTRAST.max(noise);
    let mut least = faintest;
    let mut ink = above(ground, sheet, least);
    let mut bound = edge(&ink, sheet);
    if ground.noise > 0 {
        bound = bound.or(&binding(&ink, sheet));
    }
    ink = ink.without(&bound);
    let band = sheet.border(BAND * sheet.area.width().max(sheet.area.height()) as f64);
    // Lines that run over the border are squares or rules, which are no scene.
    let is_scene = opened(&ink, SEAM).and(&band).area() as f64 > SCENE * band.area() as f64;
    while crossings(&ink, &border) > PATTERN && least < STRONGEST_PATTERN {
        least += least / 3;
        ink = above(ground, sheet, least).without(&bound);
    }
    let patterned = least > faintest;
    // What was not photographed has no pixels that are fainter by chance.
    let is_uneven = ground.noise > 0 && !patterned;
    let stretches =
        if is_uneven { stretches(ground, &ink).without(&bound) } else { Bitmap::new(ink.width(), ink.height()) };
    let seen = ink.or(&stretches);
    bound = bound.or(&edge(&seen, sheet));
    let seen = seen.without(&bound);
    let kept = without_rules(&seen, ground, sheet);
    let rules = seen.without(&kept);
    let ink = faint::continued(&ink.and(&kept), &stretches.and(&kept));
    let strong = f64::from(exceeded(&ground.contrast, &ink, 4));
    let all = without_dust(&without_seams(ground, ink, strong));
    if all.area() == 0 {
        return Drawn::Nothing;
    }
    let shadow = shadow(&all, &neutral(ground, &all, strong)).unwrap_or_else(|| Bitmap::new(all.width(), all.height()));
    let all = all.without(&shadow);
    let dark = dark(ground, &all);
    let ink = Ink { all, dark, aside: shadow.or(&rules).or(&bound), patterned };
    if is_scene { Drawn::Scene(ink) } else { Drawn::Ink(ink) }
}

/// The stretches of lines that are fainter than the ink, but neither as faint as seams nor as the ground's grain.
fn stretches(ground: &Ground, ink: &Bitmap) -> Bitmap {
    let strong = f64::from(exceeded(&ground.contrast, ink, 4));
    faint::stretches(ground, ink, ((FAINTEST_LINE * strong) as u8).max(ground.grain).max(FAINTEST_STRETCH))
}

/// The ink that differs from the ground in brightness by [`DARK`] of what the strongest of it does at least.
fn dark(ground: &Ground, ink: &Bitmap) -> Bitmap {
    let width = ink.width();
    let pixels = || (0..ink.height()).flat_map(|y| ink.runs(y).flatten().map(move |x| (x, y)));
    let least = DARK * f64::from(exceeded(&ground.shade, ink, 20));
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
    let mut ink = ink.without(&ground.seen);
    trim(&mut ink, &ground.contrast);
    ink
}

/// Takes away the outer half of soft edges: from the rim inwards what has less than half of the contrast that its
/// surroundings rise to.
fn trim(ink: &mut Bitmap, contrast: &[u8]) {
    let (width, height) = (ink.width(), ink.height());
    let is_inside = |x: usize, y: usize| x > 0 && y > 0 && x + 1 < width && y + 1 < height;
    let mut rim: Vec<[usize; 2]> = Vec::new();
    for y in 0..height {
        let ends = ink.runs(y).flat_map(|run| [run.start, run.end - 1]);
        rim.extend(ends.chain(exposed(ink, y)).map(|x| [x, y]));
    }
    while let Some([x, y]) = rim.pop() {
        if !is_inside(x, y) || !ink.get(x, y) {
            continue;
        }
        let own = contrast[y * width + x];
        let around = [y - 1, y, y + 1].map(|y| &contrast[y * width + x - 1..][..3]);
        let least = around.into_iter().flatten().copied().min().unwrap_or(0);
        // Beside a paler fill an edge leads down to that and no further.
        let is_edge = own >= least.saturating_add(STEEP);
        if is_edge && 2 * u32::from(own) < u32::from(risen(contrast, width, height, [x, y])) {
            ink.fill(y, x, x + 1, false);
            rim.extend([[x - 1, y], [x + 1, y], [x, y - 1], [x, y + 1]]);
        }
    }
}

/// The contrast to which the way up from a pixel leads, as long as it is steep.
fn risen(contrast: &[u8], width: usize, height: usize, [mut x, mut y]: [usize; 2]) -> u8 {
    for _ in 0..SOFTEST_EDGE {
        let own = contrast[y * width + x];
        let around = (y.saturating_sub(1)..(y + 2).min(height))
            .flat_map(|y| (x.saturating_sub(1)..(x + 2).min(width)).map(move |x| [x, y]));
        let Some([next, down]) = around.max_by_key(|&[x, y]| contrast[y * width + x]) else { break };
        if contrast[down * width + next] < own.saturating_add(STEEP) {
            break;
        }
        [x, y] = [next, down];
    }
    contrast[y * width + x]
}

/// The pixels of a row that are set while that above or below is not.
fn exposed(ink: &Bitmap, y: usize) -> impl Iterator<Item = usize> {
    let is_set = |x: usize, y: Option<usize>| y.is_some_and(|y| y < ink.height() && ink.get(x, y));
    ink.runs(y).flatten().filter(move |&x| !is_set(x, y.checked_sub(1)) || !is_set(x, Some(y + 1)))
}

/// How many pieces of ink lie on the border.
fn crossings(ink: &Bitmap, border: &Bitmap) -> usize {
    Pieces::of(&dilated(&ink.and(border), 1.0), true).sizes.len()
}

/// The ink that is faint beside the rest and has the ground's colour, only darker or lighter.
fn neutral(ground: &Ground, ink: &Bitmap, strong: f64) -> Bitmap {
    let (width, most) = (ink.width(), FAINT * strong);
    let mut faint = Bitmap::new(width, ink.height());
    for y in 0..ink.height() {
        for x in ink.runs(y).flatten() {
            let at = y * width + x;
            if f64::from(ground.contrast[at]) < most && ground.contrast[at].abs_diff(ground.shade[at]) <= COLOURLESS {
                faint.set(x, y);
            }
        }
    }
    faint
}

/// The ink without lines so faint beside the rest that no pen has drawn them.
fn without_seams(ground: &Ground, ink: Bitmap, strong: f64) -> Bitmap {
    let width = ink.width();
    let faintest = (FAINTEST_LINE * strong) as u8;
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
    // More pixels than a square of this side.
    without_specks(ink, (side * side) as usize + 1)
}
