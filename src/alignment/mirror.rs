//! Which limbs are each other's mirror image: left and right arm, left and right leg.

use super::limbs::{Limb, MOST};
use super::sampled_distances::SampledDistances;
use super::symmetry::Symmetry;
use crate::mesh::{length, subtract};

/// Price of the distance between a reflected tip and its twin, and of that between joints, which a pose moves less; and
/// of a limb without a twin, whose distances agree with its own exactly. All in units of a mean change of distance.
/// They were found on bodies of animals and persons, some with their limbs turned by up to 75°.
const TIPS: f64 = 0.1;
const JOINTS: f64 = 0.4;
const ALONE: f64 = 0.03;

/// For every limb its mirror twin, `None` for those that are their own: head, tail.
///
/// The pairing is the one of least cost among all: the mean change of the geodesic distance of two tips when both are
/// replaced by their twins, which hardly knows the pose; the mean distance of reflected tips and joints from their
/// twins', which knows the sides but suffers from the pose; and the number of limbs alone. Limbs beyond the tenth are
/// left alone.
pub fn mirrored_pairs(
    limbs: &[Limb],
    positions: &[[f64; 3]],
    symmetry: &Symmetry,
    distances: &SampledDistances,
) -> Vec<Option<usize>> {
    let tips: Vec<u32> = limbs.iter().take(MOST).map(|limb| limb.tip).collect();
    let apart = |a: [f64; 3], b: [f64; 3]| length(subtract(symmetry.reflect(a), b));
    let price = |i: usize, j: usize| {
        let [a, b] = [i, j].map(|limb| positions[tips[limb] as usize]);
        let alone = if i == j { ALONE } else { 0.0 };
        TIPS * apart(a, b) + JOINTS * apart(limbs[i].joint, limbs[j].joint) + alone
    };
    let table = |value: &dyn Fn(usize, usize) -> f64| -> Vec<Vec<f64>> {
        (0..tips.len()).map(|i| (0..tips.len()).map(|j| value(i, j)).collect()).collect()
    };
    let search = Search { prices: table(&price), distances: table(&|i, j| distances.between(tips[i], tips[j])) };
    let mut best = (f64::INFINITY, vec![None; tips.len()]);
    search.extend(&mut vec![None; tips.len()], 0.0, &mut best);
    let twins = best.1.into_iter().enumerate().map(|(i, twin)| twin.filter(|&twin| twin != i));
    twins.chain(std::iter::repeat(None)).take(limbs.len()).collect()
}

/// All pairings of a few tips, each with another or itself, and what they cost.
struct Search {
    /// Of making the second limb the first one's twin.
    prices: Vec<Vec<f64>>,
    /// Of the tips, geodesic.
    distances: Vec<Vec<f64>>,
}

impl Search {
    /// Puts the cheapest completion of `twins`, which costs `cost` so far, in the place of `best` if it costs less.
    fn extend(&self, twins: &mut Vec<Option<usize>>, cost: f64, best: &mut (f64, Vec<Option<usize>>)) {
        if cost >= best.0 {
            return;
        }
        let Some(i) = twins.iter().position(Option::is_none) else {
            *best = (cost, twins.clone());
            return;
        };
        for j in i..twins.len() {
            if twins[j].is_none() {
                (twins[i], twins[j]) = (Some(j), Some(i));
                self.extend(twins, cost + self.added(twins, i, j), best);
                (twins[i], twins[j]) = (None, None);
            }
        }
    }

    /// What the pair of i and j, the last made, adds to the cost.
    fn added(&self, twins: &[Option<usize>], i: usize, j: usize) -> f64 {
        let count = twins.len() as f64;
        let changes = |i: usize, j: usize| -> f64 {
            let known = twins.iter().enumerate().filter_map(|(k, twin)| twin.map(|twin| (k, twin)));
            known.map(|(k, twin)| (self.distances[i][k] - self.distances[j][twin]).abs()).sum()
        };
        // Each pair of tips counts in both orders.
        if i == j {
            self.prices[i][i] / count + 2.0 * changes(i, i) / (count * count)
        } else {
            (self.prices[i][j] + self.prices[j][i]) / count + 2.0 * (changes(i, j) + changes(j, i)) / (count * count)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::alignment::limbs::limbs;
    use crate::alignment::solids::star;
    use crate::numerics::Unwatched;

    const PLANE: Symmetry = Symmetry { normal: [1.0, 0.0, 0.0], offset: 0.0, asymmetry: 0.0 };

    #[test]
    fn arms_and_legs_are_paired_and_the_head_is_alone_even_in_a_pose() {
        for bend in [0.0, 0.8] {
            let mesh = star(bend);
            let distances = SampledDistances::new(&mesh, 40, &Unwatched).unwrap();
            let limbs = limbs(&mesh, &distances, &Unwatched).unwrap();
            let pairs = mirrored_pairs(&limbs, mesh.positions(), &PLANE, &distances);
            assert_eq!(pairs.len(), 5);
            for (limb, twin) in limbs.iter().zip(pairs) {
                let [x, _, z] = mesh.positions()[limb.tip as usize];
                let Some(twin) = twin else {
                    assert!(x.abs() < 0.05, "{x} {z}");
                    continue;
                };
                let [other, _, height] = mesh.positions()[limbs[twin].tip as usize];
                assert!(x * other < 0.0 && z * height > 0.0);
            }
        }
    }

    #[test]
    fn no_limbs_have_no_twins() {
        let mesh = star(0.0);
        let distances = SampledDistances::new(&mesh, 1, &Unwatched).unwrap();
        assert!(mirrored_pairs(&[], mesh.positions(), &PLANE, &distances).is_empty());
    }
}
