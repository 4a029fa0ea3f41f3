//! An ensemble of clusterings, and the energy of a partition against it.
//!
//! Letters: E_u is member u of m, x the partition, w_i the area of vertex i. Written out, eq. 2.27–2.28 of the thesis is
//!
//! Σ_u Σ_ij w_i w_j (1[E_ui = E_uj] − 1[x_i = x_j])² = Σ_u Σ_l |E_ul|² + Σ_c (m |c|² − 2 Σ_u Σ_l |c ∩ E_ul|²)
//!
//! with |·| for areas, c over the regions of x and l over the clusters of a member. With the overlaps |c ∩ E_ul| kept,
//! what it costs a vertex to join a region takes m additions, and the n² pairs are never looked at.

use super::assignment::Label;
use crate::numerics::{Cancelled, Watch};

/// Sweeps over all nodes at most, in one descent.
const SWEEPS: usize = 100;

/// A move has to lower the energy by more than this share of the energy's largest value, so that rounding moves nothing.
const NEGLIGIBLE: f64 = 1e-12;

/// Clusterings of one set of vertices. Vertices that no member tells apart are one node: the paper's super-pixels.
pub(super) struct Ensemble {
    /// Number of clusterings, m.
    members: usize,
    /// The first slot of every member, and the number of slots at the end: a slot is a cluster of one of the members.
    offsets: Vec<usize>,
    /// m slots per node, node after node: the clusters it is in.
    slots: Vec<u16>,
    /// Area of every node.
    areas: Vec<f64>,
    /// The node every vertex belongs to.
    nodes: Vec<usize>,
}

/// A partition of an ensemble's nodes into regions, some perhaps empty.
#[derive(Clone)]
pub(super) struct Partition<'a> {
    ensemble: &'a Ensemble,
    /// Region of every node.
    labels: Vec<usize>,
    /// |c|, the area of every region.
    areas: Vec<f64>,
    /// |c ∩ E_ul|: per region an area for every slot.
    overlaps: Vec<Vec<f64>>,
}

impl Ensemble {
    /// `clusterings` holds a label per vertex for every member, `areas` the area of every vertex.
    pub(super) fn of(clusterings: &[Vec<Label>], areas: &[f64]) -> Self {
        let mut offsets = vec![0];
        for clustering in clusterings {
            let clusters = clustering.iter().max().map_or(0, |&last| usize::from(last) + 1);
            offsets.push(offsets[offsets.len() - 1] + clusters);
        }
        let members = clusterings.len();
        let mut slots = vec![0; areas.len() * members];
        for (u, clustering) in clusterings.iter().enumerate() {
            for (slots, label) in slots.chunks_exact_mut(members).zip(clustering) {
                slots[u] = offsets[u] as u16 + label;
            }
        }

        // Neighbours mostly share their node, so that few are left to be sorted.
        let slots_of = |vertex: usize| &slots[vertex * members..(vertex + 1) * members];
        let mut distinct: Vec<&[u16]> = (0..areas.len()).map(slots_of).collect();
        distinct.dedup();
        distinct.sort_unstable();
        distinct.dedup();
        let mut ensemble = Self {
            members,
            slots: distinct.concat(),
            areas: vec![0.0; distinct.len()],
            nodes: Vec::with_capacity(areas.len()),
            offsets,
        };
        let mut node = 0;
        for (vertex, area) in areas.iter().enumerate() {
            if distinct[node] != slots_of(vertex) {
                node = distinct.partition_point(|&slots| slots < slots_of(vertex));
            }
            ensemble.areas[node] += area;
            ensemble.nodes.push(node);
        }
        ensemble
    }

    fn slots(&self, node: usize) -> &[u16] {
        &self.slots[node * self.members..(node + 1) * self.members]
    }

