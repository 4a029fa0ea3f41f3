//! Which region of the mesh a region of the sketch is: by assignment on signatures, then by how regions touch.

use faer::Mat;
use pathfinding::{kuhn_munkres::kuhn_munkres_min, matrix::Matrix};
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::graph::{RegionGraph, RegionSignature};

/// Swaps that improve a pairing, at most.
const SWAPS: usize = 32;

/// Costs are assigned as integers, so that sums are exact: this many to the unit, and no more than `DEAREST` units.
const UNIT: f64 = 1e9;
const DEAREST: f64 = 1e6;

/// A region of the sketch and the region of the mesh it corresponds to.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = Pair)]
pub struct RegionPair {
    pub sketch: usize,
    pub mesh: usize,
    /// How unlike the two are, from 0: in area, descriptors and neighbours.
    pub cost: f64,
}

/// Pairs of corresponding regions.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct Pairing {
    /// In ascending order of the sketch's region; no region occurs twice.
    pub pairs: Vec<RegionPair>,
    /// Sum of the pairs' costs.
    pub cost: f64,
}

/// As many pairs of regions as the shape with fewer has, of a low total cost: the least by signatures alone, improved by
/// swaps that take into account which regions touch. Both graphs have the same descriptors.
///
/// A pair costs |a − b| / (a + b) for its area shares, plus the root mean square difference of its descriptors, each in
/// standard deviations over its own shape, plus the part of its borders, in [0, 1], that is not with regions paired
/// with each other.
pub fn pair(sketch: &RegionGraph, mesh: &RegionGraph) -> Pairing {
    let mut assignment = Assignment::of(sketch, mesh);
    for _ in 0..SWAPS {
        if !assignment.swap_best() {
            break;
        }
    }
    let pairs = assignment.pairs();
    Pairing { cost: pairs.iter().map(|pair| pair.cost).sum(), pairs }
}

/// Every region of the sketch has a partner, and of the mesh too: the shape with fewer regions has dummies for the rest.
struct Assignment {
    sketch_count: usize,
    mesh_count: usize,
    /// N × N costs by signature, N the larger count; 0 for dummies.
    unlikeness: Mat<f64>,
    /// N × N, 0 for dummies.
    sketch_adjacency: Mat<f64>,
    mesh_adjacency: Mat<f64>,
    /// The mesh's region for every one of the sketch: a permutation of N.
    partners: Vec<usize>,
}

impl Assignment {
    /// The assignment of least cost by signatures alone.
    fn of(sketch: &RegionGraph, mesh: &RegionGraph) -> Self {
        let (sketch_count, mesh_count) = (sketch.signatures.len(), mesh.signatures.len());
        let size = sketch_count.max(mesh_count);
        let padded = |matrix: &Mat<f64>| {
            let inside = |i, j| i < matrix.nrows() && j < matrix.ncols();
            Mat::from_fn(size, size, |i, j| if inside(i, j) { matrix[(i, j)] } else { 0.0 })
        };
        let unlikeness = padded(&unlikeness(&sketch.signatures, &mesh.signatures));
        Self {
            sketch_count,
            mesh_count,
            partners: cheapest(&unlikeness),
            unlikeness,
            sketch_adjacency: padded(&sketch.adjacency),
            mesh_adjacency: padded(&mesh.adjacency),
        }
    }

    /// Cost of the pair of the sketch's region `i` and its partner; 0 where one of them is a dummy.
    fn pair_cost(&self, i: usize) -> f64 {
        let a = self.partners[i];
        if i >= self.sketch_count || a >= self.mesh_count {
            return 0.0;
        }
        let other_neighbours: f64 = (self.partners.iter().enumerate())
            .map(|(j, &b)| (self.sketch_adjacency[(i, j)] - self.mesh_adjacency[(a, b)]).abs())
            .sum();
        self.unlikeness[(i, a)] + 0.5 * other_neighbours
    }

    fn cost(&self) -> f64 {
        (0..self.partners.len()).map(|i| self.pair_cost(i)).sum()
    }

