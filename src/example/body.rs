//! A smooth implicit body: stretched, tapering limbs in a soft union, standing at rest or in mid-stride.
//!
//! Axes: x to the creature's left, y up, z forwards; the ground is y = 0. The body at rest is its own mirror image in
//! the plane x = 0.

use crate::geometry::{dot, length, subtract};

/// Number of blends by which a limb has to be farther than the nearest one to change nothing but the last digits.
const REACH: f64 = 40.0;

/// A ball swept along a chain of segments while its radius changes, then stretched along the axes.
#[derive(Clone, Debug)]
pub(super) struct Limb {
    /// Before they are stretched.
    joints: Vec<Joint>,
    stretch: [f64; 3],
}

/// A centre and the radius there.
pub(super) type Joint = ([f64; 3], f64);

impl Limb {
    /// A round limb through its joints.
    pub(super) fn new(joints: &[Joint]) -> Self {
        Self { joints: joints.to_vec(), stretch: [1.0; 3] }
    }

    /// An ellipsoid with its three half axes.
    pub(super) fn ellipsoid(centre: [f64; 3], axes: [f64; 3]) -> Self {
        Self::new(&[(centre, 1.0), (centre, 1.0)]).stretched(axes)
    }

    /// The same joints with the cross-section of a round limb multiplied along every axis.
    pub(super) fn stretched(self, stretch: [f64; 3]) -> Self {
        let joints = self.joints.iter().map(|&(centre, radius)| (divided(centre, stretch), radius)).collect();
        Self { joints, stretch }
    }

    fn mirrored(&self) -> Self {
        Self { joints: self.joints.iter().map(|&(centre, radius)| (reflected(centre), radius)).collect(), ..*self }
    }

    /// The signed distance to the limb, negative inside; a lower bound of its magnitude where the limb is stretched.
    fn distance(&self, p: [f64; 3]) -> f64 {
        let p = divided(p, self.stretch);
        let segments = self.joints.windows(2).map(|ends| segment(p, [ends[0], ends[1]]));
        let narrowest = self.stretch.into_iter().fold(f64::INFINITY, f64::min);
        narrowest * segments.fold(f64::INFINITY, f64::min)
    }
}

/// The signed distance to a ball swept from a to b while its radius changes.
fn segment(p: [f64; 3], [(a, from), (b, to)]: [Joint; 2]) -> f64 {
    let (axis, reach) = (subtract(b, a), subtract(p, a));
    let squared = dot(axis, axis);
    let t = if squared > 0.0 { (dot(reach, axis) / squared).clamp(0.0, 1.0) } else { 0.0 };
    // The radius levels out at both ends, which keeps the surface smooth from one segment to the next.
    let radius = from + (to - from) * t * t * (3.0 - 2.0 * t);
    length(std::array::from_fn(|i| reach[i] - t * axis[i])) - radius
}

/// A body, left and right alike, and the pose it is drawn in.
#[derive(Clone, Debug)]
pub(super) struct Body {
    limbs: Vec<Limb>,
    /// Width of the fillet between limbs.
    blend: f64,
    stride: Stride,
}

/// How far the legs stand apart: the left ones forwards, the right ones backwards.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stride {
    /// Displacement of a foot along z.
    pub(super) length: f64,
    /// Height above which nothing moves.
    pub(super) hip: f64,
    /// Distance from the plane x = 0 over which left turns into right.
    pub(super) turn: f64,
}

impl Body {
    /// The body made of limbs in the middle plane and of left limbs, each of which is repeated on the right.
    pub(super) fn new(middle: Vec<Limb>, left: Vec<Limb>, blend: f64, stride: Stride) -> Self {
        let right: Vec<Limb> = left.iter().map(Limb::mirrored).collect();
        Self { limbs: [middle, left, right].concat(), blend, stride }
    }

    /// Near zero on the surface of the body at rest and negative inside: the soft minimum −b ln Σ exp(−dᵢ / b) of the
    /// limbs' distances, in which the order of the limbs does not matter.
    pub(super) fn field(&self, p: [f64; 3]) -> f64 {
        let (mut nearest, mut sum) = (f64::INFINITY, 0.0);
        for limb in &self.limbs {
            let d = limb.distance(p) / self.blend;
            if d < nearest {
                sum = sum * (d - nearest).exp() + 1.0;
                nearest = d;
            } else if d - nearest < REACH {
                sum += (nearest - d).exp();
            }
        }
        self.blend * (nearest - sum.ln())
    }

