//! Triangles in space.

use super::vectors::{dot, length, subtract};

/// The weights of a triangle's corners, none negative and of sum 1, at its point nearest to p.
pub fn nearest_on_triangle(p: [f64; 3], corners: [[f64; 3]; 3]) -> [f64; 3] {
    let [u, v, w] = [corners[1], corners[2], p].map(|q| subtract(q, corners[0]));
    let (uu, uv, vv) = (dot(u, u), dot(u, v), dot(v, v));
    let squared = uu * vv - uv * uv;
    let [s, t] = [vv * dot(w, u) - uv * dot(w, v), uu * dot(w, v) - uv * dot(w, u)].map(|x| x / squared);
    let below = [1.0 - s - t, s, t];
    // Without an area not a number.
    if below.iter().all(|&weight| weight >= 0.0) { below } else { nearest_on_sides(p, corners) }
}

fn nearest_on_sides(p: [f64; 3], corners: [[f64; 3]; 3]) -> [f64; 3] {
    let on_side = |from: usize| {
        let to = (from + 1) % 3;
        let (along, there) = (subtract(corners[to], corners[from]), subtract(p, corners[from]));
        let share = (dot(there, along) / dot(along, along).max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
        let mut weights = [0.0; 3];
        (weights[from], weights[to]) = (1.0 - share, share);
        (length([0, 1, 2].map(|i: usize| there[i] - share * along[i])), weights)
    };
    [1, 2].map(on_side).into_iter().fold(on_side(0), |a, b| if b.0 < a.0 { b } else { a }).1
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn above_a_triangle_the_point_below_is_nearest_and_beside_it_one_of_a_side_or_a_corner() {
        let corners = [[1.0, 0.0, 3.0], [5.0, 0.0, 3.0], [1.0, 4.0, 3.0]];
        for (point, expected) in [
            ([2.0, 2.0, 9.0], [0.25, 0.25, 0.5]),
            ([2.0, -2.0, 3.0], [0.75, 0.25, 0.0]),
            ([0.0, 3.0, 4.0], [0.25, 0.0, 0.75]),
            ([5.0, 4.0, 3.0], [0.0, 0.5, 0.5]),
            ([-1.0, -1.0, 0.0], [1.0, 0.0, 0.0]),
            ([9.0, -1.0, 3.0], [0.0, 1.0, 0.0]),
        ] {
            assert_eq!(nearest_on_triangle(point, corners), expected, "{point:?}");
        }
    }

    #[test]
    fn triangles_without_area_have_a_nearest_point_too() {
        let line = [[0.0; 3], [1.0, 0.0, 0.0], [4.0, 0.0, 0.0]];
        assert_eq!(nearest_on_triangle([2.5, 1.0, 0.0], line), [0.0, 0.5, 0.5]);
        assert_eq!(nearest_on_triangle([1.0; 3], [[2.0; 3]; 3]), [1.0, 0.0, 0.0]);
    }
}
