//! The paper's own lines: straight thin ones from border to border, which are rules, a margin, a horizon; and its creases.

use super::Sheet;
use super::ground::Ground;
use crate::raster::PixelBox;
use crate::raster::bitmap::Bitmap;

/// How far from the border the ends of a line are looked for, in pixels, and how many are looked at along a side.
const RULE_END: usize = 4;
const MOST_RULES: usize = 24;

/// Ends on both sides together up to which they may be those of creases: a paper is folded once or twice. How far a crease is
/// from upright, in parts of its length, and the distance of the ends between which it is looked for, in pixels.
const MOST_CREASES: usize = 8;
const LEANING: f64 = 0.1;
const STEP: usize = 4;

/// How near a line is to where it is looked for, in pixels.
const NEAR: usize = 1;

/// What a line that swerves by a pixel is less likely by, beside a pixel of ink.
const SWERVING: f64 = 0.1;

/// How straight and whole such a line is.
struct Kind {
    /// How wide it is at most, and how far it swerves from the straight line between its ends, in pixels.
    wide: usize,
    swerve: usize,
    /// The share of its length that is there, and that along which nothing else is.
    whole: f64,
    thin: f64,
}

/// What is printed; the same in a photograph; and a crease of the paper, which is soft and may have no end that is seen.
const PRINTED: Kind = Kind { wide: 5, swerve: 0, whole: 0.97, thin: 0.6 };
const PHOTOGRAPHED: Kind = Kind { wide: 5, swerve: 2, whole: 0.9, thin: 0.55 };
const CREASE: Kind = Kind { wide: 8, swerve: 6, whole: 0.75, thin: 0.55 };

/// What has more than this many times the contrast of most of a rule is drawn over it.
const STRONGER: f64 = 1.5;

/// How far from the sides of the sheet rules begin, in parts of its size.
const OFF_FRAME: f64 = 0.03;

/// The ink without the paper's own lines.
pub(super) fn without_rules(ink: &Bitmap, ground: &Ground, sheet: &Sheet) -> Bitmap {
    let (bounds, contrast) = (sheet.sides, &ground.contrast[..]);
    let mut kept = ink.clone();
    for across in [false, true] {
        let axis = usize::from(!across);
        let (first, last) = (bounds.low[axis] + RULE_END, bounds.high[axis].saturating_sub(RULE_END + 1));
        if first >= last {
            continue;
        }
        let crossed = |kind: &Kind| [first, last].map(|at| crossed(ink, at, across, bounds, kind.wide));
        let creases = (ground.noise > 0).then(|| crossed(&CREASE));
        let (kind, ways) = match creases.filter(|[from, to]| from.len() + to.len() <= MOST_CREASES) {
            Some(ends) => (CREASE, leaning(&ends, LEANING * (last - first) as f64)),
            None => {
                let kind = if ground.noise > 0 { PHOTOGRAPHED } else { PRINTED };
                let ends = crossed(&kind);
                (kind, ends[0].iter().flat_map(|&from| ends[1].iter().map(move |&to| vec![[from, to]])).collect())
            }
        };
        for ways in ways {
            let lines = ways.into_iter().map(|ends| Line::between(ends, [first, last], across, ink, contrast, &kind));
            let Some(line) = lines.max_by(|a, b| a.drawn.total_cmp(&b.drawn)) else { continue };
            let thin: Vec<usize> = (bounds.low[axis]..bounds.high[axis]).filter(|&at| line.is_thin(at)).collect();
            let there = (first..=last).filter(|&at| line.is_there(at)).count() as f64;
            let length = (last + 1 - first) as f64;
            if there >= kind.whole * length && thin.len() as f64 >= kind.thin * length {
                let most = STRONGER * f64::from(line.median_contrast(&thin));
                thin.into_iter().for_each(|at| line.clear(&mut kept, at, most));
            }
        }
    }
    kept
}

/// For every end on either side the ways to all that are opposite of it by so much at most.
fn leaning(ends: &[Vec<f64>; 2], most: f64) -> Vec<Vec<[f64; 2]>> {
    let steps = (most / STEP as f64) as i32;
    let opposite = |end: f64| (-steps..=steps).map(move |k| end + f64::from(k) * STEP as f64);
    let from = ends[0].iter().map(|&from| opposite(from).map(move |to| [from, to]).collect());
    let to = ends[1].iter().map(|&to| opposite(to).map(move |from| [from, to]).collect());
    from.chain(to).collect()
}

/// A line that may be a rule, from one side of the sheet to the other.
struct Line<'a> {
    ink: &'a Bitmap,
    contrast: &'a [u8],
    /// Whether it runs from left to right; from top to bottom otherwise.
    across: bool,
    /// Where along the way it begins, and how far across the way it is from there on.
    first: usize,
    sides: Vec<usize>,
    /// How many pixels of ink it goes through, less what speaks against its swerving; 0 of a straight one.
    drawn: f64,
    /// How wide it is at most, in pixels.
    wide: usize,
}

