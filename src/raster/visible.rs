//! The surface a camera sees: from points of a picture to points of the mesh.

use crate::geometry::doubled_area;
use crate::geometry::frame::Frame;

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
}

impl<'a> Visible<'a> {
    /// The view of the mesh through a parallel projection, of triangles that are clockwise in it nothing where the mesh is
    /// `closed`: they are behind others.
    pub fn new(positions: &[[f64; 3]], triangles: &'a [[u32; 3]], closed: bool, frame: &Frame) -> Visible<'a> {
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
        let mut view = Visible { points, triangles, low, scale, front: Vec::new() };
        view.front = view.drawn(closed);
        view
    }

    /// The triangle in front of every pixel's centre.
    fn drawn(&self, closed: bool) -> Vec<u32> {
        let mut front = vec![NOTHING; SIDE * SIDE];
        let mut depths = vec![f32::NEG_INFINITY; SIDE * SIDE];
        let corners: Vec<[f64; 3]> = self
            .points
            .iter()
            .map(|&point| {
                let [x, y] = self.pixel(point);
                [x, y, point[2]]
            })
            .collect();
        for (t, triangle) in self.triangles.iter().enumerate() {
            let corners = triangle.map(|v| corners[v as usize]);
            let doubled = doubled_area(corners.map(|[x, y, _]| [x, y]));
            if closed && doubled < 0.0 {
                continue;
            }
            let [columns, rows] = [0, 1].map(|axis| pixels(corners.map(|c| c[axis])));
            // Of a fine mesh many triangles lie between the pixels' centres.
            if columns.is_empty() || rows.is_empty() {
                continue;
            }
            let Some(plane) = Plane::through(corners, doubled) else { continue };
            for y in rows {
                for x in columns.clone() {
                    let at = y * SIDE + x;
                    let Some(depth) = plane.depth(x as f64, y as f64) else { continue };
                    if depth as f32 > depths[at] {
                        depths[at] = depth as f32;
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
        // A picture that shows no triangle has no vertex in front.
        let Some(triangle) = self.triangle(point) else { return 0 };
        let squared = |v: &u32| {
            let p = self.points[*v as usize];
            (p[0] - point[0]).powi(2) + (p[1] - point[1]).powi(2)
        };
        triangle.into_iter().min_by(|a, b| squared(a).total_cmp(&squared(b))).unwrap_or(triangle[0])
    }

    /// The place on the surface in front of a point of the picture: the triangle's vertices and their weights, which sum to
    /// 1. Outside of the silhouette it is at its rim; nothing where no triangle is shown.
    pub fn place(&self, point: [f64; 2]) -> Option<([u32; 3], [f64; 3])> {
        let triangle = self.triangle(point)?;
        let corners = triangle.map(|v| self.points[v as usize]);
        let doubled = doubled_area(corners.map(|[x, y, _]| [x, y]));
        let plane = Plane::through(corners, doubled)?;
        let [first, second] = [plane.first, plane.second].map(|f| f[0] * point[0] + f[1] * point[1] + f[2]);
        let inside = [first, second, 1.0 - first - second].map(|weight| weight.max(0.0));
        let total: f64 = inside.iter().sum();
        Some((triangle, inside.map(|weight| weight / total)))
    }

    /// The vertices of the triangle in front of a point, of the one shown nearest to it outside of the silhouette.
    fn triangle(&self, point: [f64; 2]) -> Option<[u32; 3]> {
        let pixel = self.pixel([point[0], point[1], 0.0]);
        let t = self.nearest(pixel.map(|c| c.round().clamp(0.0, SIDE as f64 - 1.0) as usize))?;
        Some(self.triangles[t as usize])
    }

    /// The triangle shown nearest to a pixel, looked for on squares of growing size around it.
    fn nearest(&self, [x, y]: [usize; 2]) -> Option<u32> {
        let mut best: Option<(usize, u32)> = None;
        for ring in 0..SIDE {
            if best.is_some_and(|(squared, _)| squared <= ring * ring) {
                break;
            }
            let mut look = |column: usize, row: usize| {
                let squared = column.abs_diff(x).pow(2) + row.abs_diff(y).pow(2);
                let t = self.front[row * SIDE + column];
                if t != NOTHING && best.is_none_or(|(least, _)| squared < least) {
                    best = Some((squared, t));
                }
            };
            let [columns, rows] = [x, y].map(|c| c.saturating_sub(ring)..=(c + ring).min(SIDE - 1));
            let sides = |c: usize| [c.checked_sub(ring), Some(c + ring).filter(|&c| c < SIDE)].into_iter().flatten();
            sides(y).for_each(|row| columns.clone().for_each(|column| look(column, row)));
            sides(x).for_each(|column| rows.clone().for_each(|row| look(column, row)));
        }
        best.map(|(_, t)| t)
    }
}

/// The pixels between the least and the largest coordinate of a triangle, within the picture; none is negative.
fn pixels([a, b, c]: [f64; 3]) -> std::ops::Range<usize> {
    let smaller = |a: f64, b: f64| if a < b { a } else { b };
    let larger = |a: f64, b: f64| if a > b { a } else { b };
    let (low, high) = (smaller(smaller(a, b), c), larger(larger(a, b), c));
    // What is not negative is rounded down.
    let below = low as i32;
    let first = below.saturating_add(i32::from(f64::from(below) < low));
    first as usize..(high as i32 as usize + 1).min(SIDE)
}

/// A triangle of the picture: the weights of two corners and the depth as linear functions of the place.
struct Plane {
    first: [f64; 3],
    second: [f64; 3],
    depth: [f64; 3],
}

/// How far outside, as a weight, a pixel's centre still belongs to a triangle, so that no seam is left open.
const SEAM: f64 = 1e-9;

impl Plane {
    /// None where the triangle, of this doubled area in the picture, is seen edge-on.
    fn through([a, b, c]: [[f64; 3]; 3], doubled: f64) -> Option<Plane> {
        if doubled == 0.0 {
            return None;
        }
        // The weight of the corner opposite the side from p to q is the doubled area over it, (p − x) × (q − x).
        let weight = |p: [f64; 3], q: [f64; 3]| {
            [(p[1] - q[1]) / doubled, (q[0] - p[0]) / doubled, (p[0] * q[1] - p[1] * q[0]) / doubled]
        };
        let (first, second) = (weight(b, c), weight(c, a));
        let third = |i: usize| if i == 2 { 1.0 - first[2] - second[2] } else { -first[i] - second[i] };
        let depth = std::array::from_fn(|i| first[i] * a[2] + second[i] * b[2] + third(i) * c[2]);
        Some(Plane { first, second, depth })
    }

    /// The depth at a place of the triangle, none outside.
    fn depth(&self, x: f64, y: f64) -> Option<f64> {
        let at = |f: &[f64; 3]| f[0] * x + f[1] * y + f[2];
        let (first, second) = (at(&self.first), at(&self.second));
        (first >= -SEAM && second >= -SEAM && first + second <= 1.0 + SEAM).then(|| at(&self.depth))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::dot;
    use crate::mesh::solids::sphere;

    #[test]
    fn of_a_sphere_the_side_towards_the_camera_is_seen() {
        let mesh = sphere(24, 48);
        for (direction, closed) in [([0.0, 0.0, 1.0], false), ([1.0, -2.0, 0.5], false), ([1.0, -2.0, 0.5], true)] {
            let frame = Frame::looking_from(direction);
            let visible = Visible::new(mesh.positions(), mesh.triangles(), closed, &frame);
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
    fn a_place_between_vertices_is_in_front_of_its_point() {
        let mesh = sphere(12, 24);
        let frame = Frame::looking_from([1.0, -2.0, 0.5]);
        let visible = Visible::new(mesh.positions(), mesh.triangles(), true, &frame);
        for step in 0..200 {
            let (radius, angle) = (0.25 * f64::from(step) / 200.0, 2.4 * f64::from(step));
            let point = [radius * angle.cos(), radius * angle.sin()];
            let (triangle, weights) = visible.place(point).unwrap();
            assert!(
                (weights.iter().sum::<f64>() - 1.0).abs() < 1e-12 && weights.iter().all(|w| (0.0..=1.0).contains(w))
            );
            let corners = triangle.map(|v| mesh.positions()[v as usize]);
            let place = [0, 1, 2].map(|axis| (0..3).map(|i| weights[i] * corners[i][axis]).sum::<f64>());
            let seen = frame.project(place);
            // The sphere has area 1, so a radius of 0.28; a pixel is a thousandth wide.
            assert!((seen[0] - point[0]).hypot(seen[1] - point[1]) < 2e-3 && frame.depth(place) > 0.0, "{point:?}");
        }
        let (_, weights) = visible.place([3.0, 0.0]).unwrap();
        assert!(weights.iter().all(|w| (0.0..=1.0).contains(w)));
    }

    #[test]
    fn a_point_outside_sees_the_nearest_of_the_outline() {
        let positions = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let triangles = [[0, 1, 2]];
        let visible = Visible::new(&positions, &triangles, false, &Frame::looking_from([0.0, 0.0, 1.0]));
        let frame = Frame::looking_from([0.0, 0.0, 1.0]);
        for (v, position) in positions.iter().enumerate() {
            let away = position.map(|x| 1.5 * x - 0.2);
            assert_eq!(visible.vertex(frame.project(away)), v as u32);
        }
        assert_eq!(Visible::new(&positions, &[], false, &frame).vertex([5.0, 5.0]), 0);
    }
}
