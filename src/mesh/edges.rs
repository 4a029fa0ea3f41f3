//! The edges of a list of triangles.

/// Side `h % 3` of triangle `h / 3`, which runs from its corner `h % 3` to the next one.
pub(crate) type HalfEdge = u32;

/// The edges of a list of triangles, each with the half-edges on it, in ascending order of (smaller vertex, larger
/// vertex) and of half-edges within an edge.
pub(crate) struct Edges {
    half_edges: Vec<(u64, HalfEdge)>,
}

impl Edges {
    /// O(n log n). The triangles may be any: nothing is assumed but that 3 n fits 32 bits.
    pub fn of(triangles: &[[u32; 3]]) -> Edges {
        let mut half_edges = Vec::with_capacity(3 * triangles.len());
        for (t, triangle) in triangles.iter().enumerate() {
            for side in 0..3 {
                let (a, b) = (triangle[side], triangle[(side + 1) % 3]);
                half_edges.push((u64::from(a.min(b)) << 32 | u64::from(a.max(b)), (3 * t + side) as HalfEdge));
            }
        }
        half_edges.sort_unstable();
        Edges { half_edges }
    }

    /// Every edge with the half-edges on it.
    pub fn iter(&self) -> impl Iterator<Item = Edge<'_>> {
        self.half_edges.chunk_by(|a, b| a.0 == b.0).map(|half_edges| Edge { half_edges })
    }

    /// The pairs of half-edges on the edges that have exactly two.
    pub fn pairs(&self) -> impl Iterator<Item = [HalfEdge; 2]> {
        self.iter().filter_map(|edge| match edge.half_edges {
            [(_, g), (_, h)] => Some([*g, *h]),
            _ => None,
        })
    }

    /// The half-edges that are alone on their edge.
    pub fn boundary(&self) -> impl Iterator<Item = HalfEdge> {
        self.iter().filter_map(|edge| match edge.half_edges {
            [(_, h)] => Some(*h),
            _ => None,
        })
    }
}

/// One edge and the half-edges on it.
#[derive(Clone, Copy)]
pub(crate) struct Edge<'a> {
    half_edges: &'a [(u64, HalfEdge)],
}

impl Edge<'_> {
    /// The smaller and the larger vertex.
    pub fn ends(&self) -> [u32; 2] {
        let key = self.half_edges[0].0;
        [(key >> 32) as u32, key as u32]
    }

    pub fn half_edges(&self) -> impl ExactSizeIterator<Item = HalfEdge> {
        self.half_edges.iter().map(|&(_, h)| h)
    }
}

pub(crate) fn triangle_of(h: HalfEdge) -> usize {
    (h / 3) as usize
}

/// The vertex a half-edge comes from and the one it goes to.
pub(super) fn ends(triangles: &[[u32; 3]], h: HalfEdge) -> [u32; 2] {
    let (t, side) = (triangle_of(h), (h % 3) as usize);
    [triangles[t][side], triangles[t][(side + 1) % 3]]
}

/// The next half-edge of the same triangle. It starts at the corner where this one ends.
pub(super) fn next(h: HalfEdge) -> HalfEdge {
    if h % 3 == 2 { h - 2 } else { h + 1 }
}
