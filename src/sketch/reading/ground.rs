//! The ground a figure is drawn on, and how much every pixel differs from it.

use super::Sheet;
use super::blocks::{BLOCK, Blocks};
use super::colours::{apart, lightness};
use super::continued::beyond_lines;
use super::leaks::leaks;
use crate::raster::bitmap::Bitmap;
use crate::raster::enclosed::parts;
use crate::raster::neighbourhood::dilated;
use crate::raster::pieces::Pieces;

/// Colours of neighbours differ by no more within a ground, in 255ths; shades and soft shadows change more slowly.
pub(super) const STEADY: u8 = 12;

/// How far the edge between two grounds reaches, in pixels, and how far its colours may lie off those between the two.
const EDGE: usize = 4;
const OFF_EDGE: f32 = 1.25;

/// The paper's own lines are as much darker than it in a shadow as elsewhere, down to this brightness of it, in 255ths.
const DARKEST: u8 = 100;

/// A ground of at least this brightness may be a white paper in little light; a darker one is dark itself.
const DIM: u8 = 80;

/// The share of a ground of one colour that may be lighter, and that may be darker: what is written in the bar of a window.
const OTHERS: f64 = 0.02;

/// One in so many of the ground's pixels may differ more from it than its grain.
const GRAIN: usize = 50;

/// How far from a corner of the sheet its ground is looked for, in parts of the sheet's side.
const CORNER: f64 = 0.02;

/// What lies in one corner of a sheet while its other three have one ground is a part of a figure that runs over the corner,
/// where it takes less than this share of what that ground does.
const LONE: f64 = 0.35;

/// The share of a sheet that a paper on it takes which has an edge all round.
const PLATE: f64 = 0.15;

/// The ground of a sheet.
pub(super) struct Ground {
    /// What is joined with a corner of the sheet without an edge between.
    pub seen: Bitmap,
    /// The pieces of it, each of one ground.
    pub pieces: Vec<Bitmap>,
    /// What else has hardly an edge within and takes a good part of the sheet: papers that lie on others.
    pub plates: Vec<Bitmap>,
    /// How much each pixel differs from the ground, row by row, in 255ths; 0 off the sheet.
    pub contrast: Vec<u8>,
    /// How much lighter or darker each is, in 255ths.
    pub shade: Vec<u8>,
    /// What equal pixels differ by, in 255ths.
    pub noise: u8,
    /// The contrast that hardly any of the ground's own pixels exceeds, in 255ths.
    pub grain: u8,
}

impl Ground {
    /// The ground of a sheet, which goes on beyond thin lines where the sheet is `lined`.
    pub fn of(colours: &[[u8; 3]], sheet: &Sheet, lined: bool) -> Ground {
        let (width, height) = (sheet.area.width(), sheet.area.height());
        let noise = noise(colours, sheet);
        let smoothed;
        let colours = if noise > 1 {
            smoothed = smoothed_colours(colours, width, height);
            &smoothed
        } else {
            colours
        };
        let steady = steady(colours, sheet, STEADY.max(noise.saturating_mul(2)));
        let pieces = joined_with_corners(&steady, sheet);
        let plates = plates(&steady, &pieces, sheet);
        let pieces = if lined { beyond_lines(colours, &steady, &pieces) } else { pieces };
        let leaks = pieces.iter().fold(Bitmap::new(width, height), |all, piece| all.or(&leaks(colours, piece, sheet)));
        let pieces: Vec<Bitmap> = pieces.iter().map(|piece| piece.without(&leaks)).collect();
        let mut seen = pieces.iter().fold(Bitmap::new(width, height), |all, piece| all.or(piece));
        let plain: Vec<[u8; 3]> = pieces.iter().filter_map(|piece| one_colour(colours, piece)).collect();
        // Beside a leak the ground has the colour of what it leaked through.
        let blocks = Blocks::of(colours, &seen.without(&dilated(&leaks, BLOCK as f64)));
        let (mut contrast, mut shade) = (vec![0; colours.len()], vec![0; colours.len()]);
        for y in 0..height {
            for run in sheet.area.runs(y) {
                for x in run {
                    let colour = colours[y * width + x];
                    let around = blocks.colour(x, y);
                    let grounds = plain.iter().copied().chain([around]);
                    let ground = grounds.min_by_key(|&ground| apart(colour, ground)).unwrap_or(around);
                    let light = lightness(ground);
                    let light = if lined || light >= DIM { light.max(DARKEST) } else { 255 };
                    let lit = |value: u8| (u32::from(value) * 255 / u32::from(light)).min(255) as u8;
                    contrast[y * width + x] = lit(apart(colour, ground));
                    shade[y * width + x] = lit(lightness(colour).abs_diff(lightness(ground)));
                }
            }
        }
        let grain = exceeded(&contrast, &seen, GRAIN);
        if plain.len() > 1 {
            let alike = alike(&steady, &contrast);
            seen = seen.or(&edges(colours, &seen.or(&alike)));
        }
        Ground { seen, pieces, plates, contrast, shade, noise, grain }
    }
}

