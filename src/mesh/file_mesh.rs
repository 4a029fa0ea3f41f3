//! A mesh as its file has it, and what is matched in its place.

use std::ops::Range;

use super::decimation::{Decimated, decimated};
use super::mending::{Mends, mended};
use super::sound::Sound;
use super::{TriangleMesh, content_hash};

/// The vertices and triangles of a user's file, untouched, and the sound mesh made of them.
///
/// Vertices of the file are what users speak of: in answers, landmarks and labels. Where several are one vertex of the
/// sound mesh, the lowest answers for it and any of them names it; where the surface was made coarser, the vertices that are
/// left answer for those that left to them.
#[derive(Clone, Debug, PartialEq)]
pub struct FileMesh {
    positions: Vec<[f64; 3]>,
    triangles: Vec<[u32; 3]>,
    sound: TriangleMesh,
    origins: Vec<u32>,
    merged: Vec<u32>,
    decimated: bool,
}

impl FileMesh {
    /// The mesh of a file whose triangles name existing vertices with sound coordinates, and what was mended for it;
    /// nothing where no triangle can be matched.
    pub(super) fn of(positions: Vec<[f64; 3]>, triangles: Vec<[u32; 3]>) -> (Option<FileMesh>, Mends) {
        let (mended, mends) = mended(&positions, &triangles);
        let mesh = mended.and_then(|Sound { triangles: sound, origins, merged, decimated }| {
            let corners = origins.iter().map(|&v| positions[v as usize]).collect();
            let sound = TriangleMesh::new(corners, sound).ok()?;
            Some(FileMesh { positions, triangles, sound, origins, merged, decimated })
        });
        (mesh, mends)
    }

    /// The same with a sound mesh of at most so many triangles; nothing where it cannot be had.
    pub(super) fn decimated(self, most: usize) -> Option<FileMesh> {
        let Decimated { triangles, left_to } = decimated(&self.sound, most)?;
        let left = |v: &u32| left_to[*v as usize] == *v;
        let answers = |v: u32| {
            let of_file = self.sound_vertices(v);
            let stays = of_file.clone().any(|own| left(&own));
            if stays { None } else { of_file.clone().next() }
        };
        let merged = (0..)
            .zip(&self.merged)
            .map(|(v, &lowest)| answers(v).map_or(lowest, |own| self.origins[left_to[own as usize] as usize]));
        let merged = merged.collect();
        let kept: Vec<u32> = (0..left_to.len() as u32).filter(left).collect();
        let mut numbers = vec![0; left_to.len()];
        (0..).zip(&kept).for_each(|(number, &v)| numbers[v as usize] = number);
        let positions = kept.iter().map(|&v| self.sound.positions[v as usize]).collect();
        let triangles = triangles.iter().map(|t| t.map(|v| numbers[v as usize])).collect();
        let sound = TriangleMesh::new(positions, triangles).ok()?;
        let origins = kept.iter().map(|&v| self.origins[v as usize]).collect();
        Some(FileMesh { sound, origins, merged, decimated: true, ..self })
    }

    /// The mesh that had these vertices, triangles and [`mends`](Self::mends) if `known` says that its
    /// [`content_hash`](Self::content_hash) is that of a mesh that was made before: nothing is checked again.
    pub fn recognised(
        positions: Vec<[f64; 3]>,
        triangles: Vec<[u32; 3]>,
        mends: Option<Sound>,
        known: impl FnOnce(blake3::Hash) -> bool,
    ) -> Option<FileMesh> {
        let exists = |&v: &u32| (v as usize) < positions.len();
        let Sound { triangles: sound, origins, merged, decimated } = mends.unwrap_or_else(|| {
            let each: Vec<u32> = (0..positions.len() as u32).collect();
            Sound { triangles: triangles.clone(), origins: each.clone(), merged: each, decimated: false }
        });
        if !origins.iter().all(exists) {
            return None;
        }
        let corners = origins.iter().map(|&v| positions[v as usize]).collect();
        let sound = TriangleMesh { positions: corners, triangles: sound };
        let mesh = FileMesh { positions, triangles, sound, origins, merged, decimated };
        known(mesh.content_hash()).then_some(mesh)
    }

    /// What makes the sound mesh out of the file's vertices; nothing where it is what the file has.
    pub fn mends(&self) -> Option<Sound> {
        let untouched = self.origins.len() == self.positions.len()
            && (0..).zip(&self.origins).all(|(v, &origin)| v == origin)
            && self.sound.triangles == self.triangles;
        (!untouched).then(|| Sound {
            triangles: self.sound.triangles.clone(),
            origins: self.origins.clone(),
            merged: self.merged.clone(),
            decimated: self.decimated,
        })
    }

    /// n × 3, in units of the file; not a number where the file has none, which happens at vertices of no triangle only.
    pub fn positions(&self) -> &[[f64; 3]] {
        &self.positions
    }

    /// m × 3, the faces of the file cut into triangles, in its order and winding.
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    /// The mesh that is matched. Its vertices stand where those of the file do that they are made of.
    pub fn sound(&self) -> &TriangleMesh {
        &self.sound
    }

    /// Per vertex of the sound mesh the file's vertex that answers for it, ascending.
    pub fn origins(&self) -> &[u32] {
        &self.origins
    }

    /// Per vertex of the file the one that answers for it: the lowest of those that are one vertex of the sound mesh with it, and
    /// where the surface [was made coarser](Self::is_decimated) the one it left to; itself where it stands alone or belongs to no
    /// triangle.
    pub fn merged(&self) -> &[u32] {
        &self.merged
    }

