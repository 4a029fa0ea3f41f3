//! Figures as PNG.

use std::io::Cursor;

use image::{ImageError, ImageFormat, RgbImage};

use super::figure::Figure;
use super::raster::Raster;

/// A PNG file of these pixels, by rows; white where there are too few.
///
/// # Errors
/// What the encoder reports.
pub fn encoded(width: u32, height: u32, pixels: impl IntoIterator<Item = [u8; 3]>) -> Result<Vec<u8>, ImageError> {
    let mut picture = RgbImage::from_pixel(width, height, image::Rgb([255; 3]));
    picture.pixels_mut().zip(pixels).for_each(|(pixel, bytes)| pixel.0 = bytes);
    let mut file = Cursor::new(Vec::new());
    picture.write_to(&mut file, ImageFormat::Png)?;
    Ok(file.into_inner())
}

/// The pixels of a white picture of this width and height with the figures in their windows, by rows.
pub fn pixels(width: u32, height: u32, figures: &[Figure]) -> Vec<[u8; 3]> {
    let mut picture = vec![[255; 3]; width as usize * height as usize];
    for figure in figures {
        let window = figure.window;
        for (i, colour) in Raster::of(figure).pixels(figure).into_iter().enumerate() {
            let (row, column) = (i / window.width as usize, i % window.width as usize);
            let (row, column) = (row + window.top as usize, column + window.left as usize);
            picture[row * width as usize + column] = colour.bytes();
        }
    }
    picture
}
