//! The paper's own lines: straight thin ones from border to border, which are rules, a margin, a horizon.

use super::Sheet;
use crate::raster::PixelBox;
use crate::raster::bitmap::Bitmap;

/// The widest line that is the paper's own, in pixels; how far from the border its ends are looked for; the share of its
/// length that is there, and that along which nothing else is; and how many ends are looked at along a side.
const RULE: usize = 5;
const RULE_END: usize = 4;
const WHOLE_RULE: f64 = 0.97;
const THIN_RULE: f64 = 0.6;
const MOST_RULES: usize = 64;

/// Where the sheet is so high, or wide, in parts of what it is at most, the ends of rules are looked for: it may lie askew.
const WHOLE_SIDE: f64 = 0.8;

/// How far from the sides of the sheet rules begin, in parts of its size.
const OFF_FRAME: f64 = 0.03;

/// The ink without the paper's own lines.
pub(super) fn without_rules(ink: &Bitmap, sheet: &Sheet) -> Bitmap {
    let Some(bounds) = PixelBox::of(&sheet.area) else { return ink.clone() };
    let mut kept = ink.clone();
    for across in [true, false] {
        let axis = usize::from(!across);
        let [low, high] = whole_sides(&sheet.area, across, bounds);
        let (first, last) = (low + RULE_END, high.saturating_sub(RULE_END + 1));
        if first >= last {
            continue;
        }
        let length = last + 1 - first;
        let ends = [first, last].map(|at| crossed(ink, at, across, bounds));
        for (from, to) in ends[0].iter().flat_map(|&from| ends[1].iter().map(move |&to| (from, to))) {
            let line = Line { ink, across, first, last, from, to };
            let mut missing = (first..=last).filter(|&at| !line.is_there(at));
            if missing.nth(((1.0 - WHOLE_RULE) * length as f64) as usize).is_some() {
                continue;
            }
            // A margin is thin where rules cross it, once those are gone.
            let thin: Vec<usize> =
                (bounds.low[axis]..bounds.high[axis]).filter(|&at| line.is_thin(&kept, at)).collect();
            if thin.len() as f64 >= THIN_RULE * length as f64 {
                thin.into_iter().for_each(|at| line.clear(&mut kept, at));
            }
        }
    }
    kept
}

/// The first and the last column of a sheet that is nearly as high as it is at all, or row that is nearly as wide.
fn whole_sides(area: &Bitmap, across: bool, bounds: PixelBox) -> [usize; 2] {
    let axis = usize::from(!across);
    let mut counts = vec![0; bounds.high[axis]];
    for y in 0..area.height() {
        match across {
            true => area.runs(y).flatten().for_each(|x| counts[x] += 1),
            false if y < counts.len() => counts[y] = area.runs(y).map(|run| run.len()).sum(),
            false => {}
        }
    }
    let least = WHOLE_SIDE * counts.iter().copied().max().unwrap_or(0) as f64;
    let is_whole = |&count: &usize| count as f64 >= least;
    let first = counts.iter().position(is_whole).unwrap_or(0);
    [first, counts.iter().rposition(is_whole).map_or(0, |last| last + 1)]
}

/// A straight line that may be a rule, from one side of the sheet to the other.
struct Line<'a> {
    ink: &'a Bitmap,
    /// Whether it runs from left to right; from top to bottom otherwise.
    across: bool,
    /// Where along the way its ends were looked for, and how far across the way they are.
    first: usize,
    last: usize,
    from: f64,
    to: f64,
}

impl Line<'_> {
    /// How far across the way it is there.
    fn side(&self, at: usize) -> usize {
        let share = (at as f64 - self.first as f64) / (self.last - self.first) as f64;
        (self.from + share * (self.to - self.from)).floor() as usize
    }

    fn is_set(&self, picture: &Bitmap, at: usize, side: usize) -> bool {
        let [x, y] = if self.across { [at, side] } else { [side, at] };
        x < picture.width() && y < picture.height() && picture.get(x, y)
    }

    fn is_there(&self, at: usize) -> bool {
        let side = self.side(at);
        (side.saturating_sub(1)..=side + 1).any(|side| self.is_set(self.ink, at, side))
    }

    /// Whether what is left there ends within a few pixels on either side.
    fn is_thin(&self, left: &Bitmap, at: usize) -> bool {
        let side = self.side(at);
        !self.is_set(left, at, side.saturating_sub(RULE)) && !self.is_set(left, at, side + RULE)
    }

    /// Clears what is drawn there, as wide as a rule may be.
    fn clear(&self, kept: &mut Bitmap, at: usize) {
        let side = self.side(at);
        let (from, to) = (side.saturating_sub(RULE), side + RULE + 1);
        if self.across {
            (from..to.min(kept.height())).for_each(|y| kept.fill(y, at, at + 1, false));
        } else {
            kept.fill(at, from.min(kept.width()), to.min(kept.width()), false);
        }
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
