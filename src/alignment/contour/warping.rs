//! Cyclic dynamic time warping of one contour onto another [SC78].

use super::shape_context::BINS;
use super::{Contour, SAMPLES};
use crate::numerics::lanes::vectorised;

/// Samples more different than this are as bad as can be: a part that is missing costs its length, no more.
pub const TRUNCATE: f32 = 0.4;

/// Price of going on along one contour alone, beside the differences of samples.
const SKIP: f32 = 0.05;

/// Starting samples looked at together.
const LANES: usize = 32;

/// Terms of a sum added side by side.
const WIDTH: usize = 8;

/// What the two cues of a sample weigh in the difference of two: what it sees of the others (½χ², up to 1), and
/// how thick the figure is there (a difference of logarithms).
const CONTEXT: f32 = 0.6;
const THICKNESS: f32 = 0.18;

/// How different every two samples are, in [0, 0.4]: ½χ² between their histograms and the difference of their
/// thicknesses, a factor of e or more counting as 1, weighted and held below 0.4. 110 × 110, row = sample of `a`, column = sample of `b`.
pub fn differences(a: &Contour, b: &Contour) -> Vec<f32> {
    let rows = a.histograms.as_chunks::<BINS>().0;
    let columns = Columns::of(&b.histograms);
    let mut differences = vec![0.0; SAMPLES * SAMPLES];
    vectorised(
        #[inline(always)]
        || {
            for ((out, row), own) in differences.chunks_exact_mut(SAMPLES).zip(rows).zip(&a.thickness) {
                let chi = columns.chi_squared(row);
                for j in 0..SAMPLES {
                    let thickness = (own - b.thickness[j]).abs().min(1.0);
                    out[j] = least(CONTEXT * (0.5 * chi[j]) + THICKNESS * thickness, TRUNCATE);
                }
            }
        },
    );
    differences
}

/// The histograms of all samples of a contour, bin by bin.
struct Columns {
    bins: Vec<[f32; SAMPLES]>,
    /// The terms of χ² where the other histogram is empty, which is the case for about half the bins.
    alone: Vec<[f32; SAMPLES]>,
}

impl Columns {
    fn of(histograms: &[f32]) -> Columns {
        let samples = histograms.as_chunks::<BINS>().0;
        let mut bins = vec![[0.0; SAMPLES]; BINS];
        for (bin, column) in bins.iter_mut().enumerate() {
            column.iter_mut().zip(samples).for_each(|(value, sample)| *value = sample[bin]);
        }
        let alone = bins.iter().map(|column| column.map(|q| term(0.0, q))).collect();
        Columns { bins, alone }
    }

    /// χ² between a histogram and every sample's, the terms of every eighth bin summed up before these sums are.
    #[inline(always)]
    fn chi_squared(&self, histogram: &[f32; BINS]) -> [f32; SAMPLES] {
        let mut total = [0.0; SAMPLES];
        for first in 0..WIDTH {
            let mut sum = [0.0; SAMPLES];
            for bin in (first..BINS).step_by(WIDTH) {
                let (p, column) = (histogram[bin], &self.bins[bin]);
                if p == 0.0 {
                    let alone = &self.alone[bin];
                    (0..SAMPLES).for_each(
                        #[inline(always)]
                        |j| sum[j] += alone[j],
                    );
                } else {
                    (0..SAMPLES).for_each(
                        #[inline(always)]
                        |j| sum[j] += term(p, column[j]),
                    );
                }
            }
            for j in 0..SAMPLES {
                total[j] += sum[j];
            }
        }
        total
    }
}

#[inline(always)]
fn term(p: f32, q: f32) -> f32 {
    let difference = p - q;
    // Where both are 0, so is the term.
    difference * difference / (p + q + f32::MIN_POSITIVE)
}

/// Cost per sample, in [0, 0.4], of the cheapest cyclic warp that begins with sample 0 of `a` and one of the samples 0,
/// `every`, 2 · `every`, … of `b`, for `differences` of 110 × 110. A step along both contours costs twice the
/// difference, a step along one the difference and 0.05.
pub fn cost(differences: &[f32], every: usize) -> f64 {
    cheapest(differences, every).0
}

/// A warp of one closed contour onto another.
#[derive(Clone, Debug, PartialEq)]
pub struct Warp {
    /// Per sample, as [`cost`] at every start.
    pub cost: f64,
    /// Pairs of samples, of `a` and of `b`, that lie on each other. The first index runs from 0 to 109, the second once
    /// round from wherever it begins; a step moves one of them or both by 1.
    pub path: Vec<(usize, usize)>,
}

