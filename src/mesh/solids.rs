//! Bodies for tests, centred and of area 1.

use std::f64::consts::PI;

use crate::geometry::dot;
use crate::mesh::TriangleMesh;

/// A unit sphere of parallels and meridians; vertex 0 is the north pole and the last the south pole.
pub fn globe(rows: usize, columns: usize) -> TriangleMesh {
    let mut directions = vec![[0.0, 0.0, 1.0]];
    for row in 1..rows {
        let (polar, z) = (PI * row as f64 / rows as f64).sin_cos();
        directions.extend((0..columns).map(|column| {
            let (y, x) = (2.0 * PI * column as f64 / columns as f64).sin_cos();
            [polar * x, polar * y, z]
        }));
    }
    directions.push([0.0, 0.0, -1.0]);
    let south = (directions.len() - 1) as u32;
    let at = |row: usize, column: usize| (1 + row * columns + column % columns) as u32;
    let mut triangles = Vec::new();
    for column in 0..columns {
        triangles.push([0, at(0, column), at(0, column + 1)]);
        triangles.push([south, at(rows - 2, column + 1), at(rows - 2, column)]);
        for row in 0..rows - 2 {
            let [a, b] = [at(row, column), at(row, column + 1)];
            let [c, d] = [at(row + 1, column + 1), at(row + 1, column)];
            triangles.extend([[a, d, c], [a, c, b]]);
        }
    }
    TriangleMesh::new(directions, triangles).unwrap()
}

/// The unit sphere of parallels and meridians with each of its points put where `place` says.
pub fn ball(rows: usize, columns: usize, place: impl Fn([f64; 3]) -> [f64; 3]) -> TriangleMesh {
    let globe = globe(rows, columns);
    let (triangles, positions) = (globe.triangles().to_vec(), globe.positions().iter().map(|&p| place(p)));
    let positions: Vec<_> = positions.collect();
    let scale = TriangleMesh::new(positions.clone(), triangles.clone()).unwrap().area().sqrt();
    let middle: [f64; 3] =
        std::array::from_fn(|i| positions.iter().map(|p| p[i]).sum::<f64>() / positions.len() as f64);
    let positions = positions.iter().map(|p| std::array::from_fn(|i| (p[i] - middle[i]) / scale)).collect();
    TriangleMesh::new(positions, triangles).unwrap()
}

pub fn sphere(rows: usize, columns: usize) -> TriangleMesh {
    ball(rows, columns, |direction| direction)
}

/// A body of five rays: a head up, two arms, two longer legs, its left side at x > 0, the mirror image of its right but
/// that the left arm is bent backwards by `bend` of its length, and the head leans to the front.
pub fn star(bend: f64) -> TriangleMesh {
    let rays = [(0.0f64, 1.0), (1.3, 1.3), (-1.3, 1.3), (2.6, 1.7), (-2.6, 1.7)];
    ball(40, 80, |direction| {
        let reach = rays.iter().map(|&(angle, reach)| {
            let away = dot(direction, [angle.sin(), 0.0, angle.cos()]).clamp(-1.0, 1.0).acos();
            reach * (-(away / 0.25).powi(2)).exp()
        });
        let radius = 0.4 + reach.sum::<f64>();
        let [x, y, z] = direction.map(|x| radius * x);
        let beyond = if z > 0.0 { (x - 0.5).max(0.0) } else { 0.0 };
        [x, y - bend * beyond + 0.2 * z.max(0.0).powi(2), z]
    })
}

/// The point turned about the z-axis and then about the x-axis.
pub fn turned([x, y, z]: [f64; 3], angles: [f64; 2]) -> [f64; 3] {
    let [(sin, cos), (tilt_sin, tilt_cos)] = angles.map(f64::sin_cos);
    let [x, y] = [cos * x - sin * y, sin * x + cos * y];
    [x, tilt_cos * y - tilt_sin * z, tilt_sin * y + tilt_cos * z]
}

/// A flat grid of `columns` × `rows` squares, cut in two.
pub fn sheet(columns: u32, rows: u32) -> TriangleMesh {
    let corner = |i: u32, j: u32| i + j * (columns + 1);
    let side = f64::from(columns * rows).sqrt().recip();
    let point = move |i: u32, j: u32| [side * f64::from(i), side * f64::from(j), 0.0];
    let positions = (0..=rows).flat_map(|j| (0..=columns).map(move |i| point(i, j))).collect();
    let squares = (0..rows).flat_map(|j| (0..columns).map(move |i| (i, j)));
    let halves = squares.flat_map(|(i, j)| {
        let [a, b, c, d] = [corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)];
        [[a, b, c], [a, c, d]]
    });
    TriangleMesh::new(positions, halves.collect()).expect("a grid is a mesh")
}
