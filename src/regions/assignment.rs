//! Which of some centres is nearest to every point, looking at as few distances as the answer needs.
//!
//! Points are looked at in blocks. A bound that spares a block is kept away from what it bounds by more than all
//! rounding, so that the labels are those of looking at every distance, bit for bit.

use crate::numerics::lanes::{self, Kernel, Lanes};

/// Points whose distances to a centre are taken together: as many as stay in registers beside what is known of them.
pub(super) const BLOCK: usize = 16;

/// More than what distances and their differences are rounded by, as a share of the largest in them.
const MARGIN: f64 = 1e-9;

/// More than what underflow takes from a distance.
const UNDERFLOW: f64 = 1e-150;

/// The number of a cluster.
pub(super) type Label = u16;

/// One coordinate of a block of points.
pub(super) type Coordinate = [f64; BLOCK];

/// Blocks of points, d coordinates each, one block after the other.
#[derive(Clone, Copy)]
pub(super) struct Blocks<'a> {
    pub coordinates: &'a [Coordinate],
    pub dimensions: usize,
    pub count: usize,
}

impl<'a> Blocks<'a> {
    #[inline(always)]
    fn block(self, block: usize) -> &'a [Coordinate] {
        &self.coordinates[block * self.dimensions..][..self.dimensions]
    }

    /// The squared distance of every point from `centre`.
    pub(super) fn squared_distances(self, centre: &[f64]) -> Vec<Coordinate> {
        lanes::vectorised(
            #[inline(always)]
            || (0..self.count).map(|block| squared_distances(self.block(block), centre)).collect(),
        )
    }
}

/// Σ_j (x_j − c_j)², in the order of the coordinates.
#[inline(always)]
fn squared_distances(coordinates: &[Coordinate], centre: &[f64]) -> Coordinate {
    let mut distances = [0.0; BLOCK];
    for (coordinate, c) in coordinates.iter().zip(centre) {
        for (distance, x) in distances.iter_mut().zip(coordinate) {
            *distance += (x - c) * (x - c);
        }
    }
    distances
}

/// For every point of a block the first of the nearest centres, the squared distance to it and to the nearest other.
struct Nearest {
    /// As wide as the distances, so that one comparison chooses both.
    labels: [u64; BLOCK],
    least: Coordinate,
    second: Coordinate,
}

impl Nearest {
    const NONE: Nearest = Nearest { labels: [0; BLOCK], least: [f64::INFINITY; BLOCK], second: [f64::INFINITY; BLOCK] };

    #[inline(always)]
    fn offer(&mut self, label: u64, distances: &Coordinate) {
        let Nearest { labels, least, second } = self;
        for l in 0..BLOCK {
            let nearer = distances[l] < least[l];
            let farther = if nearer { least[l] } else { distances[l] };
            second[l] = if farther < second[l] { farther } else { second[l] };
            least[l] = if nearer { distances[l] } else { least[l] };
            labels[l] = if nearer { label } else { labels[l] };
        }
    }
}

/// The labels of points while centres move from round to round.
pub(super) struct Rounds<'a> {
    blocks: Blocks<'a>,
    pub labels: Vec<[Label; BLOCK]>,
    /// How far the centres may have moved, on the scale of `moved`, before a label of a block can change.
    until: Vec<f64>,
    /// What two centres have moved together at most, since the beginning.
    moved: f64,
    /// Whether a point has come to a label or gone from it in the last round.
    pub changed: Vec<bool>,
}

impl<'a> Rounds<'a> {
    /// No point has a label of the `centres` yet.
    pub(super) fn new(blocks: Blocks<'a>, centres: usize) -> Self {
        let (labels, until) = (vec![[Label::MAX; BLOCK]; blocks.count], vec![f64::NEG_INFINITY; blocks.count]);
        Self { blocks, labels, until, moved: 0.0, changed: vec![false; centres] }
    }

    /// Gives every point the label of the first of the nearest `centres`; whether any label changed.
    pub(super) fn assign(&mut self, centres: &[Vec<f64>]) -> bool {
        self.changed.fill(false);
        lanes::run(Round { rounds: self, centres });
        self.changed.contains(&true)
    }

    /// Takes note that every centre has moved from its place `before`.
    pub(super) fn follow(&mut self, before: &[Vec<f64>], centres: &[Vec<f64>]) {
        let distance = |(a, b): (&Vec<f64>, &Vec<f64>)| a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum::<f64>();
        let farthest = before.iter().zip(centres).map(distance).fold(0.0, f64::max).sqrt();
        self.moved += 2.0 * (farthest * (1.0 + MARGIN) + UNDERFLOW);
    }
}

