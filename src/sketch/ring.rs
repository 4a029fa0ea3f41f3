//! One closed line of a drawing, and its mending.

/// Two points nearer than this, in a drawing of unit size, are one point; a corner nearer to the chord of its
/// neighbours is no corner.
const NEGLIGIBLE: f64 = 1e-12;

/// A closed line: the last point is joined to the first, which is not repeated.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Ring {
    pub points: Vec<[f64; 2]>,
    /// For every point its index in the ring as it was uploaded.
    pub origin: Vec<usize>,
}

/// How often each kind of mending was needed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Mended {
    pub closing: usize,
    pub repeated: usize,
    pub collinear: usize,
    pub spikes: usize,
}

/// What a point is to the line between its neighbours.
enum Corner {
    Proper,
    /// On the way from one to the other.
    Passed,
    /// The line turns back on itself here.
    Reversal,
}

impl Ring {
    /// The ring of `points` without repeated points, points in the middle of straight lines and spikes, and what was
    /// left out. Fewer than three points are left where the ring encloses nothing.
    pub fn mended(points: &[[f64; 2]]) -> (Self, Mended) {
        let mut mended = Mended::default();
        let mut ring = Self::default();
        for (index, &point) in points.iter().enumerate() {
            ring.push(point, index, &mut mended);
        }
        ring.close(points.len(), &mut mended);
        (ring, mended)
    }

    /// The enclosed area: positive for counter-clockwise rings (y up).
    pub fn signed_area(&self) -> f64 {
        signed_area(&self.points)
    }

    /// The same ring walked the other way.
    pub fn reversed(mut self) -> Self {
        self.points.reverse();
        self.origin.reverse();
        self
    }

    fn push(&mut self, point: [f64; 2], index: usize, mended: &mut Mended) {
        self.points.push(point);
        self.origin.push(index);
        while self.mend_end(mended) {}
    }

    /// Removes the last point but one, or the last, where it is no corner; whether it did.
    fn mend_end(&mut self, mended: &mut Mended) -> bool {
        let n = self.points.len();
        if n >= 2 && coincide(self.points[n - 2], self.points[n - 1]) {
            self.pop();
            mended.repeated += 1;
            return true;
        }
        if n < 3 || !mended.notes(corner(self.points[n - 3], self.points[n - 2], self.points[n - 1])) {
            return false;
        }
        self.points.swap_remove(n - 2);
        self.origin.swap_remove(n - 2);
        true
    }

    /// Mends where the end of the ring meets its start.
    fn close(&mut self, uploaded: usize, mended: &mut Mended) {
        // Points are cut off both ends; those at the start all at once, for the cost of one move.
        let mut start = 0;
        while self.points.len() >= start + 2 {
            let n = self.points.len();
            let [first, last] = [start, n - 1].map(|i| self.points[i]);
            if coincide(first, last) {
                let is_last = self.origin[n - 1] + 1 == uploaded;
                *(if is_last { &mut mended.closing } else { &mut mended.repeated }) += 1;
                self.pop();
            } else if n < start + 3 {
                break;
            } else if mended.notes(corner(self.points[n - 2], last, first)) {
                self.pop();
            } else if mended.notes(corner(last, first, self.points[start + 1])) {
                start += 1;
            } else {
                break;
            }
        }
        self.points.drain(..start);
        self.origin.drain(..start);
    }

    fn pop(&mut self) {
        self.points.pop();
        self.origin.pop();
    }
}

impl Mended {
    /// Counts a corner that has to go; whether it is one.
    fn notes(&mut self, corner: Corner) -> bool {
        match corner {
            Corner::Proper => return false,
            Corner::Passed => self.collinear += 1,
            Corner::Reversal => self.spikes += 1,
        }
        true
    }
}

/// The area a closed line encloses: positive where it runs counter-clockwise (y up).
pub(super) fn signed_area(points: &[[f64; 2]]) -> f64 {
    // Differences to the first point keep figures far from the origin exact.
    let Some(&o) = points.first() else { return 0.0 };
    0.5 * points.windows(2).map(|w| cross(difference(w[0], o), difference(w[1], o))).sum::<f64>()
}

