//! The paper's own lines: straight thin ones from border to border, which are rules, a margin, a horizon.

use super::Sheet;
use super::ground::Ground;
use crate::raster::PixelBox;
use crate::raster::bitmap::Bitmap;

/// The widest line that is the paper's own, in pixels; how far from the border its ends are looked for; and how many ends are
/// looked at along a side.
const RULE: usize = 5;
const RULE_END: usize = 4;
const MOST_RULES: usize = 24;

/// How straight and whole such a line is.
struct Kind {
    /// How far it swerves, in pixels.
    swerve: usize,
    /// The share of its length that is there, and that along which nothing else is.
    whole: f64,
    thin: f64,
}

const PRINTED: Kind = Kind { swerve: 1, whole: 0.97, thin: 0.6 };
const CREASE: Kind = Kind { swerve: 2, whole: 0.9, thin: 0.55 };

/// What has more than this many times the contrast of most of a rule is drawn over it.
const STRONGER: f64 = 1.5;

/// How far from the sides of the sheet rules begin, in parts of its size.
const OFF_FRAME: f64 = 0.03;

/// The ink without the paper's own lines.
pub(super) fn without_rules(ink: &Bitmap, ground: &Ground, sheet: &Sheet) -> Bitmap {
    let (bounds, contrast) = (sheet.sides, &ground.contrast[..]);
    // A paper that was photographed has creases, too.
    let kind = if ground.noise > 0 { CREASE } else { PRINTED };
    let mut kept = ink.clone();
    for across in [false, true] {
        let axis = usize::from(!across);
        let (first, last) = (bounds.low[axis] + RULE_END, bounds.high[axis].saturating_sub(RULE_END + 1));
        if first >= last {
            continue;
        }
        let ends = [first, last].map(|at| crossed(ink, at, across, bounds));
        for line in ends[0].iter().flat_map(|&from| ends[1].iter().map(move |&to| (from, to))) {
            let line = Line { ink, contrast, across, first, last, from: line.0, to: line.1, swerve: kind.swerve };
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

/// A straight line that may be a rule, from one side of the sheet to the other.
struct Line<'a> {
    ink: &'a Bitmap,
    contrast: &'a [u8],
    /// Whether it runs from left to right; from top to bottom otherwise.
    across: bool,
    /// Where along the way its ends were looked for, and how far across the way they are.
    first: usize,
    last: usize,
    from: f64,
    to: f64,
    /// How far it swerves, in pixels.
    swerve: usize,
}

impl Line<'_> {
    /// How far across the way it is there.
    fn side(&self, at: usize) -> usize {
        let share = (at as f64 - self.first as f64) / (self.last - self.first) as f64;
        (self.from + share * (self.to - self.from)).floor() as usize
    }

    fn is_ink(&self, at: usize, side: usize) -> bool {
        let [x, y] = if self.across { [at, side] } else { [side, at] };
        x < self.ink.width() && y < self.ink.height() && self.ink.get(x, y)
    }

    fn is_there(&self, at: usize) -> bool {
        let side = self.side(at);
        (side.saturating_sub(self.swerve)..=side + self.swerve).any(|side| self.is_ink(at, side))
    }

    /// Whether what is drawn there ends within a few pixels on either side.
    fn is_thin(&self, at: usize) -> bool {
        let side = self.side(at);
        !self.is_ink(at, side.saturating_sub(RULE)) && !self.is_ink(at, side + RULE)
    }

    /// The pixels there, as wide as a rule may be.
    fn pixels(&self, at: usize) -> impl Iterator<Item = [usize; 2]> {
        let (side, across) = (self.side(at), self.across);
        let end = if across { self.ink.height() } else { self.ink.width() };
        let places = side.saturating_sub(RULE)..(side + RULE + 1).min(end);
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

/// The middles of the narrow pieces of ink along a row of the sheet, or a column of it.
fn crossed(ink: &Bitmap, at: usize, column: bool, bounds: PixelBox) -> Vec<f64> {
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
                if side - from <= RULE {
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
