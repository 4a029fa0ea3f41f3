//! Consensus segmentation: the regions closest to all clusterings of an ensemble.

use faer::MatRef;
use rand_chacha::{ChaCha8Rng, rand_core::SeedableRng};

use super::assignment::Label;
use super::ensemble::{Ensemble, Partition};
use super::k_means::{self, Points};
use super::{MAX_REGIONS, Regions};
use crate::numerics::{Cancelled, Watch};

/// Clusterings in the ensemble.
const MEMBERS: usize = 30;

/// The number of clusters of the ensemble's members runs from so many below the number of regions to so many above.
const SPREAD: usize = 2;

/// The members of the least energy the consensus is sought from.
const STARTS: usize = 6;

/// A region of a smaller share of the area is no part of a shape.
const SLIVER: f64 = 0.01;

/// The points k-means settles on where a shape has more.
const SAMPLE: usize = 4096;

/// Member u of the ensemble draws its seeds from the stream of `SEED + u`.
const SEED: u64 = 0x5EED_0F5E_6111_E275;

/// At most `count` regions of a shape, from 0 in descending order of area (of equals the one with the first vertex).
///
/// `signature` is n × d, row x the point in space that stands for vertex x; `mass` is its n areas. A vertex without area
/// is in no region. `count` is taken as 1 below 1 and as [`MAX_REGIONS`] above. Fewer regions than asked for come back
/// where the clusterings agree on fewer, or where one would have less than 1 % of the area. The same input gives the same
/// regions.
///
/// The ensemble E is made of k-means clusterings with different seeds and numbers of clusters; the regions x are the
/// best local minimum found of eq. 2.27, Σ_u d²(E_u, x), and never worse than a member of at most `count` clusters.
///
/// # Errors
/// [`Cancelled`] by `watch`, asked at every round of k-means and every sweep of the descent.
///
/// Source: [RBC14].
pub fn segment(
    signature: MatRef<'_, f64>,
    mass: &[f64],
    count: usize,
    watch: &dyn Watch,
) -> Result<Regions, Cancelled> {
    let count = count.clamp(1, MAX_REGIONS);
    let vertices: Vec<usize> = (0..mass.len()).filter(|&x| mass[x] > 0.0).collect();
    let areas: Vec<f64> = vertices.iter().map(|&x| mass[x]).collect();
    let points = Points::of(signature, &vertices, areas.clone());

    let ensemble = Ensemble::of(&clusterings(&points, count, watch)?, &areas);
    let consensus = consensus(&ensemble, count, watch)?;

    let mut labels = vec![Regions::NONE; mass.len()];
    for (x, label) in vertices.iter().zip(in_order(&ensemble.spread(&consensus), &areas)) {
        labels[*x] = label;
    }
    Ok(Regions { count: labels.iter().max().map_or(0, |&last| (last + 1) as usize), labels })
}

/// The ensemble's members: k-means labels of every point, [`MEMBERS`] times.
fn clusterings(points: &Points, count: usize, watch: &dyn Watch) -> Result<Vec<Vec<Label>>, Cancelled> {
    let steps = (MEMBERS + STARTS) as f64;
    let balls = points.balls();
    (0..MEMBERS)
        .map(|u| {
            let k = (count + u % (2 * SPREAD + 1)).saturating_sub(SPREAD).max(count.min(2));
            let mut random = ChaCha8Rng::seed_from_u64(SEED.wrapping_add(u as u64));
            k_means::labels((points, &balls), k as Label, SAMPLE, &mut random, (watch, u as f64 / steps))
        })
        .collect()
}

/// The partition of least energy among those that descend from the best members of at most `count` clusters.
fn consensus(ensemble: &Ensemble, count: usize, watch: &dyn Watch) -> Result<Vec<usize>, Cancelled> {
    let mut starts: Vec<Partition> = ensemble.members(count).collect();
    starts.sort_by(|a, b| a.energy().total_cmp(&b.energy()));
    starts.truncate(STARTS);
    let bound = starts.first().map_or(0.0, Partition::energy);
    for (s, start) in starts.iter_mut().enumerate() {
        start.descend(watch, (MEMBERS + s) as f64 / (MEMBERS + STARTS) as f64)?;
    }
    let best = starts.into_iter().min_by(|a, b| a.energy().total_cmp(&b.energy()));
    Ok(best.map_or_else(Vec::new, |mut best| {
        best.dissolve_slivers(SLIVER, bound);
        best.into_labels()
    }))
}

