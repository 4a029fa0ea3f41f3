//! Which way is up on both shapes.

/// Which way is up on a sketch and on a mesh, in the axes they are laid in, both of length 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Upright {
    pub sketch: [f64; 2],
    pub mesh: [f64; 3],
}
