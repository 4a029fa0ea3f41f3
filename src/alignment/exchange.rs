//! Limbs that are each other's mirror image, and a point map that takes one for the other.

use super::frame::Frame;
use super::limbs::Limb;
use super::prepared::PreparedMesh;
use super::visible::Visible;
use crate::mesh::{length, subtract};

/// How far the mirror image of a tip may be from the tip of its partner, in units of √area.
const APART: f64 = 0.3;
/// The weight from which a vertex belongs to a limb.
const BELONGS: f32 = 0.5;

/// The limbs that lie on each other when the mesh is reflected in its plane of symmetry.
pub(super) fn partners(mesh: &PreparedMesh) -> Vec<[usize; 2]> {
    let tip = |limb: &Limb| mesh.positions[limb.tip as usize];
    let partner = |i: usize| {
        let image = mesh.symmetry.reflect(tip(&mesh.limbs[i]));
        let away = |j: &usize| length(subtract(tip(&mesh.limbs[*j]), image));
        (0..mesh.limbs.len()).min_by(|a, b| away(a).total_cmp(&away(b))).filter(|j| away(j) < APART)
    };
    let mutual = |&i: &usize| partner(i).filter(|&j| i < j && partner(j) == Some(i)).map(|j| [i, j]);
    (0..mesh.limbs.len()).filter_map(|i| mutual(&i)).collect()
}

/// The map with the answers on either limb of a pair moved to the other limb, to what the camera sees of it alone.
pub(super) fn exchanged(mesh: &PreparedMesh, frame: &Frame, pair: [usize; 2], map: &[u32]) -> Vec<u32> {
    let mut answer = map.to_vec();
    for [from, to] in [pair, [pair[1], pair[0]]] {
        let (from, to) = (&mesh.limbs[from], &mesh.limbs[to]);
        let on_limb = |t: &&[u32; 3]| t.iter().all(|&v| to.weight[v as usize] > 0.0);
        let triangles: Vec<[u32; 3]> = mesh.triangles.iter().filter(on_limb).copied().collect();
        let visible = Visible::new(&mesh.positions, &triangles, frame);
        for (answer, &v) in answer.iter_mut().zip(map) {
            if from.weight[v as usize] >= BELONGS {
                *answer = visible.vertex(frame.project(mesh.symmetry.reflect(mesh.positions[v as usize])));
            }
        }
    }
    answer
}
