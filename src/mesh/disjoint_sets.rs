//! Disjoint sets: which elements have been joined.

/// A partition of 0 .. n that only gets coarser. The representative of a set is its smallest element.
pub(crate) struct DisjointSets {
    parents: Vec<u32>,
}

impl DisjointSets {
    /// n sets of one element each.
    pub fn new(n: usize) -> DisjointSets {
        DisjointSets { parents: (0..n as u32).collect() }
    }

    /// The smallest element of the set of `a`; halves the path on the way.
    pub fn representative(&mut self, mut a: u32) -> u32 {
        while self.parents[a as usize] != a {
            let grandparent = self.parents[self.parents[a as usize] as usize];
            self.parents[a as usize] = grandparent;
            a = grandparent;
        }
        a
    }

    pub fn join(&mut self, a: u32, b: u32) {
        let (a, b) = (self.representative(a), self.representative(b));
        self.parents[a.max(b) as usize] = a.min(b);
    }
}