struct Round<'a, 'b> {
    rounds: &'a mut Rounds<'b>,
    centres: &'a [Vec<f64>],
}

impl Kernel for Round<'_, '_> {
    #[inline(always)]
    fn compute<L: Lanes>(self, _: L) {
        let Rounds { blocks, labels, until, moved, changed } = self.rounds;
        for (block, (labels, until)) in labels.iter_mut().zip(until).enumerate() {
            if *moved < *until {
                continue;
            }
            let mut nearest = Nearest::NONE;
            for (label, centre) in (0..).zip(self.centres) {
                nearest.offer(label, &squared_distances(blocks.block(block), centre));
            }
            let mut room = f64::INFINITY;
            for l in 0..BLOCK {
                let (first, second) = (nearest.least[l].sqrt(), nearest.second[l].sqrt());
                let gap = second - first - MARGIN * (second + *moved) - UNDERFLOW;
                // What is not a number, by overflow, leaves no room.
                let gap = if gap > 0.0 { gap } else { 0.0 };
                room = if gap < room { gap } else { room };
            }
            *until = *moved + room;
            let nearest = nearest.labels.map(|label| label as Label);
            for (label, nearest) in labels.iter_mut().zip(nearest).filter(|(label, nearest)| **label != *nearest) {
                for of in [*label, nearest] {
                    if let Some(changed) = changed.get_mut(usize::from(of)) {
                        *changed = true;
                    }
                }
                *label = nearest;
            }
        }
    }
}

/// Balls around blocks of points, told where they are by blocks of their own.
pub(super) struct Balls {
    centres: Vec<Coordinate>,
    radii: Vec<Coordinate>,
}

impl Balls {
    /// The ball around every block: its centre is the mean of the block.
    pub(super) fn around(blocks: Blocks<'_>) -> Balls {
        let (d, count) = (blocks.dimensions, blocks.count.div_ceil(BLOCK));
        let mut balls = Balls { centres: vec![[0.0; BLOCK]; count * d], radii: vec![[0.0; BLOCK]; count] };
        for block in 0..blocks.count {
            let (coordinates, place) = (blocks.block(block), block % BLOCK);
            let mean: Vec<f64> = coordinates.iter().map(|x| x.iter().sum::<f64>() / BLOCK as f64).collect();
            let squared = squared_distances(coordinates, &mean).into_iter().fold(0.0, f64::max);
            balls.radii[block / BLOCK][place] = squared.sqrt() * (1.0 + MARGIN) + UNDERFLOW;
            for (j, mean) in mean.into_iter().enumerate() {
                balls.centres[block / BLOCK * d + j][place] = mean;
            }
        }
        balls
    }
}

/// The label of the first of the nearest `centres` for every point of the blocks in the `balls`.
pub(super) fn labels(blocks: Blocks<'_>, balls: &Balls, centres: &[Vec<f64>]) -> Vec<[Label; BLOCK]> {
    let mut labels = vec![[0; BLOCK]; blocks.count];
    lanes::run(InBalls { blocks, balls, centres, labels: &mut labels });
    labels
}

struct InBalls<'a> {
    blocks: Blocks<'a>,
    balls: &'a Balls,
    centres: &'a [Vec<f64>],
    labels: &'a mut [[Label; BLOCK]],
}

