//! What speaks against an attempt, and what each of it weighs.

/// Costs of an attempt, each the less the better.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Terms {
    /// What the outlines cost per sample, in [0, 0.4].
    pub contour: f64,
    /// Mean distortion of geodesic distances, in [0, 0.4].
    pub distortion: f64,
    /// All swings and bends together, in radians.
    pub swing: f64,
    /// The logarithms of all changes of length together.
    pub stretch: f64,
    /// 1 for a view from anywhere, 0 for one along an axis of the body.
    pub sphere: f64,
    /// (1 − cos)/2 of the angle between the ups of the drawing and of the mesh.
    pub tilt: f64,
    /// 1 − the area that figure and silhouette share over that which they cover.
    pub mismatch: f64,
    /// 1 − the rank correlation of heights in the drawing and on the body.
    pub disorder: f64,
    /// The share of the mesh's side in front that no answer is near.
    pub uncovered: f64,
    /// How much figure and silhouette reach over their feet on different sides, from 0 to 1.
    pub turned_about: f64,
    /// 1 − cos of the angle between the camera and the side such a body is mostly drawn from.
    pub askew: f64,
    /// How far from the top of the body drawn eyes are answered, from 0 to 1.
    pub eyes_astray: f64,
}

impl Terms {
    const COUNT: usize = 12;

    /// The names of the values.
    pub const NAMES: [&str; Terms::COUNT] = [
        "contour",
        "distortion",
        "swing",
        "stretch",
        "sphere",
        "tilt",
        "mismatch",
        "disorder",
        "uncovered",
        "turned_about",
        "askew",
        "eyes_astray",
    ];

    /// In the order of their names.
    pub fn values(&self) -> [f64; Terms::COUNT] {
        [
            self.contour,
            self.distortion,
            self.swing,
            self.stretch,
            self.sphere,
            self.tilt,
            self.mismatch,
            self.disorder,
            self.uncovered,
            self.turned_about,
            self.askew,
            self.eyes_astray,
        ]
    }

    /// The weighted sum.
    pub fn score(&self) -> f64 {
        self.values().iter().zip(WEIGHTS).map(|(value, weight)| value * weight).sum()
    }
}

/// What each weighs, in the order of the values; the outlines' cost is the unit.
pub const WEIGHTS: [f64; 12] = [1.0, 0.8, 0.005, 0.016, 0.025, 0.06, 0.08, 0.03, 0.17, 0.1, 0.05, 0.08];
