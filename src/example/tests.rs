use std::collections::BTreeMap;

use super::view::{FRAME, Projection};
use super::*;
use crate::geometry::{cross, dot, doubled_area, subtract, triangle_area};
use crate::numerics::Unwatched;

fn made(creature: Creature, vertices: usize) -> (TriangleMesh, Silhouette) {
    let mesh = creature.mesh(vertices).unwrap();
    let silhouette = creature.silhouette(&mesh).unwrap();
    (mesh, silhouette)
}

fn corners(mesh: &TriangleMesh, triangle: [u32; 3]) -> [[f64; 3]; 3] {
    triangle.map(|v| mesh.positions()[v as usize])
}

/// The smallest angle of a triangle, in degrees.
fn smallest_angle(p: [[f64; 3]; 3]) -> f64 {
    let angle = |i: usize| {
        let (u, v) = (subtract(p[(i + 1) % 3], p[i]), subtract(p[(i + 2) % 3], p[i]));
        (dot(u, v) / (dot(u, u) * dot(v, v)).sqrt()).acos().to_degrees()
    };
    (0..3).map(angle).fold(f64::INFINITY, f64::min)
}

#[test]
fn meshes_are_closed_spheres_wound_outwards() {
    for (creature, vertices) in Creature::ALL.into_iter().flat_map(|c| [2_000, 3_100, 5_000, 9_000].map(|n| (c, n))) {
        let mesh = creature.mesh(vertices).unwrap();
        let n = mesh.positions().len();
        assert!(n.abs_diff(vertices) * 10 < vertices, "{creature:?}: {n} vertices for {vertices}");
        let mut uses: BTreeMap<(u32, u32), usize> = BTreeMap::new();
        for &[a, b, c] in mesh.triangles() {
            [(a, b), (b, c), (c, a)].into_iter().for_each(|edge| *uses.entry(edge).or_default() += 1);
        }
        assert!(uses.iter().all(|(&(a, b), &uses_of_edge)| uses_of_edge == 1 && uses.get(&(b, a)) == Some(&1)));
        // One component of genus 0 has the Euler characteristic 2, and everything is reached from everywhere.
        assert_eq!(n + mesh.triangles().len() - uses.len() / 2, 2);
        assert!(
            crate::mesh::geodesics::Marching::new(&mesh)
                .distances(&[0], &Unwatched)
                .unwrap()
                .iter()
                .all(|d| d.is_finite())
        );
        let volume: f64 =
            mesh.triangles().iter().map(|&t| corners(&mesh, t)).map(|[a, b, c]| dot(a, cross(b, c)) / 6.0).sum();
        assert!(volume > 0.0);
    }
}

#[test]
fn triangles_are_well_shaped() {
    for mesh in Creature::ALL.map(|creature| creature.mesh(5_000).unwrap()) {
        let mean = mesh.area() / mesh.triangles().len() as f64;
        let shapes: Vec<[[f64; 3]; 3]> = mesh.triangles().iter().map(|&t| corners(&mesh, t)).collect();
        assert!(shapes.iter().all(|&t| triangle_area(t) > 0.02 * mean && smallest_angle(t) > 5.0));
        let narrow = shapes.iter().filter(|&&t| smallest_angle(t) < 20.0).count();
        assert!(narrow * 200 < shapes.len(), "{narrow} narrow triangles");
    }
}

#[test]
fn vertices_lie_on_the_body() {
    // The biped does not stride: its mesh is that of the body at rest.
    let (mesh, body) = (Creature::Biped.mesh(3_000).unwrap(), Creature::Biped.body());
    assert!(mesh.positions().iter().all(|&p| body.field(p).abs() < 1e-3));
}

#[test]
fn every_vertex_has_one_opposite_to_it() {
    for creature in Creature::ALL {
        let (mesh, body) = (creature.mesh(3_000).unwrap(), creature.body());
        let spacing = (mesh.area() / mesh.positions().len() as f64).sqrt();
        for opposite in mesh.positions().iter().step_by(17).map(|&p| body.opposite(p)) {
            let squared = mesh.positions().iter().map(|&q| dot(subtract(q, opposite), subtract(q, opposite)));
            assert!(squared.fold(f64::INFINITY, f64::min).sqrt() < spacing);
        }
    }
}

