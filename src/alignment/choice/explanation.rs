//! How well an attempt explains the drawing: what is compared when one is chosen.

use crate::alignment::scene::Scene;
use crate::alignment::scene::eyes::Eyes;
use crate::alignment::scene::upright::Upright;
use crate::geometry::frame::Frame;
use crate::geometry::{cross, dot, length as length_of, unit};

/// The distance from the nearest answer, in units of √area, from which a place of the mesh counts as left out, and that at
/// which it counts fully.
const NEAR: f64 = 0.04;
const FAR: f64 = 0.12;
/// Rows in which two figures are compared, and how far one is shifted against the other at most, in units of √area.
const ROWS: usize = 72;
const SHIFT: f64 = 0.12;

/// The similarity that the deformation of the sketch is nearest to.
pub struct Turn {
    pub cos: f64,
    pub sin: f64,
}

impl Turn {
    /// The turn from the m places of the sketch to those it is laid at.
    pub fn between(from: &[[f64; 2]], to: &[[f64; 2]]) -> Turn {
        let n = from.len().max(1) as f64;
        let mean = |points: &[[f64; 2]]| [0, 1].map(|axis| points.iter().map(|p| p[axis]).sum::<f64>() / n);
        let (a, b) = (mean(from), mean(to));
        let (mut cos, mut sin) = (0.0, 0.0);
        for (p, q) in from.iter().zip(to) {
            let ([x, y], [u, v]) = ([p[0] - a[0], p[1] - a[1]], [q[0] - b[0], q[1] - b[1]]);
            cos += x * u + y * v;
            sin += x * v - y * u;
        }
        let length = cos.hypot(sin);
        if length > 0.0 { Turn { cos: cos / length, sin: sin / length } } else { Turn { cos: 1.0, sin: 0.0 } }
    }
}

impl Turn {
    /// The direction turned.
    pub fn of(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        [self.cos * x - self.sin * y, self.sin * x + self.cos * y]
    }
}

/// 1 − the area two figures share over the area they cover together, once both have area 1 and `own` is turned; the best
/// of nine shifts.
pub fn mismatch(own: &[[f64; 2]], turn: &Turn, other: &[[f64; 2]]) -> f64 {
    let turned: Vec<[f64; 2]> = own.iter().map(|&point| turn.of(point)).collect();
    let (own, other) = (normalised(&turned), normalised(other));
    let low = own.iter().chain(&other).map(|p| p[1]).fold(f64::INFINITY, f64::min) - SHIFT;
    let high = own.iter().chain(&other).map(|p| p[1]).fold(f64::NEG_INFINITY, f64::max) + SHIFT;
    let height = (high - low) / ROWS as f64;
    let row = |k: usize| low + (k as f64 + 0.5) * height;
    let own: Vec<Vec<f64>> = (0..ROWS).map(|k| crossings(&own, row(k))).collect();
    let mut least = 1.0f64;
    for up in [0.0, -SHIFT, SHIFT] {
        let other: Vec<Vec<f64>> = (0..ROWS).map(|k| crossings(&other, row(k) - up)).collect();
        let covered: f64 = own.iter().chain(&other).map(|row| length(row)).sum();
        for right in [0.0, -SHIFT, SHIFT] {
            let shared: f64 = own.iter().zip(&other).map(|(a, b)| shared(a, b, right)).sum();
            least = least.min(1.0 - shared / (covered - shared).max(f64::MIN_POSITIVE));
        }
    }
    least
}

/// A closed polygon at area 1 about the mean of its corners.
fn normalised(corners: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let n = corners.len().max(1) as f64;
    let mean = [0, 1].map(|axis| corners.iter().map(|p| p[axis]).sum::<f64>() / n);
    let next = corners.iter().cycle().skip(1);
    let doubled: f64 = corners.iter().zip(next).map(|(a, b)| a[0] * b[1] - a[1] * b[0]).sum();
    let scale = (0.5 * doubled.abs()).sqrt().max(f64::MIN_POSITIVE);
    corners.iter().map(|p| [0, 1].map(|axis| (p[axis] - mean[axis]) / scale)).collect()
}

