//! The figures of a drawing: which of its parts belong together.

use super::enclosure::Body;
use crate::raster::PixelBox;
use crate::raster::bitmap::Bitmap;
use crate::raster::distance::squared;
use crate::raster::enclosed::parts;
use crate::raster::neighbourhood::dilated;

/// Parts of less than this share of the largest are specks.
const SPECK: f64 = 0.003;

/// Most parts of a drawing that are looked at, largest first.
const MOST_PARTS: usize = 24;

/// A part is joined over a gap of this part of the drawing's size however large both are: a white line.
const WHITE_LINE: f64 = 0.03;

/// A smaller part is joined over a gap of up to so much of its own size, and of the figure's: a head. A line that was made a
/// limb is joined over less of the figure's size with one this many times as large, a body: no pencil lies so near.
const OF_PART: f64 = 0.6;
const OF_FIGURE: f64 = 0.2;
const LIMB_OF_FIGURE: f64 = 0.1;
const BODY: usize = 3;

/// Scenery is joined over a gap of no more than so much of its own size: what is drawn in lines beside another, a tree; what has
/// ink in this share of it at most, where the figure has in that share, a cloud; and a box that takes this share of its bounds
/// and is so many times as wide as high, a caption. What is above the figure's middle is none: it may be a head.
const OF_DRAWN: f64 = 0.15;
const HOLLOW: f64 = 0.5;
const FILLED: f64 = 0.8;
const BOX: f64 = 0.93;
const CAPTION: usize = 2;

/// A head over the middle of shoulders is joined over a gap of up to so much of its own size however large it is, and is so
/// far off the middle at most, in parts of their width.
const OVER_SHOULDERS: f64 = 0.25;
const OFF_MIDDLE: f64 = 0.2;

/// Share of a figure's area up to which something beside it is a part of it. The area of limbs drawn as lines says nothing.
const LARGEST_PART: f64 = 0.5;
/// What lines that were made limbs take so much of consists of them.
const OF_LIMBS: f64 = 0.5;

/// What has less than this share of the largest figure's area is no figure.
const SMALLEST_FIGURE: f64 = 0.1;

/// How far a neck reaches round the shortest way, in parts of the side of the smaller part.
const NECK: f64 = 0.02;

/// Half the width of a neck at most, in parts of the side of the part: a head between raised arms is joined with the body
/// and not with the arms.
const HALF_NECK: f64 = 0.35;

/// A part below a figure, this many times as wide as high, is a shadow or the floor.
const FLAT: usize = 4;

/// A figure: its area with the necks between its parts.
pub(super) struct Figure {
    pub area: Bitmap,
    /// What was drawn in to join parts.
    pub necks: Vec<Bitmap>,
}

/// The figures that a body makes in a drawing of this size, largest first.
pub(super) fn figures(body: &Body, ink: &Bitmap, size: f64) -> Vec<Figure> {
    let mut rest = parts(&body.area, 1);
    let least = SPECK * rest.first().map_or(0, Bitmap::area) as f64;
    rest.retain(|part| part.area() as f64 >= least);
    rest.truncate(MOST_PARTS);
    let mut figures = Vec::new();
    while !rest.is_empty() {
        let seed = rest.remove(0);
        let largest = figures.iter().map(|figure: &Figure| figure.area.area()).max().unwrap_or(0);
        if (seed.area() as f64) < SMALLEST_FIGURE * largest as f64 {
            continue;
        }
        let mut figure = Figure { area: seed, necks: Vec::new() };
        figure.join(&mut rest, body, ink, size);
        figures.push(figure);
    }
    figures.sort_by_key(|figure| std::cmp::Reverse(figure.area.area()));
    figures
}

impl Figure {
    /// Takes out of `rest` what belongs to the figure, nearest first. The lines round parts are wider by the body's rim than
    /// what is seen of them here.
    fn join(&mut self, rest: &mut Vec<Bitmap>, body: &Body, ink: &Bitmap, size: f64) {
        while !rest.is_empty() {
            let width = self.area.width();
            let distances = squared(&self.area);
            let gap = |part: &Bitmap| {
                let runs = (0..part.height()).flat_map(|y| part.runs(y).map(move |run| (y, run)));
                let least =
                    runs.map(|(y, run)| distances[y * width..][run].iter().copied().fold(f32::INFINITY, f32::min));
                f64::from(least.fold(f32::INFINITY, f32::min)).sqrt()
            };
            let nearest: Vec<f64> = rest.iter().map(gap).collect();
            let mut order: Vec<usize> = (0..rest.len()).collect();
            order.sort_by(|&a, &b| nearest[a].total_cmp(&nearest[b]));
            let Some(&next) =
                order.iter().find(|&&k| self.owns(&rest[k], nearest[k] - 2.0 * body.rim, body, ink, size))
            else {
                return;
            };
            let part = rest.remove(next);
            let neck = neck(&self.area, &distances, &part, nearest[next]);
            self.area = self.area.or(&part).or(&neck);
            self.necks.push(neck);
        }
    }

