//! Silhouettes as people draw them: the line of a pen, as a picture and as an SVG.

use std::fmt::Write;
use std::io::Cursor;

use image::{GrayImage, ImageFormat, Luma};
use sketchmatch::example::Silhouette;

/// Side of the frame that silhouettes are in.
const FRAME: f64 = 600.0;
/// Half the width of the line, and how far its points are apart.
const PEN: f64 = 2.5;
const STEP: f64 = 1.25;
/// How far a trembling hand strays, and over how much of the line it strays once to and fro.
const TREMBLE: f64 = 2.0;
const PERIOD: f64 = 45.0;

/// The outline of a silhouette, drawn once around; or twice by a hand that trembles.
pub fn line(silhouette: &Silhouette, scribbled: bool) -> Vec<[f64; 2]> {
    let corners = &silhouette.outline;
    let mut once = Vec::new();
    for (a, b) in corners.iter().zip(corners.iter().cycle().skip(1)) {
        let steps = ((b[0] - a[0]).hypot(b[1] - a[1]) / STEP).ceil().max(1.0);
        once.extend((0..steps as usize).map(|i| [0, 1].map(|axis| a[axis] + i as f64 / steps * (b[axis] - a[axis]))));
    }
    if !scribbled {
        return once;
    }
    let turn = std::f64::consts::TAU * STEP / PERIOD;
    let strayed = |(i, [x, y]): (usize, [f64; 2])| {
        let (sin, cos) = (i as f64 * turn).sin_cos();
        [x + TREMBLE * sin, y + TREMBLE * cos]
    };
    let twice = once.iter().chain(&once).copied();
    twice.enumerate().map(strayed).collect()
}

/// A PNG of so many pixels a side, black on white.
pub fn png(line: &[[f64; 2]], side: u32) -> Vec<u8> {
    let scale = f64::from(side) / FRAME;
    let mut picture = GrayImage::from_pixel(side, side, Luma([255]));
    let last = f64::from(side - 1);
    let pixels = |at: f64| {
        let [low, high] = [at - PEN, at + PEN].map(|x| (x * scale).round().clamp(0.0, last) as u32);
        low..=high
    };
    for &[x, y] in line {
        for row in pixels(FRAME - y) {
            pixels(x).for_each(|column| picture.put_pixel(column, row, Luma([0])));
        }
    }
    let mut bytes = Cursor::new(Vec::new());
    picture.write_to(&mut bytes, ImageFormat::Png).expect("a picture can be encoded");
    bytes.into_inner()
}

/// An SVG of so many paths, each a piece of the line.
pub fn svg(line: &[[f64; 2]], paths: usize) -> String {
    let mut text = format!("<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {FRAME} {FRAME}\">");
    for path in 0..paths {
        let [begin, end] = [path, path + 1].map(|place| place * line.len() / paths);
        text += "<path fill=\"none\" stroke=\"black\" stroke-width=\"5\" d=\"";
        for (i, [x, y]) in (begin..=end).map(|i| line[i % line.len()]).enumerate() {
            let _ = write!(text, "{}{x:.2} {:.2}", if i == 0 { 'M' } else { 'L' }, FRAME - y);
        }
        text += "\"/>";
    }
    text + "</svg>"
}
