//! k-means of weighted points: Lloyd's rounds from k-means++ seeds.

use faer::MatRef;
use rand::{Rng, RngExt};

use super::assignment::{self, BLOCK, Balls, Blocks, Coordinate, Label, Rounds};
use crate::numerics::{Cancelled, Watch};

/// Lloyd's rounds at most; the assignment has usually settled after 10 to 30.
const ROUNDS: usize = 50;

/// More than what the quotient of a running weight is rounded by, as a share of it.
const MARGIN: f64 = 1e-9;

/// Points of a Euclidean space, each with a weight.
pub(super) struct Points {
    /// The coordinates of block after block of points, dimension by dimension within each; the last block is filled up
    /// with its last point.
    coordinates: Vec<Coordinate>,
    dimensions: usize,
    weights: Vec<f64>,
    /// The sum of the weights.
    total: f64,
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
            for i in 0..weights.len().next_multiple_of(BLOCK) {
                coordinates[i / BLOCK * dimensions + j][i % BLOCK] = coordinate(i.min(weights.len() - 1), j);
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

    fn blocks(&self) -> Blocks<'_> {
        let count = self.len().div_ceil(BLOCK);
        Blocks { coordinates: &self.coordinates, dimensions: self.dimensions, count }
    }

    /// k-means++: every centre is a point, drawn in proportion to weight × squared distance to the nearest before it.
    /// Fewer than `k` where fewer places are occupied.
    fn seeds(&self, k: usize, random: &mut impl Rng) -> Vec<Vec<f64>> {
        let mut centres: Vec<Vec<f64>> = Vec::new();
        let mut distances = vec![1.0; self.len()];
        while centres.len() < k {
            let chances: Vec<f64> = self.weights.iter().zip(&distances).map(|(w, d)| w * d).collect();
            let Some(drawn) = draw(&chances, random) else { break };
            let centre = self.point(drawn);
            let to_it = self.blocks().squared_distances(&centre);
            let to_it = to_it.as_flattened();
            let known = if centres.is_empty() { to_it } else { &distances };
            distances = known.iter().zip(to_it).map(|(a, b)| a.min(*b)).collect();
            centres.push(centre);
        }
        centres
    }

    /// Balls around the blocks of points, for [`labels`].
    pub(super) fn balls(&self) -> Balls {
        Balls::around(self.blocks())
    }

    /// Weight × coordinates and the weight itself of every point, four numbers at a time; and how many fours a point has.
    fn moments(&self) -> (Vec<[f64; 4]>, usize) {
        let fours = self.dimensions / 4 + 1;
        let mut moments = vec![[0.0; 4]; self.len() * fours];
        for (i, (moments, weight)) in moments.chunks_exact_mut(fours).zip(&self.weights).enumerate() {
            let moments = moments.as_flattened_mut();
            for (j, moment) in moments[..self.dimensions].iter_mut().enumerate() {
                *moment = weight * self.coordinate(i, j);
            }
            moments[self.dimensions] = *weight;
        }
        (moments, fours)
    }
}

/// Moves the centres whose points have `changed` to the weighted mean of the points labelled with them; one without
/// weight stays.
fn centre(centres: &mut [Vec<f64>], labels: &[Label], changed: &[bool], (moments, fours): (&[[f64; 4]], usize)) {
    let mut sums = vec![[0.0; 4]; centres.len() * fours];
    for (&label, moments) in labels.iter().zip(moments.chunks_exact(fours)) {
        let label = usize::from(label);
        if changed[label] {
            for (sums, moments) in sums[label * fours..][..fours].iter_mut().zip(moments) {
                for l in 0..4 {
                    sums[l] += moments[l];
                }
            }
        }
    }
    for (label, centre) in centres.iter_mut().enumerate() {
        let sums = sums[label * fours..][..fours].as_flattened();
        let total = sums[centre.len()];
        if total > 0.0 {
            centre.iter_mut().zip(sums).for_each(|(c, sum)| *c = sum / total);
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
    (points, balls): (&Points, &Balls),
    k: Label,
    sample: usize,
    random: &mut impl Rng,
    (watch, fraction): (&dyn Watch, f64),
) -> Result<Vec<Label>, Cancelled> {
    let sampled = (points.len() > sample).then(|| points.sample(sample, random));
    let basis = sampled.as_ref().unwrap_or(points);

    let mut centres = basis.seeds(usize::from(k), random);
    let (moments, fours) = basis.moments();
    let mut rounds = Rounds::new(basis.blocks(), centres.len());
    for _ in 0..ROUNDS {
        watch.proceed(fraction)?;
        if !rounds.assign(&centres) {
            break;
        }
        let before = centres.clone();
        centre(&mut centres, rounds.labels.as_flattened(), &rounds.changed, (&moments, fours));
        rounds.follow(&before, &centres);
    }
    let mut labels = assignment::labels(points.blocks(), balls, &centres).into_flattened();
    labels.truncate(points.len());
    Ok(labels)
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
        labels((points, &points.balls()), k, 1000, &mut ChaCha8Rng::seed_from_u64(seed), (&Unwatched, 0.0)).unwrap()
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
            let (moments, fours) = points.moments();
            centre(&mut centres, labels, &[true; 2], (&moments, fours));
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
        let labels = labels((&points, &points.balls()), 3, 100, random, (&Unwatched, 0.0)).unwrap();
        let mut runs = labels.clone();
        runs.dedup();
        assert_eq!((labels.len(), runs.len()), (900, 3));
    }
}
