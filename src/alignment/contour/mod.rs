//! The outline of a figure, sampled, and how each sample sees the others.

mod inner_paths;
mod shape_context;
mod single_outline;
pub mod view;
pub mod warping;

use serde::{Deserialize, Serialize};

use crate::raster::silhouette::{MARGIN, silhouette};
use inner_paths::InnerPaths;
use shape_context::{BINS, mirrored, shape_contexts};
use single_outline::single_outline;

/// Samples of an outline.
pub const SAMPLES: usize = 110;

/// Samples on either side of one that are too near to tell the thickness.
const ADJOINING: usize = 2;

/// The outline of a figure, counter-clockwise from an arbitrary start, at equal distances along it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Contour {
    /// 110 samples, in units of the points it was made of.
    pub curve: Vec<[f64; 2]>,
    /// 110 × (8 radii × 12 angles): per sample its inner-distance shape context [LJ07], summing to 1.
    pub histograms: Vec<f32>,
    /// Per sample the logarithm of the radius of the largest disc inside that touches the outline there, in units of
    /// the square root of the figure's area, blurred along the outline.
    pub thickness: Vec<f32>,
}

impl Contour {
    /// The contour of the union of triangles, m × 3 indices into `points`: that of its largest piece, with larger holes
    /// cut open. Looked at in a picture of 256 pixels. Does not change with position and scale of the figure, up to
    /// rounding. Of no triangles, or triangles of no extent, all samples are about the same point.
    pub fn of(points: &[[f64; 2]], triangles: &[[u32; 3]]) -> Contour {
        let outline = single_outline(&silhouette(points, triangles));
        let inside = &outline.inside;
        let samples = equal_arcs(&outline.points);
        let tangents: Vec<[f64; 2]> = (0..SAMPLES)
            .map(|i| {
                let (before, after) = (samples[(i + SAMPLES - 1) % SAMPLES], samples[(i + 1) % SAMPLES]);
                [after[0] - before[0], after[1] - before[1]]
            })
            .collect();
        let unit = (inside.area().max(1) as f64).sqrt();
        let histograms = shape_contexts(&samples, &tangents, &InnerPaths::between(&samples, inside), unit);
        let thickness: Vec<f64> =
            thickness(&samples, &tangents).into_iter().map(|r| (r / unit).max(1e-3).ln()).collect();
        let thickness = blurred(&thickness).into_iter().map(|t| t as f32).collect();
        Contour { curve: samples.iter().map(|&pixel| inside.point(pixel)).collect(), histograms, thickness }
    }

    /// The contour of the mirrored figure: the samples 0, 109, 108, …, 1, because the reflection of a counter-clockwise
    /// line runs clockwise, and their histograms with the angle a at π − a. `curve` is reordered only: which axis the
    /// reflection is in, the reader knows.
    pub fn reversed(&self) -> Contour {
        let order = || (0..SAMPLES).map(|i| (SAMPLES - i) % SAMPLES);
        Contour {
            curve: order().map(|i| self.curve[i]).collect(),
            histograms: order().flat_map(|i| mirrored(&self.histograms[i * BINS..][..BINS])).collect(),
            thickness: order().map(|i| self.thickness[i]).collect(),
        }
    }
}

/// For every sample the radius of the largest disc that touches the outline there from inside and holds no other sample,
/// but for those next to it, which tell the bumps of the picture:
/// the curvature of the circle through another sample is 2 n·(q − p) / |q − p|² for the inner normal n.
fn thickness(samples: &[[f64; 2]], tangents: &[[f64; 2]]) -> Vec<f64> {
    let radius = |i: usize| {
        let (p, t) = (samples[i], tangents[i]);
        let length = t[0].hypot(t[1]).max(1e-9);
        let normal = [-t[1] / length, t[0] / length];
        let curvature = |q: &[f64; 2]| {
            let d = [q[0] - p[0], q[1] - p[1]];
            2.0 * (normal[0] * d[0] + normal[1] * d[1]) / (d[0] * d[0] + d[1] * d[1]).max(1e-9)
        };
        let n = samples.len();
        let others = (ADJOINING + 1..n - ADJOINING).map(|step| &samples[(i + step) % n]);
        1.0 / others.map(curvature).fold(1e-6, f64::max)
    };
    (0..samples.len()).map(radius).collect()
}

/// The values round a closed line blurred by (1, 4, 6, 4, 1)/16.
fn blurred(values: &[f64]) -> Vec<f64> {
    let n = values.len();
    let at = |i: usize, step: usize| values[(i + n + step - 2) % n];
    (0..n).map(|i| (at(i, 0) + at(i, 4) + 4.0 * (at(i, 1) + at(i, 3)) + 6.0 * at(i, 2)) / 16.0).collect()
}

/// The samples of a closed polygon at equal distances along it, from its first corner on.
fn equal_arcs(corners: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let Some(&first) = corners.first() else { return vec![[MARGIN; 2]; SAMPLES] };
    let edges = || corners.iter().zip(corners.iter().cycle().skip(1));
    let length = |a: &[f64; 2], b: &[f64; 2]| (b[0] - a[0]).hypot(b[1] - a[1]);
    let spacing = edges().map(|(a, b)| length(a, b)).sum::<f64>() / SAMPLES as f64;
    let mut samples = Vec::with_capacity(SAMPLES);
    let mut passed = 0.0;
    for (a, b) in edges() {
        let length = length(a, b);
        while samples.len() < SAMPLES && samples.len() as f64 * spacing < passed + length {
            let t = (samples.len() as f64 * spacing - passed) / length;
            samples.push([0, 1].map(|axis| a[axis] + t * (b[axis] - a[axis])));
        }
        passed += length;
    }
    // Rounding may leave out the last one, or all of a polygon without length.
    samples.resize(SAMPLES, first);
    samples
}

