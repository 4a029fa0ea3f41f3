use std::f64::consts::SQRT_2;

use super::*;
use crate::geometry::{length, subtract};
use crate::mesh::solids::globe;
use crate::numerics::Unwatched;
use crate::numerics::watch::counting::Counting;

/// A unit square of n × n cells, its inner vertices moved by `jitter` cells to and fro and one diagonal per cell.
fn square(n: usize, jitter: f64) -> TriangleMesh {
    let place = |i: usize, j: usize| {
        let inner = i > 0 && j > 0 && i < n && j < n;
        let shift = |phase: f64| if inner { jitter * ((i * 7 + j * 13) as f64 + phase).sin() } else { 0.0 };
        [(i as f64 + shift(0.0)) / n as f64, (j as f64 + shift(2.0)) / n as f64, 0.0]
    };
    let positions = (0..=n).flat_map(|j| (0..=n).map(move |i| (i, j))).map(|(i, j)| place(i, j)).collect();
    let cell = |i: usize, j: usize| {
        let [a, b, c, d] = [[i, j], [i + 1, j], [i + 1, j + 1], [i, j + 1]].map(|[i, j]| (j * (n + 1) + i) as u32);
        [[a, b, c], [a, c, d]]
    };
    let triangles = (0..n).flat_map(|j| (0..n).flat_map(move |i| cell(i, j))).collect();
    TriangleMesh::new(positions, triangles).unwrap()
}

fn distances(mesh: &TriangleMesh, sources: &[u32]) -> Vec<f64> {
    Marching::new(mesh).distances(sources, &Unwatched).unwrap()
}

/// The lengths of the shortest paths along edges, by relaxing all of them until nothing changes.
fn along_edges(mesh: &TriangleMesh, sources: &[u32]) -> Vec<f64> {
    let mut distances = vec![f64::INFINITY; mesh.positions().len()];
    sources.iter().for_each(|&s| distances[s as usize] = 0.0);
    loop {
        let before = distances.clone();
        for &[a, b, c] in mesh.triangles() {
            for [a, b] in [[a, b], [b, c], [c, a], [b, a], [c, b], [a, c]].map(|e| e.map(|v| v as usize)) {
                let edge = length(subtract(mesh.positions()[a], mesh.positions()[b]));
                distances[b] = distances[b].min(distances[a] + edge);
            }
        }
        if distances == before {
            return distances;
        }
    }
}

fn mean_relative_error(found: &[f64], expected: impl Fn(usize) -> f64) -> f64 {
    let errors: Vec<f64> =
        (0..found.len()).filter(|&v| expected(v) > 0.0).map(|v| (found[v] / expected(v) - 1.0).abs()).collect();
    errors.iter().sum::<f64>() / errors.len() as f64
}

#[test]
fn distances_on_flat_ground_are_straight() {
    for (mesh, source) in [(square(40, 0.0), 0), (square(40, 0.0), 20 * 41 + 17), (square(40, 0.3), 20 * 41 + 17)] {
        let from = mesh.positions()[source];
        let error =
            mean_relative_error(&distances(&mesh, &[source as u32]), |v| length(subtract(mesh.positions()[v], from)));
        assert!(error < 1e-3, "{error}");
    }
}

#[test]
fn obtuse_corners_are_corrected() {
    // Sheared, every triangle of the square has an angle of up to 161 degrees; what it covers stays convex.
    let flat = square(30, 0.0);
    for shear in [1.0, 2.0, 3.0] {
        let sheared = flat.positions().iter().map(|&[x, y, z]| [x + shear * y, y, z]).collect();
        let mesh = TriangleMesh::new(sheared, flat.triangles().to_vec()).unwrap();
        let source = 15 * 31 + 15;
        let from = mesh.positions()[source];
        let found = distances(&mesh, &[source as u32]);
        assert!(mean_relative_error(&found, |v| length(subtract(mesh.positions()[v], from))) < 1e-6);
    }
}