    /// The members of at most `count` clusters as partitions into `count` regions.
    pub(super) fn members(&self, count: usize) -> impl Iterator<Item = Partition<'_>> {
        (0..self.members).filter(move |&u| self.offsets[u + 1] - self.offsets[u] <= count).map(move |u| {
            let label = |node| usize::from(self.slots(node)[u]) - self.offsets[u];
            Partition::of(self, (0..self.areas.len()).map(label).collect(), count)
        })
    }

    /// The labels of vertices from those of their nodes.
    pub(super) fn spread(&self, labels: &[usize]) -> Vec<usize> {
        self.nodes.iter().map(|&node| labels[node]).collect()
    }

    /// The most the energy's parts sum to: m times the squared area.
    fn scale(&self) -> f64 {
        self.members as f64 * self.areas.iter().sum::<f64>().powi(2)
    }
}

impl<'a> Partition<'a> {
    fn of(ensemble: &'a Ensemble, labels: Vec<usize>, count: usize) -> Self {
        let slots = ensemble.offsets[ensemble.members];
        let mut partition = Self { ensemble, areas: vec![0.0; count], overlaps: vec![vec![0.0; slots]; count], labels };
        for node in 0..partition.labels.len() {
            partition.add(partition.labels[node], node, 1.0);
        }
        partition
    }

    /// Adds `sign` times the area of `node` to `region`.
    fn add(&mut self, region: usize, node: usize, sign: f64) {
        let area = sign * self.ensemble.areas[node];
        self.areas[region] += area;
        for &slot in self.ensemble.slots(node) {
            self.overlaps[region][usize::from(slot)] += area;
        }
    }

    /// Moves `node` to `region`.
    fn transfer(&mut self, node: usize, region: usize) {
        self.add(self.labels[node], node, -1.0);
        self.add(region, node, 1.0);
        self.labels[node] = region;
    }

    /// Σ_u d²(E_u, x), eq. 2.27, up to Σ_u Σ_l |E_ul|², which is the same for every partition.
    pub(super) fn energy(&self) -> f64 {
        let m = self.ensemble.members as f64;
        let squares = |values: &[f64]| values.iter().map(|value| value * value).sum::<f64>();
        m * squares(&self.areas) - 2.0 * self.overlaps.iter().map(|overlap| squares(overlap)).sum::<f64>()
    }

    /// Half the change of energy, per area of `node`, when it joins `region`, not being in it.
    fn joining(&self, region: usize, node: usize) -> f64 {
        let overlap = &self.overlaps[region];
        let shared: f64 = self.ensemble.slots(node).iter().map(|&slot| overlap[usize::from(slot)]).sum();
        self.ensemble.members as f64 * self.areas[region] - 2.0 * shared
    }

    /// The region `node` joins at the least cost among those `allowed`, and the cost.
    fn cheapest(&self, node: usize, allowed: impl Fn(usize) -> bool) -> Option<(usize, f64)> {
        let regions = (0..self.areas.len()).filter(|&region| allowed(region));
        regions.map(|region| (region, self.joining(region, node))).min_by(|a, b| a.1.total_cmp(&b.1))
    }

    /// Moves every node in turn to the region where it costs least; whether any moved.
    fn sweep(&mut self) -> bool {
        let m = self.ensemble.members as f64;
        let least = NEGLIGIBLE * self.ensemble.scale();
        let mut moved = false;
        for node in 0..self.labels.len() {
            let (home, area) = (self.labels[node], self.ensemble.areas[node]);
            // The node itself is counted in its region's area and in each of m overlaps: m·w − 2·m·w too much.
            let staying = self.joining(home, node) + m * area;
            if let Some((region, cost)) = self.cheapest(node, |region| region != home)
                && area * (staying - cost) > least
            {
                self.transfer(node, region);
                moved = true;
            }
        }
        moved
    }

    /// Half the change of energy when the regions `a` and `b` become one.
    fn merging(&self, a: usize, b: usize) -> f64 {
        let shared: f64 = self.overlaps[a].iter().zip(&self.overlaps[b]).map(|(a, b)| a * b).sum();
        self.ensemble.members as f64 * self.areas[a] * self.areas[b] - 2.0 * shared
    }

