//! The vertices of a surface of which only the edges are known.

use super::super::disjoint_sets::DisjointSets;
use super::super::edges::{self, HalfEdge, next};
use super::gluing::ALONE;

/// The vertices of a surface: every fan of triangles about a point is one.
pub(super) struct Fans {
    /// Triangles of these vertices, in the order and winding they were given in.
    pub triangles: Vec<[u32; 3]>,
    /// Per vertex the lowest of the file's vertices that its triangles name here; ascending.
    pub origins: Vec<u32>,
}

/// The fans of triangles whose half-edges have these partners; `places` tells which way a half-edge runs.
pub(super) fn fans(triangles: &[[u32; 3]], partners: &[HalfEdge], places: &[u32]) -> Fans {
    // A corner is named by the half-edge that starts at it.
    let mut corners = DisjointSets::new(3 * triangles.len());
    let start = |h: HalfEdge| places[edges::ends(triangles, h)[0] as usize];
    for (g, &h) in (0..).zip(partners).filter(|&(g, &h)| h != ALONE && g < h) {
        let [from, to] = if start(g) == start(h) { [h, next(h)] } else { [next(h), h] };
        corners.join(g, from);
        corners.join(next(g), to);
    }
    let named = triangles.as_flattened();
    let mut lowest: Vec<u32> = vec![u32::MAX; named.len()];
    for corner in 0..named.len() as u32 {
        let lowest = &mut lowest[corners.representative(corner) as usize];
        *lowest = named[corner as usize].min(*lowest);
    }
    let mut fans: Vec<(u32, u32)> = (0..).zip(&lowest).filter(|&(_, &v)| v != u32::MAX).map(|(c, &v)| (v, c)).collect();
    fans.sort_unstable();
    let mut of_corner = vec![0; named.len()];
    (0..).zip(&fans).for_each(|(fan, &(_, corner))| of_corner[corner as usize] = fan);
    let mut corner = 0;
    let triangles = triangles.iter().map(|_| {
        [(); 3].map(|()| {
            corner += 1;
            of_corner[corners.representative(corner - 1) as usize]
        })
    });
    Fans { triangles: triangles.collect(), origins: fans.iter().map(|&(v, _)| v).collect() }
}
