//! The union of a drawing and its cages, triangulated around the triangles' own corners.

use std::collections::{BTreeMap, BTreeSet};

use kd_tree::KdTree;
use spade::{ConstrainedDelaunayTriangulation, Point2, Triangulation};

use crate::mesh::TriangleMesh;
use crate::mesh::disjoint_sets::DisjointSets;
use crate::mesh::edges::Edges;

/// Vertices added within cages at most, about.
const MOST_ADDED: f64 = 4000.0;
/// Vertices along the line between two corners of a cage at most.
const MOST_ALONG: f64 = 200.0;
/// How near to another vertex none is added, in spacings.
const APART: f64 = 0.6;

/// The union of a flat mesh and the insides of polygons that do not cross themselves: the mesh's vertices come first.
/// Without polygons it is the mesh itself.
///
/// # Errors
/// Why there is none, in words.
pub(super) fn domain(mesh: &TriangleMesh, cages: &[&[[f64; 2]]]) -> Result<TriangleMesh, String> {
    if cages.is_empty() {
        return Ok(mesh.clone());
    }
    let drawn: Vec<[f64; 2]> = mesh.positions().iter().map(|&[x, y, _]| [x, y]).collect();
    let outline: Vec<[u32; 2]> = {
        let edges = Edges::of(mesh.triangles());
        edges.iter().filter(|edge| edge.half_edges().len() == 1).map(|edge| edge.ends()).collect()
    };
    let is_drawn = |p: [f64; 2]| {
        let lines = outline.iter().map(|ends| ends.map(|v| drawn[v as usize]));
        crossings(lines, p) % 2 == 1
    };
    // spade takes no coordinates that are tiny beside 0: everything is laid into the unit square.
    let square = Square::around(drawn.iter().chain(cages.iter().copied().flatten()));
    let mut cdt = ConstrainedDelaunayTriangulation::<Point2<f64>>::new();
    let unfit = |error: spade::InsertionError| format!("it cannot be triangulated: {error}");
    let insert = |cdt: &mut ConstrainedDelaunayTriangulation<Point2<f64>>, p: [f64; 2]| {
        let [x, y] = square.within(p);
        cdt.insert(Point2::new(x, y)).map_err(unfit)
    };
    let corners = drawn.iter().map(|&p| insert(&mut cdt, p)).collect::<Result<Vec<_>, _>>()?;
    if cdt.num_vertices() != drawn.len() {
        return Err("the drawing is too fine to be triangulated with a cage".to_owned());
    }
    for &[a, b] in &outline {
        cdt.add_constraint_and_split(corners[a as usize], corners[b as usize], |p| p);
    }
    let spacing = mean_edge(mesh);
    let mut taken = drawn.clone();
    for cage in cages {
        let round = around(cage, spacing);
        let handles = round.iter().map(|&p| insert(&mut cdt, p)).collect::<Result<Vec<_>, _>>()?;
        for (&from, &to) in handles.iter().zip(handles.iter().cycle().skip(1)) {
            cdt.add_constraint_and_split(from, to, |p| p);
        }
        taken.extend(round);
    }
    for cage in cages {
        let tree = KdTree::build_by_ordered_float(taken.clone());
        let free = |p: &[f64; 2], spacing: f64| {
            tree.nearest(p).is_none_or(|near| near.squared_distance > (APART * spacing).powi(2))
        };
        let (inside, spacing) = lattice(cage, spacing);
        let inside: Vec<[f64; 2]> =
            inside.into_iter().filter(|p| is_within(cage, *p) && !is_drawn(*p) && free(p, spacing)).collect();
        for &p in &inside {
            insert(&mut cdt, p)?;
        }
        taken.extend(inside);
    }
    let positions: Vec<[f64; 2]> = cdt
        .vertices()
        .enumerate()
        .map(|(i, v)| drawn.get(i).copied().unwrap_or_else(|| square.back([v.position().x, v.position().y])))
        .collect();
    let is_inside = |t: [u32; 3]| {
        let middle = [0, 1].map(|axis| t.iter().map(|&v| positions[v as usize][axis]).sum::<f64>() / 3.0);
        is_drawn(middle) || cages.iter().any(|cage| is_within(cage, middle))
    };
    let triangles = enclosed(&cdt, is_inside);
    let used: BTreeSet<u32> = triangles.as_flattened().iter().copied().collect();
    let unused = (drawn.len() as u32..positions.len() as u32).find(|v| !used.contains(v));
    let positions = positions.into_iter().map(|[x, y]| [x, y, 0.0]).collect();
    let whole = TriangleMesh::new(positions, triangles).map_err(|error| format!("it cannot be triangulated: {error}"));
    if unused.is_some() { Err("it touches the drawing or itself without room between".to_owned()) } else { whole }
}

