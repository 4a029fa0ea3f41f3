//! Which sides of triangles are one edge of a surface.

use super::super::disjoint_sets::DisjointSets;
use super::super::edges::{self, Edges, HalfEdge, triangle_of};
use crate::geometry::triangle_area;

/// Marks a half-edge without a partner.
pub(in super::super) const ALONE: HalfEdge = HalfEdge::MAX;

/// The half-edges of triangles in pairs, each pair an edge of the surface.
pub(super) struct Gluing {
    /// Per half-edge the other one on its edge, or [`ALONE`].
    pub partners: Vec<HalfEdge>,
    /// The edges where more than two triangles met, by their ends.
    pub crowded: Vec<[u32; 2]>,
}

/// The surface of most area that triangles with these vertices make; `places` are the vertices that others stand at.
///
/// Where exactly two triangles name an edge, they share it. All other sides look for a partner among those at the same
/// two places: what several vertices at a seam keep apart is closed, and where more than two meet, those that hang
/// together elsewhere go on together, then those of most area. What is left over ends there. O(n log n).
pub(super) fn glued(positions: &[[f64; 3]], triangles: &[[u32; 3]], places: &[u32]) -> Gluing {
    let mut gluing = Gluing { partners: vec![ALONE; 3 * triangles.len()], crowded: Vec::new() };
    let named = Edges::of(triangles);
    let mut loose = Vec::new();
    for edge in named.iter() {
        let half_edges: Vec<HalfEdge> = edge.half_edges().collect();
        match half_edges[..] {
            [g, h] => gluing.join(g, h),
            _ => loose.extend(half_edges.into_iter().map(|h| (edge.ends().map(|v| places[v as usize]), h))),
        }
    }
    loose.iter_mut().for_each(|(ends, _)| ends.sort_unstable());
    loose.sort_unstable();
    let mut crowds = Vec::new();
    for at_edge in loose.chunk_by(|a, b| a.0 == b.0) {
        match at_edge {
            [_] => {}
            [(_, g), (_, h)] => gluing.join(*g, *h),
            crowd => {
                gluing.crowded.push(crowd[0].0);
                crowds.push(crowd);
            }
        }
    }
    if !crowds.is_empty() {
        let sheets = Sheets::of(positions, triangles, &gluing.partners);
        for crowd in crowds {
            let crowd = crowd.iter().map(|&(_, h)| h).collect();
            sheets.pairs(crowd, |h| places[edges::ends(triangles, h)[0] as usize], |g, h| gluing.join(g, h));
        }
    }
    gluing
}

impl Gluing {
    fn join(&mut self, g: HalfEdge, h: HalfEdge) {
        self.partners[g as usize] = h;
        self.partners[h as usize] = g;
    }
}

/// The parts of a surface that hang together away from its crowded edges.
struct Sheets {
    of_triangle: Vec<u32>,
    /// By the number of a sheet.
    areas: Vec<f64>,
}

impl Sheets {
    fn of(positions: &[[f64; 3]], triangles: &[[u32; 3]], partners: &[HalfEdge]) -> Sheets {
        let mut sets = DisjointSets::new(triangles.len());
        for (g, &h) in partners.iter().enumerate().filter(|&(_, &h)| h != ALONE) {
            sets.join(triangle_of(g as HalfEdge) as u32, triangle_of(h) as u32);
        }
        let of_triangle: Vec<u32> = (0..triangles.len() as u32).map(|t| sets.representative(t)).collect();
        let mut areas = vec![0.0; triangles.len()];
        for (triangle, &sheet) in triangles.iter().zip(&of_triangle) {
            areas[sheet as usize] += triangle_area(triangle.map(|v| positions[v as usize]));
        }
        Sheets { of_triangle, areas }
    }

    /// Pairs the half-edges of a crowded edge: those of one sheet that run against each other, then any of one sheet,
    /// then the two largest sheets that are left.
    fn pairs(
        &self,
        mut crowd: Vec<HalfEdge>,
        start: impl Fn(HalfEdge) -> u32,
        mut join: impl FnMut(HalfEdge, HalfEdge),
    ) {
        let sheet = |h: &HalfEdge| self.of_triangle[triangle_of(*h)];
        let area = |h: &HalfEdge| self.areas[sheet(h) as usize];
        crowd.sort_by(|g, h| area(h).total_cmp(&area(g)).then(sheet(g).cmp(&sheet(h))).then(g.cmp(h)));
        let mut left = Vec::new();
        for same in crowd.chunk_by(|g, h| sheet(g) == sheet(h)) {
            let (forth, back): (Vec<HalfEdge>, Vec<HalfEdge>) = same.iter().partition(|h| start(**h) == start(same[0]));
            let paired = forth.len().min(back.len());
            (0..paired).for_each(|i| join(forth[i], back[i]));
            let rest = [&forth[paired..], &back[paired..]].concat();
            let (pairs, single) = rest.as_chunks::<2>();
            pairs.iter().for_each(|&[g, h]| join(g, h));
            left.extend(single);
        }
        if let [g, h, ..] = left[..] {
            join(g, h);
        }
    }
}
