//! A sketch laid on a view: from the warp of the outlines to a place in the picture for every point.

use super::contour::SAMPLES;
use super::contour::view::View;
use super::contour::warping::{TRUNCATE, Warp, cost_along};
use super::prepared::FlatShape;
use crate::deformation::as_rigid_as_possible::{Pull, deformed};
use crate::numerics::cholesky::FactorisationError;

/// The cost of a pair of samples, as the warp reckons it, at which its weight has fallen to 1/e.
const SIGMA: f64 = 0.15;
/// Samples over which the warp is smoothed.
const WIDTH: f64 = 3.0;
/// The share of the largest cost of a pair from which nothing is known of it: costs are cut off there.
const UNKNOWN: f64 = 0.95;
/// A vertex of the outline further than this from the sampled outline is not pulled.
const OFF: f64 = 0.03;
/// How far the closest point of the other outline may be, and the cosine of the angle between the tangents.
const REACH: f64 = 0.06;
const PARALLEL: f64 = 0.6;
/// Rounds of closest points, and the share of its weight the warp keeps in them.
const ROUNDS: usize = 2;
const KEPT: f64 = 0.3;
/// What a landmark weighs beside a vertex of the outline.
const PINNED: f64 = 50.0;
/// Points of the view's outline per sample among which the closest is looked for.
const FINENESS: usize = 4;

/// A sketch laid on a view.
#[derive(Clone)]
pub struct Laying {
    /// m × 2, in the plane of the view's picture.
    pub positions: Vec<[f64; 2]>,
    /// For every vertex of the sketch's outline the smoothed cost of its pair.
    pub costs: Vec<f64>,
    /// The cost of the warp as a whole.
    pub cost: f64,
    /// Whether it is the mirror image of what was laid.
    pub reflected: bool,
}

impl Laying {
    /// The same places in the picture of the camera on the other side.
    pub fn turned_round(&self) -> Laying {
        let positions = self.positions.iter().map(|&[x, y]| [-x, y]).collect();
        Laying { positions, reflected: !self.reflected, ..self.clone() }
    }
}

/// The sketch laid on the view by a warp of the contours, whose `differences` are 110 × 110, and by
/// vertices whose place in the picture is known.
///
/// # Errors
/// Where the deformation is undetermined.
pub fn laid(
    shape: &FlatShape,
    view: &View,
    differences: &[f32],
    warp: &Warp,
    pinned: &[(u32, [f64; 2])],
) -> Result<Laying, FactorisationError> {
    let smooth = SmoothWarp::of(warp, differences);
    let density = warp.path.len() as f64 / shape.outline.len() as f64;

    let (mut pulls, mut costs) = (Vec::new(), Vec::new());
    for &v in &shape.outline {
        let (parameter, gap) = nearest_parameter(&shape.contour.curve, shape.positions[v as usize]);
        let (image, cost) = smooth.at(parameter);
        let sure = cost < UNKNOWN * f64::from(TRUNCATE) && gap < OFF;
        let weight = if sure { 2.0 * density * weight(cost) } else { 0.0 } + 1e-6;
        pulls.push(Pull { vertex: v, target: point_at(&view.contour.curve, image), weight });
        costs.push(cost);
    }
    let pin = |&(vertex, target): &(u32, [f64; 2])| Pull { vertex, target, weight: PINNED * density };
    pulls.extend(pinned.iter().map(pin));
    let mut positions = deformed(&shape.elastic, &shape.positions, &pulls)?;

    let fine: Vec<[f64; 2]> =
        (0..FINENESS * SAMPLES).map(|i| point_at(&view.contour.curve, i as f64 / FINENESS as f64)).collect();
    let tangents = tangents(&fine);
    let kept: Vec<Pull> = pulls[..shape.outline.len()]
        .iter()
        .map(|p| Pull { weight: KEPT * p.weight, ..*p })
        .chain(pinned.iter().map(pin))
        .collect();
    for _ in 0..ROUNDS {
        let outline: Vec<[f64; 2]> = shape.outline.iter().map(|&v| positions[v as usize]).collect();
        let own = self::tangents(&outline);
        let mut pulls = kept.clone();
        for ((&vertex, &at), &along) in shape.outline.iter().zip(&outline).zip(&own) {
            if let Some(target) = closest(&fine, &tangents, at, along) {
                pulls.push(Pull { vertex, target, weight: density });
            }
        }
        positions = deformed(&shape.elastic, &shape.positions, &pulls)?;
    }
    Ok(Laying { positions, costs, cost: cost_along(&warp.path, differences), reflected: false })
}

fn weight(cost: f64) -> f64 {
    (-(cost / SIGMA).powi(2)).exp()
}