/// The triangles, in pieces with constraints all round, that are inside.
///
/// Of each piece only the largest triangle is asked: points along a slanted line are rounded, and triangles between three of them
/// have next to no inside.
fn enclosed(
    cdt: &ConstrainedDelaunayTriangulation<Point2<f64>>,
    is_inside: impl Fn([u32; 3]) -> bool,
) -> Vec<[u32; 3]> {
    // The outer face is number 0, and so is the piece that it is of.
    let mut pieces = DisjointSets::new(cdt.num_all_faces());
    for edge in cdt.directed_edges().filter(|edge| !edge.is_constraint_edge()) {
        pieces.join(edge.face().index() as u32, edge.rev().face().index() as u32);
    }
    let mut triangles = Vec::new();
    let mut largest = BTreeMap::new();
    for face in cdt.inner_faces() {
        let (piece, area) = (pieces.representative(face.index() as u32), face.area());
        let corners = face.vertices().map(|v| v.fix().index() as u32);
        triangles.push((corners, piece));
        let found = largest.entry(piece).or_insert((area, corners));
        if area > found.0 {
            *found = (area, corners);
        }
    }
    largest.remove(&0);
    let inside: BTreeMap<u32, bool> = largest.into_iter().map(|(piece, (_, t))| (piece, is_inside(t))).collect();
    let kept = triangles.into_iter().filter(|(_, piece)| inside.get(piece) == Some(&true));
    kept.map(|(corners, _)| corners).collect()
}

/// The side of an even triangle, were all triangles of the mesh alike.
pub(super) fn mean_edge(mesh: &TriangleMesh) -> f64 {
    (4.0 / 3f64.sqrt() * mesh.area() / mesh.triangles().len() as f64).sqrt()
}

/// Whether a point lies within a closed polygon.
pub(super) fn is_within(points: &[[f64; 2]], point: [f64; 2]) -> bool {
    let lines = points.iter().zip(points.iter().cycle().skip(1));
    crossings(lines.map(|(&from, &to)| [from, to]), point) % 2 == 1
}

/// How many of these lines lie to the right of a point.
fn crossings(lines: impl Iterator<Item = [[f64; 2]; 2]>, [x, y]: [f64; 2]) -> usize {
    let crossed = lines.filter(|[[_, from], [_, to]]| (*from > y) != (*to > y));
    crossed.filter(|[[u, from], [v, to]]| u + (y - from) / (to - from) * (v - u) > x).count()
}

/// The corners of a polygon and points between them, as close as `spacing` or as many as may be.
fn around(cage: &[[f64; 2]], spacing: f64) -> Vec<[f64; 2]> {
    let lines = cage.iter().zip(cage.iter().cycle().skip(1));
    let points = lines.flat_map(|(from, to)| {
        let length = (to[0] - from[0]).hypot(to[1] - from[1]);
        let count = (length / spacing).ceil().clamp(1.0, MOST_ALONG) as usize;
        (0..count).map(move |i| {
            let share = i as f64 / count as f64;
            [0, 1].map(|axis| from[axis] + share * (to[axis] - from[axis]))
        })
    });
    points.collect()
}

/// Points of equal triangles over the box of a polygon, as close as `spacing` or as many as may be; and how close.
fn lattice(cage: &[[f64; 2]], spacing: f64) -> (Vec<[f64; 2]>, f64) {
    let bound = |axis: usize, pick: fn(f64, f64) -> f64, start: f64| cage.iter().map(|p| p[axis]).fold(start, pick);
    let low = [0, 1].map(|axis| bound(axis, f64::min, f64::INFINITY));
    let extent = [0, 1].map(|axis| bound(axis, f64::max, f64::NEG_INFINITY) - low[axis]);
    let row = 0.75f64.sqrt();
    let spacing = spacing.max((extent[0] * extent[1] / (row * MOST_ADDED)).sqrt()).max(extent[0].max(extent[1]) / 1e3);
    let rows = 0..(extent[1] / (row * spacing)).ceil() as usize;
    let points = rows.flat_map(|j| {
        let columns = 0..(extent[0] / spacing).ceil() as usize;
        columns.map(move |i| {
            let shifted = i as f64 + if j % 2 == 0 { 0.5 } else { 0.0 };
            [low[0] + spacing * shifted, low[1] + spacing * row * (j as f64 + 0.5)]
        })
    });
    (points.collect(), spacing)
}

