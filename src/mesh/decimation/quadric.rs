//! How far a place is from the planes and points that a vertex stands for [GH97].

use std::ops::AddAssign;

use crate::geometry::dot;

/// p ↦ pᵀ A p + 2 b·p + c, a sum of weighted squared distances.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Quadric {
    /// xx, yy, zz, yz, zx, xy of A.
    a: [f64; 6],
    b: [f64; 3],
    c: f64,
}

impl Quadric {
    /// `weight` times the squared distance from the plane through `point` across `normal`, which is of length 1.
    pub fn of_plane(normal: [f64; 3], point: [f64; 3], weight: f64) -> Quadric {
        let [x, y, z] = normal;
        let offset = -dot(normal, point);
        Quadric {
            a: [x * x, y * y, z * z, y * z, z * x, x * y].map(|a| weight * a),
            b: normal.map(|n| weight * offset * n),
            c: weight * offset * offset,
        }
    }

    /// `weight` times the squared distance from a point.
    pub fn of_point(point: [f64; 3], weight: f64) -> Quadric {
        let a = [weight, weight, weight, 0.0, 0.0, 0.0];
        Quadric { a, b: point.map(|x| -weight * x), c: weight * dot(point, point) }
    }

    pub fn at(&self, p: [f64; 3]) -> f64 {
        let [xx, yy, zz, yz, zx, xy] = self.a;
        let [x, y, z] = p;
        let squares = xx * x * x + yy * y * y + zz * z * z;
        squares + 2.0 * (yz * y * z + zx * z * x + xy * x * y + dot(self.b, p)) + self.c
    }
}

impl AddAssign for Quadric {
    fn add_assign(&mut self, other: Quadric) {
        self.a.iter_mut().zip(other.a).for_each(|(a, b)| *a += b);
        self.b.iter_mut().zip(other.b).for_each(|(a, b)| *a += b);
        self.c += other.c;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tells_squared_distances() {
        let mut sum = Quadric::of_plane([0.6, 0.0, 0.8], [1.0, 2.0, 3.0], 2.0);
        // 0.6 · 5 + 0.8 · 10 from the plane.
        assert!((sum.at([6.0, -7.0, 13.0]) - 2.0 * 121.0).abs() < 1e-10);
        sum += Quadric::of_point([6.0, -7.0, 12.0], 3.0);
        assert!((sum.at([6.0, -7.0, 13.0]) - 245.0).abs() < 1e-10);
    }
}