    /// Whether the sound mesh is coarser than the surface of the file, which had more triangles than are matched.
    pub fn is_decimated(&self) -> bool {
        self.decimated
    }

    /// The vertices of the sound mesh that a vertex of the file names: none where it belongs to no triangle, several where
    /// parts of the surface met in a point.
    pub fn sound_vertices(&self, vertex: u32) -> Range<u32> {
        let Some(&answering) = self.merged.get(vertex as usize) else { return 0..0 };
        let end = |first: bool| self.origins.partition_point(|&v| v < answering || !first && v == answering) as u32;
        end(true)..end(false)
    }

    /// Hash of what the file has, as [`content_hash`] has it, and of the mends where there are any.
    pub fn content_hash(&self) -> blake3::Hash {
        let of_file = content_hash(&self.positions, &self.triangles);
        let Some(Sound { triangles, origins, merged, decimated }) = self.mends() else { return of_file };
        let mut hasher = blake3::Hasher::new();
        hasher.update(of_file.as_bytes());
        for numbers in [triangles.as_flattened(), &origins, &merged] {
            hasher.update(&(numbers.len() as u64).to_le_bytes());
            numbers.iter().for_each(|number| {
                hasher.update(&number.to_le_bytes());
            });
        }
        // What was stored before surfaces were made coarser keeps its name.
        if decimated {
            hasher.update(&[1]);
        }
        hasher.finalize()
    }
}

impl From<TriangleMesh> for FileMesh {
    /// The file of a mesh that needs no mending.
    fn from(sound: TriangleMesh) -> FileMesh {
        let (positions, triangles) = (sound.positions().to_vec(), sound.triangles().to_vec());
        let each: Vec<u32> = (0..positions.len() as u32).collect();
        FileMesh { positions, triangles, sound, origins: each.clone(), merged: each, decimated: false }
    }
}

#[cfg(test)]
mod tests {
    use std::collections::HashSet;

    use super::*;
    use crate::geometry::{length, subtract};
    use crate::mesh::solids::sphere;

    /// A square of two triangles whose diagonal is a seam, and a vertex of no triangle.
    fn seam() -> FileMesh {
        let corners = [[0., 0.], [1., 0.], [1., 1.], [0., 0.], [1., 1.], [0., 1.], [7., 7.]];
        let positions = corners.map(|[x, y]| [x, y, 0.0]).to_vec();
        FileMesh::of(positions, vec![[0, 1, 2], [3, 4, 5]]).0.unwrap()
    }

    #[test]
    fn every_vertex_of_the_file_names_one_of_the_sound_mesh() {
        let mesh = seam();
        assert_eq!(mesh.sound().triangles(), [[0, 1, 2], [0, 2, 3]]);
        assert_eq!(mesh.origins(), [0, 1, 2, 5]);
        assert_eq!(mesh.merged(), [0, 1, 2, 0, 2, 5, 6]);
        let named: Vec<Option<u32>> = (0..8).map(|v| mesh.sound_vertices(v).next()).collect();
        assert_eq!(named, [Some(0), Some(1), Some(2), Some(0), Some(2), Some(3), None, None]);
    }

    /// A sphere whose half is on vertices of its own, those of the other half first, made coarser.
    fn coarser() -> FileMesh {
        let ball = sphere(30, 60);
        let n = ball.positions().len() as u32;
        let doubled = [ball.positions(), ball.positions()].concat();
        let own = |t: &[u32; 3]| if t.iter().any(|&v| v > n / 2) { t.map(|v| v + n) } else { *t };
        let triangles: Vec<[u32; 3]> = ball.triangles().iter().map(own).collect();
        FileMesh::of(doubled, triangles).0.unwrap().decimated(500).unwrap()
    }

    #[test]
    fn vertices_that_are_left_answer_for_those_near_them() {
        let mesh = coarser();
        let (most, sound) = (500, mesh.sound());
        assert!(mesh.is_decimated() && sound.triangles().len() <= most && mesh.origins().is_sorted());
        for (&origin, p) in mesh.origins().iter().zip(sound.positions()) {
            assert_eq!((mesh.positions()[origin as usize], mesh.merged()[origin as usize]), (*p, origin));
        }
        let used: HashSet<u32> = mesh.triangles().iter().flatten().copied().collect();
        for v in 0..mesh.positions().len() as u32 {
            let named = mesh.sound_vertices(v);
            assert_eq!(named.len(), usize::from(used.contains(&v)));
            for own in named {
                let apart = subtract(sound.positions()[own as usize], mesh.positions()[v as usize]);
                // Twice the side of the triangles there are.
                assert!(length(apart) < 2.0 * (4.0 * sound.area() / most as f64 / 3f64.sqrt()).sqrt());
            }
        }
    }

    #[test]
    fn a_mesh_is_recognised_by_its_hash_alone() {
        let whole: FileMesh = TriangleMesh::new(seam().positions()[..3].to_vec(), vec![[0, 1, 2]]).unwrap().into();
        assert_eq!((whole.mends(), whole.content_hash()), (None, whole.sound().content_hash()));
        for mesh in [seam(), whole, coarser()] {
            let recognised = |positions: Vec<[f64; 3]>| {
                let known = |content| content == mesh.content_hash();
                FileMesh::recognised(positions, mesh.triangles().to_vec(), mesh.mends(), known)
            };
            assert_eq!(recognised(mesh.positions().to_vec()).as_ref(), Some(&mesh));
            let mut moved = mesh.positions().to_vec();
            moved[2][2] += 1e-9;
            assert_eq!(recognised(moved), None);
        }
    }
}
