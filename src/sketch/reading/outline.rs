//! The lines round a figure.

use super::FRAME;
use super::canvas::Canvas;
use crate::raster::bitmap::Bitmap;
use crate::raster::contour::Covered;
use crate::raster::enclosed::parts;
use crate::sketch::outline::Drawing;
use crate::sketch::ring::signed_area;
use crate::sketch::simplification::{looks, simplified};

/// Corners of the contour that cut off less are noise of the pixel grid, in squared pixels.
const PIXEL_NOISE: f64 = 0.5;

/// Holes of less than this part of the figure's area are filled.
const TINY_HOLE: f64 = 4e-4;

/// The outline of a figure and its holes, in the coordinates of the upload; none where it needs more than `max_points`
/// points before it is simplified.
pub(super) fn drawing(canvas: &Canvas, figure: &Bitmap, max_points: usize) -> Option<Drawing> {
    let figure = parts(figure, 1).into_iter().next()?;
    let mut rings = Covered { figure: &figure, shares: &softened(&figure) }.rings(max_points)?;
    let area = |ring: &Vec<[f64; 2]>| signed_area(ring).abs();
    rings.sort_by(|a, b| area(b).total_cmp(&area(a)));
    let least = TINY_HOLE * rings.first().map_or(0.0, area);
    rings.retain(|ring| area(ring) >= least);
    let rings = simplified(&rings, PIXEL_NOISE, &mut looks(&rings));
    let placed = |ring: Vec<[f64; 2]>| {
        ring.into_iter().map(|point| canvas.upload_point(point.map(|x| x - FRAME as f64))).collect()
    };
    let mut rings = rings.into_iter().map(placed);
    Some(Drawing { outline: rings.next()?, holes: rings.collect() })
}

/// The share of each pixel's neighbourhood that the figure takes, in 255ths: near pixels count double.
fn softened(figure: &Bitmap) -> Vec<u8> {
    let (width, height) = (figure.width(), figure.height());
    let mut counts = vec![0u8; width * height];
    for y in 1..height.saturating_sub(1) {
        for (dy, weight) in [(0, 1), (1, 2), (2, 1)] {
            let row = &mut counts[(y + dy - 1) * width..][..width];
            for x in figure.runs(y).flatten().filter(|&x| x > 0 && x + 1 < width) {
                row[x - 1] += weight;
                row[x] += 2 * weight;
                row[x + 1] += weight;
            }
        }
    }
    counts.iter_mut().for_each(|count| *count = (u32::from(*count) * 255 / 16) as u8);
    counts
}
