//! Polygons cut into triangles.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use crate::geometry::{cross, dot, doubled_area, length, subtract};

/// Twice the area below which a triangle counts as flat, in a polygon scaled to unit size.
const FLAT: f64 = 1e-12;
/// Corners times turns to the wrong side, summed over the polygons of a file, up to which it is looked whether an ear covers a
/// corner: a second at most, at 5 ns for each.
pub(super) const LOOKS: usize = 1 << 27;

type Point = [f64; 2];

/// A polygon in triangles.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Cut {
    /// In the winding of the polygon.
    pub triangles: Vec<[u32; 3]>,
    /// Whether they cover the polygon and nothing else: it does not cross itself and has an area seen along the normal of
    /// its best-fit plane.
    pub clean: bool,
}

/// n − 2 triangles whose sides are those of a polygon of n ≥ 3 corners and n − 3 diagonals. A corner may occur again, as at
/// the bridge to a hole.
///
/// Quads are cut along the shorter diagonal of those that stay inside; other polygons by ear clipping, the best-shaped
/// ear first. The outcome does not depend on the corner the polygon starts from nor on its direction, so that a
/// repeated polygon gives repeated triangles, as long as there are `looks` left for it: a polygon takes its own of them. O(n log n)
/// where all corners turn to one side.
pub(super) fn cut(polygon: &[u32], positions: &[[f64; 3]], looks: &mut usize) -> Cut {
    if let &[a, b, c] = polygon {
        return Cut { triangles: vec![[a, b, c]], clean: true };
    }
    let (distinct, folded) = apart(polygon, positions);
    if !folded.is_empty() && distinct.len() > 2 {
        let Cut { triangles, clean } = cut(&distinct, positions, looks);
        return Cut { triangles: [triangles, folded].concat(), clean };
    }
    let (polygon, reversed) = canonical(polygon);
    let points = projection(&polygon.iter().map(|&v| positions[v as usize]).collect::<Vec<_>>());
    let (corners, clean) = match points {
        Some(points) => match quad(&points) {
            Some(halves) => (halves, true),
            None => ears(&points, looks),
        },
        None => ((2..polygon.len()).map(|i| [0, i - 1, i]).collect(), false),
    };
    let triangle = |[a, b, c]: [usize; 3]| if reversed { [a, c, b] } else { [a, b, c] }.map(|i| polygon[i]);
    Cut { triangles: corners.into_iter().map(triangle).collect(), clean }
}

/// The polygon without corners that stand where the one before them does, as at the pole of a sphere of quads, and the
/// triangles without area that cut those off.
fn apart(polygon: &[u32], positions: &[[f64; 3]]) -> (Vec<u32>, Vec<[u32; 3]>) {
    let at = |v: u32| positions[v as usize];
    let (mut distinct, mut folded) = (Vec::with_capacity(polygon.len()), Vec::new());
    for (&corner, &next) in polygon.iter().zip(polygon.iter().cycle().skip(1)) {
        match distinct.last() {
            Some(&before) if at(before) == at(corner) => folded.push([before, corner, next]),
            _ => distinct.push(corner),
        }
    }
    while let [first, .., before, last] = distinct[..]
        && at(first) == at(last)
    {
        folded.push([before, last, first]);
        distinct.pop();
    }
    (distinct, folded)
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

fn squared_distance(a: Point, b: Point) -> f64 {
    (b[0] - a[0]).powi(2) + (b[1] - a[1]).powi(2)
}

/// The halves of a quad that has any inside it.
fn quad(points: &[Point]) -> Option<Vec<[usize; 3]>> {
    if points.len() != 4 {
        return None;
    }
    let cuts = [([0, 2], [[0, 1, 2], [0, 2, 3]]), ([1, 3], [[1, 2, 3], [1, 3, 0]])];
    cuts.into_iter()
        .filter(|(_, halves)| halves.iter().all(|corners| doubled_area(corners.map(|i| points[i])) > FLAT))
        .map(|([a, b], halves)| (squared_distance(points[a], points[b]), halves))
        .min_by(|(a, _), (b, _)| a.total_cmp(b))
        .map(|(_, halves)| halves.to_vec())
}

/// Ear clipping, and whether every triangle was an ear. Where there is none, the best-shaped corner is cut off.
fn ears(points: &[Point], looks: &mut usize) -> (Vec<[usize; 3]>, bool) {
    let mut ring = Ring::of(points, looks);
    let mut queue: BinaryHeap<Ear> = (0..points.len()).map(|i| ring.ear(i)).collect();
    let mut triangles = Vec::with_capacity(points.len() - 2);
    let mut clean = ring.is_looked_at;
    while triangles.len() + 2 < points.len() {
        let Some(ear) = queue.pop() else { break };
        if ear.cuts != ring.cuts[ear.corner] {
            continue;
        }
        clean &= ear.quality > 0.0;
        triangles.push(ring.corner(ear.corner));
        // Only the neighbours' ears have changed.
        for neighbour in ring.cut_off(ear.corner) {
            queue.push(ring.ear(neighbour));
        }
    }
    (triangles, clean)
}

/// The corners that are left of a polygon.
struct Ring<'a> {
    points: &'a [Point],
    before: Vec<usize>,
    after: Vec<usize>,
    /// How often a neighbour of the corner was cut off; `GONE` for one that was itself.
    cuts: Vec<u32>,
    /// The corners that do not turn with the polygon: in an ear that covers anything there is one of them.
    wrong: Vec<usize>,
    is_looked_at: bool,
}

