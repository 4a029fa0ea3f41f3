//! What the vertices of a file take from those of the sound mesh that answer for them.

use super::seen::Seen;
use crate::deformation::transfer::Carried;
use crate::mesh::file_mesh::FileMesh;
use crate::mesh::followers::{Follower, followers};

/// A vertex of a file beside the sound mesh.
pub(super) struct Beside<'a> {
    seen: &'a Seen,
    follower: Follower,
    /// Where it lies in the plane of the drawing.
    pub place: [f64; 2],
}

impl Beside<'_> {
    /// A function there: blended of what it is beside each corner, so that one that is linear in the plane of the drawing is exact,
    /// and the surface of the file turns with the coarser one.
    pub fn value(&self, carried: &Carried, function: usize) -> f64 {
        let of_corner = |v: usize| {
            let [x, y] = self.seen.places[v];
            [carried.beside(v, [self.place[0] - x, self.place[1] - y], function)]
        };
        let [value] = self.follower.blended(of_corner);
        value
    }
}

/// Per vertex of the file how it lies beside the sound mesh; nothing where it is of no triangle.
pub(super) fn beside<'a>(mesh: &FileMesh, seen: &'a Seen) -> Vec<Option<Beside<'a>>> {
    let answering = (0..mesh.positions().len() as u32).map(|v| mesh.sound_vertices(v).next().map(|own| own as usize));
    let followers = followers(mesh.sound(), mesh.positions(), answering);
    let beside = |(follower, &p): (Option<Follower>, &[f64; 3])| {
        Some(Beside { seen, follower: follower?, place: seen.place(p) })
    };
    followers.zip(mesh.positions()).map(beside).collect()
}
