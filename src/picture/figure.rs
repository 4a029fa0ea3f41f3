//! One of the figures of a picture: coloured triangles and lines, placed.

use super::colour::Colour;
use crate::geometry::doubled_area;

/// A rectangle of whole pixels in the picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Window {
    pub left: u32,
    pub top: u32,
    pub width: u32,
    pub height: u32,
}

/// Triangles and lines as they are drawn, in pixels of their window: x to the right, y down, z towards the viewer.
pub struct Figure {
    pub window: Window,
    pub points: Vec<[f64; 3]>,
    pub triangles: Vec<[u32; 3]>,
    /// One for every point, shading included.
    pub colours: Vec<Colour>,
    /// Outlines, in front of everything.
    pub lines: Vec<[[f64; 2]; 2]>,
}

/// From units of a shape to pixels of a window.
#[derive(Clone, Copy, Debug)]
pub struct Placement {
    pub window: Window,
    /// Pixels per unit.
    pub scale: f64,
    /// The point of the picture's plane, y up, in the middle of the window.
    pub middle: [f64; 2],
}

impl Placement {
    /// Where a point of the plane lies in the window, y down.
    pub fn pixel(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        [
            (x - self.middle[0]) * self.scale + 0.5 * f64::from(self.window.width),
            (self.middle[1] - y) * self.scale + 0.5 * f64::from(self.window.height),
        ]
    }
}

impl Figure {
    /// Twice the area of a triangle as it is seen, negative where it turns clockwise to the viewer.
    pub fn doubled_area(&self, triangle: usize) -> f64 {
        let [a, b, c] = self.triangles[triangle].map(|v| self.points[v as usize]).map(|[x, y, _]| [x, y]);
        // y points down.
        doubled_area([a, c, b])
    }
}