const GONE: u32 = u32::MAX;

impl Ring<'_> {
    fn of<'a>(points: &'a [Point], looks: &mut usize) -> Ring<'a> {
        let n = points.len();
        let (before, after) = ((0..n).map(|i| (i + n - 1) % n).collect(), (0..n).map(|i| (i + 1) % n).collect());
        let mut ring = Ring { points, before, after, cuts: vec![0; n], wrong: Vec::new(), is_looked_at: true };
        ring.wrong = (0..n).filter(|&i| ring.turn(i) <= FLAT).collect();
        let left = looks.checked_sub(n.saturating_mul(ring.wrong.len()));
        ring.is_looked_at = left.is_some();
        *looks = left.unwrap_or(*looks);
        ring
    }

    fn corner(&self, i: usize) -> [usize; 3] {
        [self.before[i], i, self.after[i]]
    }

    fn turn(&self, i: usize) -> f64 {
        doubled_area(self.corner(i).map(|i| self.points[i]))
    }

    /// How well the corner would be cut off: area over squared edges, 0 or less where it is no ear.
    fn ear(&self, corner: usize) -> Ear {
        let [a, b, c] = self.corner(corner).map(|i| self.points[i]);
        let area = doubled_area([a, b, c]);
        let quality = area / (squared_distance(a, b) + squared_distance(b, c) + squared_distance(c, a));
        let covers = |p: Point| [[a, b, p], [b, c, p], [c, a, p]].into_iter().all(|t| doubled_area(t) >= -FLAT);
        let others = self.wrong.iter().filter(|&&i| self.cuts[i] != GONE).map(|&i| self.points[i]);
        // The two banks of a bridge stand at one place.
        let covering = self.is_looked_at && others.filter(|p| ![a, b, c].contains(p)).any(covers);
        let is_ear = area > FLAT && !covering;
        // Of those that are none the best-shaped comes first too.
        let quality = if is_ear || quality.is_nan() { quality } else { quality - 1.0 };
        Ear { quality: if quality.is_nan() { -2.0 } else { quality }, corner, cuts: self.cuts[corner] }
    }

    /// Takes the corner out; its neighbours.
    fn cut_off(&mut self, i: usize) -> [usize; 2] {
        let [before, _, after] = self.corner(i);
        self.cuts[i] = GONE;
        self.after[before] = after;
        self.before[after] = before;
        [before, after].into_iter().for_each(|i| self.cuts[i] += 1);
        [before, after]
    }
}

/// A corner that might be cut off as it was after so many cuts beside it. The best is the greatest; of equals the first.
struct Ear {
    quality: f64,
    corner: usize,
    cuts: u32,
}

impl Ord for Ear {
    fn cmp(&self, other: &Self) -> Ordering {
        self.quality.total_cmp(&other.quality).then(other.corner.cmp(&self.corner))
    }
}

impl PartialOrd for Ear {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Ear {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Ear {}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::triangle_area;

    /// A flat polygon, lifted into a tilted plane far from the origin.
    fn lifted(outline: &[Point]) -> Vec<[f64; 3]> {
        outline.iter().map(|&[x, y]| [100.0 + 3.0 * x, 7.0 + 3.0 * y, -20.0 + x - 2.0 * y]).collect()
    }

    fn whole(outline: &[Point]) -> Cut {
        cut(&(0..outline.len() as u32).collect::<Vec<_>>(), &lifted(outline), &mut LOOKS.clone())
    }

    fn shoelace(outline: &[Point]) -> f64 {
        (0..outline.len()).map(|i| doubled_area([[0.0; 2], outline[i], outline[(i + 1) % outline.len()]])).sum::<f64>()
            / 2.0
    }