impl Kernel for InBalls<'_> {
    #[inline(always)]
    fn compute<L: Lanes>(self, _: L) {
        let mut distances = vec![[0.0; BLOCK]; self.centres.len()];
        let balls = Blocks { coordinates: &self.balls.centres, count: self.balls.radii.len(), ..self.blocks };
        for (ball, (labels, radii)) in self.labels.chunks_mut(BLOCK).zip(&self.balls.radii).enumerate() {
            let mut nearest = Nearest::NONE;
            for (distances, (label, centre)) in distances.iter_mut().zip((0..).zip(self.centres)) {
                *distances = squared_distances(balls.block(ball), centre);
                nearest.offer(label, distances);
            }
            // A centre farther from the ball's than the nearest by more than the diameter is the nearest of no point.
            let mut reach = [0.0; BLOCK];
            for l in 0..BLOCK {
                let far = nearest.least[l].sqrt() + 2.0 * radii[l];
                reach[l] = far * far * (1.0 + MARGIN);
            }
            for (l, labels) in labels.iter_mut().enumerate() {
                if nearest.second[l] > reach[l] {
                    *labels = [nearest.labels[l] as Label; BLOCK];
                    continue;
                }
                let coordinates = self.blocks.block(ball * BLOCK + l);
                let mut nearest = Nearest::NONE;
                for (distances, (label, centre)) in distances.iter().zip((0..).zip(self.centres)) {
                    if distances[l] > reach[l] {
                        continue;
                    }
                    nearest.offer(label, &squared_distances(coordinates, centre));
                }
                *labels = nearest.labels.map(|label| label as Label);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numerics::random;

    /// Blocks of `count` points near one another, of which some are the same, `d` coordinates each.
    fn blocks(count: usize, d: usize, scale: f64) -> Vec<Coordinate> {
        let noise = random::normal(count * d, BLOCK, 7);
        let place = |block: usize, j: usize| ((block * (j + 3)) as f64 * 0.1).sin();
        let value = |row: usize, l: usize| place(row / d, row % d) + (0.2 * noise[(row, l)]).round() * 0.25;
        (0..count * d).map(|row| std::array::from_fn(|l| scale * value(row, l))).collect()
    }

    /// The first of the nearest centres by every distance, in plain arithmetic.
    fn naive(blocks: Blocks<'_>, centres: &[Vec<f64>]) -> Vec<[Label; BLOCK]> {
        let label = |block: usize, l: usize| {
            let to = |c: &Vec<f64>| blocks.block(block).iter().zip(c).fold(0.0, |sum, (x, c)| sum + (x[l] - c).powi(2));
            let least = centres.iter().map(to).fold(f64::INFINITY, f64::min);
            centres.iter().position(|c| to(c) == least).unwrap_or(0) as Label
        };
        (0..blocks.count).map(|block| std::array::from_fn(|l| label(block, l))).collect()
    }

    /// Centres that are points of some blocks, the first of them twice.
    fn centres(blocks: Blocks<'_>, k: usize) -> Vec<Vec<f64>> {
        let point = |i: usize| blocks.block(i * 7 % blocks.count).iter().map(|x| x[i % BLOCK]).collect();
        (0..k).map(|i| point(if i == k / 2 { 0 } else { i })).collect()
    }

    const SHAPES: [(usize, usize, usize); 6] = [(1, 1, 1), (1, 3, 4), (16, 2, 5), (17, 7, 2), (40, 7, 9), (100, 5, 30)];

    #[test]
    fn labels_are_those_of_looking_at_every_distance() {
        for (count, dimensions, k) in SHAPES {
            for scale in [1.0, 1e-170, 1e-155, 1e150, 1e153, 1e160] {
                let coordinates = blocks(count, dimensions, scale);
                let blocks = Blocks { coordinates: &coordinates, dimensions, count };
                let centres = centres(blocks, k);
                let found = labels(blocks, &Balls::around(blocks), &centres);
                assert_eq!(found, naive(blocks, &centres), "{count} {dimensions} {k} {scale}");
            }
        }
    }

    #[test]
    fn labels_follow_centres_that_move_ever_less() {
        for (count, dimensions, k) in SHAPES {
            let coordinates = blocks(count, dimensions, 1.0);
            let blocks = Blocks { coordinates: &coordinates, dimensions, count };
            let mut centres = centres(blocks, k);
            let mut rounds = Rounds::new(blocks, k);
            for round in 0..20 {
                let before = rounds.labels.clone();
                let any = rounds.assign(&centres);
                assert_eq!(rounds.labels, naive(blocks, &centres), "{count} {dimensions} {k}, round {round}");
                assert_eq!(any, rounds.labels != before);
                for (label, &changed) in (0..).zip(&rounds.changed) {
                    let points = before.as_flattened().iter().zip(rounds.labels.as_flattened());
                    let come_or_gone =
                        points.filter(|(was, is)| was != is).any(|(&was, &is)| [was, is].contains(&label));
                    assert_eq!(changed, come_or_gone);
                }
                let places = centres.clone();
                for (i, centre) in centres.iter_mut().enumerate() {
                    centre.iter_mut().for_each(|c| *c += ((i * round) as f64).sin() * 0.5f64.powi(round as i32));
                }
                rounds.follow(&places, &centres);
            }
        }
    }
}