/// Where a horizontal line crosses a closed polygon, ascending: inside between the first and the second, and so on.
fn crossings(corners: &[[f64; 2]], y: f64) -> Vec<f64> {
    let next = corners.iter().cycle().skip(1);
    let across = corners.iter().zip(next).filter(|(a, b)| (a[1] <= y) != (b[1] <= y));
    let mut crossings: Vec<f64> = across.map(|(a, b)| a[0] + (y - a[1]) / (b[1] - a[1]) * (b[0] - a[0])).collect();
    crossings.sort_by(f64::total_cmp);
    crossings
}

fn length(row: &[f64]) -> f64 {
    row.as_chunks::<2>().0.iter().map(|[from, to]| to - from).sum()
}

/// The length that the spans of `a` share with those of `b` shifted to the right.
fn shared(a: &[f64], b: &[f64], right: f64) -> f64 {
    let spans = |row: &[f64]| row.as_chunks::<2>().0.to_vec();
    let (a, b) = (spans(a), spans(b));
    a.iter().flat_map(|[from, to]| b.iter().map(move |[u, v]| (to.min(v + right) - from.max(u + right)).max(0.0))).sum()
}

/// What a figure stands on: the lowest part of its height; and the share of its area that reaches over it by much.
const FEET: f64 = 0.08;
const MUCH: f64 = 0.02;
/// The least length of an up in the picture where a figure is seen standing, not from above or below.
const STANDING: f64 = 0.5;

/// How much two figures reach over their feet on different sides, from 0 to 1: an animal's head does, and less of its tail.
/// `ups` are their ups in the picture, of length 1 where they lie in it.
pub fn turned_about(curves: [&[[f64; 2]]; 2], ups: [[f64; 2]; 2]) -> f64 {
    let [own, other] = [0, 1].map(|k| overhang(curves[k], ups[k]));
    (-own * other).max(0.0)
}

/// On which side a figure reaches farther over its feet, and how clearly: from −1, all on the left, to 1, all on the right
/// as it is seen standing.
fn overhang(curve: &[[f64; 2]], up: [f64; 2]) -> f64 {
    let length_of_up = up[0].hypot(up[1]);
    if length_of_up < STANDING {
        return 0.0;
    }
    let [x, y] = up.map(|u| u / length_of_up);
    let standing: Vec<[f64; 2]> = curve.iter().map(|&[u, v]| [y * u - x * v, x * u + y * v]).collect();
    let figure = normalised(&standing);
    let low = figure.iter().map(|p| p[1]).fold(f64::INFINITY, f64::min);
    let high = figure.iter().map(|p| p[1]).fold(f64::NEG_INFINITY, f64::max);
    let height = (high - low) / ROWS as f64;
    let rows: Vec<Vec<f64>> = (0..ROWS).map(|k| crossings(&figure, low + (k as f64 + 0.5) * height)).collect();
    let feet = rows.iter().take((FEET * ROWS as f64).ceil() as usize).flatten();
    let (left, right) = feet.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, r), &x| (l.min(x), r.max(x)));
    let area = |from: f64, to: f64| height * rows.iter().map(|row| shared(row, &[from, to], 0.0)).sum::<f64>();
    let (behind, before) = (area(f64::NEG_INFINITY, left), area(right, f64::INFINITY));
    (before - behind) / (before + behind + MUCH)
}

/// A body longer from front to back than so much of its height is mostly drawn from its side, another from its front.
const LONG: f64 = 0.6;