/// The mean colour of a piece of ground where it has one colour nearly throughout; a word in a window has others.
fn one_colour(colours: &[[u8; 3]], piece: &Bitmap) -> Option<[u8; 3]> {
    let width = piece.width();
    let (mut sums, mut counts, mut n) = ([0u64; 3], [[0u64; 256]; 3], 0);
    for y in 0..piece.height() {
        for x in piece.runs(y).flatten() {
            let colour = colours[y * width + x];
            n += 1;
            for i in 0..3 {
                sums[i] += u64::from(colour[i]);
                counts[i][usize::from(colour[i])] += 1;
            }
        }
    }
    let few = (OTHERS * n as f64) as u64;
    let is_one = counts.iter().all(|counts| spread(counts, few) <= 2 * usize::from(STEADY));
    (n > 0 && is_one).then(|| sums.map(|sum| (sum / n) as u8))
}

/// How far the values that were counted lie apart, the lowest `few` and the highest `few` left out.
fn spread(counts: &[u64; 256], few: u64) -> usize {
    let within = |passed: &mut u64, count: u64| {
        *passed += count;
        *passed > few
    };
    let (mut below, mut above) = (0, 0);
    let low = counts.iter().position(|&count| within(&mut below, count));
    let high = counts.iter().rposition(|&count| within(&mut above, count));
    high.unwrap_or(0).saturating_sub(low.unwrap_or(0))
}

/// What is steady and differs from the grounds by no more than they do from pixel to pixel, such as sky between legs.
fn alike(steady: &Bitmap, contrast: &[u8]) -> Bitmap {
    let width = steady.width();
    let mut alike = Bitmap::new(width, steady.height());
    for y in 0..steady.height() {
        for x in steady.runs(y).flatten().filter(|x| contrast[y * width + x] <= STEADY) {
            alike.set(x, y);
        }
    }
    alike
}

/// The pixels between two grounds of different colours that are a mixture of both.
fn edges(colours: &[[u8; 3]], seen: &Bitmap) -> Bitmap {
    let (width, height) = (seen.width(), seen.height());
    let mut edges = Bitmap::new(width, height);
    let is_mixed = |at: usize, [a, b]: [usize; 2]| {
        let [own, a, b] = [at, a, b].map(|at| colours[at]);
        let whole = f32::from(apart(a, b));
        whole > f32::from(2 * STEADY) && f32::from(apart(own, a)) + f32::from(apart(own, b)) <= OFF_EDGE * whole
    };
    for y in EDGE..height.saturating_sub(EDGE) {
        for x in (EDGE..width.saturating_sub(EDGE)).filter(|&x| !seen.get(x, y)) {
            let at = y * width + x;
            let on = |steps: [[usize; 2]; EDGE]| {
                steps.into_iter().find(|&[x, y]| seen.get(x, y)).map(|[x, y]| y * width + x)
            };
            let step = |k: usize| k + 1;
            let [left, right] =
                [on(std::array::from_fn(|k| [x - step(k), y])), on(std::array::from_fn(|k| [x + step(k), y]))];
            let [above, below] =
                [on(std::array::from_fn(|k| [x, y - step(k)])), on(std::array::from_fn(|k| [x, y + step(k)]))];
            let across = [[left, right], [above, below]];
            if across.into_iter().any(|ends| matches!(ends, [Some(a), Some(b)] if is_mixed(at, [a, b]))) {
                edges.set(x, y);
            }
        }
    }
    edges
}

/// The value that one in `share` pixels of an area exceeds.
pub(super) fn exceeded(values: &[u8], area: &Bitmap, share: usize) -> u8 {
    let mut counts = [0usize; 256];
    for y in 0..area.height() {
        area.runs(y).flatten().for_each(|x| counts[usize::from(values[y * area.width() + x])] += 1);
    }
    let (mut passed, few) = (0, area.area() / share);
    let exceeded = (0..=u8::MAX).rev().find(|&value| {
        passed += counts[usize::from(value)];
        passed > few
    });
    exceeded.unwrap_or(0)
}

