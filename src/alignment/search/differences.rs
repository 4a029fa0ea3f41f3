//! How different the outlines of the sketch and of a view are where up is known: what is high in the drawing is high on the
//! body.

use crate::alignment::contour::view::View;
use crate::alignment::contour::warping::{self, TRUNCATE};
use crate::alignment::contour::{Contour, SAMPLES};
use crate::alignment::scene::Scene;

/// What the heights of two samples in their boxes weigh beside their shape contexts, and their places across.
const HEIGHT: f32 = 0.1;
const ACROSS: f32 = 0.05;
/// A camera that sees less of up than this looks at the body from above or from below.
const STEEP: f64 = 0.5;
/// The mean difference of two unrelated heights.
const UNRELATED: f32 = 0.25;

/// How different every two samples of the sketch's outline and the view's are (110 × 110), their places in the upright
/// boxes about the outlines included where up is known.
pub fn differences(scene: &Scene<'_>, view: &View) -> Vec<f32> {
    let mut differences = warping::differences(&scene.shape.contour, &view.contour);
    let Some(upright) = scene.upright else { return differences };
    let up = view.frame.project(upright.mesh);
    if up[0].hypot(up[1]) < STEEP {
        for difference in &mut differences {
            *difference = (*difference + UNRELATED * (HEIGHT + ACROSS)).min(TRUNCATE);
        }
        return differences;
    }
    let (own, other) = (boxed(&scene.shape.contour, upright.sketch), boxed(&view.contour, up));
    for (row, [x, y]) in differences.chunks_exact_mut(SAMPLES).zip(own) {
        for (difference, [u, v]) in row.iter_mut().zip(&other) {
            *difference = (*difference + HEIGHT * (y - v).abs() + ACROSS * (x - u).abs()).min(TRUNCATE);
        }
    }
    differences
}

/// The places of the samples in the box about them that stands in the direction of `up`, each coordinate from 0 to 1.
fn boxed(contour: &Contour, up: [f64; 2]) -> Vec<[f32; 2]> {
    let length = up[0].hypot(up[1]);
    let [sin, cos] = up.map(|x| x / length);
    let turned: Vec<[f64; 2]> = contour.curve.iter().map(|[x, y]| [x * cos - y * sin, x * sin + y * cos]).collect();
    let bound = |axis: usize, pick: fn(f64, f64) -> f64, start: f64| turned.iter().map(|p| p[axis]).fold(start, pick);
    let low = [0, 1].map(|axis| bound(axis, f64::min, f64::INFINITY));
    let extent = [0, 1].map(|axis| (bound(axis, f64::max, f64::NEG_INFINITY) - low[axis]).max(f64::MIN_POSITIVE));
    turned.iter().map(|p| [0, 1].map(|axis| ((p[axis] - low[axis]) / extent[axis]) as f32)).collect()
}
