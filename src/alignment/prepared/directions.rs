//! Directions to look at a mesh from.

use std::f64::consts::PI;

use crate::geometry::axes::longest;
use crate::geometry::frame::Frame;
use crate::geometry::subtract;

/// Directions in the plane of symmetry.
const IN_PLANE: usize = 6;

/// `count` directions, evenly spread on the half sphere z > 0 along a Fibonacci spiral.
pub fn half_sphere(count: usize) -> Vec<[f64; 3]> {
    let direction = |i: usize| {
        let turn = i as f64 + 0.5;
        let z = 1.0 - turn / count as f64;
        let radius = (1.0 - z * z).sqrt();
        let (sin, cos) = (PI * (1.0 + 5f64.sqrt()) * turn).sin_cos();
        [cos * radius, sin * radius, z]
    };
    (0..count).map(direction).collect()
}

/// The directions a body is usually drawn from: `normal` (length 1), that of the plane of symmetry, then six in the plane
/// at steps of 30° from the longest principal axis of the n masses within it.
pub fn canonical_directions(positions: &[[f64; 3]], masses: &[f64], normal: [f64; 3]) -> Vec<[f64; 3]> {
    let frame = Frame::looking_from(normal);
    let total: f64 = masses.iter().sum();
    let mean = |i: usize| positions.iter().zip(masses).map(|(p, mass)| p[i] * mass).sum::<f64>() / total;
    let centre = std::array::from_fn(mean);
    let [mut squares, mut product] = [0.0; 2];
    for (&position, mass) in positions.iter().zip(masses) {
        let [x, y] = frame.project(subtract(position, centre));
        squares += mass * (x * x - y * y);
        product += mass * x * y;
    }
    let longest = longest(squares, product);
    let in_plane = (0..IN_PLANE).map(|step| {
        let (sin, cos) = (longest + PI * step as f64 / IN_PLANE as f64).sin_cos();
        std::array::from_fn(|i| cos * frame.right[i] + sin * frame.up[i])
    });
    std::iter::once(normal).chain(in_plane).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{cross, dot, length, unit};

    #[test]
    fn the_half_sphere_is_covered_evenly() {
        let directions = half_sphere(120);
        assert!(directions.iter().all(|&d| (length(d) - 1.0).abs() < 1e-12 && d[2] > 0.0));
        for &a in &directions {
            let nearest = directions.iter().filter(|&&b| a != b).map(|&b| dot(a, b).acos()).fold(PI, f64::min);
            assert!((0.1..0.35).contains(&nearest), "{nearest}");
        }
    }

    #[test]
    fn views_follow_the_normal_and_the_longest_axis_in_the_plane() {
        // Points along `long` within the plane, and farther off along the normal, which does not count.
        let normal = unit([1.0, 2.0, 3.0]);
        let long = unit(cross(normal, [0.3, -1.0, 0.2]));
        let other = cross(normal, long);
        let mut positions = Vec::new();
        for (axis, extent) in [(normal, 5.0), (long, 2.0), (other, 1.0)] {
            for sign in [-1.0, 1.0] {
                positions.push(axis.map(|x| 7.0 + sign * extent * x));
            }
        }
        let found = canonical_directions(&positions, &[0.5; 6], normal);
        assert_eq!((found.len(), found[0]), (7, normal));
        assert!(dot(found[1], long).abs() > 1.0 - 1e-9);
        for pair in found[1..].windows(2) {
            assert!((dot(pair[0], pair[1]) - (PI / 6.0).cos()).abs() < 1e-12 && dot(pair[1], normal).abs() < 1e-12);
        }
    }
}