/// 1 − |cos| of the angle between the camera and the side that bodies of this build are mostly drawn from: that of a
/// four-legged one along the `normal` of its plane of symmetry, that of an upright one at right angles to it and to `up`.
/// `points` are spread over the body; the directions have length 1.
pub fn askew(points: impl Iterator<Item = [f64; 3]> + Clone, normal: [f64; 3], up: [f64; 3], toward: [f64; 3]) -> f64 {
    let across = cross(normal, up);
    // Where the plane of symmetry lies flat the build says nothing.
    if length_of(across) < STANDING {
        return 0.0;
    }
    let ahead = unit(across);
    let extent = |direction: [f64; 3]| {
        let along = points.clone().map(|point| dot(point, direction));
        along.clone().fold(f64::NEG_INFINITY, f64::max) - along.fold(f64::INFINITY, f64::min)
    };
    let side = if extent(ahead) > LONG * extent(up) { normal } else { ahead };
    1.0 - dot(side, toward).abs()
}

/// (1 − cos)/2 of the angle between the ups in the picture, where the sketch lies turned.
pub fn tilt(upright: &Upright, frame: &Frame, turn: &Turn) -> f64 {
    let ([x, y], seen) = (turn.of(upright.sketch), frame.project(upright.mesh));
    0.5 * (1.0 - (x * seen[0] + y * seen[1]))
}

/// 1 − the rank correlation of the drawing's heights at its samples and the body's heights at their answers.
pub fn disorder(scene: &Scene<'_>, map: &[u32]) -> f64 {
    let Some(upright) = scene.upright else { return 0.0 };
    let [x, y] = upright.sketch;
    let samples = &scene.shape.samples;
    let drawn = samples.iter().map(|&v| {
        let p = scene.shape.positions[v as usize];
        x * p[0] + y * p[1]
    });
    let found = samples.iter().map(|&v| dot(upright.mesh, scene.mesh.positions[map[v as usize] as usize]));
    1.0 - correlation(&ranks(drawn.collect()), &ranks(found.collect()))
}

fn ranks(values: Vec<f64>) -> Vec<f64> {
    let mut order: Vec<usize> = (0..values.len()).collect();
    order.sort_by(|&a, &b| values[a].total_cmp(&values[b]).then(a.cmp(&b)));
    let mut ranks = vec![0.0; values.len()];
    order.into_iter().enumerate().for_each(|(rank, i)| ranks[i] = rank as f64);
    ranks
}

fn correlation(a: &[f64], b: &[f64]) -> f64 {
    let n = a.len().max(1) as f64;
    let (ma, mb) = (a.iter().sum::<f64>() / n, b.iter().sum::<f64>() / n);
    let product: f64 = a.iter().zip(b).map(|(x, y)| (x - ma) * (y - mb)).sum();
    let squares = |v: &[f64], m: f64| v.iter().map(|x| (x - m) * (x - m)).sum::<f64>();
    product / (squares(a, ma) * squares(b, mb)).sqrt().max(f64::MIN_POSITIVE)
}

/// How much of the mesh's side in front no answer is near, from 0 to 1: judged at the farthest points that face the camera.
pub fn uncovered(scene: &Scene<'_>, toward: [f64; 3], map: &[u32]) -> f64 {
    let distances = &scene.mesh.distances;
    let (mut left_out, mut count) = (0.0, 0.0);
    for (field, &normal) in distances.fields.iter().zip(&scene.mesh.normals) {
        if dot(normal, toward) <= 0.0 {
            continue;
        }
        let nearest = map.iter().map(|&v| field[v as usize]).fold(f32::INFINITY, f32::min);
        left_out += ((f64::from(nearest) - NEAR) / (FAR - NEAR)).clamp(0.0, 1.0);
        count += 1.0;
    }
    if count > 0.0 { left_out / count } else { 0.0 }
}

/// The distance from the top of the body up to which a place may be on the head, and that from which it is not, in units of
/// √area.
const HEAD: f64 = 0.3;
const NO_HEAD: f64 = 0.6;

