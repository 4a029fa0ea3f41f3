//! Rings with fewer points that bound nearly the same figure.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use super::ring::{cross, difference};

/// Looks at a point or at a row of cells, per point of a drawing, for all its simplifications together; more are only
/// needed by drawings made to need them, which then stay less simple than asked.
const LOOKS_PER_POINT: usize = 1000;

/// Most looks that simplifications of a drawing may take together.
pub(super) fn looks(rings: &[Vec<[f64; 2]>]) -> usize {
    LOOKS_PER_POINT * rings.iter().map(Vec::len).sum::<usize>()
}

/// The rings after removing, smallest first, every corner whose triangle with its neighbours is smaller than `area`
/// [VW93]. A corner stays while another point lies in its triangle, so that rings that met nowhere still meet nowhere
/// and are nested as before; every ring keeps at least three points. Each look is taken off `looks`; without
/// any left, corners stay.
pub(super) fn simplified(rings: &[Vec<[f64; 2]>], area: f64, looks: &mut usize) -> Vec<Vec<[f64; 2]>> {
    let mut outline = Outline::new(rings);
    let mut queue: BinaryHeap<Reverse<Entry>> = BinaryHeap::new();
    for point in 0..outline.points.len() {
        queue.extend(outline.entry(point, area).map(Reverse));
    }
    while let Some(Reverse(entry)) = queue.pop() {
        let point = entry.point;
        if outline.version[point] != entry.version || outline.remaining[outline.ring[point]] <= 3 {
            continue;
        }
        if outline.is_blocked(point, looks) {
            continue;
        }
        for neighbour in outline.remove(point) {
            queue.extend(outline.entry(neighbour, area).map(Reverse));
        }
    }
    outline.rings()
}

/// A corner that may go, in the order of going.
#[derive(PartialEq, Eq, PartialOrd, Ord)]
struct Entry {
    /// Bits of the triangle's area: areas are not negative, so that they sort as the numbers do.
    area: u64,
    point: usize,
    version: u32,
}

/// All points of all rings, linked both ways.
struct Outline {
    points: Vec<[f64; 2]>,
    ring: Vec<usize>,
    next: Vec<usize>,
    previous: Vec<usize>,
    /// Raised when a neighbour goes; `GONE` when the point itself has gone.
    version: Vec<u32>,
    /// Points left per ring.
    remaining: Vec<usize>,
    grid: Grid,
}

const GONE: u32 = u32::MAX;

impl Outline {
    fn new(rings: &[Vec<[f64; 2]>]) -> Self {
        let points: Vec<[f64; 2]> = rings.iter().flatten().copied().collect();
        let n = points.len();
        let (mut ring, mut next, mut previous) = (vec![0; n], vec![0; n], vec![0; n]);
        let mut start = 0;
        for (index, members) in rings.iter().enumerate() {
            let len = members.len();
            for i in 0..len {
                ring[start + i] = index;
                next[start + i] = start + (i + 1) % len;
                previous[start + i] = start + (i + len - 1) % len;
            }
            start += len;
        }
        let grid = Grid::new(&points);
        Self {
            points,
            ring,
            next,
            previous,
            version: vec![0; n],
            remaining: rings.iter().map(Vec::len).collect(),
            grid,
        }
    }

    fn triangle(&self, point: usize) -> [usize; 3] {
        [self.previous[point], point, self.next[point]]
    }

    fn entry(&self, point: usize, limit: f64) -> Option<Entry> {
        let [a, b, c] = self.triangle(point).map(|i| self.points[i]);
        let area = 0.5 * cross(difference(b, a), difference(c, a)).abs();
        (area < limit).then(|| Entry { area: area.to_bits(), point, version: self.version[point] })
    }

    /// Whether another point lies in the corner's triangle, its sides included, or too many were asked about already.
    fn is_blocked(&self, point: usize, looks: &mut usize) -> bool {
        let corners = self.triangle(point);
        let triangle = corners.map(|i| self.points[i]);
        *looks = looks.saturating_sub(self.grid.rows(triangle).count());
        *looks == 0
            || self.grid.any_in(triangle, |candidate| {
                *looks = looks.saturating_sub(1);
                let other = self.version[candidate] != GONE && !corners.contains(&candidate);
                *looks == 0 || other && contains(triangle, self.points[candidate])
            })
    }

