//! The axes a shape brings along, however it lies: what starts from them turns with it.

use faer::{Mat, Side};
use serde::{Deserialize, Serialize};

use super::frame::Frame;
use super::{cross, dot};

/// The n positions of a mesh about their centre of mass, divided by `scale`; the masses sum to 1.
pub fn centred(positions: &[[f64; 3]], masses: &[f64], scale: f64) -> Vec<[f64; 3]> {
    let middle: [f64; 3] = std::array::from_fn(|i| positions.iter().zip(masses).map(|(p, mass)| p[i] * mass).sum());
    positions.iter().map(|p| std::array::from_fn(|i| (p[i] - middle[i]) / scale)).collect()
}

/// The angle of the longest axis of a figure of which the sums of x² − y² and of x y about its middle are known: where the
/// quadratic form of the second moments is largest on the circle.
pub fn longest(squares: f64, product: f64) -> f64 {
    0.5 * (2.0 * product).atan2(squares)
}

/// Orthonormal axes, right-handed.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Axes([[f64; 3]; 3]);

impl Axes {
    /// The principal axes of the n masses about the origin, the longest first. The two along which they are most lopsided
    /// point to the side that reaches farther, and the third makes them right-handed.
    pub fn principal(positions: &[[f64; 3]], masses: &[f64]) -> Axes {
        let moment = |of: &dyn Fn(&[f64; 3]) -> f64| positions.iter().zip(masses).map(|(p, m)| m * of(p)).sum::<f64>();
        let squares = Mat::from_fn(3, 3, |i, j| moment(&|p| p[i] * p[j]));
        let Ok(eigen) = squares.self_adjoint_eigen(Side::Lower) else { return Axes::OWN };
        let axis = |k: usize| std::array::from_fn(|i| eigen.U()[(i, k)]);
        let mut axes: [[f64; 3]; 3] = [axis(2), axis(1), axis(0)];
        let lopsided = axes.map(|axis| {
            let spread = moment(&|&p| dot(axis, p).powi(2)).powf(1.5).max(f64::MIN_POSITIVE);
            moment(&|&p| dot(axis, p).powi(3)) / spread
        });
        for (axis, lopsided) in axes.iter_mut().zip(lopsided) {
            *axis = axis.map(|x| x * lopsided.signum());
        }
        let even = (0..3).min_by(|&a, &b| lopsided[a].abs().total_cmp(&lopsided[b].abs())).unwrap_or(2);
        axes[even] = cross(axes[(even + 1) % 3], axes[(even + 2) % 3]);
        Axes(axes)
    }

    /// Those of the coordinates themselves.
    const OWN: Axes = Axes([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);

    /// The axis along which the masses are spread most.
    pub fn longest(&self) -> [f64; 3] {
        self.0[0]
    }

    /// A vector by its components along the axes.
    pub fn along(&self, vector: [f64; 3]) -> [f64; 3] {
        self.0.map(|axis| dot(axis, vector))
    }

    /// The vector that has these components along the axes.
    pub fn back(&self, components: [f64; 3]) -> [f64; 3] {
        std::array::from_fn(|i| (0..3).map(|k| components[k] * self.0[k][i]).sum())
    }

    /// The frame that has these components along the axes.
    pub fn frame_back(&self, frame: &Frame) -> Frame {
        let [right, up, toward_camera] = [frame.right, frame.up, frame.toward_camera].map(|axis| self.back(axis));
        Frame { right, up, toward_camera }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{length, subtract};
    use crate::mesh::solids::{star, turned};

    #[test]
    fn axes_turn_with_the_body() {
        let body = star(0.2);
        let masses = vec![1.0; body.positions().len()];
        let lying: Vec<[f64; 3]> =
            body.positions().iter().map(|&[x, y, z]| [3.0 * x, 1.5 * y, z + 0.3 * x * x]).collect();
        let own = Axes::principal(&lying, &masses);
        for angles in [[0.7, 2.1], [2.5, 0.9], [-1.0, 3.0]] {
            let standing: Vec<_> = lying.iter().map(|&p| turned(p, angles)).collect();
            let axes = Axes::principal(&standing, &masses);
            for (&p, &q) in lying.iter().zip(&standing) {
                assert!(length(subtract(own.along(p), axes.along(q))) < 1e-9);
                assert!(length(subtract(axes.back(axes.along(q)), q)) < 1e-12);
            }
        }
    }

    #[test]
    fn points_in_one_place_have_axes() {
        for positions in [vec![[0.0; 3]; 4], vec![[1.0, 0.0, 0.0]; 4], vec![]] {
            let Axes(axes) = Axes::principal(&positions, &vec![1.0; positions.len()]);
            assert!(axes.iter().all(|&axis| (length(axis) - 1.0).abs() < 1e-9));
            assert!(length(subtract(cross(axes[0], axes[1]), axes[2])) < 1e-9);
        }
    }
}
