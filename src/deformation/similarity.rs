//! The similarity that lays points of the plane on others.

/// p ↦ scale · R p + shift.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Similarity {
    pub scale: f64,
    /// R as (cos, sin).
    pub turn: [f64; 2],
    pub shift: [f64; 2],
}

impl Similarity {
    /// The weighted least-squares similarity from the first points of the triples to the second, without reflection; the
    /// third are the weights. Where the points do not tell one, it does not turn, nor scale.
    pub fn fitted(pairs: impl Iterator<Item = ([f64; 2], [f64; 2], f64)> + Clone) -> Similarity {
        let total: f64 = pairs.clone().map(|(_, _, weight)| weight).sum();
        let mean = |of_first: bool| -> [f64; 2] {
            let weighted = |axis: usize| {
                pairs
                    .clone()
                    .map(|(from, to, weight)| weight * if of_first { from[axis] } else { to[axis] })
                    .sum::<f64>()
            };
            std::array::from_fn(|axis| weighted(axis) / total)
        };
        let (a, b) = (mean(true), mean(false));
        let (mut c, mut s, mut spread) = (0.0, 0.0, 0.0);
        for (x, y, weight) in pairs {
            let (x, y) = ([x[0] - a[0], x[1] - a[1]], [y[0] - b[0], y[1] - b[1]]);
            c += weight * (x[0] * y[0] + x[1] * y[1]);
            s += weight * (x[0] * y[1] - x[1] * y[0]);
            spread += weight * (x[0] * x[0] + x[1] * x[1]);
        }
        let length = c.hypot(s);
        let turn = if length > 0.0 { [c / length, s / length] } else { [1.0, 0.0] };
        let scale = if spread > 0.0 && length > 0.0 { length / spread } else { 1.0 };
        let [c, s] = turn.map(|x| x * scale);
        Similarity { scale, turn, shift: [b[0] - c * a[0] + s * a[1], b[1] - s * a[0] - c * a[1]] }
    }

    pub fn apply(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let [c, s] = self.turn.map(|t| t * self.scale);
        [c * x - s * y + self.shift[0], s * x + c * y + self.shift[1]]
    }

    /// The difference of two points that [`apply`](Self::apply) lays `difference` apart.
    pub fn difference_back(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let [c, s] = self.turn.map(|t| t / self.scale);
        [c * x + s * y, c * y - s * x]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_similarity_is_found_again_and_differences_go_back() {
        let (s, c) = 2.1f64.sin_cos();
        let known = Similarity { scale: 0.7, turn: [c, s], shift: [3.0, -4.0] };
        let points = [[0.0, 0.0], [1.0, 0.3], [-0.4, 2.0], [5.0, 1.0]];
        let found = Similarity::fitted(points.iter().enumerate().map(|(i, &p)| (p, known.apply(p), 1.0 + i as f64)));
        for p in points {
            let (a, b) = (known.apply(p), found.apply(p));
            assert!((a[0] - b[0]).hypot(a[1] - b[1]) < 1e-12);
        }
        let [a, b] = [points[1], points[3]].map(|p| found.apply(p));
        let back = found.difference_back([a[0] - b[0], a[1] - b[1]]);
        assert!((back[0] + 4.0).hypot(back[1] + 0.7) < 1e-12, "{back:?}");
    }

    #[test]
    fn one_place_is_moved_only() {
        let found = Similarity::fitted([([1.0, 2.0], [4.0, 4.0], 1.0); 3].into_iter());
        assert_eq!(found, Similarity { scale: 1.0, turn: [1.0, 0.0], shift: [3.0, 2.0] });
    }
}
