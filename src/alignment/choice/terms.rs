//! What speaks against an attempt, and what each of it weighs.

/// Makes the terms of their list: what each is, its name and its weight.
macro_rules! terms {
    ($($(#[$about:meta])* $name:ident weighs $weight:literal,)+) => {
        /// Costs of an attempt, each the less the better.
        #[derive(Clone, Copy, Debug, Default, PartialEq)]
        pub struct Terms {
            $($(#[$about])* pub $name: f64,)+
        }

        impl Terms {
            const COUNT: usize = Terms::NAMES.len();

            /// The names of the values.
            pub const NAMES: &[&str] = &[$(stringify!($name),)+];

            /// In the order of their names.
            pub fn values(&self) -> [f64; Terms::COUNT] {
                [$(self.$name,)+]
            }
        }

        /// What each weighs, in the order of the values; the outlines' cost is the unit.
        pub const WEIGHTS: [f64; Terms::COUNT] = [$($weight,)+];
    };
}

terms! {
    /// What the outlines cost per sample, in [0, 0.4].
    contour weighs 1.0,
    /// Mean distortion of geodesic distances, in [0, 0.4].
    distortion weighs 0.8,
    /// All swings and bends together, in radians.
    swing weighs 0.005,
    /// The logarithms of all changes of length together.
    stretch weighs 0.016,
    /// 1 for a view from anywhere, 0 for one along an axis of the body.
    sphere weighs 0.025,
    /// (1 − cos)/2 of the angle between the ups of the drawing and of the mesh.
    tilt weighs 0.06,
    /// 1 − the area that figure and silhouette share over that which they cover.
    mismatch weighs 0.08,
    /// 1 − the rank correlation of heights in the drawing and on the body.
    disorder weighs 0.03,
    /// The share of the mesh's side in front that no answer is near.
    uncovered weighs 0.17,
    /// How much figure and silhouette reach over their feet on different sides, from 0 to 1.
    turned_about weighs 0.1,
    /// 1 − cos of the angle between the camera and the side such a body is mostly drawn from.
    askew weighs 0.05,
    /// How far from the top of the body drawn eyes are answered, from 0 to 1.
    eyes_astray weighs 0.08,
}

impl Terms {
    /// The weighted sum.
    pub fn score(&self) -> f64 {
        self.values().iter().zip(WEIGHTS).map(|(value, weight)| value * weight).sum()
    }
}
