//! How often lines meet: what their union costs.

use crate::sketch::refusal::{Fault, Refusal};
use crate::sketch::ring::{cross, difference};

/// Most places where lines meet: the union takes about 5 µs and 300 bytes for each.
const MAX_CROSSINGS: usize = 100_000;

/// Most pairs of lines whose boxes overlap: the union takes about 0.1 µs for each, crossed or not.
const MAX_NEIGHBOURS: usize = 10_000_000;

/// Most pairs of lines that are compared at all. Only many thousand long lines side by side need more.
const MAX_PAIRS: usize = 200_000_000;

/// A line between two points.
struct Line {
    ends: [[f64; 2]; 2],
    low: [f64; 2],
    high: [f64; 2],
}

/// Passes closed lines of points whose union is cheap.
///
/// # Errors
/// Where they cross, touch or overlap too often, or lie so densely side by side that this cannot be told: the place
/// that the count has come to.
pub(super) fn check<'a>(contours: impl Iterator<Item = &'a [[f64; 2]]>) -> Result<(), Refusal> {
    let mut lines: Vec<Line> = contours.flat_map(closed).collect();
    // Swept along the axis on which the lines are short, so that few are open at a time.
    let axis = usize::from(overlap(&lines, 1) < overlap(&lines, 0));
    lines.sort_by(|a, b| a.low[axis].total_cmp(&b.low[axis]));
    let (mut crossings, mut neighbours, mut pairs) = (0, 0, 0);
    let mut open: Vec<&Line> = Vec::new();
    for line in &lines {
        open.retain(|other| other.high[axis] >= line.low[axis]);
        pairs += open.len();
        for other in open.iter().filter(|other| line.is_beside(other)) {
            neighbours += 1;
            crossings += usize::from(line.meets(other));
        }
        let refused = |detail: String| Err(Refusal { faults: vec![Fault::plain(detail).at(line.ends[0])] });
        if crossings > MAX_CROSSINGS {
            return refused(format!("the lines of the SVG cross or touch more than {MAX_CROSSINGS} times"));
        }
        if neighbours > MAX_NEIGHBOURS || pairs > MAX_PAIRS {
            return refused("too many long lines of the SVG lie side by side".into());
        }
        open.push(line);
    }
    Ok(())
}

/// The lines between points and from the last to the first.
fn closed(points: &[[f64; 2]]) -> impl Iterator<Item = Line> {
    let following = points.iter().cycle().skip(1);
    points.iter().zip(following).map(|(&from, &to)| Line::new(from, to))
}

/// The mean number of lines over a point of an axis.
fn overlap(lines: &[Line], axis: usize) -> f64 {
    let low = lines.iter().map(|line| line.low[axis]).fold(f64::INFINITY, f64::min);
    let high = lines.iter().map(|line| line.high[axis]).fold(f64::NEG_INFINITY, f64::max);
    lines.iter().map(|line| line.high[axis] - line.low[axis]).sum::<f64>() / (high - low)
}

impl Line {
    fn new(from: [f64; 2], to: [f64; 2]) -> Self {
        let low = [0, 1].map(|axis| from[axis].min(to[axis]));
        let high = [0, 1].map(|axis| from[axis].max(to[axis]));
        Self { ends: [from, to], low, high }
    }

    /// Whether the boxes around the lines overlap.
    fn is_beside(&self, other: &Self) -> bool {
        [0, 1].iter().all(|&axis| self.low[axis] <= other.high[axis] && other.low[axis] <= self.high[axis])
    }

    /// Whether lines cross, or one ends within the other; not whether they are equal or only have ends in common.
    fn meets(&self, other: &Self) -> bool {
        let [sides, other_sides] = [(self, other), (other, self)].map(|(line, ends)| ends.ends.map(|p| line.side(p)));
        let is_parted = |[s, t]: [f64; 2]| s < 0.0 && t > 0.0 || s > 0.0 && t < 0.0;
        is_parted(sides) && is_parted(other_sides) || self.contains_end(other) || other.contains_end(self)
    }

    /// Positive for a point on the left.
    fn side(&self, point: [f64; 2]) -> f64 {
        let [from, to] = self.ends;
        cross(difference(to, from), difference(point, from))
    }

    /// Whether an end of another line lies on this one, between its ends.
    fn contains_end(&self, other: &Self) -> bool {
        other.ends.iter().any(|&p| {
            let [u, v] = self.ends.map(|end| difference(end, p));
            self.side(p) == 0.0 && u[0] * v[0] + u[1] * v[1] < 0.0
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn met(a: [[f64; 2]; 2], b: [[f64; 2]; 2]) -> bool {
        let [a, b] = [a, b].map(|[from, to]| Line::new(from, to));
        assert_eq!(a.meets(&b), b.meets(&a));
        a.meets(&b)
    }

    #[test]
    fn lines_meet_where_the_union_has_to_cut_one() {
        let line = [[0.0, 0.0], [4.0, 4.0]];
        for cutting in [[[0.0, 4.0], [4.0, 0.0]], [[2.0, 2.0], [4.0, 0.0]], [[1.0, 1.0], [3.0, 3.0]]] {
            assert!(met(line, cutting), "{cutting:?}");
        }
        assert!(met(line, [[0.0, 0.0], [3.0, 3.0]]));
        let beside = [line, [[4.0, 4.0], [0.0, 0.0]], [[4.0, 4.0], [5.0, 5.0]], [[4.0, 4.0], [4.0, 0.0]]];
        for passing in beside.into_iter().chain([[[1.0, 0.0], [4.0, 3.0]], [[5.0, 4.0], [6.0, 0.0]]]) {
            assert!(!met(line, passing), "{passing:?}");
        }
    }

    /// A line of n strokes to and fro between two sides of a square.
    fn zigzag(n: usize) -> Vec<[f64; 2]> {
        (0..n).map(|i| [(i * 617 % n) as f64 + 0.001 * (i as f64).sin(), (i % 2 * n) as f64]).collect()
    }

    #[test]
    fn crossings_are_bounded() {
        // A star whose strokes are all crossed by nearly all others.
        assert_eq!(check([zigzag(101).as_slice()].into_iter()), Ok(()));
        for points in [zigzag(2_000), zigzag(200_000)] {
            let refusal = check([points.as_slice()].into_iter()).unwrap_err();
            assert!(refusal.to_string().contains("cross or touch more than"), "{refusal}");
            assert!(refusal.faults[0].point.is_some());
        }
        // Squares one over the other, each a little further.
        let square =
            |i: usize| [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]].map(|p| p.map(|x| x + i as f64 * 1e-4));
        let squares = |n: usize| (0..n).map(square).collect::<Vec<_>>();
        assert!(check(squares(300).iter().map(<[_; 4]>::as_slice)).is_ok());
        assert!(check(squares(500).iter().map(<[_; 4]>::as_slice)).is_err());
    }

    #[test]
    fn lines_side_by_side_do_not_cross() {
        let mut comb: Vec<[f64; 2]> = (0..20_000).map(|i| [f64::from(i), f64::from(i % 2 * 20_000)]).collect();
        comb.extend([[20_000.0, -1.0], [-1.0, -1.0]]);
        let askew: Vec<[f64; 2]> = comb.iter().map(|&[x, y]| [x - y, x + y]).collect();
        assert!(check([askew.as_slice()].into_iter()).unwrap_err().to_string().contains("side by side"));
        for turned in [comb.iter().map(|&[x, y]| [y, x]).collect(), comb] {
            assert_eq!(check([turned.as_slice()].into_iter()).map_err(|refusal| refusal.to_string()), Ok(()));
        }
    }
}
