//! What makes a mesh that can be matched out of the vertices of a file.

/// The sound mesh of a file in terms of its vertices.
#[derive(Clone, Debug, PartialEq)]
pub struct Sound {
    /// Of the sound mesh's own vertices.
    pub triangles: Vec<[u32; 3]>,
    /// Per vertex of the sound mesh the file's vertex that answers for it, ascending.
    pub origins: Vec<u32>,
    /// Per vertex of the file the one that answers for it: the lowest of those that are one vertex of the sound mesh with it,
    /// and where the surface was made coarser the one it left to.
    pub merged: Vec<u32>,
    /// Whether the surface was made coarser.
    pub decimated: bool,
}