/// The vector from b to a.
pub(super) fn difference(a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    [a[0] - b[0], a[1] - b[1]]
}

/// The signed area of the parallelogram that two vectors span, positive where b lies counter-clockwise of a (y up).
pub(super) fn cross(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}

fn coincide(a: [f64; 2], b: [f64; 2]) -> bool {
    let [x, y] = difference(a, b);
    x.hypot(y) <= NEGLIGIBLE
}

fn corner(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> Corner {
    let (u, v) = (difference(b, a), difference(c, b));
    let (ahead, aside) = (u[0] * v[0] + u[1] * v[1], cross(u, v).abs());
    // The height of the triangle over its longest side: the chord where b is passed, the longer leg of a spike.
    let [x, y] = difference(c, a);
    let longest = x.hypot(y).max(u[0].hypot(u[1])).max(v[0].hypot(v[1]));
    if aside > NEGLIGIBLE * longest {
        Corner::Proper
    } else if ahead >= 0.0 {
        Corner::Passed
    } else {
        Corner::Reversal
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SQUARE: [[f64; 2]; 4] = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];

    #[test]
    fn a_clean_ring_stays_as_it_is() {
        let (ring, mended) = Ring::mended(&SQUARE);
        assert_eq!(ring.points, SQUARE);
        assert_eq!(ring.origin, [0, 1, 2, 3]);
        assert_eq!(mended, Mended::default());
        assert_eq!(ring.signed_area(), 1.0);
        assert_eq!(ring.reversed().signed_area(), -1.0);
    }

    #[test]
    fn the_closing_point_and_repeated_points_go() {
        let (ring, mended) = Ring::mended(&[[0.0, 0.0], [0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0], [0.0, 0.0]]);
        assert_eq!(ring.points, SQUARE);
        assert_eq!(ring.origin, [0, 2, 3, 4]);
        assert_eq!(mended, Mended { closing: 1, repeated: 1, ..Mended::default() });
    }

    #[test]
    fn collinear_points_go_also_across_the_seam() {
        let (ring, mended) = Ring::mended(&[[0.5, 0.0], [1.0, 0.0], [1.0, 0.5], [1.0, 1.0], [0.0, 1.0], [0.0, 0.0]]);
        assert_eq!(ring.points, [[1.0, 0.0], [1.0, 1.0], [0.0, 1.0], [0.0, 0.0]]);
        assert_eq!(mended.collinear, 2);
    }

    #[test]
    fn a_spike_of_several_points_goes_whole() {
        let spike = [[1.0, 0.0], [2.0, 0.5], [3.0, 3.0], [2.0, 0.5], [1.0, 0.0]];
        let points = [&SQUARE[..1], &spike, &SQUARE[2..]].concat();
        let (ring, mended) = Ring::mended(&points);
        assert_eq!(ring.points, SQUARE);
        assert_eq!(mended.spikes, 2);
    }

    #[test]
    fn a_ring_that_encloses_nothing_vanishes() {
        for points in [&[][..], &SQUARE[..1], &SQUARE[..2], &[[0.0, 0.0], [1.0, 1.0], [2.0, 2.0], [1.0, 1.0]]] {
            let (ring, _) = Ring::mended(points);
            assert!(ring.points.len() < 3, "{:?}", ring.points);
        }
    }

    #[test]
    fn a_finely_sampled_circle_keeps_its_points() {
        let n = 100_000;
        let circle = |i: usize| (i as f64 / n as f64 * std::f64::consts::TAU).sin_cos();
        let points: Vec<[f64; 2]> = (0..n).map(circle).map(|(s, c)| [0.5 * c, 0.5 * s]).collect();
        let (ring, _) = Ring::mended(&points);
        assert_eq!(ring.points.len(), n);
    }
}