    /// [`Body::field`] and its gradient, by forward differences.
    pub(super) fn slope(&self, p: [f64; 3]) -> (f64, [f64; 3]) {
        const STEP: f64 = 1e-6;
        let here = self.field(p);
        let ahead = |axis| self.field(std::array::from_fn(|i| if i == axis { p[i] + STEP } else { p[i] }));
        (here, std::array::from_fn(|axis| (ahead(axis) - here) / STEP))
    }

    /// The lower and upper corner of a box around the body at rest.
    pub(super) fn bounds(&self) -> [[f64; 3]; 2] {
        let mut bounds = [[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]];
        for limb in &self.limbs {
            for (centre, radius) in &limb.joints {
                for i in 0..3 {
                    let reach = |signed: f64| (centre[i] + signed) * limb.stretch[i];
                    bounds[0][i] = bounds[0][i].min(reach(-radius) - 2.0 * self.blend);
                    bounds[1][i] = bounds[1][i].max(reach(*radius) + 2.0 * self.blend);
                }
            }
        }
        bounds
    }

    /// Where a point of the body at rest goes in the stride.
    pub(super) fn posed(&self, p: [f64; 3]) -> [f64; 3] {
        [p[0], p[1], p[2] + self.stride.shift(p)]
    }

    /// The point on the other side of the body that corresponds to a point of it, both in the stride.
    pub(super) fn opposite(&self, p: [f64; 3]) -> [f64; 3] {
        // The shift depends on x and y only, which posing leaves alone: subtracting it undoes the pose.
        let rest = [p[0], p[1], p[2] - self.stride.shift(p)];
        self.posed(reflected(rest))
    }
}

impl Stride {
    fn shift(&self, [x, y, _]: [f64; 3]) -> f64 {
        let below = (1.0 - y / self.hip).max(0.0);
        self.length * (x / self.turn).tanh() * below.powf(1.5)
    }
}

fn divided(p: [f64; 3], by: [f64; 3]) -> [f64; 3] {
    [p[0] / by[0], p[1] / by[1], p[2] / by[2]]
}

fn reflected([x, y, z]: [f64; 3]) -> [f64; 3] {
    [-x, y, z]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn body(limbs: Vec<Limb>) -> Body {
        Body::new(limbs, Vec::new(), 0.01, Stride { length: 0.2, hip: 0.5, turn: 0.1 })
    }

    #[test]
    fn a_single_ball_has_the_distance_of_a_sphere() {
        let ball = body(vec![Limb::new(&[([0.0; 3], 0.5), ([0.0; 3], 0.5)])]);
        for (p, d) in [([1.0, 0.0, 0.0], 0.5), ([0.0, 0.3, 0.4], 0.0), ([0.0; 3], -0.5)] {
            assert!((ball.field(p) - d).abs() < 1e-12);
        }
    }

    #[test]
    fn an_ellipsoid_ends_at_its_half_axes() {
        let axes = [0.1, 0.2, 0.3];
        let ellipsoid = body(vec![Limb::ellipsoid([0.0; 3], axes)]);
        for (i, axis) in axes.into_iter().enumerate() {
            let tip = std::array::from_fn(|j| if i == j { axis } else { 0.0 });
            assert!(ellipsoid.field(tip).abs() < 1e-12);
        }
    }

    #[test]
    fn the_union_is_soft_and_knows_no_order() {
        let limbs: Vec<Limb> =
            [0.0, 0.3, 0.5].map(|z| Limb::new(&[([0.0, 0.0, z], 0.2), ([0.0, 0.1, z], 0.1)])).to_vec();
        let (there, back) = (body(limbs.clone()), body(limbs.iter().rev().cloned().collect()));
        for z in [-0.5, 0.1, 0.15, 0.9] {
            let p = [0.05, 0.12, z];
            let nearest = limbs.iter().map(|l| l.distance(p)).fold(f64::INFINITY, f64::min);
            assert!((there.field(p) - back.field(p)).abs() < 1e-12);
            assert!(there.field(p) <= nearest && there.field(p) >= nearest - 0.01 * 3f64.ln());
        }
    }

    #[test]
    fn opposite_is_its_own_inverse_and_keeps_the_height() {
        let body = body(vec![Limb::new(&[([0.0; 3], 0.5), ([0.0; 3], 0.5)])]);
        let p = [0.1, 0.1, 0.3];
        let q = body.opposite(p);
        assert_eq!((q[0], q[1]), (-0.1, 0.1));
        assert!(q[2] < p[2], "the left foot stands in front of the right one");
        assert!(length(subtract(body.opposite(q), p)) < 1e-12);
    }
}
