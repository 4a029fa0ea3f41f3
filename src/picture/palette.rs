//! The colour of every place of a sketch.

use super::colour::Colour;
use crate::mesh::TriangleMesh;

/// Lightness at the low and at the high end of the shorter side.
const LIGHTNESS: [f64; 2] = [0.54, 0.86];
/// As much as most hues have at these lightnesses.
const CHROMA: f64 = 0.16;
/// The hue at the start, in turns, and how far it goes along the longer side: not all the way round, so that the two
/// ends differ; and along the shorter side.
const HUE: f64 = 0.72;
const ALONG: f64 = -0.8;
const ACROSS: f64 = -0.1;

/// Confidence from which a colour is full, and up to which there is none.
const SURE: f64 = 0.7;
const UNSURE: f64 = 0.3;

/// The grey of what is matched without confidence.
const DOUBTFUL: f64 = 0.76;

/// The colour of every vertex of a flat mesh by its place in the bounding box: the hue goes along the longer side, the
/// lightness along the shorter. No place is grey, near places look alike and far ones do not.
pub fn colours(mesh: &TriangleMesh) -> Vec<Colour> {
    let bound =
        |axis: usize, pick: fn(f64, f64) -> f64, start: f64| mesh.positions().iter().map(|p| p[axis]).fold(start, pick);
    let low = [0, 1].map(|axis| bound(axis, f64::min, f64::INFINITY));
    let extent = [0, 1].map(|axis| bound(axis, f64::max, f64::NEG_INFINITY) - low[axis]);
    let long = usize::from(extent[1] > extent[0]);
    // The mesh has a triangle, and so an extent along the longer side.
    let place = |p: &[f64; 3], axis: usize| {
        if extent[axis] > 0.0 { ((p[axis] - low[axis]) / extent[axis]).clamp(0.0, 1.0) } else { 0.5 }
    };
    mesh.positions().iter().map(|p| colour(place(p, long), place(p, 1 - long))).collect()
}

/// The colour of a place, `along` the longer side and `across`, both in `[0, 1]`.
fn colour(along: f64, across: f64) -> Colour {
    let lightness = LIGHTNESS[0] + across * (LIGHTNESS[1] - LIGHTNESS[0]);
    Colour::of(lightness, CHROMA, HUE + along * ALONG + across * ACROSS)
}

/// The colour as far as it is believed: full from a confidence of 0.7, grey up to one of 0.3.
pub fn believed(colour: Colour, confidence: f64) -> Colour {
    let doubt = ((SURE - confidence) / (SURE - UNSURE)).clamp(0.0, 1.0);
    colour.mixed(Colour::grey(DOUBTFUL), doubt)
}

#[cfg(test)]
mod tests {
    use super::super::colour::difference;
    use super::*;

    fn chroma(colour: Colour) -> f64 {
        let [_, a, b] = colour.oklab();
        a.hypot(b)
    }

    #[test]
    fn near_places_look_alike_and_far_ones_do_not() {
        let places: Vec<[f64; 2]> = (0..441).map(|i| [f64::from(i % 21) / 20.0, f64::from(i / 21) / 20.0]).collect();
        for p in &places {
            for q in &places {
                let apart = (p[0] - q[0]).hypot(p[1] - q[1]);
                let seen = difference(colour(p[0], p[1]), colour(q[0], q[1]));
                assert!(apart > 0.06 || seen < 0.09, "{p:?} {q:?} {seen}");
                assert!(apart < 0.5 || seen > 0.05, "{p:?} {q:?} {seen}");
            }
            assert!(chroma(colour(p[0], p[1])) > 0.06, "{p:?}");
        }
    }

    #[test]
    fn the_colour_has_no_jumps() {
        for step in 0..10_000 {
            let t = f64::from(step) / 1e4;
            let jump = difference(colour(t, 1.0 - t), colour(t + 1e-4, 1.0 - t - 1e-4));
            assert!(jump < 2e-3, "{t}: {jump}");
        }
    }

    #[test]
    fn the_hue_goes_along_the_longer_side() {
        let triangle = |corners: [[f64; 3]; 3]| TriangleMesh::new(corners.to_vec(), vec![[0, 1, 2]]).unwrap();
        let wide = colours(&triangle([[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [4.0, 1.0, 0.0]]));
        assert_eq!(wide, [colour(0.0, 0.0), colour(1.0, 0.0), colour(1.0, 1.0)]);
        let tall = colours(&triangle([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 4.0, 0.0]]));
        assert_eq!(tall, [colour(0.0, 0.0), colour(0.0, 1.0), colour(1.0, 1.0)]);
    }

    #[test]
    fn doubt_is_grey() {
        let vivid = colour(0.5, 0.5);
        assert!(difference(believed(vivid, 0.7), vivid) < 1e-6 && difference(believed(vivid, 1.0), vivid) < 1e-6);
        for confidence in [0.0, 0.3] {
            assert!(difference(believed(vivid, confidence), Colour::grey(DOUBTFUL)) < 1e-6);
        }
        assert!((chroma(believed(vivid, 0.5)) - 0.5 * chroma(vivid)).abs() < 1e-3);
    }
}
