//! Which vertices stand at one place.

use std::collections::HashMap;

use super::super::disjoint_sets::DisjointSets;
use super::super::edges::Edges;
use crate::geometry::{length, subtract};

/// Vertices nearer than about this share of the mesh's diagonal stand at one place: what single precision and text of
/// seven digits leave of equal coordinates.
const NEAR: f64 = 1e-6;
/// And nearer than this share of the short edges of the mesh, so that fine parts of a large scene keep their shape.
const SHORT: f64 = 1e-2;
/// The share of edges that are shorter than what counts as a short edge.
const SHORTER: usize = 10;

/// Per vertex the lowest one at its place: itself but where several of the `loose` vertices nearly meet. O(n log n).
pub(super) fn places(positions: &[[f64; 3]], edges: &Edges, loose: &[u32]) -> Vec<u32> {
    let mut sets = DisjointSets::new(positions.len());
    let distinct = distinct(positions, loose, &mut sets);
    if let Some(cell) = cell(positions, edges) {
        // Points nearer than half a cell share a cell of at least one of these grids.
        for grid in 0..8 {
            let shift = [0, 1, 2].map(|axis| if grid >> axis & 1 == 1 { 0.5 } else { 0.0 });
            let mut firsts: HashMap<[i64; 3], u32> = HashMap::with_capacity(distinct.len());
            for &v in &distinct {
                let p = positions[v as usize];
                let at = [0, 1, 2].map(|axis: usize| (p[axis] / cell + shift[axis]).floor() as i64);
                sets.join(*firsts.entry(at).or_insert(v), v);
            }
        }
    }
    (0..positions.len() as u32).map(|v| sets.representative(v)).collect()
}

/// The first of the vertices at each point, after all at exactly one point are joined.
fn distinct(positions: &[[f64; 3]], loose: &[u32], sets: &mut DisjointSets) -> Vec<u32> {
    let mut firsts: HashMap<[u64; 3], u32> = HashMap::with_capacity(loose.len());
    let mut distinct = Vec::new();
    for &v in loose {
        // Negative zero is zero.
        let first = *firsts.entry(positions[v as usize].map(|x| (x + 0.0).to_bits())).or_insert(v);
        if first == v {
            distinct.push(v);
        }
        sets.join(first, v);
    }
    distinct
}

/// The side of the cells whose points stand at one place; none where the mesh has no extent.
fn cell(positions: &[[f64; 3]], edges: &Edges) -> Option<f64> {
    let ends = || edges.iter().map(|edge| edge.ends().map(|v| positions[v as usize]));
    let (low, high) = ends().flatten().fold(([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]), |(low, high), p| {
        ([0, 1, 2].map(|i: usize| p[i].min(low[i])), [0, 1, 2].map(|i: usize| p[i].max(high[i])))
    });
    let diagonal = length(subtract(high, low));
    let mut lengths: Vec<f64> = ends().map(|[p, q]| length(subtract(q, p))).filter(|&l| l > NEAR * diagonal).collect();
    let rank = lengths.len() / SHORTER;
    let short = if lengths.is_empty() { diagonal } else { *lengths.select_nth_unstable_by(rank, f64::total_cmp).1 };
    let cell = (NEAR * diagonal).min(SHORT * short);
    (cell > 0.0).then_some(cell)
}