/// The median difference of pixels beside each other.
fn noise(colours: &[[u8; 3]], sheet: &Sheet) -> u8 {
    let width = sheet.area.width();
    let mut counts = [0usize; 256];
    for y in (0..sheet.area.height()).step_by(4) {
        for run in sheet.area.runs(y) {
            for x in run.clone().skip(1) {
                counts[usize::from(apart(colours[y * width + x], colours[y * width + x - 1]))] += 1;
            }
        }
    }
    let half = counts.iter().sum::<usize>() / 2;
    let mut passed = 0;
    let median = counts.iter().position(|&count| {
        passed += count;
        passed > half
    });
    median.unwrap_or(0) as u8
}

/// Every colour the mean of the nine around it.
fn smoothed_colours(colours: &[[u8; 3]], width: usize, height: usize) -> Vec<[u8; 3]> {
    let sum = |a: [u16; 3], b: [u16; 3]| [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
    let across = |y: usize| -> Vec<[u16; 3]> {
        let row = &colours[y * width..][..width];
        let at = |x: usize| row[x].map(u16::from);
        (0..width).map(|x| sum(sum(at(x.saturating_sub(1)), at(x)), at((x + 1).min(width - 1)))).collect()
    };
    let mut rows = [across(0), across(0), across(1.min(height - 1))];
    let mut smoothed = Vec::with_capacity(colours.len());
    for y in 0..height {
        smoothed
            .extend((0..width).map(|x| sum(sum(rows[0][x], rows[1][x]), rows[2][x]).map(|value| (value / 9) as u8)));
        rows.rotate_left(1);
        rows[2] = across((y + 2).min(height - 1));
    }
    smoothed
}

/// The pixels of the sheet whose neighbours on both sides have about one colour.
fn steady(colours: &[[u8; 3]], sheet: &Sheet, most: u8) -> Bitmap {
    let (width, height) = (sheet.area.width(), sheet.area.height());
    let mut steady = Bitmap::new(width, height);
    for y in 0..height {
        let [above, own, below] =
            [y.saturating_sub(1), y, (y + 1).min(height - 1)].map(|y| &colours[y * width..][..width]);
        for run in sheet.area.runs(y) {
            for x in run {
                let beside = apart(own[x.saturating_sub(1)], own[(x + 1).min(width - 1)]);
                if beside <= most && apart(above[x], below[x]) <= most {
                    steady.set(x, y);
                }
            }
        }
    }
    steady
}

/// The pieces of what is steady that lie in the corners of the sheet.
fn joined_with_corners(steady: &Bitmap, sheet: &Sheet) -> Vec<Bitmap> {
    let pieces = Pieces::of(steady, false);
    let reach = CORNER * steady.width().max(steady.height()) as f64;
    let mut corners = Vec::new();
    for [right, down] in [[1.0, 1.0], [1.0, -1.0], [-1.0, 1.0], [-1.0, -1.0]] {
        let depth = |x: usize, y: usize| right * x as f64 + down * y as f64;
        let deepest = |from: usize, to: usize, y: usize| depth(from, y).max(depth(to - 1, y));
        let rows = (0..steady.height()).flat_map(|y| sheet.area.runs(y).map(move |run| (y, run)));
        let corner = rows.map(|(y, run)| deepest(run.start, run.end, y)).fold(f64::NEG_INFINITY, f64::max);
        let near = corner - 2.0 * reach;
        let mut sizes = vec![0usize; pieces.sizes.len()];
        for run in pieces.runs.iter().filter(|run| deepest(run.from, run.to, run.y) >= near) {
            sizes[run.piece] += (run.from..run.to).filter(|&x| depth(x, run.y) >= near).count();
        }
        // The one that takes most of the place about the corner: of squared paper a square, not its lines.
        let largest = (0..sizes.len()).filter(|&piece| sizes[piece] > 0).max_by_key(|&piece| sizes[piece]);
        corners.extend(largest);
    }
    let is_lone = |piece: usize| {
        corners.iter().any(|&most| {
            corners.iter().filter(|&&other| other == most).count() == 3
                && (pieces.sizes[piece] as f64) < LONE * pieces.sizes[most] as f64
        })
    };
    let mut chosen: Vec<usize> = Vec::new();
    for &piece in &corners {
        if !chosen.contains(&piece) && !is_lone(piece) {
            chosen.push(piece);
        }
    }
    let mut grounds = vec![Bitmap::new(steady.width(), steady.height()); chosen.len()];
    for run in &pieces.runs {
        if let Some(k) = chosen.iter().position(|&piece| piece == run.piece) {
            grounds[k].fill(run.y, run.from, run.to, true);
        }
    }
    grounds
}

/// The large pieces of what is steady that are none of the grounds.
fn plates(steady: &Bitmap, grounds: &[Bitmap], sheet: &Sheet) -> Vec<Bitmap> {
    let least = (PLATE * sheet.area.area() as f64) as usize;
    parts(steady, least).into_iter().filter(|part| grounds.iter().all(|ground| ground.and(part).area() == 0)).collect()
}