    /// Swaps the partners of the two regions whose swap lowers the cost most; whether there are such.
    fn swap_best(&mut self) -> bool {
        let before = self.cost();
        let size = self.partners.len();
        let mut best = (before * (1.0 - 1e-12), None);
        for (i, j) in (0..size).flat_map(|i| (0..i).map(move |j| (i, j))) {
            self.partners.swap(i, j);
            let cost = self.cost();
            if cost < best.0 {
                best = (cost, Some((i, j)));
            }
            self.partners.swap(i, j);
        }
        if let (_, Some((i, j))) = best {
            self.partners.swap(i, j);
        }
        best.1.is_some()
    }

    fn pairs(&self) -> Vec<RegionPair> {
        let partners = self.partners.iter().enumerate();
        let real = partners.filter(|&(i, &a)| i < self.sketch_count && a < self.mesh_count);
        real.map(|(i, &a)| RegionPair { sketch: i, mesh: a, cost: self.pair_cost(i) }).collect()
    }
}

/// The permutation of least cost: the column of every row of a square matrix.
fn cheapest(costs: &Mat<f64>) -> Vec<usize> {
    if costs.nrows() == 0 {
        return Vec::new();
    }
    let whole = |cost: f64| (cost.min(DEAREST) * UNIT).round() as i64;
    kuhn_munkres_min(&Matrix::from_fn(costs.nrows(), costs.ncols(), |place| whole(costs[place]))).1
}

/// sketch regions × mesh regions: how unlike the area shares and descriptors of two regions are.
fn unlikeness(sketch: &[RegionSignature], mesh: &[RegionSignature]) -> Mat<f64> {
    let (standard_sketch, standard_mesh) = (standardised(sketch), standardised(mesh));
    Mat::from_fn(sketch.len(), mesh.len(), |i, j| {
        let (a, b) = (sketch[i].area_share, mesh[j].area_share);
        let by_area = if a + b > 0.0 { (a - b).abs() / (a + b) } else { 0.0 };
        let (x, y) = (&standard_sketch[i], &standard_mesh[j]);
        let squares: f64 = x.iter().zip(y).map(|(x, y)| (x - y).powi(2)).sum();
        by_area + (squares / x.len().max(1) as f64).sqrt()
    })
}

