//! The two bodies, in metres or thereabouts.

use super::body::{Body, Limb, Stride};

/// A cat in mid-stride, 0.9 high at the ears and 1.6 long with its tail.
pub(super) fn quadruped() -> Body {
    let middle = vec![
        // Chest, belly and hips.
        Limb::new([0.0, 0.43, 0.20], [0.0, 0.45, -0.26], [0.155, 0.135]).stretched([0.85, 1.0, 1.0]),
        // Neck, head, snout.
        Limb::new([0.0, 0.47, 0.26], [0.0, 0.68, 0.44], [0.12, 0.085]),
        Limb::ellipsoid([0.0, 0.73, 0.49], [0.105, 0.10, 0.115]),
        Limb::new([0.0, 0.70, 0.54], [0.0, 0.685, 0.62], [0.065, 0.045]),
        // Tail.
        Limb::new([0.0, 0.51, -0.34], [0.0, 0.56, -0.55], [0.055, 0.045]),
        Limb::new([0.0, 0.56, -0.55], [0.0, 0.55, -0.75], [0.045, 0.042]),
        Limb::new([0.0, 0.55, -0.75], [0.0, 0.66, -0.93], [0.042, 0.036]),
    ];
    let left = vec![
        // Ear.
        Limb::new([0.062, 0.79, 0.48], [0.080, 0.905, 0.465], [0.048, 0.014]),
        // Fore leg: shoulder, upper arm, forearm, paw.
        Limb::new([0.075, 0.42, 0.23], [0.095, 0.29, 0.20], [0.085, 0.055]),
        Limb::new([0.095, 0.29, 0.20], [0.095, 0.10, 0.22], [0.052, 0.040]),
        Limb::new([0.095, 0.10, 0.22], [0.095, 0.045, 0.225], [0.040, 0.040]),
        Limb::new([0.095, 0.045, 0.225], [0.095, 0.038, 0.275], [0.042, 0.038]),
        // Hind leg: thigh, shin, metatarsus, paw.
        Limb::new([0.075, 0.42, -0.25], [0.10, 0.29, -0.20], [0.105, 0.065]),
        Limb::new([0.10, 0.29, -0.20], [0.10, 0.16, -0.31], [0.058, 0.040]),
        Limb::new([0.10, 0.16, -0.31], [0.10, 0.05, -0.28], [0.039, 0.039]),
        Limb::new([0.10, 0.045, -0.27], [0.10, 0.038, -0.215], [0.042, 0.038]),
    ];
    Body::new(middle, left, 0.012, Stride { length: 0.15, hip: 0.46, turn: 0.05 })
}

/// A standing person, 1.75 high, arms a little away from the body and feet pointing forwards.
pub(super) fn biped() -> Body {
    let middle = vec![
        // Head, nose, neck.
        Limb::ellipsoid([0.0, 1.62, 0.015], [0.09, 0.13, 0.11]),
        Limb::ellipsoid([0.0, 1.60, 0.12], [0.022, 0.032, 0.035]),
        Limb::new([0.0, 1.42, -0.01], [0.0, 1.54, 0.0], [0.065, 0.055]),
        // Chest, waist, hips.
        Limb::new([0.0, 1.29, 0.0], [0.0, 1.08, 0.0], [0.125, 0.105]).stretched([1.3, 1.0, 0.9]),
        Limb::new([0.0, 1.08, 0.0], [0.0, 0.95, -0.01], [0.105, 0.115]).stretched([1.3, 1.0, 1.0]),
    ];
    let left = vec![
        // Shoulder, upper arm, forearm, hand.
        Limb::new([0.05, 1.40, -0.01], [0.19, 1.365, -0.01], [0.065, 0.062]),
        Limb::new([0.19, 1.365, -0.01], [0.35, 1.12, -0.02], [0.060, 0.045]),
        Limb::new([0.35, 1.12, -0.02], [0.47, 0.88, 0.03], [0.047, 0.036]),
        Limb::new([0.47, 0.88, 0.03], [0.51, 0.78, 0.055], [0.040, 0.038]).stretched([0.9, 1.0, 1.1]),
        // Thigh, shin, foot.
        Limb::new([0.09, 0.90, -0.01], [0.115, 0.50, 0.01], [0.098, 0.062]),
        Limb::new([0.115, 0.50, 0.01], [0.13, 0.10, -0.02], [0.066, 0.045]),
        Limb::new([0.13, 0.10, -0.02], [0.13, 0.055, -0.025], [0.045, 0.048]),
        Limb::new([0.13, 0.055, -0.025], [0.145, 0.038, 0.15], [0.048, 0.038]),
    ];
    Body::new(middle, left, 0.014, Stride { length: 0.0, hip: 1.0, turn: 0.1 })
}
