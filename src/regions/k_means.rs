//! k-means of weighted points: Lloyd's rounds from k-means++ seeds.

use faer::MatRef;
use rand::{Rng, RngExt};

use crate::numerics::lanes::{self, Kernel, Lanes};
use crate::numerics::{Cancelled, Watch};

/// Points whose distances to a centre are taken together: as many as stay in registers beside what is known of them.
const BLOCK: usize = 16;

/// Lloyd's rounds at most; the assignment has usually settled after 10 to 30.
const ROUNDS: usize = 50;

/// More than what the quotient of a running weight is rounded by, as a share of it.
const MARGIN: f64 = 1e-9;

/// The number of a cluster.
pub(super) type Label = u16;

/// Points of a Euclidean space, each with a weight.
pub(super) struct Points {
    /// The coordinates of block after block of points, dimension by dimension within each; the last block is filled up
    /// with zeros.
    coordinates: Vec<[f64; BLOCK]>,
    dimensions: usize,
    weights: Vec<f64>,
    /// The sum of the weights.
    total: f64,
}

/// For every point its nearest centre, and the squared distance to it.
struct Assignment {
    labels: Vec<Label>,
    distances: Vec<f64>,
}

impl Points {
    /// The rows of `points` (n × d) named by `rows`, weighted by `weights`, one per name.
    pub(super) fn of(points: MatRef<'_, f64>, rows: &[usize], weights: Vec<f64>) -> Self {
        Self::new(points.ncols(), weights, |i, j| points[(rows[i], j)])
    }

    /// The points whose coordinate j is `coordinate(i, j)`, one per weight.
    fn new(dimensions: usize, weights: Vec<f64>, coordinate: impl Fn(usize, usize) -> f64) -> Self {
        let mut coordinates = vec![[0.0; BLOCK]; weights.len().div_ceil(BLOCK) * dimensions];
        for j in 0..dimensions {
            for i in 0..weights.len() {
                coordinates[i / BLOCK * dimensions + j][i % BLOCK] = coordinate(i, j);
            }
        }
        let total = weights.iter().sum();
        Self { coordinates, dimensions, weights, total }
    }

    fn len(&self) -> usize {
        self.weights.len()
    }

    /// About `size` points drawn with probability in proportion to weight, each weighted by how often it was drawn.
    ///
    /// Systematic sampling: marks stand at equal steps of the running weight, the first at a random place.
    fn sample(&self, size: usize, random: &mut impl Rng) -> Self {
        let step = self.total / size as f64;
        let mut running = random.random::<f64>() * step;
        let (mut passed, mut drawn) = ((running / step) as u64, (Vec::new(), Vec::new()));
        let before_next = |passed: u64| (1.0 - MARGIN) * step * (passed + 1) as f64;
        let mut plainly_before = before_next(passed);
        for (i, weight) in self.weights.iter().enumerate() {
            running += weight;
            // Most weights reach no mark, which is told without a division.
            if running < plainly_before {
                continue;
            }
            // What is not negative is rounded down.
            let marks = ((running / step) as u64).saturating_sub(passed);
            if marks > 0 {
                drawn.0.push(i);
                drawn.1.push(marks as f64);
                passed += marks;
                plainly_before = before_next(passed);
            }
        }
        let (rows, weights) = drawn;
        Self::new(self.dimensions, weights, |i, j| self.coordinate(rows[i], j))
    }

    fn coordinate(&self, i: usize, j: usize) -> f64 {
        self.coordinates[i / BLOCK * self.dimensions + j][i % BLOCK]
    }

    fn point(&self, i: usize) -> Vec<f64> {
        (0..self.dimensions).map(|j| self.coordinate(i, j)).collect()
    }

    /// The first of the nearest of `centres`, for every point.
    fn nearest(&self, centres: &[Vec<f64>]) -> Assignment {
        let blocks = self.len().div_ceil(BLOCK);
        let mut labels = vec![[0; BLOCK]; blocks];
        let mut distances = vec![[f64::INFINITY; BLOCK]; blocks];
        lanes::run(Nearest { points: self, centres, labels: &mut labels, distances: &mut distances });
        let (mut labels, mut distances) = (labels.into_flattened(), distances.into_flattened());
        labels.truncate(self.len());
        distances.truncate(self.len());
        Assignment { labels, distances }
    }