/// The descriptors with mean 0 and variance 1 over the shape, by area; 0 where a descriptor is the same everywhere.
fn standardised(signatures: &[RegionSignature]) -> Vec<Vec<f64>> {
    let dimensions = signatures.first().map_or(0, |signature| signature.descriptors.len());
    let mean = |value: &dyn Fn(&RegionSignature) -> f64| -> f64 {
        signatures.iter().map(|signature| signature.area_share * value(signature)).sum()
    };
    let means: Vec<f64> = (0..dimensions).map(|j| mean(&|signature| signature.descriptors[j])).collect();
    let deviation = |j: usize| mean(&|signature| (signature.descriptors[j] - means[j]).powi(2)).sqrt();
    let deviations: Vec<f64> = (0..dimensions).map(deviation).collect();
    let standard = |j: usize, value: f64| {
        let constant = deviations[j] <= 1e-12 * means[j].abs();
        if constant { 0.0 } else { (value - means[j]) / deviations[j] }
    };
    let row =
        |signature: &RegionSignature| signature.descriptors.iter().enumerate().map(|(j, &v)| standard(j, v)).collect();
    signatures.iter().map(row).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A shape of regions with area share, two descriptors and neighbours along a chain.
    fn chain(regions: &[(f64, [f64; 2])]) -> RegionGraph {
        let count = regions.len();
        let signatures = regions
            .iter()
            .map(|&(area_share, descriptors)| RegionSignature { area_share, descriptors: descriptors.to_vec() })
            .collect();
        let neighbours = |r: usize| if r == 0 || r + 1 == count { 1.0 } else { 0.5 };
        let adjacency = Mat::from_fn(count, count, |r, s| if r.abs_diff(s) == 1 { neighbours(r) } else { 0.0 });
        RegionGraph { signatures, adjacency }
    }

    fn permuted(graph: &RegionGraph, order: &[usize]) -> RegionGraph {
        let signatures = order.iter().map(|&r| graph.signatures[r].clone()).collect();
        let adjacency = Mat::from_fn(order.len(), order.len(), |r, s| graph.adjacency[(order[r], order[s])]);
        RegionGraph { signatures, adjacency }
    }

    fn partners(pairing: &Pairing) -> Vec<(usize, usize)> {
        pairing.pairs.iter().map(|pair| (pair.sketch, pair.mesh)).collect()
    }

    fn animal() -> RegionGraph {
        chain(&[(0.4, [1.0, 5.0]), (0.3, [2.0, 1.0]), (0.2, [4.0, 2.0]), (0.1, [9.0, 3.0])])
    }

    #[test]
    fn a_permuted_copy_pairs_to_its_original_at_no_cost() {
        let order = [2, 0, 3, 1];
        let pairing = pair(&permuted(&animal(), &order), &animal());
        assert_eq!(partners(&pairing), [(0, 2), (1, 0), (2, 3), (3, 1)]);
        assert!(pairing.cost < 1e-12);
    }

    #[test]
    fn the_shape_with_more_regions_keeps_some_alone() {
        let fewer = permuted(&animal(), &[0, 1, 3]);
        assert_eq!(partners(&pair(&fewer, &animal())), [(0, 0), (1, 1), (2, 3)]);
        assert_eq!(partners(&pair(&animal(), &fewer)), [(0, 0), (1, 1), (3, 2)]);
    }

    #[test]
    fn neighbours_decide_between_regions_that_look_alike() {
        // A chain of five equal regions with one end marked: only neighbours tell the others apart.
        let alike = (0.2, [1.0, 1.0]);
        let mesh = chain(&[(0.2, [7.0, 2.0]), alike, alike, alike, alike]);
        for order in [[0, 2, 1, 3, 4], [0, 1, 3, 2, 4], [0, 4, 2, 3, 1], [3, 4, 0, 1, 2]] {
            let pairing = pair(&permuted(&mesh, &order), &mesh);
            let expected: Vec<(usize, usize)> = order.iter().copied().enumerate().collect();
            assert_eq!(partners(&pairing), expected);
        }
    }

    #[test]
    fn the_total_is_the_sum_and_descends_from_the_assignment_by_signatures() {
        let mesh = chain(&[(0.1, [3.0, 1.0]), (0.5, [2.0, 2.0]), (0.2, [5.0, 2.5]), (0.2, [4.0, 0.0])]);
        let pairing = pair(&animal(), &mesh);
        assert!((pairing.cost - pairing.pairs.iter().map(|pair| pair.cost).sum::<f64>()).abs() < 1e-15);
        assert!(pairing.cost <= Assignment::of(&animal(), &mesh).cost());
    }

    #[test]
    fn the_cheapest_permutation_is_that_of_all_permutations() {
        let costs = Mat::from_fn(4, 4, |i, j| ((i * 7 + j * 13 + i * j * 5) % 11) as f64);
        let total = |columns: &[usize]| columns.iter().enumerate().map(|(i, &j)| costs[(i, j)]).sum::<f64>();
        let digits = |n: usize| [n / 64, n / 16 % 4, n / 4 % 4, n % 4];
        let permutations = (0..256).map(digits).filter(|p| (0..4).all(|d| p.contains(&d)));
        let least = permutations.map(|p| total(&p)).fold(f64::INFINITY, f64::min);
        assert_eq!(total(&cheapest(&costs)), least);
    }

    #[test]
    fn no_regions_make_no_pairs() {
        assert_eq!(pair(&chain(&[]), &animal()), Pairing { pairs: vec![], cost: 0.0 });
        assert_eq!(pair(&chain(&[]), &chain(&[])).pairs, []);
    }

    #[test]
    fn descriptors_that_are_none_or_not_finite_do_not_hang() {
        let mut strange = animal();
        strange.signatures[1].descriptors = vec![f64::NAN, f64::INFINITY];
        assert_eq!(pair(&strange, &animal()).pairs.len(), 4);
        let mut bare = animal();
        bare.signatures.iter_mut().for_each(|signature| signature.descriptors.clear());
        assert_eq!(pair(&bare, &bare).pairs.len(), 4);
    }
}