/// The square around some points.
struct Square {
    low: [f64; 2],
    side: f64,
}

impl Square {
    fn around<'a>(points: impl Iterator<Item = &'a [f64; 2]> + Clone) -> Square {
        let low = [0, 1].map(|axis| points.clone().map(|p| p[axis]).fold(f64::INFINITY, f64::min));
        let extent = points.map(|p| (p[0] - low[0]).max(p[1] - low[1])).fold(f64::MIN_POSITIVE, f64::max);
        Square { low, side: extent }
    }

    /// Between 1 and 2, where no coordinate is tiny.
    fn within(&self, p: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|axis| 1.0 + (p[axis] - self.low[axis]) / self.side)
    }

    fn back(&self, p: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|axis| self.low[axis] + self.side * (p[axis] - 1.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::solids::sheet;

    #[test]
    fn a_cage_around_the_drawing_is_filled_and_the_drawing_kept() {
        let mesh = sheet(8, 4);
        let cage = [[-0.3, -0.2], [1.8, -0.2], [1.8, 1.0], [-0.3, 1.0]];
        let whole = domain(&mesh, &[&cage]).unwrap();
        assert_eq!(whole.positions()[..mesh.positions().len()], mesh.positions()[..]);
        assert!((whole.area() - 2.1 * 1.2).abs() < 1e-9);
    }

    #[test]
    fn a_cage_across_the_drawing_adds_what_is_beside_it() {
        let mesh = sheet(8, 4);
        // The right half of a sheet of 1.41 by 0.71, and as much beside it.
        let side = mesh.positions()[44][0];
        let cage = [[0.5 * side, 0.1], [1.5 * side, 0.1], [1.5 * side, 0.4], [0.5 * side, 0.4]];
        let whole = domain(&mesh, &[&cage]).unwrap();
        assert!((whole.area() - (1.0 + 0.5 * side * 0.3)).abs() < 1e-9, "{}", whole.area());
    }

    #[test]
    fn the_sides_of_a_cage_lie_as_they_like() {
        let mesh = sheet(8, 4);
        let regular = |n: usize, turn: f64| -> Vec<[f64; 2]> {
            let angle = |i: usize| turn + std::f64::consts::TAU * i as f64 / n as f64;
            (0..n).map(|i| [0.7 + 2.0 * angle(i).cos(), 0.35 + 2.0 * angle(i).sin()]).collect()
        };
        let turned = (3..=12).flat_map(|n| [0.0, 0.1, 0.5, 1.0, 2.0].map(|turn| regular(n, turn)));
        let star = regular(12, 0.3).into_iter().enumerate().map(|(i, [x, y])| match i % 2 {
            0 => [x, y],
            _ => [0.35 + 0.5 * x, 0.175 + 0.5 * y],
        });
        let slanted = vec![[-1.0, -1.0], [4.0, -1.3], [4.2, 2.0], [-1.0, 2.3]];
        for cage in turned.chain([slanted, star.collect()]) {
            let lines = cage.iter().zip(cage.iter().cycle().skip(1));
            let area = 0.5 * lines.map(|([x, y], [u, v])| x * v - u * y).sum::<f64>();
            let whole = domain(&mesh, &[&cage]).map(|whole| whole.area());
            assert!(whole.as_ref().is_ok_and(|whole| (whole - area).abs() < 1e-9 * area), "{cage:?}: {whole:?}");
        }
        let (over, beside) = (regular(5, 0.2), [[0.2, 0.1], [4.0, -0.7], [4.5, 0.9], [0.3, 0.6]]);
        assert!(domain(&mesh, &[&beside]).is_ok());
        assert!(domain(&mesh, &[&over, &beside]).is_ok());
    }

    #[test]
    fn a_cage_of_any_size_is_filled_with_some_thousand_vertices() {
        let cage = [[-1e3, -1e3], [1e3, -1e3], [1e3, 1e3], [-1e3, 1e3]];
        let whole = domain(&sheet(8, 4), &[&cage]).unwrap();
        assert!((1000..8000).contains(&whole.positions().len()), "{}", whole.positions().len());
    }
}