    fn owns(&self, part: &Bitmap, gap: f64, body: &Body, ink: &Bitmap, size: f64) -> bool {
        let (Some(own), Some(other)) = (PixelBox::of(&self.area), PixelBox::of(part)) else { return false };
        let is_floor = other.low[1] + other.height() / 2 > own.high[1] - own.height() / 10
            && other.width() > FLAT * other.height()
            && 3 * other.width() > own.width();
        if is_floor {
            return false;
        }
        let is_stick = |area: &Bitmap| area.and(&body.limbs).area() as f64 >= OF_LIMBS * area.area() as f64;
        let is_small = part.area() as f64 <= LARGEST_PART * self.area.area() as f64;
        let is_of_limbs = is_stick(part) || is_stick(&self.area);
        let beside = own.low[0] >= other.high[0] || other.low[0] >= own.high[0];
        let inked = |area: &Bitmap| area.and(ink).area() as f64 / area.area() as f64;
        let is_hollow = inked(part) <= HOLLOW && inked(&self.area) >= FILLED;
        let is_drawn = body.rim > 0.0 && beside && !is_of_limbs;
        let is_scenery = (is_hollow || is_caption(part, other)) && !is_above(own, other);
        let of_part = if is_drawn || is_scenery { OF_DRAWN } else { OF_PART };
        let is_body = self.area.area() >= BODY * part.area();
        let of_figure = if is_stick(part) && is_body { LIMB_OF_FIGURE } else { OF_FIGURE };
        gap <= WHITE_LINE * size
            || is_above(own, other) && gap <= OVER_SHOULDERS * other.side() as f64
            || gap <= of_part * other.side() as f64
                && gap <= of_figure * own.side().max(other.side()) as f64
                && (is_small || is_of_limbs)
    }
}

/// Whether a part is a wide box: of words below or above a picture.
fn is_caption(part: &Bitmap, bounds: PixelBox) -> bool {
    part.area() as f64 >= BOX * (bounds.width() * bounds.height()) as f64 && bounds.width() >= CAPTION * bounds.height()
}

/// Whether one box lies over the middle of another.
fn is_above(own: PixelBox, other: PixelBox) -> bool {
    let off = (own.centre()[0] - other.centre()[0]).abs();
    other.high[1] <= own.low[1] && off <= OFF_MIDDLE * own.width() as f64
}

/// What lies nearly on the shortest ways between a figure and a part of it that are so far apart, about the middle of the
/// part's side that is nearest. `distances` are those from the figure, squared.
fn neck(figure: &Bitmap, distances: &[f32], part: &Bitmap, gap: f64) -> Bitmap {
    let side = (part.area() as f64).sqrt();
    let reach = gap + (NECK * side).max(1.5);
    let near = (reach * reach) as f32;
    let pixels = (0..part.height()).flat_map(|y| part.runs(y).flatten().map(move |x| [x, y]));
    let nearest: Vec<[usize; 2]> = pixels.filter(|&[x, y]| distances[y * part.width() + x] <= near).collect();
    let mean = [0, 1].map(|i| nearest.iter().map(|p| p[i] as f64).sum::<f64>() / nearest.len() as f64);
    let from_mean = |p: &[usize; 2]| (p[0] as f64 - mean[0]).hypot(p[1] as f64 - mean[1]);
    let mut middle = Bitmap::new(part.width(), part.height());
    if let Some([x, y]) = nearest.into_iter().min_by(|p, q| from_mean(p).total_cmp(&from_mean(q))) {
        middle.set(x, y);
    }
    let box_side = PixelBox::of(part).map_or(0, PixelBox::side) as f64;
    let about = dilated(&middle, (HALF_NECK * box_side).max(1.5 * reach));
    // Only where the ways to both are together hardly longer than the gap: much that is near to both lies on no short way
    // from one to the other where the figure runs along the part.
    let mut neck = about.without(figure).without(part);
    let from_part = squared(part);
    for (y, x) in (0..neck.height()).flat_map(|y| (0..part.width()).map(move |x| (y, x))) {
        let k = y * part.width() + x;
        if neck.get(x, y) && f64::from(distances[k].sqrt() + from_part[k].sqrt()) > reach + 1.0 {
            neck.fill(y, x, x + 1, false);
        }
    }
    neck
}