#[cfg(test)]
mod tests {
    use super::warping::{Warp, cost, differences, warp};
    use super::*;

    /// A fan of triangles about the origin: a star-shaped figure without symmetry, with two long limbs.
    fn star() -> (Vec<[f64; 2]>, Vec<[u32; 3]>) {
        let corner = |k: u32| {
            let angle = f64::from(k) * std::f64::consts::TAU / 200.0;
            let bump = |at: f64, width: f64| (-((angle - at) / width).powi(2)).exp();
            let radius = 1.0 + 2.0 * bump(1.0, 0.15) + 1.2 * bump(2.6, 0.3) + 0.8 * bump(4.0, 0.2);
            [radius * angle.cos(), radius * angle.sin()]
        };
        let points = std::iter::once([0.0; 2]).chain((0..200).map(corner)).collect();
        (points, (0..200).map(|k| [0, 1 + k, 1 + (k + 1) % 200]).collect())
    }

    fn turned(points: &[[f64; 2]], degrees: f64) -> Vec<[f64; 2]> {
        let (sin, cos) = degrees.to_radians().sin_cos();
        points.iter().map(|&[x, y]| [cos * x - sin * y, sin * x + cos * y]).collect()
    }

    #[test]
    fn samples_lie_on_the_outline_at_equal_distances() {
        let square = [[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]];
        let contour = Contour::of(&square, &[[0, 1, 2], [0, 2, 3]]);
        assert_eq!((contour.curve.len(), contour.histograms.len()), (110, 110 * 96));
        for p in &contour.curve {
            let depth = p.iter().map(|x| x.min(2.0 - x)).fold(f64::INFINITY, f64::min);
            assert!(depth.abs() < 0.01, "{p:?}");
        }
        let area: f64 = (0..SAMPLES)
            .map(|i| (contour.curve[i], contour.curve[(i + 1) % SAMPLES]))
            .map(|(a, b)| 0.5 * (a[0] * b[1] - a[1] * b[0]))
            .sum();
        assert!((area - 4.0).abs() < 0.05, "{area}");
        for row in contour.histograms.chunks_exact(BINS) {
            assert!((row.iter().sum::<f32>() - 1.0).abs() < 1e-5);
        }
    }

    #[test]
    fn the_twin_is_the_contour_of_the_reflection() {
        let (points, triangles) = star();
        let contour = Contour::of(&points, &triangles);
        let reflection: Vec<[f64; 2]> = points.iter().map(|&[x, y]| [-x, y]).collect();
        let reflection = Contour::of(&reflection, &triangles);
        let twin = contour.reversed();
        let Warp { cost: alike, path } = warp(&differences(&reflection, &twin));
        let unlike = cost(&differences(&reflection, &contour), 1);
        assert!(alike < 0.02 && unlike > 4.0 * alike, "{alike} {unlike}");
        for (i, j) in path {
            let ([x, y], [u, v]) = (reflection.curve[i], twin.curve[j]);
            assert!((x + u).hypot(y - v) < 0.2, "{x} {y} {u} {v}");
        }
        assert_eq!(twin.reversed(), contour);
    }

    #[test]
    fn position_scale_and_turn_hardly_matter() {
        let (points, triangles) = star();
        let contour = Contour::of(&points, &triangles);
        assert!(cost(&differences(&contour, &contour), 1) < 1e-6);
        let moved: Vec<[f64; 2]> = points.iter().map(|&[x, y]| [8.0 * x + 64.0, 8.0 * y - 16.0]).collect();
        assert_eq!(Contour::of(&moved, &triangles).histograms, contour.histograms);
        for degrees in [20.0, 90.0, 137.0] {
            let other = Contour::of(&turned(&points, degrees), &triangles);
            let changed = cost(&differences(&contour, &other), 1);
            assert!(changed < 0.02, "{degrees}: {changed}");
        }
    }

    #[test]
    fn thickness_is_the_radius_of_the_largest_disc_inside() {
        // A bar of 8 × 1: half its width, but near the corners, in units of the root of its area.
        let bar = Contour::of(&[[0.0, 0.0], [8.0, 0.0], [8.0, 1.0], [0.0, 1.0]], &[[0, 1, 2], [0, 2, 3]]);
        let along = bar.curve.iter().zip(&bar.thickness).filter(|(p, _)| (1.0..7.0).contains(&p[0]));
        for (p, thickness) in along {
            assert!((f64::from(thickness.exp()) - 0.5 / 8f64.sqrt()).abs() < 0.02, "{p:?} {}", thickness.exp());
        }
        let (points, triangles) = star();
        let figure = Contour::of(&points, &triangles);
        let larger: Vec<[f64; 2]> = points.iter().map(|p| p.map(|x| 4.0 * x)).collect();
        assert_eq!(Contour::of(&larger, &triangles).thickness, figure.thickness);
    }

    #[test]
    fn figures_without_extent_have_a_contour() {
        let needle = Contour::of(&[[0.0, 0.0], [1.0, 0.0], [0.5, 0.0]], &[[0, 1, 2]]);
        for contour in [Contour::of(&[], &[]), Contour::of(&[[5.0, 6.0]; 3], &[[0, 1, 2]]), needle] {
            assert_eq!((contour.curve.len(), contour.histograms.len()), (110, 110 * 96));
            assert!(contour.curve.as_flattened().iter().all(|x| x.is_finite()));
            assert!(contour.histograms.iter().all(|x| x.is_finite()));
            assert!(warp(&differences(&contour, &contour)).cost < 1e-6);
        }
    }
}
