//! Polygons cut into triangles.

use super::{cross, dot, length, subtract};

/// Twice the area below which a triangle counts as flat, in a polygon scaled to unit size.
const FLAT: f64 = 1e-12;

type Point = [f64; 2];

/// n − 2 triangles that cover a polygon of n ≥ 3 different, existing vertices and nothing else, in its winding; none if
/// there are none: the polygon crosses itself or has no area seen along the normal of its best-fit plane.
///
/// Quads are cut along the shorter diagonal of those that stay inside; other polygons by ear clipping, the best-shaped
/// ear first. The outcome does not depend on the corner the polygon starts from nor on its direction, so that a
/// repeated polygon gives repeated triangles.
pub(super) fn triangles(polygon: &[u32], positions: &[[f64; 3]]) -> Option<Vec<[u32; 3]>> {
    if let &[a, b, c] = polygon {
        return Some(vec![[a, b, c]]);
    }
    let (polygon, reversed) = canonical(polygon);
    let points = projection(&polygon.iter().map(|&v| positions[v as usize]).collect::<Vec<_>>())?;
    let corners = if points.len() == 4 { quad(&points) } else { ears(&points) }?;
    let triangle = |[a, b, c]: [usize; 3]| if reversed { [a, c, b] } else { [a, b, c] }.map(|i| polygon[i]);
    Some(corners.into_iter().map(triangle).collect())
}

/// The polygon from its smallest vertex on towards the smaller neighbour, and whether that reversed it.
fn canonical(polygon: &[u32]) -> (Vec<u32>, bool) {
    let start = (0..polygon.len()).min_by_key(|&i| polygon[i]).unwrap_or(0);
    let mut rotated = [&polygon[start..], &polygon[..start]].concat();
    let reversed = rotated[rotated.len() - 1] < rotated[1];
    if reversed {
        rotated[1..].reverse();
    }
    (rotated, reversed)
}

/// The corners in their best-fit plane (Newell's normal), counter-clockwise, scaled to unit size; none where the
/// enclosed area vanishes.
fn projection(corners: &[[f64; 3]]) -> Option<Vec<Point>> {
    let offsets: Vec<[f64; 3]> = corners.iter().map(|&p| subtract(p, corners[0])).collect();
    let size = offsets.iter().flatten().fold(0.0, |size: f64, x| size.max(x.abs()));
    let unit: Vec<[f64; 3]> = offsets.iter().map(|p| p.map(|x| x / size)).collect();
    let mut normal = [0.0; 3];
    for (i, &p) in unit.iter().enumerate() {
        let area = cross(p, unit[(i + 1) % unit.len()]);
        normal = [0, 1, 2].map(|axis: usize| normal[axis] + area[axis]);
    }
    let magnitude = length(normal);
    // NaN where all corners stand at one point.
    if magnitude.is_nan() || magnitude <= FLAT {
        return None;
    }
    let normal = normal.map(|x| x / magnitude);
    let (x, y) = axes(normal);
    Some(unit.iter().map(|&p| [dot(p, x), dot(p, y)]).collect())
}

/// Two unit vectors that make a right-handed frame with a unit normal.
fn axes(normal: [f64; 3]) -> ([f64; 3], [f64; 3]) {
    let smallest = (0..3).min_by(|&i, &j| normal[i].abs().total_cmp(&normal[j].abs())).unwrap_or(0);
    let mut direction = [0.0; 3];
    direction[smallest] = 1.0;
    let x = cross(direction, normal);
    let x = x.map(|c| c / length(x));
    (x, cross(normal, x))
}

/// Twice the signed area of a triangle.
fn turn(a: Point, b: Point, c: Point) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

fn squared_distance(a: Point, b: Point) -> f64 {
    (b[0] - a[0]).powi(2) + (b[1] - a[1]).powi(2)
}

