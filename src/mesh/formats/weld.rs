//! Points that stand at one place.

use std::collections::HashMap;

/// Which vertex first stood at a point, by the exact coordinates.
#[derive(Default)]
pub(super) struct Weld {
    firsts: HashMap<[u64; 3], u32>,
}

impl Weld {
    /// The vertex that first stood at `position`: `vertex` itself where there was none.
    pub fn first(&mut self, position: [f64; 3], vertex: u32) -> u32 {
        *self.firsts.entry(position.map(f64::to_bits)).or_insert(vertex)
    }
}