    /// Takes a point out and returns its former neighbours.
    fn remove(&mut self, point: usize) -> [usize; 2] {
        let [before, _, after] = self.triangle(point);
        self.next[before] = after;
        self.previous[after] = before;
        self.version[point] = GONE;
        self.version[before] += 1;
        self.version[after] += 1;
        self.remaining[self.ring[point]] -= 1;
        [before, after]
    }

    fn rings(&self) -> Vec<Vec<[f64; 2]>> {
        let mut rings: Vec<Vec<[f64; 2]>> = self.remaining.iter().map(|&n| Vec::with_capacity(n)).collect();
        for (i, &point) in self.points.iter().enumerate() {
            if self.version[i] != GONE {
                rings[self.ring[i]].push(point);
            }
        }
        rings
    }
}

/// Whether the closed triangle contains the point, whichever way it is wound.
fn contains([a, b, c]: [[f64; 2]; 3], p: [f64; 2]) -> bool {
    let sides = [(a, b), (b, c), (c, a)].map(|(from, to)| cross(difference(to, from), difference(p, from)));
    sides.iter().all(|&s| s >= 0.0) || sides.iter().all(|&s| s <= 0.0)
}

/// Points sorted into the cells of a square grid, about one a cell.
struct Grid {
    low: [f64; 2],
    cell: f64,
    side: usize,
    /// Where a cell's points start in `members`; one more at the end.
    starts: Vec<usize>,
    members: Vec<usize>,
}

impl Grid {
    fn new(points: &[[f64; 2]]) -> Self {
        let low = [0, 1].map(|axis| points.iter().map(|p| p[axis]).fold(f64::INFINITY, f64::min));
        let high = [0, 1].map(|axis| points.iter().map(|p| p[axis]).fold(f64::NEG_INFINITY, f64::max));
        let side = points.len().isqrt().max(1);
        let extent = (high[0] - low[0]).max(high[1] - low[1]).max(f64::MIN_POSITIVE);
        let mut grid =
            Self { low, cell: extent / side as f64, side, starts: vec![0; side * side + 1], members: Vec::new() };
        let cells: Vec<usize> = points.iter().map(|p| grid.row(p[1]) * side + grid.column(p[0])).collect();
        cells.iter().for_each(|&cell| grid.starts[cell + 1] += 1);
        for cell in 0..side * side {
            grid.starts[cell + 1] += grid.starts[cell];
        }
        grid.members = (0..points.len()).collect();
        grid.members.sort_by_key(|&point| cells[point]);
        grid
    }

    fn column(&self, x: f64) -> usize {
        self.index((x - self.low[0]) / self.cell)
    }

    fn row(&self, y: f64) -> usize {
        self.index((y - self.low[1]) / self.cell)
    }

    fn index(&self, cells: f64) -> usize {
        // A cast from float to integer saturates: what lies before the grid falls into its first cell.
        (cells as usize).min(self.side - 1)
    }

    /// The rows of cells that a triangle reaches.
    fn rows(&self, triangle: [[f64; 2]; 3]) -> std::ops::RangeInclusive<usize> {
        let ys = triangle.map(|p| p[1]);
        self.row(ys[0].min(ys[1]).min(ys[2]))..=self.row(ys[0].max(ys[1]).max(ys[2]))
    }

    /// Whether `holds` for any point in the cells the triangle reaches, row by row.
    fn any_in(&self, triangle: [[f64; 2]; 3], mut holds: impl FnMut(usize) -> bool) -> bool {
        self.rows(triangle).any(|row| {
            let Some([left, right]) = self.reach(triangle, row) else { return false };
            let first = row * self.side + self.column(left);
            let last = row * self.side + self.column(right);
            self.members[self.starts[first]..self.starts[last + 1]].iter().any(|&point| holds(point))
        })
    }

