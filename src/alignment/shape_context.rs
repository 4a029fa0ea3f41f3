//! Inner-distance shape contexts: what a point of an outline sees of the others [LJ07].

use std::f64::consts::TAU;

use super::inner_paths::InnerPaths;

/// Logarithmic bins of the path's length.
const RADII: usize = 8;

/// Bins of the path's direction at its beginning.
pub(super) const ANGLES: usize = 12;

/// Bins of a histogram.
pub(super) const BINS: usize = RADII * ANGLES;

/// Where the bins of length begin and end; what is shorter or longer falls into the first or the last one.
const NEAR: f64 = 0.08;
const FAR: f64 = 4.0;

/// Histograms of the n points, n × 96: over 8 bins of length × 12 of angle, the part of the other points that are
/// reached by an inner path of this length, over `unit` in pixels, whose first step makes this angle with the outline,
/// counted from the tangent (in the direction of the outline) counter-clockwise. Blurred by (1, 2, 1)/4 both ways, so
/// that a point near the edge of a bin counts for both; every row sums to 1.
pub(super) fn shape_contexts(points: &[[f64; 2]], tangents: &[[f64; 2]], paths: &InnerPaths, unit: f64) -> Vec<f32> {
    let n = points.len();
    let edges: [f32; RADII - 1] =
        std::array::from_fn(|k| (unit * NEAR * (FAR / NEAR).powf((k + 1) as f64 / RADII as f64)) as f32);
    let mut histograms = Vec::with_capacity(n * BINS);
    for i in 0..n {
        let angles: Vec<usize> = points.iter().map(|&to| angle_bin(points[i], to, tangents[i])).collect();
        let mut counts = [[0.0; ANGLES]; RADII];
        for j in (0..n).filter(|&j| j != i) {
            let radius = edges.iter().filter(|&&edge| paths.length(i, j) >= edge).count();
            counts[radius][angles[paths.first(i, j)]] += 1.0;
        }
        histograms.extend(blurred(&counts).as_flattened().iter().map(|count| count / (n - 1) as f32));
    }
    histograms
}

fn angle_bin(from: [f64; 2], to: [f64; 2], tangent: [f64; 2]) -> usize {
    let [x, y] = [to[0] - from[0], to[1] - from[1]];
    let angle = (tangent[0] * y - tangent[1] * x).atan2(tangent[0] * x + tangent[1] * y);
    (angle.rem_euclid(TAU) / TAU * ANGLES as f64) as usize % ANGLES
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
pub(super) fn mirrored(histogram: &[f32]) -> impl Iterator<Item = f32> {
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
        let bin = |degrees: f64| {
            let turned = (degrees + 70.0).to_radians();
            let tangent = [70f64.to_radians().cos(), 70f64.to_radians().sin()];
            angle_bin([3.0, 4.0], [3.0 + 5.0 * turned.cos(), 4.0 + 5.0 * turned.sin()], tangent)
        };
        assert_eq!([1.0, 29.0, 31.0, 179.0, 181.0, 359.0].map(bin), [0, 0, 1, 5, 6, 11]);
        let histogram: Vec<f32> = (0..BINS).map(|k| k as f32).collect();
        let twin: Vec<f32> = mirrored(&histogram).collect();
        assert_eq!((bin(180.0 - 31.0), twin[5], twin[4], twin[6], twin[12]), (4, 0.0, 1.0, 11.0, 17.0));
    }
}