    /// That the triangles all wind as the outline does and together have its area: they cover it and nothing else.
    fn assert_covers(outline: &[Point]) {
        let Cut { triangles, clean } = whole(outline);
        assert!(clean);
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

    /// A star whose every other corner turns to the wrong side.
    fn star(corners: u32) -> Vec<Point> {
        let corner = |i: u32| {
            let angle = f64::from(i) / f64::from(corners) * std::f64::consts::TAU;
            let radius = 1.0 + f64::from(i % 2);
            [radius * angle.cos(), radius * angle.sin()]
        };
        (0..corners).map(corner).collect()
    }

    #[test]
    fn covers_a_star_of_many_corners() {
        assert_covers(&star(2048));
    }

    #[test]
    fn polygons_of_a_file_share_the_looks() {
        let (outline, polygon) = (star(100), (0..100).collect::<Vec<u32>>());
        let positions = lifted(&outline);
        let mut looks = 2 * 100 * 50 + 1;
        let clean = [(); 3].map(|()| cut(&polygon, &positions, &mut looks).clean);
        assert_eq!((clean, looks), ([true, true, false], 1));
        assert!(cut(&[0, 1, 99], &positions, &mut looks).clean);
    }

    #[test]
    fn cuts_a_quad_along_the_shorter_diagonal_inside() {
        let kite = [[0., 0.], [3., -1.], [10., 0.], [3., 1.]];
        assert!(whole(&kite).triangles.iter().all(|t| t.contains(&1) && t.contains(&3)));
        // Here the shorter diagonal is outside.
        let dart = [[0., 0.], [5., 1.], [10., 0.], [5., 2.]];
        let dart_cut = whole(&dart).triangles;
        assert!(dart_cut.iter().all(|t| t.contains(&1) && t.contains(&3)), "{dart_cut:?}");
        assert_covers(&dart);
    }

    #[test]
    fn does_not_depend_on_start_and_direction() {
        let positions = lifted(&COMB);
        let sorted = |polygon: &[u32]| {
            let mut triangles = cut(polygon, &positions, &mut LOOKS.clone()).triangles;
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
        let parts: f64 = cut(&[0, 1, 2, 3], &positions, &mut LOOKS.clone())
            .triangles
            .iter()
            .map(|t| triangle_area(t.map(|v| positions[v as usize])))
            .sum();
        assert!((whole - parts).abs() < 1e-12);
    }

    #[test]
    fn covers_polygons_of_very_many_corners() {
        let circle: Vec<Point> =
            (0..20_000).map(|i| f64::from(i) / 20_000.0 * std::f64::consts::TAU).map(|a| [a.cos(), a.sin()]).collect();
        assert_covers(&circle);
    }

    #[test]
    fn covers_a_face_with_a_hole_and_a_bridge_to_it() {
        let points = [[0., 0.], [9., 0.], [9., 9.], [0., 9.], [3., 3.], [6., 3.], [6., 6.], [3., 6.]];
        let Cut { triangles, clean } = cut(&[0, 1, 2, 3, 0, 4, 7, 6, 5, 4], &lifted(&points), &mut LOOKS.clone());
        assert!(clean && triangles.len() == 8);
        let areas = triangles.iter().map(|t| shoelace(&t.map(|v| points[v as usize])));
        assert!(areas.clone().all(|area| area > 0.0));
        assert!((areas.sum::<f64>() - 72.0).abs() < 1e-9);
    }

    #[test]
    fn cuts_what_is_no_polygon_into_as_many_triangles() {
        let bow_tie = [[0., 0.], [1., 1.], [1., 0.], [0., 1.]];
        let line = [[0., 0.], [1., 0.], [2., 0.], [3., 0.], [4., 0.]];
        let point = [[1., 1.]; 5];
        let pentagram: Vec<Point> =
            (0..5).map(|i| f64::from(i) * 2.0 * std::f64::consts::TAU / 5.0).map(|a| [a.cos(), a.sin()]).collect();
        let jagged: Vec<Point> =
            (0..3000).map(|i| [f64::from(i * 7919 % 3001), f64::from(i * 104_729 % 3001)]).collect();
        for outline in [bow_tie.as_slice(), &line, &point, &pentagram, &jagged] {
            let Cut { triangles, clean } = whole(outline);
            assert!(!clean && triangles.len() == outline.len() - 2);
            assert!(triangles.iter().all(|[a, b, c]| a != b && b != c && c != a));
        }
    }
}