/// The cheapest cyclic warp, for `differences` of 110 × 110.
pub fn warp(differences: &[f32]) -> Warp {
    let (cost, start) = cheapest(differences, 1);
    let difference = |i: usize, j: usize| differences[i * SAMPLES + (j + start) % SAMPLES];
    let mut table = vec![[f32::INFINITY; SAMPLES]; SAMPLES];
    for i in 0..SAMPLES {
        for j in 0..SAMPLES {
            let c = difference(i, j);
            let [both, first, second] = arrivals(&table, i, j);
            table[i][j] = least(both + 2.0 * c, least(first, second) + (c + SKIP));
        }
    }
    let (mut i, mut j) = (SAMPLES - 1, SAMPLES - 1);
    let mut path = vec![(i, (j + start) % SAMPLES)];
    while (i, j) != (0, 0) {
        let c = difference(i, j);
        let [both, first, second] = arrivals(&table, i, j);
        let [both, first, second] = [both + 2.0 * c, first + (c + SKIP), second + (c + SKIP)];
        // An arrival over the edge of the table is infinite, hence never the least.
        (i, j) = match (both <= first && both <= second, first <= second) {
            (true, _) => (i - 1, j - 1),
            (false, true) => (i - 1, j),
            (false, false) => (i, j - 1),
        };
        path.push((i, (j + start) % SAMPLES));
    }
    path.reverse();
    Warp { cost, path }
}

/// What a path costs per sample for other differences than those it is the cheapest for.
pub fn cost_along(path: &[(usize, usize)], differences: &[f32]) -> f64 {
    let difference = |&(i, j): &(usize, usize)| differences[i * SAMPLES + j];
    let both = |a: &(usize, usize), b: &(usize, usize)| a.0 != b.0 && a.1 != b.1;
    let first = path.first().map_or(0.0, |pair| 2.0 * difference(pair));
    let step = |step: &[(usize, usize)]| {
        let c = difference(&step[1]);
        if both(&step[0], &step[1]) { 2.0 * c } else { c + SKIP }
    };
    f64::from(first + path.windows(2).map(step).sum::<f32>()) / (2 * SAMPLES) as f64
}

/// Costs before the last step to a pair: a step along both, along the first, along the second contour. Infinite where
/// there is none; the first pair is reached along both for nothing.
fn arrivals(table: &[[f32; SAMPLES]], i: usize, j: usize) -> [f32; 3] {
    let at = |i: Option<usize>, j: Option<usize>| match (i, j) {
        (Some(i), Some(j)) => table[i][j],
        _ => f32::INFINITY,
    };
    let (before, left) = (i.checked_sub(1), j.checked_sub(1));
    let both = if (i, j) == (0, 0) { 0.0 } else { at(before, left) };
    [both, at(before, Some(j)), at(Some(i), left)]
}

/// The least cost per sample over the starts, and its start.
fn cheapest(differences: &[f32], every: usize) -> (f64, usize) {
    let every = every.clamp(1, SAMPLES);
    let strided = Strided::of(differences, every);
    let (mut best, mut start) = (f32::INFINITY, 0);
    for first in (0..SAMPLES).step_by(every * LANES) {
        let starts = (first..SAMPLES).step_by(every);
        let totals = vectorised(
            #[inline(always)]
            || strided.totals(first),
        );
        for (start_here, total) in starts.zip(totals) {
            if total < best {
                (best, start) = (total, start_here);
            }
        }
    }
    (f64::from(best) / (2 * SAMPLES) as f64, start)
}

/// Differences in an order in which those that the lanes need at a time are side by side.
struct Strided {
    every: usize,
    /// Entries per sample of `a`, and per remainder of the column by `every`.
    row: usize,
    part: usize,
    values: Vec<f32>,
}

impl Strided {
    fn of(differences: &[f32], every: usize) -> Strided {
        let part = 2 * SAMPLES / every + LANES + 1;
        let row = every * part;
        let mut values = Vec::with_capacity(SAMPLES * row);
        for differences in differences.chunks_exact(SAMPLES) {
            for remainder in 0..every {
                let columns = (remainder..).step_by(every).take(part);
                values.extend(columns.map(|column| differences[column % SAMPLES]));
            }
        }
        Strided { every, row, part, values }
    }

    /// Differences of sample i of `a` from the samples column, column + every, column + 2 · every, … of `b`.
    #[inline(always)]
    fn lanes(&self, i: usize, column: usize) -> &[f32; LANES] {
        let at = i * self.row + column % self.every * self.part + column / self.every;
        self.values[at..].first_chunk().expect("rows are long enough for the last lane of the last column")
    }