fn quad(points: &[Point]) -> Option<Vec<[usize; 3]>> {
    let cuts = [([0, 2], [[0, 1, 2], [0, 2, 3]]), ([1, 3], [[1, 2, 3], [1, 3, 0]])];
    cuts.into_iter()
        .filter(|(_, halves)| halves.iter().all(|&[a, b, c]| turn(points[a], points[b], points[c]) > FLAT))
        .map(|([a, b], halves)| (squared_distance(points[a], points[b]), halves))
        .min_by(|(a, _), (b, _)| a.total_cmp(b))
        .map(|(_, halves)| halves.to_vec())
}

/// Ear clipping in O(n²).
fn ears(points: &[Point]) -> Option<Vec<[usize; 3]>> {
    if crosses_itself(points) {
        return None;
    }
    let mut ring: Vec<usize> = (0..points.len()).collect();
    let mut qualities: Vec<f64> = (0..ring.len()).map(|i| quality(points, &ring, i)).collect();
    let mut triangles = Vec::with_capacity(points.len() - 2);
    while ring.len() >= 3 {
        let ear = (0..ring.len()).reduce(|best, i| if qualities[i] > qualities[best] { i } else { best })?;
        if qualities[ear] <= 0.0 {
            return None;
        }
        triangles.push(corner(&ring, ear));
        ring.remove(ear);
        qualities.remove(ear);
        // Only the neighbours' ears have changed.
        let n = ring.len();
        for i in [(ear + n - 1) % n, ear % n] {
            qualities[i] = quality(points, &ring, i);
        }
    }
    Some(triangles)
}

fn corner(ring: &[usize], i: usize) -> [usize; 3] {
    [ring[(i + ring.len() - 1) % ring.len()], ring[i], ring[(i + 1) % ring.len()]]
}

/// Area over squared edges of the triangle at a corner of the ring; 0 where it is no ear.
fn quality(points: &[Point], ring: &[usize], i: usize) -> f64 {
    let indices = corner(ring, i);
    let [a, b, c] = indices.map(|i| points[i]);
    let area = turn(a, b, c);
    let covers = |p: Point| turn(a, b, p) >= -FLAT && turn(b, c, p) >= -FLAT && turn(c, a, p) >= -FLAT;
    if area <= FLAT || ring.iter().any(|i| !indices.contains(i) && covers(points[*i])) {
        return 0.0;
    }
    area / (squared_distance(a, b) + squared_distance(b, c) + squared_distance(c, a))
}

