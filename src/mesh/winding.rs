//! Triangles turned over so that neighbours agree.

use super::edges::{self, HalfEdge, triangle_of};
use super::mending::gluing::ALONE;
use crate::geometry::{cross, dot, subtract, triangle_area};

/// How the triangles of a surface are turned to one side.
pub(super) struct Winding {
    /// Per triangle whether to turn it over.
    pub flipped: Vec<bool>,
    /// The half-edges that were parted because no winding of a one-sided surface agrees there, one of each edge.
    pub parted: Vec<HalfEdge>,
}

/// The winding in which neighbours run along their common edge in opposite directions; `places` tells which way a half-edge
/// runs. Edges at which a one-sided surface, such as a Möbius strip, contradicts itself are parted in `partners`.
///
/// In every component the winding of the larger area stays (of equals, that of the first triangle). A component that was
/// consistent stays as it is; one that was not and is closed is turned outward.
pub(super) fn wound(
    positions: &[[f64; 3]],
    triangles: &[[u32; 3]],
    places: &[u32],
    partners: &mut [HalfEdge],
) -> Winding {
    let start = |h: HalfEdge| places[edges::ends(triangles, h)[0] as usize];
    let mut winding = Winding { flipped: vec![false; triangles.len()], parted: Vec::new() };
    let mut visited = vec![false; triangles.len()];
    for first in 0..triangles.len() {
        if !visited[first] {
            let component = oriented(first, start, partners, &mut visited, &mut winding);
            settle(positions, triangles, partners, &component, &mut winding.flipped);
        }
    }
    winding
}

/// The component of `first`, flags set so that all agree with `first` but across the edges that are parted for it.
fn oriented(
    first: usize,
    start: impl Fn(HalfEdge) -> u32,
    partners: &mut [HalfEdge],
    visited: &mut [bool],
    Winding { flipped, parted }: &mut Winding,
) -> Vec<usize> {
    let mut component = vec![first];
    visited[first] = true;
    let mut reached = 0;
    while let Some(&t) = component.get(reached) {
        reached += 1;
        for g in (3 * t as HalfEdge..).take(3) {
            let h = partners[g as usize];
            if h == ALONE {
                continue;
            }
            let u = triangle_of(h);
            let parallel = start(g) == start(h);
            if !visited[u] {
                visited[u] = true;
                flipped[u] = flipped[t] ^ parallel;
                component.push(u);
            } else if flipped[u] != flipped[t] ^ parallel {
                parted.push(g);
                [partners[g as usize], partners[h as usize]] = [ALONE; 2];
            }
        }
    }
    component
}

/// Chooses between the two windings of a component.
fn settle(
    positions: &[[f64; 3]],
    triangles: &[[u32; 3]],
    partners: &[HalfEdge],
    component: &[usize],
    flipped: &mut [bool],
) {
    if component.iter().all(|&t| !flipped[t]) {
        return;
    }
    let closed = component.iter().all(|&t| partners[3 * t..3 * t + 3].iter().all(|&h| h != ALONE));
    let balance: f64 = if closed {
        let origin = positions[triangles[component[0]][0] as usize];
        component.iter().map(|&t| signed(flipped[t], volume(origin, corners(positions, triangles[t])))).sum()
    } else {
        component.iter().map(|&t| signed(flipped[t], triangle_area(corners(positions, triangles[t])))).sum()
    };
    if balance < 0.0 {
        component.iter().for_each(|&t| flipped[t] = !flipped[t]);
    }
}

fn corners(positions: &[[f64; 3]], triangle: [u32; 3]) -> [[f64; 3]; 3] {
    triangle.map(|v| positions[v as usize])
}

fn signed(negative: bool, value: f64) -> f64 {
    if negative { -value } else { value }
}

/// Six times the signed volume between a triangle and the origin.
fn volume(origin: [f64; 3], triangle: [[f64; 3]; 3]) -> f64 {
    let [a, b, c] = triangle.map(|p| subtract(p, origin));
    dot(a, cross(b, c))
}