/// The warp as a function of arc length.
struct SmoothWarp {
    /// For every sample of the sketch its place on the view's outline in samples, unwrapped: it grows by about
    /// `SAMPLES` once round.
    images: Vec<f64>,
    costs: Vec<f64>,
}

impl SmoothWarp {
    /// The weighted mean of the partners of every sample, its offset from the uniform warp smoothed by a Gaussian.
    fn of(warp: &Warp, differences: &[f32]) -> SmoothWarp {
        let (mut total, mut image, mut cost) = (vec![0.0; SAMPLES], vec![0.0; SAMPLES], vec![0.0; SAMPLES]);
        let mut turns = 0.0;
        let mut last = None;
        for &(i, j) in &warp.path {
            if last.is_some_and(|last| j < last) {
                turns += SAMPLES as f64;
            }
            last = Some(j);
            let c = f64::from(differences[i * SAMPLES + j]).min(f64::from(TRUNCATE));
            let w = weight(c) + 1e-3;
            total[i] += w;
            image[i] += w * (j as f64 + turns);
            cost[i] += w * c;
        }
        // Every sample has a partner, since the path takes no step across one.
        let offsets: Vec<f64> = (0..SAMPLES).map(|i| image[i] / total[i] - i as f64).collect();
        let costs: Vec<f64> = (0..SAMPLES).map(|i| cost[i] / total[i]).collect();
        let reach = (2.0 * WIDTH) as isize;
        let images = (0..SAMPLES)
            .map(|i| {
                let (mut top, mut bottom) = (0.0, 0.0);
                for d in -reach..=reach {
                    let near = (i as isize + d).rem_euclid(SAMPLES as isize) as usize;
                    let w = (weight(costs[near]) + 1e-3) * (-0.5 * (d as f64 / WIDTH).powi(2)).exp();
                    top += w * offsets[near];
                    bottom += w;
                }
                i as f64 + top / bottom
            })
            .collect();
        SmoothWarp { images, costs }
    }

    /// The image and the cost at a place of the sketch's outline, in samples.
    fn at(&self, parameter: f64) -> (f64, f64) {
        let i = parameter as usize % SAMPLES;
        let f = parameter - parameter.floor();
        let next = (i + 1) % SAMPLES;
        let beyond = if next == 0 { self.images[0] + SAMPLES as f64 } else { self.images[next] };
        (self.images[i] * (1.0 - f) + beyond * f, self.costs[i] * (1.0 - f) + self.costs[next] * f)
    }
}

/// The place of a closed polygon nearest to a point, as index + fraction, and how far it is.
fn nearest_parameter(curve: &[[f64; 2]], [x, y]: [f64; 2]) -> (f64, f64) {
    let mut best = (0.0, f64::INFINITY);
    for (i, &a) in curve.iter().enumerate() {
        let b = curve[(i + 1) % curve.len()];
        let edge = [b[0] - a[0], b[1] - a[1]];
        let along = (x - a[0]) * edge[0] + (y - a[1]) * edge[1];
        let t = (along / (edge[0] * edge[0] + edge[1] * edge[1]).max(1e-12)).clamp(0.0, 1.0);
        let gap = (x - a[0] - t * edge[0]).powi(2) + (y - a[1] - t * edge[1]).powi(2);
        if gap < best.1 {
            best = (i as f64 + t, gap);
        }
    }
    (best.0, best.1.sqrt())
}

/// The point of a closed polygon at index + fraction.
fn point_at(curve: &[[f64; 2]], parameter: f64) -> [f64; 2] {
    let t = parameter.rem_euclid(curve.len() as f64);
    let i = t as usize % curve.len();
    let f = t - t.floor();
    let (a, b) = (curve[i], curve[(i + 1) % curve.len()]);
    [a[0] * (1.0 - f) + b[0] * f, a[1] * (1.0 - f) + b[1] * f]
}

/// The unit tangents of a closed polygon at its points.
fn tangents(curve: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let n = curve.len();
    (0..n)
        .map(|i| {
            let (a, b) = (curve[(i + n - 1) % n], curve[(i + 1) % n]);
            let length = (b[0] - a[0]).hypot(b[1] - a[1]) + 1e-12;
            [(b[0] - a[0]) / length, (b[1] - a[1]) / length]
        })
        .collect()
}

/// The nearest point within reach whose tangent is about parallel.
fn closest(curve: &[[f64; 2]], tangents: &[[f64; 2]], at: [f64; 2], along: [f64; 2]) -> Option<[f64; 2]> {
    let mut best = (REACH * REACH, None);
    for (&point, tangent) in curve.iter().zip(tangents) {
        let distance = (point[0] - at[0]).powi(2) + (point[1] - at[1]).powi(2);
        if distance < best.0 && along[0] * tangent[0] + along[1] * tangent[1] > PARALLEL {
            best = (distance, Some(point));
        }
    }
    best.1
}