impl Line<'_> {
    /// The line between two ends, which are so far across the way, that has most ink of those that swerve by so much at most.
    fn between<'a>(
        [from, to]: [f64; 2],
        [first, last]: [usize; 2],
        across: bool,
        ink: &'a Bitmap,
        contrast: &'a [u8],
        kind: &Kind,
    ) -> Line<'a> {
        let straight = |at: usize| from + (at - first) as f64 / (last - first) as f64 * (to - from);
        let sides: Vec<usize> = (first..=last).map(|at| straight(at).floor() as usize).collect();
        let line = Line { ink, contrast, across, first, sides, drawn: 0.0, wide: kind.wide };
        if kind.swerve == 0 {
            return line;
        }
        let (sides, drawn) = line.swerving(kind.swerve);
        Line { sides, drawn, ..line }
    }

    /// How far across the way it is where it follows the ink, by dynamic programming, and how much of it is drawn.
    fn swerving(&self, most: usize) -> (Vec<usize>, f64) {
        let offsets = 2 * most + 1;
        let place = |at: usize, offset: usize| (self.sides[at] + offset).checked_sub(most);
        let mut best = vec![f64::NEG_INFINITY; offsets];
        best[most] = 0.0;
        let mut next = best.clone();
        let mut came = Vec::with_capacity(self.sides.len() * offsets);
        for at in 0..self.sides.len() {
            for (offset, next) in next.iter_mut().enumerate() {
                let near = offset.saturating_sub(1)..(offset + 2).min(offsets);
                let value = |from: usize| best[from] - if from == offset { 0.0 } else { SWERVING };
                let from = near.max_by(|&a, &b| value(a).total_cmp(&value(b))).unwrap_or(offset);
                let is_ink = place(at, offset).is_some_and(|side| self.is_ink(self.first + at, side));
                *next = value(from) + f64::from(is_ink);
                came.push(from);
            }
            std::mem::swap(&mut best, &mut next);
        }
        let (mut offset, drawn) = (most, best[most]);
        let mut sides = self.sides.clone();
        for at in (0..sides.len()).rev() {
            sides[at] = place(at, offset).unwrap_or(0);
            offset = came[at * offsets + offset];
        }
        (sides, drawn)
    }

    /// How far across the way it is there; beyond its ends as far as at them.
    fn side(&self, at: usize) -> usize {
        self.sides[at.saturating_sub(self.first).min(self.sides.len() - 1)]
    }

    fn is_ink(&self, at: usize, side: usize) -> bool {
        let [x, y] = if self.across { [at, side] } else { [side, at] };
        x < self.ink.width() && y < self.ink.height() && self.ink.get(x, y)
    }

    fn is_there(&self, at: usize) -> bool {
        let side = self.side(at);
        (side.saturating_sub(NEAR)..=side + NEAR).any(|side| self.is_ink(at, side))
    }

    /// Whether what is drawn there ends within a few pixels on either side.
    fn is_thin(&self, at: usize) -> bool {
        let side = self.side(at);
        !self.is_ink(at, side.saturating_sub(self.wide)) && !self.is_ink(at, side + self.wide)
    }

    /// The pixels of ink that lie there side by side, as far as a rule may be wide.
    fn pixels(&self, at: usize) -> impl Iterator<Item = [usize; 2]> {
        let (side, across) = (self.side(at), self.across);
        let on = (side.saturating_sub(NEAR)..=side + NEAR).find(|&side| self.is_ink(at, side)).unwrap_or(side);
        let low = (0..=on).rev().take(self.wide + 1).take_while(|&side| self.is_ink(at, side)).last();
        let high = (on..).take(self.wide + 1).take_while(|&side| self.is_ink(at, side)).last();
        let places = low.zip(high).map(|(low, high)| low..high + 1).unwrap_or_default();
        places.map(move |side| if across { [at, side] } else { [side, at] })
    }

    fn contrast_of(&self, [x, y]: [usize; 2]) -> u8 {
        self.contrast[y * self.ink.width() + x]
    }

    /// The contrast that half of these places have at most.
    fn median_contrast(&self, places: &[usize]) -> u8 {
        let strongest = |&at: &usize| self.pixels(at).map(|pixel| self.contrast_of(pixel)).max();
        let mut all: Vec<u8> = places.iter().filter_map(strongest).collect();
        all.sort_unstable();
        all.get(all.len() / 2).copied().unwrap_or(0)
    }

    /// Clears what is drawn there with no more than so much contrast.
    fn clear(&self, kept: &mut Bitmap, at: usize, most: f64) {
        let own = self.pixels(at).filter(|&pixel| f64::from(self.contrast_of(pixel)) <= most);
        own.for_each(|[x, y]| kept.fill(y, x, x + 1, false));
    }
}

/// The middles of the pieces of ink along a row of the sheet, or a column of it, that are no wider than that.
fn crossed(ink: &Bitmap, at: usize, column: bool, bounds: PixelBox, widest: usize) -> Vec<f64> {
    let axis = usize::from(column);
    let get = |side: usize| if column { ink.get(at, side) } else { ink.get(side, at) };
    let (mut middles, mut start) = (Vec::new(), None);
    // What runs along the border is a frame.
    let room = (OFF_FRAME * bounds.side() as f64) as usize;
    let (low, high) = (bounds.low[axis] + room, bounds.high[axis].saturating_sub(room));
    for side in low..=high {
        let is_set = side < high && get(side);
        match start {
            None if is_set => start = Some(side),
            Some(from) if !is_set => {
                if side - from <= widest {
                    middles.push(0.5 * (from + side) as f64);
                }
                start = None;
            }
            _ => {}
        }
    }
    middles.truncate(MOST_RULES);
    middles
}
