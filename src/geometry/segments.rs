//! Straight lines between two points of the plane.

/// The distance of a point from the nearest point of the line from a to b.
pub fn distance_to_segment(p: [f64; 2], [a, b]: [[f64; 2]; 2]) -> f64 {
    let (along, to) = ([b[0] - a[0], b[1] - a[1]], [p[0] - a[0], p[1] - a[1]]);
    let squared = along[0] * along[0] + along[1] * along[1];
    let share = if squared > 0.0 { ((to[0] * along[0] + to[1] * along[1]) / squared).clamp(0.0, 1.0) } else { 0.0 };
    (to[0] - share * along[0]).hypot(to[1] - share * along[1])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn beside_a_segment_its_line_is_nearest_and_beyond_it_its_end() {
        let segment = [[1.0, 1.0], [5.0, 1.0]];
        for (point, distance) in [([3.0, 4.0], 3.0), ([8.0, 5.0], 5.0), ([1.0, -1.0], 2.0), ([2.0, 1.0], 0.0)] {
            assert_eq!(distance_to_segment(point, segment), distance);
        }
        assert_eq!(distance_to_segment([4.0, 5.0], [[1.0, 1.0]; 2]), 5.0);
    }
}
