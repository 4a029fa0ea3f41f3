//! Inner-distance shape contexts: what a point of an outline sees of the others [LJ07].

use std::f64::consts::{FRAC_PI_6, TAU};

use super::inner_paths::InnerPaths;

/// Logarithmic bins of the path's length.
const RADII: usize = 8;

/// Bins of the path's direction at its beginning.
pub const ANGLES: usize = 12;

/// Bins of a histogram.
pub const BINS: usize = RADII * ANGLES;

/// Where the bins of length begin and end, in units of the square root of the figure's area; what is shorter or longer falls
/// into the first or the last one.
const NEAR: f64 = 0.08;
const FAR: f64 = 4.0;

/// Histograms of the n points, n × 96: over 8 bins of length × 12 of angle, the part of the other points that are
/// reached by an inner path of this length, over `unit` in pixels, whose first step makes this angle with the outline,
/// counted from the tangent (in the direction of the outline) counter-clockwise. Blurred by (1, 2, 1)/4 both ways, so
/// that a point near the edge of a bin counts for both; every row sums to 1.
pub fn shape_contexts(points: &[[f64; 2]], tangents: &[[f64; 2]], paths: &InnerPaths, unit: f64) -> Vec<f32> {
    let n = points.len();
    let edges: [f32; RADII - 1] =
        std::array::from_fn(|k| (unit * NEAR * (FAR / NEAR).powf((k + 1) as f64 / RADII as f64)) as f32);
    let directions = Directions::new();
    let mut histograms = Vec::with_capacity(n * BINS);
    for i in 0..n {
        let angles: Vec<usize> = points.iter().map(|&to| directions.bin(points[i], to, tangents[i])).collect();
        let mut counts = [[0.0; ANGLES]; RADII];
        for j in (0..n).filter(|&j| j != i) {
            let length = paths.length(i, j);
            let radius: usize = edges.iter().map(|&edge| usize::from(length >= edge)).sum();
            counts[radius][angles[paths.first(i, j)]] += 1.0;
        }
        histograms.extend(blurred(&counts).as_flattened().iter().map(|count| count / (n - 1) as f32));
    }
    histograms
}

/// Where the bins of angles begin: (cos, sin) of 30°, 60°, 120° and 150°.
struct Directions([[f64; 2]; 4]);

/// Directions so near to the axes, where many are because of the pixels, are told by the rounded angle.
const ROUNDING: f64 = 1e-14;

impl Directions {
    fn new() -> Directions {
        Directions([1.0, 2.0, 4.0, 5.0].map(|step| [(step * FRAC_PI_6).cos(), (step * FRAC_PI_6).sin()]))
    }

    /// The bin of the direction to a point, counted from the tangent counter-clockwise, by the sides of the bins' edges
    /// that the point is on.
    fn bin(&self, from: [f64; 2], to: [f64; 2], tangent: [f64; 2]) -> usize {
        let [x, y] = [to[0] - from[0], to[1] - from[1]];
        let (along, aside) = (tangent[0] * x + tangent[1] * y, tangent[0] * y - tangent[1] * x);
        if along.abs().min(aside.abs()) <= ROUNDING * along.abs().max(aside.abs()) {
            return (aside.atan2(along).rem_euclid(TAU) / TAU * ANGLES as f64) as usize % ANGLES;
        }
        // Within half a turn.
        let behind = aside < 0.0;
        let (along, aside) = if behind { (-along, -aside) } else { (along, aside) };
        let passed = self.0.iter().map(|[cos, sin]| usize::from(aside * cos > along * sin));
        usize::from(along < 0.0) + passed.sum::<usize>() + if behind { ANGLES / 2 } else { 0 }
    }
}

/// The counts spread by (1, 2, 1)/4 over angles, which are cyclic, and over radii, which end; the sum remains.
fn blurred(counts: &[[f32; ANGLES]; RADII]) -> [[f32; ANGLES]; RADII] {
    let turned = counts.map(|row| {
        std::array::from_fn::<f32, ANGLES, _>(|a| {
            0.5 * row[a] + 0.25 * (row[(a + 1) % ANGLES] + row[(a + ANGLES - 1) % ANGLES])
        })
    });
    std::array::from_fn(|r| {
        let (below, above) = (turned[r.saturating_sub(1)], turned[(r + 1).min(RADII - 1)]);
        std::array::from_fn(|a| 0.5 * turned[r][a] + 0.25 * (below[a] + above[a]))
    })
}

/// The histogram that the point has in the mirrored figure, where the outline runs the other way: the angle a becomes
/// π − a.
pub fn mirrored(histogram: &[f32]) -> impl Iterator<Item = f32> {
    histogram.chunks_exact(ANGLES).flat_map(|row| (0..ANGLES).map(|a| row[(ANGLES + ANGLES / 2 - 1 - a) % ANGLES]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blur_keeps_the_sum_and_wraps_round() {
        let mut counts = [[0.0; ANGLES]; RADII];
        counts[0][0] = 16.0;
        counts[5][3] = 16.0;
        let blurred = blurred(&counts);
        assert_eq!(blurred.as_flattened().iter().sum::<f32>(), 32.0);
        assert_eq!([blurred[0][0], blurred[0][11], blurred[1][1]], [6.0, 3.0, 1.0]);
        assert_eq!([blurred[5][3], blurred[4][3], blurred[6][4]], [4.0, 2.0, 1.0]);
    }

    #[test]
    fn angles_are_counted_from_the_tangent() {
        let directions = Directions::new();
        let bin = |degrees: f64| {
            let turned = (degrees + 70.0).to_radians();
            let tangent = [70f64.to_radians().cos(), 70f64.to_radians().sin()];
            directions.bin([3.0, 4.0], [3.0 + 5.0 * turned.cos(), 4.0 + 5.0 * turned.sin()], tangent)
        };
        assert_eq!([1.0, 29.0, 31.0, 179.0, 181.0, 359.0].map(bin), [0, 0, 1, 5, 6, 11]);
        let histogram: Vec<f32> = (0..BINS).map(|k| k as f32).collect();
        let twin: Vec<f32> = mirrored(&histogram).collect();
        assert_eq!((bin(180.0 - 31.0), twin[5], twin[4], twin[6], twin[12]), (4, 0.0, 1.0, 11.0, 17.0));
    }

    #[test]
    fn bins_are_those_of_the_angle() {
        let directions = Directions::new();
        let steps = || (-24..=24).map(|step| 0.5 * f64::from(step));
        for to in steps().flat_map(|x| steps().map(move |y| [x, y])) {
            for tangent in [[1.0, 0.0], [0.5, -1.0], [-0.25, 0.0], [0.0, 2.0], [0.3, 0.7], [-1.5, -1.5]] {
                let aside: f64 = tangent[0] * to[1] - tangent[1] * to[0];
                let angle = aside.atan2(tangent[0] * to[0] + tangent[1] * to[1]);
                let expected = (angle.rem_euclid(TAU) / TAU * ANGLES as f64) as usize % ANGLES;
                assert_eq!(directions.bin([0.0; 2], to, tangent), expected, "{to:?} {tangent:?}");
            }
        }
    }
}
