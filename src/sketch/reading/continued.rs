//! Grounds that go on beyond lines of the paper: squares, rules, a grain.

use std::collections::BTreeMap;

use super::colours::apart;
use super::ground::STEADY;
use crate::mesh::disjoint_sets::DisjointSets;
use crate::raster::bitmap::Bitmap;
use crate::raster::neighbourhood::opened;
use crate::raster::pieces::{Pieces, Run};

/// The widest line beyond which a ground may go on, with its soft edges, in pixels; how often at least and in which share
/// of the places the colours on both sides of it are equal where it does; and half the width of what is steady in its middle.
const LINE: usize = 9;
const LEAST_PLACES: usize = 8;
const EQUAL: f64 = 0.8;
const CREST: f64 = 1.5;

/// Grounds with the pieces of what is steady that continue them: those beyond a thin line along which the colours are the same
/// on both sides. Grounds that so become one are given once.
pub(super) fn beyond_lines(colours: &[[u8; 3]], steady: &Bitmap, grounds: &[Bitmap]) -> Vec<Bitmap> {
    // The crest of a line is steady, too, and narrow.
    let pieces = Pieces::of(&opened(steady, CREST), false);
    // For every two pieces that face each other the places where they do, and those of equal colours.
    let mut facing: BTreeMap<[usize; 2], [usize; 2]> = BTreeMap::new();
    let mut face = |[a, b]: [usize; 2], [p, q]: [usize; 2]| {
        let [places, equal] = facing.entry([a.min(b), a.max(b)]).or_default();
        *places += 1;
        *equal += usize::from(apart(colours[p], colours[q]) <= STEADY);
    };
    // In each column the row of the last pixel that is steady so far, and its piece.
    let mut above: Vec<Option<(usize, usize)>> = vec![None; steady.width()];
    let mut before: Option<&Run> = None;
    for run in &pieces.runs {
        let at = |x: usize| run.y * steady.width() + x;
        if let Some(before) = before.filter(|before| before.y == run.y && run.from - before.to <= LINE) {
            face([before.piece, run.piece], [at(before.to - 1), at(run.from)]);
        }
        for (x, above) in (run.from..).zip(&mut above[run.from..run.to]) {
            let last = above.replace((run.y, run.piece));
            if let Some((y, piece)) = last.filter(|(y, _)| (2..=LINE + 1).contains(&(run.y - y))) {
                face([piece, run.piece], [y * steady.width() + x, at(x)]);
            }
        }
        before = Some(run);
    }
    let are_one = |&(_, &[places, equal]): &(&[usize; 2], &[usize; 2])| {
        places >= LEAST_PLACES && equal as f64 >= EQUAL * places as f64
    };
    let mut one = DisjointSets::new(pieces.sizes.len());
    facing.iter().filter(are_one).for_each(|(&[a, b], _)| one.join(a as u32, b as u32));
    let mut wholes: Vec<Bitmap> = Vec::new();
    for ground in grounds {
        if wholes.iter().any(|whole| whole.and(ground).area() > 0) {
            continue;
        }
        let mut goes_on = vec![false; pieces.sizes.len()];
        for run in pieces.runs.iter().filter(|run| ground.get(run.from, run.y)) {
            goes_on[one.representative(run.piece as u32) as usize] = true;
        }
        let mut whole = ground.clone();
        for run in &pieces.runs {
            if goes_on[one.representative(run.piece as u32) as usize] {
                whole.fill(run.y, run.from, run.to, true);
            }
        }
        wholes.push(whole);
    }
    wholes
}
