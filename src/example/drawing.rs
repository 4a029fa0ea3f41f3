//! A silhouette as the files a sketch arrives in. SVG and PNG have y down, as their formats demand; the figure is the
//! same.

use std::fmt::Write;
use std::io::Cursor;

use image::{GrayImage, ImageError, ImageFormat, Luma};

use super::silhouette::Silhouette;
use super::view::FRAME;

/// Lines of samples in every row of pixels.
const LINES: u32 = 4;

/// `{"outline": [[x, y], …], "holes": [[[x, y], …], …]}`, y up.
pub fn json(silhouette: &Silhouette) -> String {
    serde_json::json!(silhouette).to_string()
}

/// One filled path in a view box of 600 × 600.
pub fn svg(silhouette: &Silhouette) -> String {
    let mut path = String::new();
    for contour in std::iter::once(&silhouette.outline).chain(&silhouette.holes) {
        for (i, [x, y]) in contour.iter().enumerate() {
            // Writing to a string cannot fail.
            let _ = write!(path, "{}{x:.3} {:.3} ", if i == 0 { "M" } else { "L" }, FRAME - y);
        }
        path.push_str("Z ");
    }
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{FRAME}\" height=\"{FRAME}\" \
         viewBox=\"0 0 {FRAME} {FRAME}\">\n<path fill=\"black\" fill-rule=\"evenodd\" d=\"{}\"/>\n</svg>\n",
        path.trim_end()
    )
}

/// A black figure on white, 600 × 600 pixels, grey where the outline crosses a pixel.
///
/// # Errors
/// What the PNG encoder reports.
pub fn png(silhouette: &Silhouette) -> Result<Vec<u8>, ImageError> {
    let side = FRAME as u32;
    let mut picture = GrayImage::from_pixel(side, side, Luma([255]));
    for row in 0..side {
        let mut cover = vec![0.0; side as usize];
        for line in 0..LINES {
            let down = f64::from(row) + (f64::from(line) + 0.5) / f64::from(LINES);
            for span in silhouette.crossings(FRAME - down).chunks_exact(2) {
                fill(&mut cover, span[0], span[1]);
            }
        }
        for (column, cover) in (0..side).zip(cover) {
            picture.put_pixel(column, row, Luma([(255.0 * (1.0 - cover / f64::from(LINES))).round() as u8]));
        }
    }
    let mut bytes = Cursor::new(Vec::new());
    picture.write_to(&mut bytes, ImageFormat::Png)?;
    Ok(bytes.into_inner())
}

/// Adds to every pixel of a line the share of it that lies between two abscissas.
fn fill(cover: &mut [f64], from: f64, to: f64) {
    let pixels = cover.iter_mut().enumerate().take(to.ceil().max(0.0) as usize).skip(from.max(0.0) as usize);
    for (column, share) in pixels {
        let left = column as f64;
        *share += (to.min(left + 1.0) - from.max(left)).max(0.0);
    }
}
