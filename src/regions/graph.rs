//! A shape's regions as a graph: what each looks like, and which touch.

use faer::{Mat, MatRef};

use super::Regions;

/// What a region is known by, whatever the pose and the size of its shape.
#[derive(Clone, Debug, PartialEq)]
pub struct RegionSignature {
    /// Share of the shape's area, in [0, 1].
    pub area_share: f64,
    /// Means of d point descriptors over the region, weighted by area.
    pub descriptors: Vec<f64>,
}

/// The regions of one shape and how they touch.
#[derive(Clone, Debug)]
pub struct RegionGraph {
    /// One per region.
    pub signatures: Vec<RegionSignature>,
    /// regions × regions: the share of the row's border that is with the column. Rows sum to 1, or to 0 where a region
    /// touches no other.
    pub adjacency: Mat<f64>,
}

impl RegionGraph {
    /// The graph of `regions`, over the areas `mass` (n) and the point descriptors `descriptors` (n × d) of the shape,
    /// whose triangles name vertices below n.
    pub fn of(regions: &Regions, mass: &[f64], descriptors: MatRef<'_, f64>, triangles: &[[u32; 3]]) -> Self {
        Self { signatures: signatures(regions, mass, descriptors), adjacency: adjacency(regions, triangles) }
    }
}

/// One signature per region; an empty region has area 0 and descriptors 0.
fn signatures(regions: &Regions, mass: &[f64], descriptors: MatRef<'_, f64>) -> Vec<RegionSignature> {
    let areas = regions.areas(mass);
    let total: f64 = areas.iter().sum();
    let mut sums = vec![vec![0.0; descriptors.ncols()]; regions.count()];
    for (x, area) in mass.iter().enumerate() {
        if let Some(r) = regions.region(x) {
            for (j, sum) in sums[r].iter_mut().enumerate() {
                *sum += area * descriptors[(x, j)];
            }
        }
    }
    let share = |part: f64, whole: f64| if whole > 0.0 { part / whole } else { 0.0 };
    areas
        .iter()
        .zip(sums)
        .map(|(&area, sums)| RegionSignature {
            area_share: share(area, total),
            descriptors: sums.into_iter().map(|sum| share(sum, area)).collect(),
        })
        .collect()
}

/// The share of every region's border that is with every other, by the number of triangles' edges between them.
fn adjacency(regions: &Regions, triangles: &[[u32; 3]]) -> Mat<f64> {
    let count = regions.count();
    let mut edges = Mat::<f64>::zeros(count, count);
    for &[a, b, c] in triangles {
        for (from, to) in [(a, b), (b, c), (c, a)] {
            if let (Some(r), Some(s)) = (regions.region(from as usize), regions.region(to as usize))
                && r != s
            {
                edges[(r, s)] += 1.0;
                edges[(s, r)] += 1.0;
            }
        }
    }
    let borders: Vec<f64> = (0..count).map(|r| (0..count).map(|s| edges[(r, s)]).sum()).collect();
    Mat::from_fn(count, count, |r, s| if borders[r] > 0.0 { edges[(r, s)] / borders[r] } else { 0.0 })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn signatures_are_means_by_area() {
        let regions = Regions::new(vec![0, 0, 2, -1]).unwrap();
        let descriptors = Mat::from_fn(4, 2, |x, j| (x + 10 * j) as f64);
        let graph = RegionGraph::of(&regions, &[1.0, 3.0, 12.0, 100.0], descriptors.as_ref(), &[]);
        let expected = [(0.25, vec![0.75, 10.75]), (0.0, vec![0.0, 0.0]), (0.75, vec![2.0, 12.0])];
        for (signature, (area_share, descriptors)) in graph.signatures.iter().zip(expected) {
            assert_eq!(*signature, RegionSignature { area_share, descriptors });
        }
    }

    #[test]
    fn borders_are_shared_by_edges() {
        // A strip of triangles 0-1-2, 1-2-3, 2-3-4, 3-4-5 over the regions 0 0 1 1 2 and none.
        let regions = Regions::new(vec![0, 0, 1, 1, 2, -1]).unwrap();
        let triangles = [[0, 1, 2], [1, 3, 2], [2, 3, 4], [3, 5, 4]];
        let adjacency = adjacency(&regions, &triangles);
        // Edges by triangle: 0|1 twice in the first, twice in the second; 1|2 twice in the third, once in the fourth.
        let expected = [[0.0, 1.0, 0.0], [4.0 / 7.0, 0.0, 3.0 / 7.0], [0.0, 1.0, 0.0]];
        assert_eq!(adjacency, Mat::from_fn(3, 3, |r, s| expected[r][s]));
    }

    #[test]
    fn no_regions_are_an_empty_graph() {
        let regions = Regions::new(vec![-1, -1, -1]).unwrap();
        let graph = RegionGraph::of(&regions, &[1.0; 3], Mat::zeros(3, 2).as_ref(), &[[0, 1, 2]]);
        assert_eq!((graph.signatures.len(), graph.adjacency.nrows()), (0, 0));
    }
}
