//! Components that stand exactly where others do: the second side of double-sided surfaces, things exported twice.

use std::collections::HashMap;

use super::super::disjoint_sets::DisjointSets;
use super::super::soundness;
use super::Rest;

/// Leaves out the components of whose triangles every one is where one of an earlier component is, and adds their triangles
/// to `doubled`. Per vertex left out the one in its place.
pub(super) fn twins(positions: &[[f64; 3]], rest: &mut Rest, doubled: &mut Vec<usize>) -> Vec<(u32, u32)> {
    let mut sets = DisjointSets::new(positions.len());
    for &[a, b, c] in &rest.triangles {
        sets.join(a, b);
        sets.join(a, c);
    }
    let components: Vec<u32> = rest.triangles.iter().map(|t| sets.representative(t[0])).collect();
    if components.iter().all(|&c| c == components[0]) {
        return Vec::new();
    }
    // Negative zero is zero.
    let key = |v: u32| positions[v as usize].map(|x| (x + 0.0).to_bits());
    let mut firsts: HashMap<[u64; 3], u32> = HashMap::new();
    let placed: Vec<[u32; 3]> = rest.triangles.iter().map(|t| t.map(|v| *firsts.entry(key(v)).or_insert(v))).collect();
    let first = soundness::firsts(&placed);
    let mut is_whole: HashMap<u32, bool> = HashMap::new();
    for (t, &component) in components.iter().enumerate() {
        *is_whole.entry(component).or_insert(true) &= components[first[t]] != component;
    }
    let goes: Vec<bool> = components.iter().map(|component| is_whole[component]).collect();
    let gone = rest.triangles.iter().zip(&placed).zip(&goes).filter(|(_, goes)| **goes);
    let mut twins: Vec<(u32, u32)> =
        gone.flat_map(|((triangle, placed), _)| triangle.iter().copied().zip(placed.iter().copied())).collect();
    twins.sort_unstable();
    twins.dedup();
    doubled.extend(rest.without(|_, t| goes[t]));
    twins
}