    /// k-means++: every centre is a point, drawn in proportion to weight × squared distance to the nearest before it.
    /// Fewer than `k` where fewer places are occupied.
    fn seeds(&self, k: usize, random: &mut impl Rng) -> Vec<Vec<f64>> {
        let mut centres: Vec<Vec<f64>> = Vec::new();
        let mut distances = vec![1.0; self.len()];
        while centres.len() < k {
            let chances: Vec<f64> = self.weights.iter().zip(&distances).map(|(w, d)| w * d).collect();
            let Some(drawn) = draw(&chances, random) else { break };
            let centre = vec![self.point(drawn)];
            let to_it = self.nearest(&centre).distances;
            let known = if centres.is_empty() { &to_it } else { &distances };
            distances = known.iter().zip(&to_it).map(|(a, b)| a.min(*b)).collect();
            centres.extend(centre);
        }
        centres
    }

    /// Moves every centre to the weighted mean of the points labelled with it; one without weight stays.
    fn centre(&self, centres: &mut [Vec<f64>], labels: &[Label]) {
        let mut totals = vec![0.0; centres.len()];
        for (&label, weight) in labels.iter().zip(&self.weights) {
            totals[usize::from(label)] += weight;
        }
        // Point by point: the sums of one label wait for one another, those of its dimensions do not.
        let d = self.dimensions;
        let mut sums = vec![0.0; centres.len() * d];
        for (block, (labels, weights)) in labels.chunks(BLOCK).zip(self.weights.chunks(BLOCK)).enumerate() {
            let coordinates = &self.coordinates[block * d..][..d];
            for (l, (&label, weight)) in labels.iter().zip(weights).enumerate() {
                let sums = &mut sums[usize::from(label) * d..][..d];
                for (sum, coordinate) in sums.iter_mut().zip(coordinates) {
                    *sum += weight * coordinate[l];
                }
            }
        }
        for (label, (centre, total)) in centres.iter_mut().zip(totals).enumerate() {
            if total > 0.0 {
                let sums = &sums[label * d..][..d];
                centre.iter_mut().zip(sums).for_each(|(c, sum)| *c = sum / total);
            }
        }
    }
}

/// Gives every point the label of the first of the nearest centres, and the squared distance to it.
struct Nearest<'a> {
    points: &'a Points,
    centres: &'a [Vec<f64>],
    labels: &'a mut [[Label; BLOCK]],
    distances: &'a mut [[f64; BLOCK]],
}

impl Kernel for Nearest<'_> {
    #[inline(always)]
    fn compute<L: Lanes>(self, _: L) {
        let d = self.points.dimensions;
        for (block, (labels, least)) in self.labels.iter_mut().zip(self.distances).enumerate() {
            let coordinates = &self.points.coordinates[block * d..][..d];
            // As wide as the distances, so that one comparison chooses both.
            let mut nearest = [0u64; BLOCK];
            for (label, centre) in (0..).zip(self.centres) {
                let mut distances = [0.0; BLOCK];
                for (coordinate, c) in coordinates.iter().zip(centre) {
                    for (distance, x) in distances.iter_mut().zip(coordinate) {
                        *distance += (x - c) * (x - c);
                    }
                }
                for l in 0..BLOCK {
                    let nearer = distances[l] < least[l];
                    least[l] = if nearer { distances[l] } else { least[l] };
                    nearest[l] = if nearer { label } else { nearest[l] };
                }
            }
            *labels = nearest.map(|label| label as Label);
        }
    }
}

/// An index with probability in proportion to `chances`; none where they sum to 0.
fn draw(chances: &[f64], random: &mut impl Rng) -> Option<usize> {
    let mut left = random.random::<f64>() * chances.iter().sum::<f64>();
    let mut last = None;
    for (i, &chance) in chances.iter().enumerate().filter(|(_, chance)| **chance > 0.0) {
        last = Some(i);
        left -= chance;
        if left < 0.0 {
            break;
        }
    }
    last
}