    /// The costs of the cheapest warps that begin at the samples first, first + every, … of `b`. Starts above 109 are
    /// those of another turn.
    #[inline(always)]
    fn totals(&self, first: usize) -> [f32; LANES] {
        let mut reached = [[f32::INFINITY; LANES]; SAMPLES + 1];
        reached[0] = [0.0; LANES];
        for i in 0..SAMPLES {
            let mut both = std::mem::replace(&mut reached[0], [f32::INFINITY; LANES]);
            let mut second = reached[0];
            for j in 0..SAMPLES {
                let differences = self.lanes(i, first + j);
                let along = reached[j + 1];
                for lane in 0..LANES {
                    let c = differences[lane];
                    // The one that has to wait for the sample before comes last.
                    let ready = least(both[lane] + 2.0 * c, along[lane] + (c + SKIP));
                    second[lane] = least(ready, second[lane] + (c + SKIP));
                }
                both = along;
                reached[j + 1] = second;
            }
        }
        reached[SAMPLES]
    }
}

/// One instruction, unlike `f32::min`, which minds what is not a number.
#[inline(always)]
fn least(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::*;

    fn random_differences(seed: u64) -> Vec<f32> {
        let mut source = ChaCha8Rng::seed_from_u64(seed);
        let offset = source.random_range(0..SAMPLES);
        let near = |i: usize, j: usize| (j + SAMPLES - i + offset) % SAMPLES < 9;
        let cell =
            |k: usize| (source.random::<f32>() * if near(k / SAMPLES, k % SAMPLES) { 0.2 } else { 0.7 }).min(TRUNCATE);
        (0..SAMPLES * SAMPLES).map(cell).collect()
    }

    fn naive(differences: &[f32], start: usize) -> f64 {
        let mut table = vec![vec![f64::INFINITY; SAMPLES + 1]; SAMPLES + 1];
        table[0][0] = 0.0;
        for i in 0..SAMPLES {
            for j in 0..SAMPLES {
                let c = f64::from(differences[i * SAMPLES + (j + start) % SAMPLES]);
                let one = table[i][j + 1].min(table[i + 1][j]) + c + 0.05;
                table[i + 1][j + 1] = one.min(table[i][j] + 2.0 * c);
            }
        }
        table[SAMPLES][SAMPLES] / 220.0
    }

    #[test]
    fn chi_squared_is_that_of_single_pairs() {
        let mut source = ChaCha8Rng::seed_from_u64(9);
        let mut entry = || if source.random_bool(0.5) { 0.0 } else { source.random::<f32>() };
        let histograms: Vec<f32> = (0..SAMPLES * BINS).map(|_| entry()).collect();
        let row: [f32; BINS] = std::array::from_fn(|_| entry());
        let found = Columns::of(&histograms).chi_squared(&row);
        for (sample, found) in histograms.as_chunks::<BINS>().0.iter().zip(found) {
            let part = |first: usize| (first..BINS).step_by(WIDTH).map(|bin| term(row[bin], sample[bin])).sum::<f32>();
            assert_eq!((0..WIDTH).map(part).sum::<f32>(), found);
        }
    }

    #[test]
    fn the_cost_is_the_least_of_the_tables() {
        for seed in 1..4 {
            let differences = random_differences(seed);
            for every in [1, 2, 3, 4, 7, 200] {
                let least = (0..SAMPLES).step_by(every).map(|start| naive(&differences, start)).fold(1.0, f64::min);
                assert!((cost(&differences, every) - least).abs() < 1e-5, "{every}");
            }
        }
    }

    #[test]
    fn the_path_goes_once_round_and_has_the_cost() {
        for seed in 4..7 {
            let differences = random_differences(seed);
            let Warp { cost, path } = warp(&differences);
            let (first, last) = (path[0], path[path.len() - 1]);
            assert_eq!((first.0, last.0, (last.1 + 1) % SAMPLES), (0, SAMPLES - 1, first.1));
            let difference = |&(i, j): &(usize, usize)| f64::from(differences[i * SAMPLES + j]);
            let mut total = 2.0 * difference(&first);
            let mut round = 0;
            for step in path.windows(2) {
                let along = [step[1].0 - step[0].0, (step[1].1 + SAMPLES - step[0].1) % SAMPLES];
                assert!(along.iter().all(|&along| along <= 1) && along != [0, 0]);
                total += if along == [1, 1] { 2.0 * difference(&step[1]) } else { difference(&step[1]) + 0.05 };
                round += along[1];
            }
            assert_eq!(round, SAMPLES - 1);
            assert!((total / 220.0 - cost).abs() < 1e-5 && cost < 0.2);
            assert!((cost_along(&path, &differences) - cost).abs() < 1e-5);
            // Differences that are larger by 0.1 cost as much more on every path.
            let dearer: Vec<f32> = differences.iter().map(|d| d + 0.1).collect();
            assert!((cost_along(&path, &dearer) - cost - 0.1).abs() < 1e-5);
        }
    }
}