    /// Merges the two regions whose union lowers the energy most; whether there are such.
    fn merge(&mut self) -> bool {
        let pairs = (0..self.areas.len()).flat_map(|a| (0..a).map(move |b| (a, b)));
        let costs = pairs.map(|(a, b)| ((a, b), self.merging(a, b)));
        let Some(((a, b), cost)) = costs.min_by(|a, b| a.1.total_cmp(&b.1)) else { return false };
        if cost >= -NEGLIGIBLE * self.ensemble.scale() {
            return false;
        }
        for node in 0..self.labels.len() {
            if self.labels[node] == a {
                self.transfer(node, b);
            }
        }
        true
    }

    /// Lowers the energy until no node gains by moving and no two regions by merging, or [`SWEEPS`] are done.
    ///
    /// # Errors
    /// [`Cancelled`] by `watch`, asked at every sweep whether to go on at `fraction`.
    pub(super) fn descend(&mut self, watch: &dyn Watch, fraction: f64) -> Result<(), Cancelled> {
        for _ in 0..SWEEPS {
            watch.proceed(fraction)?;
            if !self.sweep() && !self.merge() {
                break;
            }
        }
        Ok(())
    }

    /// Dissolves the regions of less than `share` of the area, the smallest first, each of their nodes into another
    /// region where it costs least, unless the energy would rise above `bound`.
    ///
    /// Where members cut at slightly different places and a region is left over, the strip between the cuts makes a
    /// region of low energy; it is no part of the shape.
    pub(super) fn dissolve_slivers(&mut self, share: f64, bound: f64) {
        let least = share * self.areas.iter().sum::<f64>();
        let mut slivers: Vec<usize> = (0..self.areas.len()).filter(|&region| self.areas[region] < least).collect();
        slivers.sort_by(|&a, &b| self.areas[a].total_cmp(&self.areas[b]));
        for (s, &sliver) in slivers.iter().enumerate() {
            let mut without = self.clone();
            for node in (0..self.labels.len()).filter(|&node| self.labels[node] == sliver) {
                if let Some((region, _)) = self.cheapest(node, |region| !slivers[..=s].contains(&region)) {
                    without.transfer(node, region);
                }
            }
            if without.energy() <= bound {
                *self = without;
            }
        }
    }

