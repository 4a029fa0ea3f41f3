//! Farthest-point sampling [Gon85]: every point the one farthest from those before it.

/// How far every vertex is from those that were chosen.
pub struct FarthestPoints {
    away: Vec<f64>,
}

impl FarthestPoints {
    /// Of `n` vertices none is chosen yet, and all are endlessly far.
    pub fn new(n: usize) -> FarthestPoints {
        FarthestPoints { away: vec![f64::INFINITY; n] }
    }

    /// Chooses a vertex, whose distances from all n are these.
    pub fn choose(&mut self, distances: &[f64]) {
        self.away.iter_mut().zip(distances).for_each(|(away, &distance)| *away = away.min(distance));
    }

    /// Which of these vertices is farthest from those chosen: of equals the first, of none none.
    pub fn farthest(&self, among: impl IntoIterator<Item = u32>) -> Option<u32> {
        let farther = |best: u32, v: u32| if self.away[v as usize] > self.away[best as usize] { v } else { best };
        among.into_iter().reduce(farther)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_farthest_of_a_line_is_an_end_and_then_the_middle() {
        let distances = |from: u32| (0..5).map(|v: u32| f64::from(v.abs_diff(from))).collect::<Vec<_>>();
        let mut points = FarthestPoints::new(5);
        assert_eq!(
            [points.farthest(0..5), points.farthest((0..5).rev()), points.farthest(0..0)],
            [Some(0), Some(4), None]
        );
        points.choose(&distances(0));
        assert_eq!(points.farthest(0..5), Some(4));
        points.choose(&distances(4));
        assert_eq!(points.farthest(0..5), Some(2));
        points.choose(&distances(2));
        assert_eq!([points.farthest(0..5), points.farthest((0..5).rev())], [Some(1), Some(3)]);
    }
}
