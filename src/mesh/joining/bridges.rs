//! Gaps between the parts of a body, bridged where they are narrowest.

use std::collections::{HashMap, VecDeque};

use super::super::disjoint_sets::DisjointSets;
use super::grid::Grid;
use crate::numerics::{Cancelled, Pace, Watch};

/// A gap is bridged where it is at most so many times as wide as at its narrowest, and by so many cells: the rims of an arm
/// and its sleeve face each other so, the arm and the hip do not.
const WIDER: f64 = 1.5;
const CELLS_WIDER: f64 = 2.0;

/// Marks a cell that no part is in.
pub(super) const EMPTY: u32 = u32::MAX;

/// A straight way between two parts, from a cell of the one to a cell of the other.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Way {
    squared: usize,
    parts: [u32; 2],
    ends: [usize; 2],
}

/// The cells of bridges between parts, `parts` being the part in each cell or [`EMPTY`], of so many. There are bridges between
/// any two of them whose gap is no wider than the widest that has to be crossed for all to hang together.
///
/// # Errors
/// [`Cancelled`] by the watcher.
pub(super) fn bridges(grid: &Grid, parts: &[u32], count: usize, watch: &dyn Watch) -> Result<Vec<usize>, Cancelled> {
    let ways = ways(grid, parts, watch)?;
    let mut sets = DisjointSets::new(count);
    let mut narrowest: HashMap<[u32; 2], usize> = HashMap::new();
    let mut widest = 0;
    for way in &ways {
        narrowest.entry(way.parts).or_insert(way.squared);
        let [a, b] = way.parts;
        if sets.representative(a) != sets.representative(b) {
            sets.join(a, b);
            widest = way.squared;
        }
    }
    let mut cells = Vec::new();
    for way in &ways {
        let least = narrowest.get(&way.parts).copied().unwrap_or(way.squared);
        let most = WIDER * (least as f64).sqrt() + CELLS_WIDER;
        if least <= widest && way.squared as f64 <= most * most {
            grid.between(way.ends, |cell| cells.push(cell));
        }
    }
    Ok(cells)
}

/// The ways between parts that meet half way, the shortest first.
fn ways(grid: &Grid, parts: &[u32], watch: &dyn Watch) -> Result<Vec<Way>, Cancelled> {
    let mut pace = Pace::new(watch, parts.len());
    // Per cell the cell of a part that it was reached from in the fewest steps.
    let mut nearest: Vec<usize> = (0..parts.len()).collect();
    let mut reached: Vec<bool> = parts.iter().map(|&part| part != EMPTY).collect();
    let mut pending: VecDeque<usize> = (0..parts.len()).filter(|&cell| reached[cell]).collect();
    let mut ways = Vec::new();
    while let Some(cell) = pending.pop_front() {
        pace.step()?;
        for next in grid.beside(cell) {
            if !std::mem::replace(&mut reached[next], true) {
                nearest[next] = nearest[cell];
                pending.push_back(next);
            }
            let mut ends = [nearest[cell], nearest[next]];
            let of = |end: usize| parts[end];
            if of(ends[0]) != of(ends[1]) {
                ends.sort_unstable_by_key(|&end| (of(end), end));
                ways.push(Way { squared: grid.squared_distance(ends), parts: ends.map(of), ends });
            }
        }
    }
    ways.sort_unstable();
    ways.dedup();
    Ok(ways)
}
