//! Areas of triangles, in the plane and in space.

use super::vectors::{cross, length, subtract};

/// Twice the signed area of a triangle in the plane, positive where it is counter-clockwise.
pub fn doubled_area([a, b, c]: [[f64; 2]; 3]) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

/// Half the length of the cross product of two edges.
pub fn triangle_area([a, b, c]: [[f64; 3]; 3]) -> f64 {
    let (u, v) = (subtract(b, a), subtract(c, a));
    0.5 * length(cross(u, v))
}

/// Twice the area of a triangle of these sides, by Kahan's form of Heron's formula; not a number where they make none.
pub fn doubled_area_of_sides(mut sides: [f64; 3]) -> f64 {
    sides.sort_by(|a, b| b.total_cmp(a));
    let [a, b, c] = sides;
    0.5 * ((a + (b + c)) * (c - (a - b)) * (c + (a - b)) * (a + (b - c))).sqrt()
}