#[test]
fn the_silhouette_is_that_of_the_mesh() {
    for creature in Creature::ALL {
        let (mesh, silhouette) = made(creature, 5_000);
        let frame = Projection::around(&mesh, creature.view());
        let flat = |t: [u32; 3]| corners(&mesh, t).map(|p| frame.projected(p).0);
        // Share of a grid's points that lie under a triangle, by asking every triangle for every point near it.
        let mut covered = vec![false; 300 * 300];
        for t in mesh.triangles().iter().map(|&t| flat(t)) {
            let index = |x: f64| (x / 2.0) as usize;
            let range = |i: usize| {
                let x = t.map(|p| p[i]);
                index(x[0].min(x[1]).min(x[2]))..=index(x[0].max(x[1]).max(x[2]))
            };
            for (row, column) in range(1).flat_map(|row| range(0).map(move |column| (row, column))) {
                let p = [2.0 * column as f64 + 1.0, 2.0 * row as f64 + 1.0];
                let sides = [[t[0], t[1], p], [t[1], t[2], p], [t[2], t[0], p]].map(doubled_area);
                covered[row * 300 + column] |= sides.iter().all(|&s| s >= 0.0) || sides.iter().all(|&s| s <= 0.0);
            }
        }
        let area = 4.0 * covered.iter().filter(|&&c| c).count() as f64;
        assert!((silhouette.area() / area - 1.0).abs() < 0.01, "{} for {area}", silhouette.area());
        let within = |p: &[f64; 2]| p.iter().all(|x| (9.0..=FRAME - 9.0).contains(x));
        assert!(silhouette.outline.iter().all(within));
    }
}

#[test]
fn the_quadruped_stands_on_four_legs_and_the_biped_on_two() {
    for (creature, legs) in [(Creature::Quadruped, 4), (Creature::Biped, 2)] {
        let (_, silhouette) = made(creature, 5_000);
        let ground = silhouette.outline.iter().map(|p| p[1]).fold(f64::INFINITY, f64::min);
        assert_eq!(silhouette.crossings(ground + 8.0).len(), 2 * legs);
    }
}

#[test]
fn true_vertices_project_to_their_points() {
    for creature in Creature::ALL {
        let (mesh, silhouette) = made(creature, 5_000);
        let (truth, frame) = (creature.truth(&mesh, &silhouette), Projection::around(&mesh, creature.view()));
        let seen = |v: u32| frame.projected(mesh.positions()[v as usize]);
        // Two edges of the mesh, in drawing units.
        let [[x, _], [beyond, _]] = [[0.0; 3], [0.1, 0.0, 0.1]].map(|p| frame.projected(p).0);
        let reach = 2.0 * (mesh.area() / mesh.positions().len() as f64).sqrt() * (beyond - x).abs() / 0.1;
        assert!(truth.points.len() > 400);
        assert_eq!(truth.side, creature == Creature::Quadruped);
        for (i, point) in truth.points.iter().enumerate() {
            let [(front, near), (back, far)] = ["front", "back"].map(|variant| seen(truth.variants[variant][i] as u32));
            for p in [front, back] {
                assert!((p[0] - point[0]).hypot(p[1] - point[1]) < reach);
            }
            assert!(near >= far);
            assert!(silhouette.contains(*point));
        }
        let sides = truth.variants["front"].iter().zip(&truth.variants["front_mirrored"]);
        let changed = sides.filter(|(a, b)| a != b).count();
        assert!(changed * 10 > truth.points.len() * 9);
    }
}

#[test]
fn files_are_complete_and_the_same_every_time() {
    let files = files(2_000).unwrap();
    let names: Vec<&str> = files.iter().map(|(name, _)| name.as_str()).collect();
    let of = |creature: &str| {
        ["mesh.obj", "sketch.json", "sketch.svg", "sketch.png", "truth.json"].map(|f| format!("{creature}/{f}"))
    };
    assert_eq!(names, [of("quadruped"), of("biped")].concat());
    assert!(files == super::files(2_000).unwrap());
    let parsed = |i: usize| serde_json::from_slice::<serde_json::Value>(&files[i].1).unwrap();
    assert!(parsed(1)["outline"].as_array().unwrap().len() > 50);
    assert!(serde_json::from_value::<Truth>(parsed(4)).is_ok());
    assert!(files[2].1.starts_with(b"<svg"));
}

#[test]
fn the_picture_shows_the_same_figure_upside_down() {
    let (_, silhouette) = made(Creature::Biped, 2_000);
    let picture = image::load_from_memory(&drawing::png(&silhouette).unwrap()).unwrap().into_luma8();
    let dark: f64 = picture.pixels().map(|p| 1.0 - f64::from(p.0[0]) / 255.0).sum();
    assert!((dark / silhouette.area() - 1.0).abs() < 1e-3);
    for (column, row) in [(300, 100), (300, 590), (20, 20)] {
        let point = [f64::from(column) + 0.5, FRAME - f64::from(row) - 0.5];
        assert_eq!(picture.get_pixel(column, row).0[0] < 128, silhouette.contains(point));
    }
}