#[test]
fn distances_on_a_sphere_are_great_circles() {
    let mesh = globe(48, 96);
    for source in [0, 1 + 96 * 20 + 5] {
        let from = mesh.positions()[source];
        let error = mean_relative_error(&distances(&mesh, &[source as u32]), |v| {
            2.0 * (0.5 * length(subtract(mesh.positions()[v], from))).min(1.0).asin()
        });
        assert!(error < 0.01, "{error}");
    }
}

#[test]
fn paths_along_edges_are_never_shorter() {
    for (mesh, sources) in [(square(12, 0.3), vec![5, 100]), (globe(12, 24), vec![0, 77, 200])] {
        let found = distances(&mesh, &sources);
        for (d, bound) in found.iter().zip(along_edges(&mesh, &sources)) {
            assert!(*d <= bound + 1e-12);
        }
    }
}

#[test]
fn the_nearest_of_several_sources_counts() {
    let mesh = square(30, 0.2);
    let (one, other, both) = (distances(&mesh, &[0]), distances(&mesh, &[30]), distances(&mesh, &[0, 30]));
    for v in 0..both.len() {
        assert!((both[v] - one[v].min(other[v])).abs() < 1.5 / 30.0);
    }
    assert!((one[31 * 31 - 1] - SQRT_2).abs() < 1e-3);
}

#[test]
fn what_no_source_reaches_is_infinitely_far() {
    let corner = |x: f64| [[x, 0.0, 0.0], [x + 1.0, 0.0, 0.0], [x, 1.0, 0.0]];
    let mesh = TriangleMesh::new([corner(0.0), corner(5.0)].concat(), vec![[0, 1, 2], [3, 4, 5]]).unwrap();
    let found = distances(&mesh, &[1]);
    assert_eq!(found[..2], [1.0, 0.0]);
    assert!((found[2] - SQRT_2).abs() < 1e-12);
    assert_eq!(found[3..], [f64::INFINITY; 3]);
    assert_eq!(distances(&mesh, &[]), [f64::INFINITY; 6]);
}

#[test]
fn a_short_reach_changes_nothing_within_it() {
    let mesh = square(20, 0.3);
    let marching = Marching::new(&mesh);
    let (all, some) = (marching.distances(&[200], &Unwatched), marching.distances_within(&[200], 0.3, &Unwatched));
    for (far, near) in all.unwrap().iter().zip(some.unwrap()) {
        assert!(if *far <= 0.3 { near == *far } else { near > 0.3 });
    }
}

#[test]
fn cells_are_of_the_nearest_source() {
    for mesh in [square(24, 0.3), globe(24, 48)] {
        let sources = [5, 210, 399, 5, 47];
        let cells = Marching::new(&mesh).cells_within(&sources, 0.4, &Unwatched).unwrap();
        let fields = sources.map(|source| distances(&mesh, &[source]));
        let length =
            |a: u32, b: u32| super::length(subtract(mesh.positions()[a as usize], mesh.positions()[b as usize]));
        let edges = mesh.triangles().iter().flat_map(|&[a, b, c]| [length(a, b), length(b, c), length(c, a)]);
        let edge = edges.fold(0.0, f64::max);
        let mut of = [0; 5];
        for (v, cell) in cells.into_iter().enumerate() {
            let least = fields.iter().map(|field| field[v]).fold(f64::INFINITY, f64::min);
            match cell {
                Some(cell) => {
                    of[cell] += 1;
                    assert!(fields[cell][v] < least + edge, "{v}: {} of {least}", fields[cell][v]);
                }
                None => assert!(least > 0.4 - edge, "{v}: {least}"),
            }
        }
        // Of a vertex named twice the first place counts.
        assert!(of[3] == 0 && [0, 1, 2, 4].iter().all(|&cell| of[cell] > 5), "{of:?}");
    }
}

#[test]
fn the_watcher_is_asked_as_the_front_passes() {
    let mesh = square(150, 0.0);
    let (marching, vertices) = (Marching::new(&mesh), mesh.positions().len());
    let counting = Counting::default();
    marching.distances(&[0], &counting).unwrap();
    counting.assert_asked_within(vertices);
    assert_eq!(marching.cells_within(&[0, 7], f64::INFINITY, &Counting::until(1)), Err(Cancelled));
}
