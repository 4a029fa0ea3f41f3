//! The surface a camera sees: from points of a picture to points of the mesh.

use super::frame::Frame;

/// Pixels along the longer side of the picture.
const SIDE: usize = 640;
/// Empty border, so that points just outside of the silhouette have pixels.
const MARGIN: f64 = 24.0;
const NOTHING: u32 = u32::MAX;

/// For every pixel of a view the triangle in front.
pub struct Visible<'a> {
    points: Vec<[f64; 3]>,
    triangles: &'a [[u32; 3]],
    low: [f64; 2],
    scale: f64,
    front: Vec<u32>,
    /// For every pixel the nearest one that shows a triangle.
    nearest: Vec<u32>,
}

impl<'a> Visible<'a> {
    /// The view of the mesh through a parallel projection.
    pub fn new(positions: &[[f64; 3]], triangles: &'a [[u32; 3]], frame: &Frame) -> Visible<'a> {
        let points: Vec<[f64; 3]> = positions
            .iter()
            .map(|&p| {
                let [x, y] = frame.project(p);
                [x, y, frame.depth(p)]
            })
            .collect();
        let bound =
            |axis: usize, pick: fn(f64, f64) -> f64, start: f64| points.iter().map(|p| p[axis]).fold(start, pick);
        let low = [bound(0, f64::min, f64::INFINITY), bound(1, f64::min, f64::INFINITY)];
        let high = [bound(0, f64::max, f64::NEG_INFINITY), bound(1, f64::max, f64::NEG_INFINITY)];
        let extent = (high[0] - low[0]).max(high[1] - low[1]).max(f64::MIN_POSITIVE);
        let scale = (SIDE as f64 - 2.0 * MARGIN) / extent;
        let mut view = Visible { points, triangles, low, scale, front: Vec::new(), nearest: Vec::new() };
        view.front = view.drawn();
        view.nearest = nearest_filled(&view.front);
        view
    }

    /// The triangle in front of every pixel's centre.
    fn drawn(&self) -> Vec<u32> {
        let mut front = vec![NOTHING; SIDE * SIDE];
        let mut depth = vec![f64::NEG_INFINITY; SIDE * SIDE];
        for (t, &triangle) in self.triangles.iter().enumerate() {
            let corners = triangle.map(|v| self.pixel(self.points[v as usize]));
            let heights = triangle.map(|v| self.points[v as usize][2]);
            let range = |axis: usize| {
                let least = corners.iter().map(|c| c[axis]).fold(f64::INFINITY, f64::min);
                let most = corners.iter().map(|c| c[axis]).fold(f64::NEG_INFINITY, f64::max);
                (least.ceil().max(0.0) as usize)..((most.floor() + 1.0).clamp(0.0, SIDE as f64) as usize)
            };
            for y in range(1) {
                for x in range(0) {
                    let Some(weights) = barycentric(corners, [x as f64, y as f64]) else { continue };
                    if weights.iter().any(|&w| w < -1e-9) {
                        continue;
                    }
                    let z: f64 = weights.iter().zip(heights).map(|(w, h)| w * h).sum();
                    let at = y * SIDE + x;
                    if z > depth[at] {
                        depth[at] = z;
                        front[at] = t as u32;
                    }
                }
            }
        }
        front
    }

    fn pixel(&self, point: [f64; 3]) -> [f64; 2] {
        [(point[0] - self.low[0]) * self.scale + MARGIN, (point[1] - self.low[1]) * self.scale + MARGIN]
    }

    /// The vertex of the mesh in front of a point of the picture; outside of the silhouette, of the nearest point.
    pub fn vertex(&self, point: [f64; 2]) -> u32 {
        let pixel = self.pixel([point[0], point[1], 0.0]);
        let [x, y] = pixel.map(|c| c.round().clamp(0.0, SIDE as f64 - 1.0) as usize);
        // A picture that shows no triangle has no nearest pixel.
        let Some(&t) = self.front.get(self.nearest[y * SIDE + x] as usize) else { return 0 };
        let triangle = self.triangles[t as usize];
        let squared = |v: &u32| {
            let p = self.points[*v as usize];
            (p[0] - point[0]).powi(2) + (p[1] - point[1]).powi(2)
        };
        triangle.into_iter().min_by(|a, b| squared(a).total_cmp(&squared(b))).unwrap_or(triangle[0])
    }
}

/// The weights of the corners at a point, nothing where the triangle is seen edge-on.
pub(crate) fn barycentric([a, b, c]: [[f64; 2]; 3], [x, y]: [f64; 2]) -> Option<[f64; 3]> {
    let doubled = (b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1]);
    if doubled == 0.0 {
        return None;
    }
    let part = |p: [f64; 2], q: [f64; 2]| ((p[0] - x) * (q[1] - y) - (q[0] - x) * (p[1] - y)) / doubled;
    Some([part(b, c), part(c, a), part(a, b)])
}

