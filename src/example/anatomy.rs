//! The two bodies, in metres or thereabouts.

use super::body::{Body, Limb, Stride};

/// A cat in mid-stride, 0.9 high at the ears and 1.7 long with its tail.
pub(super) fn quadruped() -> Body {
    let trunk = Limb::new(&[([0.0, 0.43, 0.20], 0.155), ([0.0, 0.46, -0.02], 0.138), ([0.0, 0.45, -0.26], 0.145)]);
    let middle = vec![
        trunk.stretched([0.85, 1.0, 1.0]),
        // Neck, head, snout.
        Limb::new(&[([0.0, 0.47, 0.25], 0.125), ([0.0, 0.67, 0.43], 0.085)]),
        Limb::ellipsoid([0.0, 0.725, 0.475], [0.112, 0.10, 0.112]),
        Limb::ellipsoid([0.0, 0.69, 0.565], [0.062, 0.05, 0.06]),
        // Tail.
        Limb::new(&[
            ([0.0, 0.51, -0.34], 0.058),
            ([0.0, 0.55, -0.48], 0.048),
            ([0.0, 0.555, -0.61], 0.043),
            ([0.0, 0.56, -0.74], 0.042),
            ([0.0, 0.60, -0.86], 0.041),
            ([0.0, 0.68, -0.95], 0.038),
        ]),
    ];
    let left = vec![
        // Ear.
        Limb::new(&[([0.066, 0.785, 0.465], 0.055), ([0.083, 0.90, 0.45], 0.017)]),
        // Fore leg: shoulder, elbow, wrist, heel, toes.
        Limb::new(&[
            ([0.075, 0.42, 0.23], 0.092),
            ([0.095, 0.28, 0.195], 0.058),
            ([0.095, 0.10, 0.22], 0.042),
            ([0.095, 0.045, 0.225], 0.045),
            ([0.095, 0.042, 0.28], 0.042),
        ]),
        // Hind leg: hip, knee, hock, heel, toes.
        Limb::new(&[
            ([0.072, 0.42, -0.26], 0.115),
            ([0.10, 0.28, -0.20], 0.068),
            ([0.10, 0.16, -0.31], 0.044),
            ([0.10, 0.045, -0.28], 0.045),
            ([0.10, 0.042, -0.215], 0.042),
        ]),
    ];
    Body::new(middle, left, 0.018, Stride { length: 0.15, hip: 0.46, turn: 0.05 })
}

/// A standing person, 1.75 high, arms a little away from the body and feet pointing forwards.
pub(super) fn biped() -> Body {
    let trunk = Limb::new(&[([0.0, 1.30, 0.0], 0.125), ([0.0, 1.10, 0.01], 0.105), ([0.0, 0.95, -0.01], 0.122)]);
    let middle = vec![
        trunk.stretched([1.28, 1.0, 0.9]),
        // Head, nose, neck.
        Limb::ellipsoid([0.0, 1.62, 0.02], [0.09, 0.125, 0.11]),
        Limb::ellipsoid([0.0, 1.605, 0.125], [0.02, 0.03, 0.03]),
        Limb::new(&[([0.0, 1.40, -0.015], 0.07), ([0.0, 1.54, 0.0], 0.058)]),
    ];
    let left = vec![
        // Arm: collar, shoulder, elbow, wrist, palm, finger tips.
        Limb::new(&[
            ([0.05, 1.40, -0.01], 0.065),
            ([0.185, 1.37, -0.01], 0.068),
            ([0.34, 1.12, -0.02], 0.048),
            ([0.455, 0.89, 0.02], 0.038),
            ([0.485, 0.825, 0.035], 0.043),
            ([0.51, 0.77, 0.05], 0.038),
        ]),
        // Leg: hip, thigh, knee, calf, ankle, heel, toes.
        Limb::new(&[
            ([0.095, 0.92, -0.01], 0.105),
            ([0.115, 0.72, 0.005], 0.09),
            ([0.135, 0.49, 0.005], 0.064),
            ([0.145, 0.36, -0.015], 0.064),
            ([0.155, 0.11, -0.02], 0.046),
            ([0.155, 0.055, -0.03], 0.052),
            ([0.17, 0.042, 0.15], 0.043),
        ]),
    ];
    Body::new(middle, left, 0.018, Stride { length: 0.0, hip: 1.0, turn: 0.1 })
}