    /// The least and the greatest x of the triangle within a row of cells, a little more for rounding.
    fn reach(&self, [a, b, c]: [[f64; 2]; 3], row: usize) -> Option<[f64; 2]> {
        let slack = 1e-9 * self.cell;
        let bottom = self.low[1] + row as f64 * self.cell - slack;
        let top = bottom + self.cell + 2.0 * slack;
        let mut reach: Option<[f64; 2]> = None;
        for (p, q) in [(a, b), (b, c), (c, a)] {
            let (p, q) = if p[1] <= q[1] { (p, q) } else { (q, p) };
            if p[1] > top || q[1] < bottom {
                continue;
            }
            let rise = q[1] - p[1];
            let x_at =
                |y: f64| if rise > 0.0 { p[0] + ((y - p[1]) / rise).clamp(0.0, 1.0) * (q[0] - p[0]) } else { p[0] };
            let ends = if rise > 0.0 { [x_at(bottom), x_at(top)] } else { [p[0], q[0]] };
            let [left, right] = reach.unwrap_or([f64::INFINITY, f64::NEG_INFINITY]);
            reach = Some([left.min(ends[0]).min(ends[1]) - slack, right.max(ends[0]).max(ends[1]) + slack]);
        }
        reach
    }
}

#[cfg(test)]
mod tests {
    use super::super::arrangement::Arrangement;
    use super::super::ring::signed_area;
    use super::*;
    use proptest::prelude::*;

    fn circle(n: usize, radius: f64) -> Vec<[f64; 2]> {
        (0..n)
            .map(|i| (i as f64 / n as f64 * std::f64::consts::TAU).sin_cos())
            .map(|(sin, cos)| [radius * cos, radius * sin])
            .collect()
    }

    #[test]
    fn a_circle_loses_points_but_hardly_area() {
        let fine = circle(10_000, 0.5);
        let coarse = &simplified(std::slice::from_ref(&fine), 1e-6, &mut 10_000_000)[0];
        assert!(coarse.len() < 400, "{}", coarse.len());
        assert!((signed_area(coarse) / signed_area(&fine) - 1.0).abs() < 1e-3);
    }

    #[test]
    fn every_ring_keeps_three_points() {
        let rings = simplified(&[circle(50, 0.5), circle(20, 0.1)], 10.0, &mut 100_000);
        assert!(rings.iter().all(|ring| ring.len() >= 3));
    }

    #[test]
    fn a_ring_in_the_way_stays_inside() {
        // The corner (0.3, 0.3) must stay: its triangle holds the whole small ring.
        let outer = vec![[0.0, 0.0], [0.4, 0.0], [0.3, 0.3], [0.0, 0.4]];
        let inner = vec![[0.27, 0.27], [0.28, 0.27], [0.27, 0.28]];
        let rings = simplified(&[outer.clone(), inner], 0.06, &mut 1000);
        assert!(rings[0].contains(&[0.3, 0.3]));
        assert_eq!(Arrangement::new(&rings, 1).ok().unwrap().depths(), [0, 1]);
    }

    #[test]
    fn without_looks_every_corner_stays() {
        let rings = [circle(1000, 0.5)];
        let mut looks = 0;
        assert_eq!(simplified(&rings, 1e-3, &mut looks), rings);
        looks = 500;
        let points = simplified(&rings, 1e-3, &mut looks)[0].len();
        assert!(looks == 0 && points > 500 && points < 1000, "{points}");
    }

    proptest! {
        /// Stars of any radii round a point are simple and stay so.
        #[test]
        fn simple_rings_stay_simple(radii in prop::collection::vec(0.2..0.5_f64, 8..120), area in 1e-6..1e-1_f64) {
            let n = radii.len();
            let star: Vec<[f64; 2]> = circle(n, 1.0).iter().zip(&radii).map(|(p, r)| [p[0] * r, p[1] * r]).collect();
            let hole = circle(12, 0.1);
            let rings = simplified(&[star, hole], area, &mut 1_000_000);
            let arrangement = Arrangement::new(&rings, 1);
            prop_assert!(arrangement.is_ok());
            prop_assert_eq!(arrangement.ok().unwrap().depths(), vec![0, 1]);
        }
    }
}
