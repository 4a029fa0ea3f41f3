//! A line or a strip that a figure stands on: no part of it.

use std::ops::Range;

use super::closing::{between, closing, stretches};
use crate::raster::PixelBox;
use crate::raster::bitmap::Bitmap;

/// How thick it is at most, in parts of the drawing's size.
const THICKEST: f64 = 0.05;

/// It lies in this part of the drawing's height from below.
const LOWEST: f64 = 0.35;

/// It takes this share of the drawing's width at least, and of its own length so much is seen beside feet.
const WIDE: f64 = 0.6;
const SEEN: f64 = 0.4;

/// What stands on it in one place takes no more than this share of the drawing's width.
const WIDEST_FOOT: f64 = 0.35;

/// How far it rises and falls, in parts of its length.
const LEVEL: f64 = 0.15;

/// How much higher or lower it is a column on, in pixels, and behind a foot, in parts of the drawing's size.
const STEP: f64 = 2.0;
const STEP_OVER_FOOT: f64 = 0.03;

/// What ends so near above it stands on it, in parts of the drawing's size.
const NEAR: f64 = 0.03;

/// How far it reaches beyond what stands on it on either side, and on one, in parts of the drawing's size.
const BEYOND: f64 = 0.025;
const BEYOND_ONE: f64 = 0.05;

/// What touches it is within so many pixels of it.
const TOUCH: usize = 2;

/// The rows that it takes in a column.
struct Column {
    x: usize,
    rows: Range<usize>,
}

/// The line below all else that reaches beyond it on both sides; none where there is none.
pub(super) fn floor(ink: &Bitmap) -> Option<Bitmap> {
    let bounds = PixelBox::of(ink)?;
    let columns: Vec<Column> = (bounds.low[0]..bounds.high[0]).filter_map(|x| lowest(ink, bounds, x)).collect();
    let from_left = followed(columns.iter(), bounds);
    let mut from_right = followed(columns.iter().rev(), bounds);
    from_right.reverse();
    [from_left, from_right].into_iter().find_map(|seen| stood_on(ink, bounds, &seen))
}

/// The last stretch of ink in a column.
fn lowest(ink: &Bitmap, bounds: PixelBox, x: usize) -> Option<Column> {
    let rows = || bounds.low[1]..bounds.high[1];
    let bottom = rows().rev().find(|&y| ink.get(x, y))?;
    let top = rows().take(bottom - bounds.low[1]).rev().find(|&y| !ink.get(x, y)).map_or(bounds.low[1], |y| y + 1);
    Some(Column { x, rows: top..bottom + 1 })
}

/// The thin columns that go on from the first low one, without those under feet.
fn followed<'a>(columns: impl Iterator<Item = &'a Column>, bounds: PixelBox) -> Vec<&'a Column> {
    let size = bounds.side() as f64;
    let low = bounds.high[1] as f64 - LOWEST * bounds.height() as f64;
    let middle = |column: &Column| 0.5 * (column.rows.start + column.rows.end) as f64;
    let is_thin = |column: &&Column| column.rows.len() as f64 <= THICKEST * size && column.rows.start as f64 >= low;
    let mut seen: Vec<&Column> = Vec::new();
    for column in columns.filter(is_thin) {
        if let Some(last) = seen.last() {
            let apart = last.x.abs_diff(column.x);
            if apart as f64 > WIDEST_FOOT * bounds.width() as f64 {
                break;
            }
            let step = if apart == 1 { STEP } else { STEP_OVER_FOOT * size };
            if (middle(last) - middle(column)).abs() > step {
                continue;
            }
        }
        seen.push(column);
    }
    seen
}

