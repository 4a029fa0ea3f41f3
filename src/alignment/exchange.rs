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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::alignment::solids::{sphere, star};
    use crate::numerics::Unwatched;

    #[test]
    fn limbs_of_either_side_are_partners_and_what_has_none_has_none() {
        let mesh = PreparedMesh::new(&star(0.0), &Unwatched).unwrap();
        let partners = partners(&mesh);
        assert_eq!(partners.len(), 2);
        for pair in partners {
            let [left, right] = pair.map(|limb| mesh.axes.back(mesh.positions[mesh.limbs[limb].tip as usize]));
            assert!((left[0] + right[0]).abs() < 0.1 && left[0].abs() > 0.3 && (left[2] - right[2]).abs() < 0.1);
        }
        assert!(super::partners(&PreparedMesh::new(&sphere(16, 32), &Unwatched).unwrap()).is_empty());
    }

    #[test]
    fn answers_change_sides_on_the_limbs_alone() {
        let mesh = PreparedMesh::new(&star(0.0), &Unwatched).unwrap();
        let frame = Frame::looking_from(mesh.axes.along([0.0, 1.0, 0.0]));
        let visible = Visible::new(&mesh.positions, &mesh.triangles, &frame);
        let map: Vec<u32> = mesh.positions.iter().map(|&p| visible.vertex(frame.project(p))).collect();
        let pair = partners(&mesh)[0];
        let other = exchanged(&mesh, &frame, pair, &map);
        let mut moved = 0;
        for (&before, &after) in map.iter().zip(&other) {
            let on_limb = pair.iter().any(|&limb| mesh.limbs[limb].weight[before as usize] >= BELONGS);
            let wanted = if on_limb { mesh.symmetry.reflect(mesh.positions[before as usize]) } else { [0.0; 3] };
            let away = length(subtract(mesh.positions[after as usize], wanted));
            assert!(if on_limb { away < 0.1 } else { before == after }, "{before} {after} {away}");
            moved += usize::from(on_limb);
        }
        assert!(moved > 20);
    }
}