/// How far from the head drawn eyes are answered, from 0 to 1: their mean.
pub fn eyes_astray(eyes: Eyes<'_>, map: &[u32]) -> f64 {
    let away = |&eye: &u32| {
        let distance = f64::from(eyes.from_top[map[eye as usize] as usize]);
        ((distance - HEAD) / (NO_HEAD - HEAD)).clamp(0.0, 1.0)
    };
    eyes.drawn.iter().map(away).sum::<f64>() / eyes.drawn.len().max(1) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    const BAR: [[f64; 2]; 4] = [[0.0, 0.0], [4.0, 0.0], [4.0, 1.0], [0.0, 1.0]];

    fn turned_by(degrees: f64) -> Turn {
        let (sin, cos) = degrees.to_radians().sin_cos();
        Turn { cos, sin }
    }

    #[test]
    fn a_figure_matches_itself_wherever_it_lies_and_however_large_it_is() {
        let turn = turned_by(30.0);
        let moved = BAR.map(|p| turn.of(p).map(|x| 7.0 * x - 3.0));
        assert!(mismatch(&BAR, &turn, &moved) < 1e-9);
        let found = Turn::between(&BAR, &moved);
        assert!((found.cos - turn.cos).abs() < 1e-12 && (found.sin - turn.sin).abs() < 1e-12);
    }

    #[test]
    fn bars_that_cross_share_a_seventh_of_what_they_cover() {
        // 4 × 1 and 1 × 4 share 1 of 7.
        let crossed = mismatch(&BAR, &turned_by(90.0), &BAR);
        assert!((crossed - 6.0 / 7.0).abs() < 0.02, "{crossed}");
    }

    #[test]
    fn a_head_over_the_feet_tells_where_the_front_is() {
        // A body on a block of feet, its head to the right.
        let animal = [[0.0, 0.0], [4.0, 0.0], [4.0, 2.0], [6.0, 2.0], [6.0, 3.0], [0.0, 3.0]];
        let about = animal.map(|[x, y]| [-x, y]);
        let lying = animal.map(|[x, y]| [-y, x]);
        let (up, left) = ([0.0, 1.0], [-1.0, 0.0]);
        assert_eq!(turned_about([&animal, &animal], [up, up]), 0.0);
        assert_eq!(turned_about([&animal, &lying], [up, left]), 0.0);
        assert!(turned_about([&animal, &about], [up, up]) > 0.7);
        // Seen from above nothing stands.
        assert_eq!(turned_about([&animal, &about], [up, [0.0, 0.2]]), 0.0);
    }

    #[test]
    fn a_long_body_is_drawn_from_its_side_and_an_upright_one_from_its_front() {
        let (across, ahead, up) = ([1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]);
        let built = |[x, y, z]: [f64; 3]| [[0.0; 3], [x, 0.0, 0.0], [0.0, y, 0.0], [0.0, 0.0, z]].into_iter();
        let (horse, person) = (built([0.5, 2.0, 1.5]), built([1.6, 0.3, 1.8]));
        let behind = ahead.map(|x| -x);
        assert_eq!([across, ahead, up].map(|toward| askew(horse.clone(), across, up, toward)), [0.0, 1.0, 1.0]);
        assert_eq!(askew(horse.clone(), up, up, ahead), 0.0);
        assert_eq!([across, ahead, behind].map(|toward| askew(person.clone(), across, up, toward)), [1.0, 0.0, 0.0]);
    }

    #[test]
    fn eyes_belong_to_the_head() {
        let eyes = Eyes { drawn: &[0, 1], from_top: &[0.1, 0.45, 1.2] };
        assert_eq!(eyes_astray(eyes, &[0, 0]), 0.0);
        assert!((eyes_astray(eyes, &[0, 1]) - 0.25).abs() < 1e-6);
        assert_eq!(eyes_astray(eyes, &[2, 2]), 1.0);
    }

    #[test]
    fn heights_in_the_same_order_correlate() {
        let ranked = |values: &[f64]| ranks(values.to_vec());
        assert!((correlation(&ranked(&[1.0, 5.0, 9.0]), &ranked(&[0.1, 0.2, 0.9])) - 1.0).abs() < 1e-12);
        assert!((correlation(&ranked(&[1.0, 5.0, 9.0]), &ranked(&[3.0, 2.0, 1.0])) + 1.0).abs() < 1e-12);
    }
}
