//! Triangles turned over so that neighbours agree.

use super::edges::{self, Edges, HalfEdge};
use super::refusal::{Faults, Place};
use super::{cross, dot, subtract, triangle_area};

/// Marks a half-edge without a partner.
const ALONE: HalfEdge = HalfEdge::MAX;

/// m flags: the triangles to turn over so that neighbours run along their common edge in opposite directions.
///
/// In every component the winding of the larger area stays (of equals, that of the first triangle). A component that was
/// consistent stays as it is; one that was not and is closed is turned outward. A component that cannot be oriented is a
/// fault at the first edge that shows it, and stays. Edges of more than two triangles do not connect.
pub(super) fn inconsistent(
    positions: &[[f64; 3]],
    triangles: &[[u32; 3]],
    edges: &Edges,
    faults: &mut Faults,
) -> Vec<bool> {
    let partners = partners(triangles.len(), edges);
    let mut flipped = vec![false; triangles.len()];
    let mut visited = vec![false; triangles.len()];
    for start in 0..triangles.len() {
        if visited[start] {
            continue;
        }
        match oriented(start, triangles, &partners, &mut visited, &mut flipped) {
            Ok(component) => settle(positions, triangles, &partners, &component, &mut flipped),
            Err(h) => {
                let [a, b] = edges::ends(triangles, h);
                let place = Place { face: Some(edges::triangle_of(h) as u64), ..Place::edge(a, b) };
                faults.push(place, "the surface is one-sided: no winding of its faces agrees at this edge");
            }
        }
    }
    flipped
}

/// Per half-edge the other one on its edge.
fn partners(triangles: usize, edges: &Edges) -> Vec<HalfEdge> {
    let mut partners = vec![ALONE; 3 * triangles];
    for [g, h] in edges.pairs() {
        partners[g as usize] = h;
        partners[h as usize] = g;
    }
    partners
}

/// The component of `start`, flags set so that all agree with `start`; the half-edge of a contradiction if there is one.
fn oriented(
    start: usize,
    triangles: &[[u32; 3]],
    partners: &[HalfEdge],
    visited: &mut [bool],
    flipped: &mut [bool],
) -> Result<Vec<usize>, HalfEdge> {
    let mut component = vec![start];
    let mut contradiction = None;
    visited[start] = true;
    let mut reached = 0;
    while let Some(&t) = component.get(reached) {
        reached += 1;
        for g in (3 * t as HalfEdge..).take(3) {
            let h = partners[g as usize];
            if h == ALONE {
                continue;
            }
            let u = edges::triangle_of(h);
            let parallel = edges::ends(triangles, g) == edges::ends(triangles, h);
            if !visited[u] {
                visited[u] = true;
                flipped[u] = flipped[t] ^ parallel;
                component.push(u);
            } else if flipped[u] != flipped[t] ^ parallel {
                contradiction.get_or_insert(g);
            }
        }
    }
    match contradiction {
        None => Ok(component),
        Some(h) => {
            component.iter().for_each(|&t| flipped[t] = false);
            Err(h)
        }
    }
}

/// Chooses between the two windings of an orientable component.
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