/// The line that was seen from left to right, where it is one that the rest stands on.
fn stood_on(ink: &Bitmap, bounds: PixelBox, seen: &[&Column]) -> Option<Bitmap> {
    let size = bounds.side() as f64;
    let (first, last) = (seen.first()?.x, seen.last()?.x);
    let length = (last + 1 - first) as f64;
    let [highest, lowest] = [seen.iter().map(|c| c.rows.start).min()?, seen.iter().map(|c| c.rows.start).max()?];
    let is_level = (lowest - highest) as f64 <= LEVEL * length;
    if !is_level || length < WIDE * bounds.width() as f64 || (seen.len() as f64) < SEEN * length {
        return None;
    }
    let columns = with_hidden(seen);
    let whole = drawn(ink, &columns);
    let rest = ink.without(&whole);
    if rest.area() <= whole.area() {
        return None;
    }
    // A sole ends at the lines of its leg.
    let is_free = |end: &Column| {
        let about = end.x.saturating_sub(TOUCH)..=end.x + TOUCH;
        !about.into_iter().any(|x| is_within(&rest, x, &end.rows, TOUCH))
    };
    let near = |column: &&Column| is_within(&rest, column.x, &column.rows, (NEAR * size) as usize + TOUCH);
    let own = PixelBox::of(&rest)?;
    let from = columns.iter().find(near).map_or(own.low[0], |column| column.x);
    let to = columns.iter().rev().find(near).map_or(own.high[0], |column| column.x + 1);
    let beyond = [from.saturating_sub(first), (last + 1).saturating_sub(to)].map(|beyond| beyond as f64 / size);
    let reaches = beyond.iter().all(|&beyond| beyond >= BEYOND) && beyond.iter().any(|&beyond| beyond >= BEYOND_ONE);
    let ends = is_free(columns.first()?) && is_free(columns.last()?);
    (reaches && ends).then(|| whole.without(&soles(ink, &rest, &columns)))
}

/// The columns that were seen and those under feet, which are as low as on both sides of these.
fn with_hidden(seen: &[&Column]) -> Vec<Column> {
    let mut columns = Vec::new();
    for pair in seen.windows(2) {
        let top = pair[0].rows.start.min(pair[1].rows.start);
        let bottom = pair[0].rows.end.max(pair[1].rows.end);
        columns.push(Column { x: pair[0].x, rows: pair[0].rows.clone() });
        columns.extend((pair[0].x + 1..pair[1].x).map(|x| Column { x, rows: top..bottom }));
    }
    columns.extend(seen.last().map(|last| Column { x: last.x, rows: last.rows.clone() }));
    columns
}

/// What is drawn of the columns.
fn drawn(ink: &Bitmap, columns: &[Column]) -> Bitmap {
    let mut drawn = Bitmap::new(ink.width(), ink.height());
    for Column { x, rows } in columns {
        rows.clone().filter(|&y| ink.get(*x, y)).for_each(|y| drawn.set(*x, y));
    }
    drawn
}

/// Whether there is anything in a column within so many pixels above the line's rows.
fn is_within(rest: &Bitmap, x: usize, rows: &Range<usize>, reach: usize) -> bool {
    x < rest.width() && (rows.start.saturating_sub(reach)..rows.start).any(|y| rest.get(x, y))
}

/// What of the line closes legs that are drawn by their outlines.
fn soles(ink: &Bitmap, rest: &Bitmap, columns: &[Column]) -> Bitmap {
    let thick = columns.iter().map(|column| column.rows.len()).max().unwrap_or(0);
    let is_touched = |&k: &usize| is_within(rest, columns[k].x, &columns[k].rows, TOUCH);
    let mut lines = stretches((0..columns.len()).filter(is_touched));
    lines.retain(|line| line.len() <= 2 * thick);
    let above = |k: usize, depth: usize| [columns[k].x, columns[k].rows.start.saturating_sub(depth)];
    let mut soles = Bitmap::new(rest.width(), rest.height());
    for Column { x, rows } in closing(ink, &between(&lines), above).into_iter().flatten().map(|k| &columns[k]) {
        rows.clone().for_each(|y| soles.set(*x, y));
    }
    soles
}
