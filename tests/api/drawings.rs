//! Small shapes made by formula.

use std::f64::consts::TAU;
use std::io::Cursor;

use image::{DynamicImage, GrayImage, ImageFormat, Luma};
use serde_json::{Value, json};

/// An ellipsoid of three different axes as OBJ: `segments` around, `rings` between the poles.
pub fn ellipsoid(segments: usize, rings: usize) -> String {
    let mut obj = String::from("# an ellipsoid\nv 0 0 0.4\n");
    for ring in 1..rings {
        let polar = TAU / 2.0 * ring as f64 / rings as f64;
        for segment in 0..segments {
            let azimuth = TAU * segment as f64 / segments as f64;
            let (x, y, z) = (polar.sin() * azimuth.cos(), 0.7 * polar.sin() * azimuth.sin(), 0.4 * polar.cos());
            obj += &format!("v {x} {y} {z}\n");
        }
    }
    obj += "v 0 0 -0.4\n";
    let at = |ring: usize, segment: usize| 2 + (ring - 1) * segments + segment % segments;
    let last = 2 + (rings - 1) * segments;
    for segment in 0..segments {
        obj += &format!("f 1 {} {}\n", at(1, segment), at(1, segment + 1));
        obj += &format!("f {last} {} {}\n", at(rings - 1, segment + 1), at(rings - 1, segment));
        for ring in 1..rings - 1 {
            let corners = (at(ring, segment), at(ring + 1, segment), at(ring + 1, segment + 1), at(ring, segment + 1));
            obj += &format!("f {} {} {} {}\n", corners.0, corners.1, corners.2, corners.3);
        }
    }
    obj
}

/// The ellipsoid's outline seen from above, as a sketch of about 100 vertices.
pub fn ellipse() -> Value {
    let angles = (0..40).map(|i| TAU * f64::from(i) / 40.0);
    let outline: Vec<[f64; 2]> = angles.map(|angle| [100.0 * angle.cos(), 70.0 * angle.sin()]).collect();
    json!({"outline": outline, "target_vertices": 100})
}

/// A black disk on white, 64 pixels a side.
pub fn disk() -> GrayImage {
    GrayImage::from_fn(64, 64, |x, y| {
        let distance = (f64::from(x) - 31.5).hypot(f64::from(y) - 31.5);
        Luma([if distance < 20.0 { 0 } else { 255 }])
    })
}

pub fn encoded(picture: GrayImage, format: ImageFormat) -> Vec<u8> {
    let mut bytes = Cursor::new(Vec::new());
    DynamicImage::ImageLuma8(picture).write_to(&mut bytes, format).unwrap();
    bytes.into_inner()
}

/// A square as SVG.
pub const SQUARE_SVG: &str =
    r#"<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 100 100"><path d="M10 10h80v80h-80z"/></svg>"#;