/// `labels` with the used ones renumbered from 0 by descending area, of equals the one used first.
fn in_order(labels: &[usize], areas: &[f64]) -> Vec<i32> {
    let mut used: Vec<usize> = Vec::new();
    let mut area = [0.0; MAX_REGIONS];
    for (&label, a) in labels.iter().zip(areas) {
        if !used.contains(&label) {
            used.push(label);
        }
        area[label] += a;
    }
    used.sort_by(|&a, &b| area[b].total_cmp(&area[a]));
    let mut number = [Regions::NONE; MAX_REGIONS];
    for (i, &label) in (0..).zip(&used) {
        number[label] = i;
    }
    labels.iter().map(|&label| number[label]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numerics::Unwatched;
    use faer::Mat;
    use std::f64::consts::PI;
    use std::sync::atomic::{AtomicUsize, Ordering};

    /// Says stop when asked for the given time.
    struct Until(AtomicUsize);

    impl Watch for Until {
        fn proceed(&self, fraction: f64) -> Result<(), Cancelled> {
            assert!((0.0..=1.0).contains(&fraction));
            if self.0.fetch_sub(1, Ordering::Relaxed) == 0 { Err(Cancelled) } else { Ok(()) }
        }
    }

    /// `sizes[b]` points in a small square around each of the `places`.
    fn blobs(places: &[[f64; 2]], sizes: &[usize]) -> Mat<f64> {
        let rows: Vec<[f64; 2]> = places
            .iter()
            .zip(sizes)
            .flat_map(|(place, &size)| {
                (0..size).map(move |i| [place[0] + 0.1 * (i as f64).sin(), place[1] + 0.1 * (i as f64 * 1.7).cos()])
            })
            .collect();
        Mat::from_fn(rows.len(), 2, |i, j| rows[i][j])
    }

    /// Global point signature of a `w` × `h` rectangle under Neumann conditions, on a grid of `nx` × `ny` cells'
    /// centres: φ ~ cos(iπx/w) cos(jπy/h), λ = π² (i²/w² + j²/h²), for the first `d` pairs after the constant.
    fn rectangle([w, h]: [f64; 2], [nx, ny]: [usize; 2], d: usize) -> Mat<f64> {
        let lambda = |(i, j): (usize, usize)| PI * PI * ((i as f64 / w).powi(2) + (j as f64 / h).powi(2));
        let mut modes: Vec<(usize, usize)> = (0..=d).flat_map(|i| (0..=d).map(move |j| (i, j))).skip(1).collect();
        modes.sort_by(|&a, &b| lambda(a).total_cmp(&lambda(b)));
        Mat::from_fn(nx * ny, d, |v, m| {
            let (x, y) = (((v % nx) as f64 + 0.5) / nx as f64, ((v / nx) as f64 + 0.5) / ny as f64);
            let norm = |index: usize| if index == 0 { 1.0 } else { 2f64.sqrt() };
            let (i, j) = modes[m];
            norm(i) * norm(j) * (i as f64 * PI * x).cos() * (j as f64 * PI * y).cos() / (w * h * lambda((i, j))).sqrt()
        })
    }

    #[test]
    fn separated_blobs_are_the_regions_in_order_of_area() {
        let points = blobs(&[[0.0, 0.0], [5.0, 0.0], [0.0, 7.0]], &[20, 30, 40]);
        let regions = segment(points.as_ref(), &[1.0; 90], 3, &Unwatched).unwrap();
        assert_eq!(regions.count(), 3);
        assert_eq!(regions.areas(&[1.0; 90]), [40.0, 30.0, 20.0]);
        assert_eq!((regions.labels()[0], regions.labels()[20], regions.labels()[50]), (2, 1, 0));
    }

    #[test]
    fn fewer_regions_than_asked_for_where_there_are_fewer_places() {
        let points = Mat::from_fn(12, 2, |i, _| (i / 6) as f64);
        assert_eq!(segment(points.as_ref(), &[1.0; 12], 5, &Unwatched).unwrap().count(), 2);
        assert_eq!(segment(points.as_ref(), &[1.0; 12], 1, &Unwatched).unwrap().count(), 1);
        assert_eq!(segment(points.as_ref(), &[1.0; 12], 0, &Unwatched).unwrap().count(), 1);
    }

    #[test]
    fn area_weighs_not_the_number_of_vertices() {
        // Three places a, b, c on a line, two regions. The light vertices at c are many; with their area c may be merged.
        let points = Mat::from_fn(60, 1, |i, _| {
            if i < 5 {
                0.0
            } else if i < 10 {
                2.0
            } else {
                5.0
            }
        });
        let with = |far: f64| {
            let mass: Vec<f64> = (0..60).map(|i| if i < 10 { 1.0 } else { far }).collect();
            segment(points.as_ref(), &mass, 2, &Unwatched).unwrap()
        };
        let (heavy, light) = (with(1.0), with(1e-4));
        assert!(heavy.labels()[0] == heavy.labels()[5] && heavy.labels()[5] != heavy.labels()[10]);
        assert!(light.labels()[0] != light.labels()[5] && light.labels()[5] == light.labels()[10]);
    }

    #[test]
    fn vertices_without_area_are_in_no_region() {
        let points = blobs(&[[0.0, 0.0], [5.0, 0.0]], &[10, 10]);
        let mass: Vec<f64> = (0..20).map(|i| if i % 5 == 0 { 0.0 } else { 1.0 }).collect();
        let regions = segment(points.as_ref(), &mass, 2, &Unwatched).unwrap();
        assert!((0..20).all(|x| (regions.labels()[x] == Regions::NONE) == (x % 5 == 0)));
        assert_eq!(segment(points.as_ref(), &[0.0; 20], 2, &Unwatched).unwrap().count(), 0);
        assert_eq!(segment(Mat::zeros(0, 3).as_ref(), &[], 2, &Unwatched).unwrap().count(), 0);
    }

    #[test]
    fn a_long_rectangle_is_cut_across_into_intervals() {
        let (nx, ny) = (80, 8);
        let signature = rectangle([10.0, 1.0], [nx, ny], 6);
        let regions = segment(signature.as_ref(), &vec![1.0; nx * ny], 4, &Unwatched).unwrap();
        let row = |y: usize| &regions.labels()[y * nx..(y + 1) * nx];
        let mut runs = row(0).to_vec();
        runs.dedup();
        assert_eq!((regions.count(), runs.len()), (4, 4));
        assert!((1..ny).all(|y| row(y) == row(0)));
    }

    #[test]
    fn more_points_than_the_sample_are_cut_like_fewer() {
        let (nx, ny) = (300, 20);
        let signature = rectangle([10.0, 1.0], [nx, ny], 6);
        let regions = segment(signature.as_ref(), &vec![1.0; nx * ny], 4, &Unwatched).unwrap();
        let mut runs = regions.labels()[..nx].to_vec();
        runs.dedup();
        assert_eq!((regions.count(), runs.len()), (4, 4));
    }

    #[test]
    fn a_permuted_shape_has_the_permuted_regions() {
        let points = blobs(&[[0.0, 0.0], [5.0, 0.0], [0.0, 7.0]], &[20, 30, 40]);
        let order: Vec<usize> = (0..90).map(|i| i * 37 % 90).collect();
        let permuted = Mat::from_fn(90, 2, |i, j| points[(order[i], j)]);
        let regions = segment(points.as_ref(), &[1.0; 90], 3, &Unwatched).unwrap();
        let of_permuted = segment(permuted.as_ref(), &[1.0; 90], 3, &Unwatched).unwrap();
        assert!((0..90).all(|i| of_permuted.labels()[i] == regions.labels()[order[i]]));
    }

    #[test]
    fn stops_whenever_the_watcher_says_so() {
        let signature = rectangle([3.0, 2.0], [12, 8], 5);
        let count = AtomicUsize::new(usize::MAX);
        let everything = Until(count);
        segment(signature.as_ref(), &[1.0; 96], 4, &everything).unwrap();
        let asked = usize::MAX - everything.0.into_inner();
        assert!(asked > MEMBERS);
        for time in [0, MEMBERS, asked - 1] {
            let watch = Until(AtomicUsize::new(time));
            assert_eq!(segment(signature.as_ref(), &[1.0; 96], 4, &watch), Err(Cancelled));
        }
    }
}
