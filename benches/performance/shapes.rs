//! The shapes that are measured: a bumpy four-legged body of any size, and a drawing of it. Kept as files, so that the
//! peer is timed on the same.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};

use sketchmatch::example::{Silhouette, View, drawing};
use sketchmatch::mesh::TriangleMesh;
use sketchmatch::sketch::outline::OutlineRequest;
use sketchmatch::sketch::{self, Choice, Sketch};

use crate::pen;

/// Frequencies of the octahedron: 4 f² + 2 vertices.
pub const SMALL: usize = 35;
pub const MIDDLE: usize = 79;
pub const LARGE: usize = 112;
pub const HUGE: usize = 158;
pub const VAST: usize = 316;
/// 8 f² triangles, just fewer than a million.
pub const MILLION: usize = 353;

/// The figure a drawing is taken for, in the usual number of vertices.
const FIRST: Choice = Choice { vertices: 800, figure: 0 };

/// Directions, heights and widths of the bumps: legs, head, tail. x to the left, y up, z forwards.
const BUMPS: [([f64; 3], f64, f64); 6] = [
    ([0.45, -0.75, 0.6], 1.1, 0.25),
    ([-0.45, -0.75, 0.6], 1.1, 0.25),
    ([0.45, -0.75, -0.6], 1.0, 0.25),
    ([-0.45, -0.75, -0.6], 1.0, 0.25),
    ([0.0, 0.4, 0.9], 0.8, 0.3),
    ([0.1, 0.3, -0.95], 0.9, 0.16),
];

/// Where the files are kept.
pub fn directory() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("target/bench-data")
}

/// The body of a frequency; its file is written beside.
pub fn body(frequency: usize) -> TriangleMesh {
    let mesh = made(frequency);
    write(&format!("body{}.off", mesh.positions().len()), &off(&mesh));
    mesh
}

/// The body drawn from its side, about 1000 vertices; its file is written beside.
pub fn drawn() -> Sketch {
    let request: OutlineRequest = serde_json::from_str(&drawing()).expect("a drawing is a request");
    let (drawing, _) = request.into_parts();
    let sketch =
        sketch::from_outline(&drawing, 1000, &sketch::Config::default()).expect("a silhouette is a figure").sketch;
    write("sketch.off", &off(sketch.mesh()));
    sketch
}

/// The sketch that a picture shows.
pub fn read(picture: &[u8]) -> Sketch {
    let read = sketch::from_picture(picture, FIRST, &sketch::Config::default());
    read.expect("a figure is seen in the picture").sketch
}

/// The sketch that an SVG shows.
pub fn read_svg(svg: &str) -> Sketch {
    let read = sketch::from_svg(svg.as_bytes(), FIRST, &sketch::Config::default());
    read.expect("a figure is seen in the drawing").sketch
}

/// The body's outline, as a pen draws it.
pub fn line() -> Vec<[f64; 2]> {
    pen::line(&Silhouette::of(&made(SMALL), View::Side).expect("the body can be seen"), false)
}

/// The drawing as the body of a request.
pub fn drawing() -> String {
    drawing::json(&Silhouette::of(&made(SMALL), View::Side).expect("the body can be seen"))
}

/// As Wavefront OBJ.
pub fn obj(mesh: &TriangleMesh) -> String {
    let mut text = String::new();
    for [x, y, z] in mesh.positions() {
        let _ = writeln!(text, "v {x} {y} {z}");
    }
    for [a, b, c] in mesh.triangles().iter().map(|t| t.map(|v| v + 1)) {
        let _ = writeln!(text, "f {a} {b} {c}");
    }
    text
}

/// As Wavefront OBJ out of a bad exporter: of ten triangles one is on vertices of its own, and one is turned over.
pub fn broken(mesh: &TriangleMesh) -> String {
    let mut text = String::new();
    for [x, y, z] in mesh.positions() {
        let _ = writeln!(text, "v {x} {y} {z}");
    }
    for (t, &[a, b, c]) in mesh.triangles().iter().enumerate() {
        let _ = match t % 10 {
            0 => {
                for [x, y, z] in [a, b, c].map(|v| mesh.positions()[v as usize]) {
                    let _ = writeln!(text, "v {x} {y} {z}");
                }
                writeln!(text, "f -3 -2 -1")
            }
            5 => writeln!(text, "f {} {} {}", a + 1, c + 1, b + 1),
            _ => writeln!(text, "f {} {} {}", a + 1, b + 1, c + 1),
        };
    }
    text
}

fn off(mesh: &TriangleMesh) -> String {
    let mut text = format!("OFF\n{} {} 0\n", mesh.positions().len(), mesh.triangles().len());
    for [x, y, z] in mesh.positions() {
        let _ = writeln!(text, "{x} {y} {z}");
    }
    for [a, b, c] in mesh.triangles() {
        let _ = writeln!(text, "3 {a} {b} {c}");
    }
    text
}

fn write(name: &str, text: &str) {
    fs::create_dir_all(directory()).expect("the directory of the shapes can be made");
    fs::write(directory().join(name), text).expect("a shape can be written");
}

/// The octahedron with every triangle split into f², its vertices brought to the sphere and moved out by the bumps.
fn made(frequency: usize) -> TriangleMesh {
    let f = frequency as i64;
    let (mut ids, mut positions, mut triangles) = (BTreeMap::new(), Vec::new(), Vec::new());
    let mut vertex = |lattice: [i64; 3]| {
        *ids.entry(lattice).or_insert_with(|| {
            positions.push(bumped(unit(lattice.map(|x| x as f64))));
            positions.len() as u32 - 1
        })
    };
    for octant in 0..8 {
        let sign = [0, 1, 2].map(|axis| if octant >> axis & 1 == 1 { -1 } else { 1 });
        let mirrored = sign.iter().product::<i64>() < 0;
        let mut add = |corners: [[i64; 2]; 3]| {
            let [a, b, c] = corners.map(|[x, y]| vertex([sign[0] * x, sign[1] * y, sign[2] * (f - x - y)]));
            triangles.push(if mirrored { [a, c, b] } else { [a, b, c] });
        };
        for (x, y) in (0..f).flat_map(|x| (0..f - x).map(move |y| (x, y))) {
            add([[x, y], [x + 1, y], [x, y + 1]]);
            if x + y < f - 1 {
                add([[x + 1, y], [x + 1, y + 1], [x, y + 1]]);
            }
        }
    }
    TriangleMesh::new(positions, triangles).expect("a star-shaped surface is a mesh")
}

fn unit(p: [f64; 3]) -> [f64; 3] {
    let length = p.iter().map(|x| x * x).sum::<f64>().sqrt();
    p.map(|x| x / length)
}

fn bumped(p: [f64; 3]) -> [f64; 3] {
    let bump = |&(direction, height, width): &([f64; 3], f64, f64)| {
        let cosine: f64 = p.iter().zip(unit(direction)).map(|(a, b)| a * b).sum();
        height * (-(cosine.clamp(-1.0, 1.0).acos() / width).powi(2)).exp()
    };
    let r = 1.0 + BUMPS.iter().map(bump).sum::<f64>();
    [0.75 * r * p[0], 0.85 * r * p[1] + 0.06 * (2.0 * p[2]).sin(), 1.5 * r * p[2]]
}