fn crosses_itself(points: &[Point]) -> bool {
    let n = points.len();
    let edge = |i: usize| (points[i], points[(i + 1) % n]);
    let apart = |a: f64, b: f64| (a > FLAT && b < -FLAT) || (a < -FLAT && b > FLAT);
    let cross = |(a, b): (Point, Point), (c, d): (Point, Point)| {
        apart(turn(a, b, c), turn(a, b, d)) && apart(turn(c, d, a), turn(c, d, b))
    };
    (0..n).any(|i| (i + 2..n).any(|j| cross(edge(i), edge(j))))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::triangle_area;

    /// A flat polygon, lifted into a tilted plane far from the origin.
    fn lifted(outline: &[Point]) -> Vec<[f64; 3]> {
        outline.iter().map(|&[x, y]| [100.0 + 3.0 * x, 7.0 + 3.0 * y, -20.0 + x - 2.0 * y]).collect()
    }

    fn cut(outline: &[Point]) -> Option<Vec<[u32; 3]>> {
        triangles(&(0..outline.len() as u32).collect::<Vec<_>>(), &lifted(outline))
    }

    fn shoelace(outline: &[Point]) -> f64 {
        (0..outline.len()).map(|i| turn([0.0; 2], outline[i], outline[(i + 1) % outline.len()])).sum::<f64>() / 2.0
    }

    /// That the triangles all wind as the outline does and together have its area: they cover it and nothing else.
    fn assert_covers(outline: &[Point]) {
        let triangles = cut(outline).unwrap();
        assert_eq!(triangles.len(), outline.len() - 2);
        let areas = triangles.iter().map(|t| shoelace(&t.map(|v| outline[v as usize])));
        assert!(areas.clone().all(|area| area.signum() == shoelace(outline).signum()), "{triangles:?}");
        assert!((areas.sum::<f64>() - shoelace(outline)).abs() < 1e-9);
    }

    /// A comb of four teeth: concave, with collinear corners.
    const COMB: [Point; 17] = [
        [0., 0.],
        [1., 0.],
        [2., 0.],
        [7., 0.],
        [7., 5.],
        [6., 5.],
        [6., 1.],
        [5., 1.],
        [5., 5.],
        [4., 5.],
        [4., 1.],
        [3., 1.],
        [3., 5.],
        [2., 5.],
        [2., 1.],
        [1., 1.],
        [0., 5.],
    ];

    #[test]
    fn covers_concave_polygons() {
        let arrow = [[0., 0.], [4., 4.], [0., 1.], [-4., 4.]];
        let midpoints = [[0., 0.], [1., 0.], [2., 0.], [1., 1.], [0., 2.], [0., 1.]];
        for outline in [arrow.as_slice(), &midpoints, &COMB] {
            assert_covers(outline);
            assert_covers(&outline.iter().rev().copied().collect::<Vec<_>>());
        }
    }

    #[test]
    fn covers_a_star_of_the_most_corners() {
        let n = 1024;
        let star: Vec<Point> = (0..n)
            .map(|i| {
                let (angle, radius) = (i as f64 / n as f64 * std::f64::consts::TAU, 1.0 + f64::from(i % 2));
                [radius * angle.cos(), radius * angle.sin()]
            })
            .collect();
        assert_covers(&star);
    }

    #[test]
    fn cuts_a_quad_along_the_shorter_diagonal_inside() {
        let kite = [[0., 0.], [3., -1.], [10., 0.], [3., 1.]];
        assert!(cut(&kite).unwrap().iter().all(|t| t.contains(&1) && t.contains(&3)));
        // Here the shorter diagonal is outside.
        let dart = [[0., 0.], [5., 1.], [10., 0.], [5., 2.]];
        let dart_cut = cut(&dart).unwrap();
        assert!(dart_cut.iter().all(|t| t.contains(&1) && t.contains(&3)), "{dart_cut:?}");
        assert_covers(&dart);
    }

    #[test]
    fn does_not_depend_on_start_and_direction() {
        let positions = lifted(&COMB);
        let sorted = |polygon: &[u32]| {
            let mut triangles = triangles(polygon, &positions).unwrap();
            triangles.iter_mut().for_each(|t| t.sort_unstable());
            triangles.sort_unstable();
            triangles
        };
        let mut polygon: Vec<u32> = (0..17).collect();
        let expected = sorted(&polygon);
        polygon.rotate_left(5);
        assert_eq!(sorted(&polygon), expected);
        polygon.reverse();
        assert_eq!(sorted(&polygon), expected);
    }

    #[test]
    fn cuts_a_square_to_its_area_in_space() {
        let positions = lifted(&[[0., 0.], [1., 0.], [1., 1.], [0., 1.]]);
        let whole = length(cross(subtract(positions[1], positions[0]), subtract(positions[3], positions[0])));
        let parts: f64 = triangles(&[0, 1, 2, 3], &positions)
            .unwrap()
            .iter()
            .map(|t| triangle_area(t.map(|v| positions[v as usize])))
            .sum();
        assert!((whole - parts).abs() < 1e-12);
    }

    #[test]
    fn gives_none_for_what_is_no_polygon() {
        let bow_tie = [[0., 0.], [1., 1.], [1., 0.], [0., 1.]];
        let line = [[0., 0.], [1., 0.], [2., 0.], [3., 0.], [4., 0.]];
        let point = [[1., 1.]; 5];
        let pentagram: Vec<Point> =
            (0..5).map(|i| f64::from(i) * 2.0 * std::f64::consts::TAU / 5.0).map(|a| [a.cos(), a.sin()]).collect();
        for outline in [bow_tie.as_slice(), &line, &point, &pentagram] {
            assert_eq!(cut(outline), None);
        }
    }
}
