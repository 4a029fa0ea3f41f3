//! The axes of a view.

use serde::{Deserialize, Serialize};

use super::{cross, dot, unit};

/// An orthonormal right-handed frame of a parallel projection: the picture's axes and the direction to the camera.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Frame {
    pub right: [f64; 3],
    pub up: [f64; 3],
    pub toward_camera: [f64; 3],
}

impl Frame {
    /// The frame that looks along −`toward_camera`, a vector of any positive length; its roll is arbitrary but fixed.
    pub fn looking_from(toward_camera: [f64; 3]) -> Frame {
        let toward_camera = unit(toward_camera);
        let pole = if toward_camera[2].abs() < 0.9 { [0.0, 0.0, 1.0] } else { [0.0, 1.0, 0.0] };
        let along = dot(pole, toward_camera);
        let up = unit(std::array::from_fn(|i| pole[i] - along * toward_camera[i]));
        Frame { right: cross(up, toward_camera), up, toward_camera }
    }

    /// The picture turned about its middle so that the direction (x, y), of length 1, points right.
    pub fn rolled(&self, [x, y]: [f64; 2]) -> Frame {
        let Frame { right, up, toward_camera } = *self;
        Frame {
            right: std::array::from_fn(|i| x * right[i] + y * up[i]),
            up: std::array::from_fn(|i| x * up[i] - y * right[i]),
            toward_camera,
        }
    }

    /// The frame of the camera on the other side, with the same up.
    pub fn from_behind(&self) -> Frame {
        let Frame { right, up, toward_camera } = *self;
        Frame { right: right.map(|x| -x), up, toward_camera: toward_camera.map(|x| -x) }
    }

    /// The point in the plane of the picture.
    pub fn project(&self, point: [f64; 3]) -> [f64; 2] {
        [dot(self.right, point), dot(self.up, point)]
    }

    /// How near to the camera the point is.
    pub fn depth(&self, point: [f64; 3]) -> f64 {
        dot(self.toward_camera, point)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{length, subtract};

    #[test]
    fn a_frame_is_orthonormal_and_right_handed() {
        for direction in [[0.0, 0.0, 3.0], [1.0, 2.0, -0.5], [-1.0, 0.0, 0.0], [0.0, -1.0, 1e-9]] {
            let Frame { right, up, toward_camera } = Frame::looking_from(direction);
            for axis in [right, up, toward_camera] {
                assert!((length(axis) - 1.0).abs() < 1e-12);
            }
            assert!(dot(right, up).abs() < 1e-12 && dot(up, toward_camera).abs() < 1e-12);
            assert!(length(subtract(cross(right, up), toward_camera)) < 1e-12);
        }
    }

    #[test]
    fn a_rolled_frame_has_the_direction_to_the_right() {
        let frame = Frame::looking_from([1.0, 2.0, -0.5]);
        let point = [0.3, -0.7, 0.9];
        let [x, y] = frame.project(point);
        let length = x.hypot(y);
        let rolled = frame.rolled([x / length, y / length]);
        let [right, up] = rolled.project(point);
        assert!((right - length).abs() < 1e-12 && up.abs() < 1e-12);
        assert_eq!(rolled.toward_camera, frame.toward_camera);
    }
}