/// Labels below `k`, one per point, that lower Σ weight · ‖point − mean of its label‖² (eq. 2.25 of the thesis) until
/// they no longer change; some may be used by no point.
///
/// The means settle on a sample of about `sample` points where there are more, and every point then takes the label of
/// the nearest mean: the time no longer grows with rounds × points.
///
/// # Errors
/// [`Cancelled`] by `watch`, asked at every round whether to go on at `fraction`.
///
/// Source: [AV07] for the seeds.
pub(super) fn labels(
    points: &Points,
    k: Label,
    sample: usize,
    random: &mut impl Rng,
    (watch, fraction): (&dyn Watch, f64),
) -> Result<Vec<Label>, Cancelled> {
    let sampled = (points.len() > sample).then(|| points.sample(sample, random));
    let basis = sampled.as_ref().unwrap_or(points);

    let mut centres = basis.seeds(usize::from(k), random);
    let mut labels = Vec::new();
    for _ in 0..ROUNDS {
        watch.proceed(fraction)?;
        let before = std::mem::replace(&mut labels, basis.nearest(&centres).labels);
        if before == labels {
            break;
        }
        basis.centre(&mut centres, &labels);
    }
    Ok(points.nearest(&centres).labels)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numerics::Unwatched;
    use faer::Mat;
    use rand_chacha::{ChaCha8Rng, rand_core::SeedableRng};

    fn line(coordinates: &[f64], weights: &[f64]) -> Points {
        let points = Mat::from_fn(coordinates.len(), 1, |i, _| coordinates[i]);
        let rows: Vec<usize> = (0..coordinates.len()).collect();
        Points::of(points.as_ref(), &rows, weights.to_vec())
    }

    fn clustered(points: &Points, k: Label, seed: u64) -> Vec<Label> {
        labels(points, k, 1000, &mut ChaCha8Rng::seed_from_u64(seed), (&Unwatched, 0.0)).unwrap()
    }

    #[test]
    fn the_first_of_the_nearest_centres_is_told_bit_for_bit() {
        for (n, d) in [(1, 1), (BLOCK, 3), (2 * BLOCK + 5, 7)] {
            let points = Mat::from_fn(n, d, |i, j| ((i * (j + 3)) as f64).sin().round() + (i / 9) as f64 * 0.1);
            let rows: Vec<usize> = (0..n).collect();
            let centres: Vec<Vec<f64>> = [0, n / 2, 0, n - 1].map(|i| points.row(i).iter().copied().collect()).to_vec();
            let Assignment { labels, distances } = Points::of(points.as_ref(), &rows, vec![1.0; n]).nearest(&centres);
            assert_eq!((labels.len(), distances.len()), (n, n));
            for i in 0..n {
                let to = |c: &Vec<f64>| (0..d).fold(0.0, |sum, j| sum + (points[(i, j)] - c[j]).powi(2));
                let least = centres.iter().map(to).fold(f64::INFINITY, f64::min);
                let first = centres.iter().position(|c| to(c) == least).unwrap();
                assert_eq!((usize::from(labels[i]), distances[i]), (first, least));
            }
        }
    }

    #[test]
    fn separated_blobs_are_found_whatever_the_seed() {
        let points = line(&[0.0, 0.1, 5.0, 5.1, 9.0, 9.1], &[1.0; 6]);
        for seed in 0..20 {
            let labels = clustered(&points, 3, seed);
            assert!(labels[0] == labels[1] && labels[2] == labels[3] && labels[4] == labels[5]);
            assert!(labels[0] != labels[2] && labels[2] != labels[4] && labels[4] != labels[0]);
        }
    }

    #[test]
    fn weight_decides_where_two_means_part_three_points() {
        // Cost of the split a | b c is w_b w_c / (w_b + w_c) · 1², of a b | c it is w_a w_b / (w_a + w_b) · 1.2².
        for seed in 0..20 {
            let light = clustered(&line(&[0.0, 1.2, 2.2], &[1.0, 1.0, 1.0]), 2, seed);
            assert!(light[0] != light[1] || light[1] != light[2]);
        }
        let cost = |points: &Points, labels: &[Label]| {
            let mut centres = vec![vec![0.0]; 2];
            points.centre(&mut centres, labels);
            labels
                .iter()
                .enumerate()
                .map(|(i, &l)| points.weights[i] * (points.point(i)[0] - centres[usize::from(l)][0]).powi(2))
                .sum::<f64>()
        };
        let heavy_end = line(&[0.0, 1.2, 2.2], &[1.0, 5.0, 100.0]);
        assert!(cost(&heavy_end, &[0, 0, 1]) < cost(&heavy_end, &[0, 1, 1]));
        let best = (0..20)
            .map(|seed| clustered(&heavy_end, 2, seed))
            .min_by(|a, b| cost(&heavy_end, a).total_cmp(&cost(&heavy_end, b)));
        let best = best.unwrap();
        assert!(best[0] == best[1] && best[1] != best[2]);
    }

    #[test]
    fn fewer_places_than_means_give_fewer_labels() {
        assert_eq!(clustered(&line(&[3.0; 5], &[1.0; 5]), 4, 0), [0; 5]);
        let mut labels = clustered(&line(&[3.0, 3.0, 4.0], &[1.0; 3]), 3, 0);
        labels.dedup();
        assert_eq!(labels.len(), 2);
    }

    #[test]
    fn points_without_dimensions_are_one_blob() {
        let points = Points::of(Mat::<f64>::zeros(3, 0).as_ref(), &[0, 1, 2], vec![1.0; 3]);
        assert_eq!(clustered(&points, 2, 0), [0; 3]);
    }

    #[test]
    fn a_sample_has_the_asked_weight_and_follows_the_weights() {
        let weights: Vec<f64> = (0..1000).map(|i| if i < 500 { 3.0 } else { 1.0 }).collect();
        let points = line(&(0..1000).map(f64::from).collect::<Vec<_>>(), &weights);
        let sample = points.sample(200, &mut ChaCha8Rng::seed_from_u64(1));
        assert!((sample.weights.iter().sum::<f64>() - 200.0).abs() <= 1.0);
        let heavy = sample.coordinates.as_flattened().iter().zip(&sample.weights);
        let heavy = heavy.filter(|(x, _)| **x < 500.0).map(|(_, w)| w);
        assert!((heavy.sum::<f64>() - 150.0).abs() <= 1.0);
    }

    #[test]
    fn a_sample_is_what_a_division_per_weight_draws() {
        for (seed, size) in [(1, 7), (2, 50), (3, 299), (4, 1000)] {
            let weights: Vec<f64> = (0..300).map(|i| f64::from(i % 7) + if i == 40 { 90.0 } else { 0.0 }).collect();
            let points = line(&(0..300).map(f64::from).collect::<Vec<_>>(), &weights);
            let step = weights.iter().sum::<f64>() / size as f64;
            let mut running = ChaCha8Rng::seed_from_u64(seed).random::<f64>() * step;
            let mut naive = Vec::new();
            for (i, weight) in weights.iter().enumerate() {
                let before = (running / step).floor();
                running += weight;
                let marks = (running / step).floor() - before;
                naive.extend((marks > 0.0).then_some((i as f64, marks)));
            }
            let sample = points.sample(size, &mut ChaCha8Rng::seed_from_u64(seed));
            let drawn: Vec<_> = (0..sample.len()).map(|s| (sample.coordinate(s, 0), sample.weights[s])).collect();
            assert_eq!(drawn, naive);
        }
    }

    #[test]
    fn means_of_a_sample_label_all_points() {
        let coordinates: Vec<f64> = (0..900).map(|i| f64::from(i / 300) * 10.0 + f64::from(i % 300) / 300.0).collect();
        let points = line(&coordinates, &[1.0; 900]);
        let random = &mut ChaCha8Rng::seed_from_u64(5);
        let labels = labels(&points, 3, 100, random, (&Unwatched, 0.0)).unwrap();
        let mut runs = labels.clone();
        runs.dedup();
        assert_eq!((labels.len(), runs.len()), (900, 3));
    }
}