    /// The region of every node.
    pub(super) fn into_labels(self) -> Vec<usize> {
        self.labels
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numerics::Unwatched;
    use rand::RngExt;
    use rand_chacha::{ChaCha8Rng, rand_core::SeedableRng};

    const VERTICES: usize = 40;

    /// 1 where vertices i and j have one label.
    fn together<T: PartialEq>(labels: &[T], i: usize, j: usize) -> f64 {
        f64::from(u8::from(labels[i] == labels[j]))
    }

    /// Eq. 2.27 and 2.28 as printed.
    fn naive_energy(clusterings: &[Vec<Label>], areas: &[f64], x: &[usize]) -> f64 {
        let mut energy = 0.0;
        for clustering in clusterings {
            for i in 0..areas.len() {
                for j in 0..areas.len() {
                    energy += areas[i] * areas[j] * (together(clustering, i, j) - together(x, i, j)).powi(2);
                }
            }
        }
        energy
    }

    /// Nine noisy copies of runs of equal labels, of 2 to 6 clusters, and uneven areas.
    fn clusterings(seed: u64) -> (Vec<Vec<Label>>, Vec<f64>) {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let clusterings = (0..9)
            .map(|u| {
                let k: Label = 2 + u % 5;
                let noisy = |i: usize| {
                    if random.random_bool(0.2) { random.random_range(0..k) } else { i as Label * k / VERTICES as Label }
                };
                (0..VERTICES).map(noisy).collect()
            })
            .collect();
        (clusterings, (0..VERTICES).map(|_| random.random_range(0.1..2.0)).collect())
    }

    fn constant(clusterings: &[Vec<Label>], areas: &[f64]) -> f64 {
        naive_energy(clusterings, areas, &(0..areas.len()).collect::<Vec<_>>())
            + clusterings.len() as f64 * areas.iter().map(|a| a * a).sum::<f64>()
    }

    #[test]
    fn the_energy_is_the_sum_over_all_pairs() {
        let (clusterings, areas) = clusterings(1);
        let ensemble = Ensemble::of(&clusterings, &areas);
        for partition in ensemble.members(6) {
            let naive = naive_energy(&clusterings, &areas, &ensemble.spread(&partition.labels));
            let fast = partition.energy() + constant(&clusterings, &areas);
            assert!((fast - naive).abs() < 1e-9 * naive, "{fast} is not {naive}");
        }
    }

    #[test]
    fn a_descent_ends_no_higher_than_its_start_and_where_no_single_move_helps() {
        for seed in 0..10 {
            let (clusterings, areas) = clusterings(seed);
            let ensemble = Ensemble::of(&clusterings, &areas);
            for mut partition in ensemble.members(4) {
                let before = naive_energy(&clusterings, &areas, &ensemble.spread(&partition.labels));
                partition.descend(&Unwatched, 0.0).unwrap();
                let x = ensemble.spread(&partition.labels);
                let after = naive_energy(&clusterings, &areas, &x);
                assert!(after <= before * (1.0 + 1e-12));
                for (i, region) in (0..VERTICES).flat_map(|i| (0..4).map(move |region| (i, region))) {
                    let mut moved = x.clone();
                    moved[i] = region;
                    assert!(naive_energy(&clusterings, &areas, &moved) >= after * (1.0 - 1e-12));
                }
            }
        }
    }

    #[test]
    fn vertices_no_member_tells_apart_are_one_node() {
        let ensemble = Ensemble::of(&[vec![0, 1, 0, 1], vec![2, 0, 2, 1]], &[1.0, 2.0, 4.0, 8.0]);
        assert_eq!(ensemble.nodes[0], ensemble.nodes[2]);
        let mut areas = ensemble.areas.clone();
        areas.sort_by(f64::total_cmp);
        assert_eq!(areas, [2.0, 5.0, 8.0]);
    }

    #[test]
    fn members_that_agree_are_the_consensus() {
        let agreed: Vec<Label> = (0..12).map(|i| i / 4).collect();
        let ensemble = Ensemble::of(&vec![agreed.clone(); 5], &[1.0; 12]);
        let mut partition = Partition::of(&ensemble, vec![0, 1, 0], 3);
        partition.descend(&Unwatched, 0.0).unwrap();
        let x = ensemble.spread(&partition.labels);
        assert!((0..12).all(|i| (0..12).all(|j| (x[i] == x[j]) == (agreed[i] == agreed[j]))));
    }

    #[test]
    fn regions_that_no_member_parts_are_merged() {
        let ensemble = Ensemble::of(&[vec![0, 0, 0, 1], vec![0, 0, 1, 1], vec![0, 0, 0, 0]], &[3.0, 3.0, 3.0, 1.0]);
        let mut partition = Partition::of(&ensemble, vec![0, 1, 2], 3);
        let before = partition.energy();
        assert!(partition.merge());
        assert!(partition.energy() < before);
    }

    #[test]
    fn slivers_are_dissolved_as_far_as_the_energy_allows() {
        // Five members cut before the light vertex and four after it: it belongs with what comes after.
        let cut = |after: usize| (0..6).map(|i| Label::from(i > after)).collect::<Vec<_>>();
        let clusterings: Vec<Vec<Label>> = (0..9).map(|u| cut(2 + u % 2)).collect();
        let areas = [1.0, 1.0, 1.0, 0.01, 1.0, 1.0];
        let ensemble = Ensemble::of(&clusterings, &areas);
        let strip = || Partition::of(&ensemble, vec![0, 1, 2], 3);
        let (mut kept, mut dissolved) = (strip(), strip());
        kept.dissolve_slivers(0.1, strip().energy() - 1.0);
        assert_eq!(kept.labels, strip().labels);
        dissolved.dissolve_slivers(0.1, f64::INFINITY);
        assert_eq!(ensemble.spread(&dissolved.labels), [0, 0, 0, 2, 2, 2]);
    }
}
