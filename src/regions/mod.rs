//! Regions of a shape, and which of them correspond on two shapes.

mod assignment;
pub mod consensus;
mod ensemble;
pub mod graph;
mod k_means;
pub mod pairing;

use std::collections::BTreeSet;

/// The most regions a shape may be divided into.
pub const MAX_REGIONS: usize = 64;

/// A shape's vertices divided into regions 0, 1, …; a vertex may be in none.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Regions {
    labels: Vec<i32>,
    count: usize,
}

/// A label that names neither a region nor none.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("label {label} of vertex {vertex} is outside -1 to {}", MAX_REGIONS - 1)]
pub struct LabelOutOfRange {
    pub vertex: usize,
    pub label: i32,
}

impl Regions {
    /// The label of a vertex in no region.
    pub const NONE: i32 = -1;

    /// The division that `labels` describes, one per vertex: the number of its region, or −1 for none. Numbers may be
    /// left out; those regions are empty.
    ///
    /// # Errors
    /// [`LabelOutOfRange`] names the first vertex whose label is below −1 or not below [`MAX_REGIONS`].
    pub fn new(labels: Vec<i32>) -> Result<Self, LabelOutOfRange> {
        let valid = Self::NONE..MAX_REGIONS as i32;
        match labels.iter().position(|label| !valid.contains(label)) {
            Some(vertex) => Err(LabelOutOfRange { vertex, label: labels[vertex] }),
            None => {
                let count = labels.iter().max().map_or(0, |&last| (last + 1) as usize);
                Ok(Self { labels, count })
            }
        }
    }

    /// Per vertex the number of its region, or [`Regions::NONE`]: n labels.
    pub fn labels(&self) -> &[i32] {
        &self.labels
    }

    /// One more than the largest label.
    pub fn count(&self) -> usize {
        self.count
    }

    /// The numbers of the regions that have a vertex, ascending.
    pub fn numbers(&self) -> Vec<usize> {
        let numbers: BTreeSet<i32> = self.labels.iter().copied().collect();
        numbers.into_iter().filter_map(|label| usize::try_from(label).ok()).collect()
    }

    /// The number of the region `vertex` is in.
    pub fn region(&self, vertex: usize) -> Option<usize> {
        usize::try_from(self.labels[vertex]).ok()
    }

    /// The sum of `mass` (n areas) over each region: `count` areas, 0 where a region is empty.
    pub fn areas(&self, mass: &[f64]) -> Vec<f64> {
        let mut areas = vec![0.0; self.count];
        for (x, &area) in mass.iter().enumerate() {
            if let Some(r) = self.region(x) {
                areas[r] += area;
            }
        }
        areas
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn areas_leave_out_vertices_of_no_region() {
        let regions = Regions::new(vec![2, -1, 0, 2]).unwrap();
        assert_eq!((regions.count(), regions.numbers()), (3, vec![0, 2]));
        assert_eq!(regions.areas(&[1.0, 10.0, 100.0, 1000.0]), [100.0, 0.0, 1001.0]);
    }

    #[test]
    fn no_vertex_or_no_region_is_a_count_of_zero() {
        assert_eq!(Regions::new(vec![]).unwrap().count(), 0);
        assert_eq!(Regions::new(vec![-1, -1]).unwrap().count(), 0);
    }

    #[test]
    fn a_label_out_of_range_is_named_with_its_vertex() {
        let error = Regions::new(vec![0, -2]).unwrap_err();
        assert_eq!(error, LabelOutOfRange { vertex: 1, label: -2 });
        assert_eq!(error.to_string(), "label -2 of vertex 1 is outside -1 to 63");
        assert!(Regions::new(vec![63]).is_ok());
        assert_eq!(Regions::new(vec![0, 0, 64]).unwrap_err().vertex, 2);
        assert!(Regions::new(vec![i32::MAX]).is_err());
    }
}