/// For every pixel the nearest filled one, by two passes over the picture [Dan80].
fn nearest_filled(front: &[u32]) -> Vec<u32> {
    let mut nearest: Vec<u32> =
        front.iter().enumerate().map(|(i, &t)| if t == NOTHING { NOTHING } else { i as u32 }).collect();
    let squared = |at: usize, to: u32| {
        let to = to as usize;
        let (dx, dy) = ((at % SIDE).abs_diff(to % SIDE), (at / SIDE).abs_diff(to / SIDE));
        dx * dx + dy * dy
    };
    let mut look = |at: usize, from: usize| {
        let candidate = nearest[from];
        if candidate != NOTHING && (nearest[at] == NOTHING || squared(at, candidate) < squared(at, nearest[at])) {
            nearest[at] = candidate;
        }
    };
    for y in 0..SIDE {
        for x in 0..SIDE {
            let at = y * SIDE + x;
            if x > 0 {
                look(at, at - 1);
            }
            if y > 0 {
                (x.saturating_sub(1)..=(x + 1).min(SIDE - 1)).for_each(|n| look(at, (y - 1) * SIDE + n));
            }
        }
        (0..SIDE - 1).rev().for_each(|x| look(y * SIDE + x, y * SIDE + x + 1));
    }
    for y in (0..SIDE).rev() {
        for x in (0..SIDE).rev() {
            let at = y * SIDE + x;
            if x + 1 < SIDE {
                look(at, at + 1);
            }
            if y + 1 < SIDE {
                (x.saturating_sub(1)..=(x + 1).min(SIDE - 1)).for_each(|n| look(at, (y + 1) * SIDE + n));
            }
        }
        (1..SIDE).for_each(|x| look(y * SIDE + x, y * SIDE + x - 1));
    }
    nearest
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::alignment::solids::sphere;
    use crate::mesh::dot;

    #[test]
    fn of_a_sphere_the_side_towards_the_camera_is_seen() {
        let mesh = sphere(24, 48);
        for direction in [[0.0, 0.0, 1.0], [1.0, -2.0, 0.5]] {
            let frame = Frame::looking_from(direction);
            let visible = Visible::new(mesh.positions(), mesh.triangles(), &frame);
            for &position in mesh.positions() {
                let seen = mesh.positions()[visible.vertex(frame.project(position)) as usize];
                let ([x, y], [u, v]) = (frame.project(position), frame.project(seen));
                // Near the rim the nearest vertex of the triangle in front may lie just behind it.
                assert!((x - u).hypot(y - v) < 0.12 && frame.depth(seen) > -0.1, "{position:?} {seen:?}");
                let front = frame.depth(position) > 0.2;
                assert!(!front || dot(position, seen) > 0.0);
            }
        }
    }

    #[test]
    fn a_point_outside_sees_the_nearest_of_the_outline() {
        let positions = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let triangles = [[0, 1, 2]];
        let visible = Visible::new(&positions, &triangles, &Frame::looking_from([0.0, 0.0, 1.0]));
        let frame = Frame::looking_from([0.0, 0.0, 1.0]);
        for (v, position) in positions.iter().enumerate() {
            let away = position.map(|x| 1.5 * x - 0.2);
            assert_eq!(visible.vertex(frame.project(away)), v as u32);
        }
        assert_eq!(Visible::new(&positions, &[], &frame).vertex([5.0, 5.0]), 0);
    }
}
