//! PNG and JPEG pictures as they are shown.

use std::io::Cursor;

use image::metadata::Orientation;
use image::{DynamicImage, ImageBuffer, ImageDecoder, ImageError, ImageReader, Limits, Pixel, RgbaImage, imageops};

use super::Config;
use super::reading::canvas::{Canvas, LONGEST_SIDE};
use super::refusal::Refusal;

/// Memory a decoder may take beside its output.
const MAX_DECODER_BYTES: u64 = 1 << 30;

/// Bytes per pixel beside the decoded picture: six of the coefficients of a progressive JPEG, four where a pixel is not of
/// eight bits a channel.
const WORKING_BYTES_PER_PIXEL: u64 = 10;

/// Bytes that reading a canvas takes at its peak, whatever the picture: measured, and a third more.
const READING_BYTES: u64 = 64 << 20;

/// Pixels along the longer side below which a picture is made larger, so that lines and gaps have pixels of their own.
const SHORTEST_SIDE: u32 = 256;

/// A picture on a canvas, in pixels as it is shown, y down: the centre of the first is (0.5, 0.5).
///
/// # Errors
/// Not a picture, cut off, or too large.
pub(super) fn canvas(bytes: &[u8], config: &Config) -> Result<Canvas, Refusal> {
    let mut decoder = decoder(bytes, config)?;
    let orientation = decoder.orientation().unwrap_or(Orientation::NoTransforms);
    let picture = DynamicImage::from_decoder(decoder).map_err(|error| unreadable(&error, config))?;
    let [width, height] = [picture.width(), picture.height()];
    let (pixels, scale) = at_reading_size(picture);
    // Where sides are no multiples of the scale the last pixels reach beyond the picture, and come first when it is turned.
    let beyond = [pixels.width() as f64 * scale - f64::from(width), pixels.height() as f64 * scale - f64::from(height)];
    let (shown, [left, top]) = shown(pixels, orientation, beyond);
    Ok(Canvas {
        width: shown.width() as usize,
        height: shown.height() as usize,
        pixels: shown.pixels().map(|pixel| pixel.0).collect(),
        origin: [-left, -top],
        pixel: [scale; 2],
    })
}

/// Bytes of memory that a picture takes at its peak, about, by its header; none where [`canvas`] refuses that.
pub(super) fn memory(bytes: &[u8], config: &Config) -> usize {
    let Ok(decoder) = decoder(bytes, config) else { return 0 };
    let (width, height) = decoder.dimensions();
    let working = u64::from(width) * u64::from(height) * WORKING_BYTES_PER_PIXEL + READING_BYTES;
    usize::try_from(decoder.total_bytes().saturating_add(working)).unwrap_or(usize::MAX)
}

/// A decoder that has read the header of a picture within the limits.
fn decoder<'a>(bytes: &'a [u8], config: &Config) -> Result<impl ImageDecoder + use<'a>, Refusal> {
    let mut reader = ImageReader::new(Cursor::new(bytes))
        .with_guessed_format()
        .map_err(|error| unreadable(&error.into(), config))?;
    if reader.format().is_none() {
        return Err(Refusal::plain("this is not a PNG or JPEG picture"));
    }
    let mut limits = Limits::default();
    limits.max_image_width = Some(config.max_picture_side);
    limits.max_image_height = Some(config.max_picture_side);
    limits.max_alloc = Some(MAX_DECODER_BYTES);
    reader.limits(limits);
    let decoder = reader.into_decoder().map_err(|error| unreadable(&error, config))?;
    let (width, height) = decoder.dimensions();
    if u64::from(width) * u64::from(height) > config.max_picture_pixels {
        let detail = format!("{width} × {height} pixels; at most {} are taken", config.max_picture_pixels);
        return Err(Refusal::plain(detail));
    }
    Ok(decoder)
}

fn unreadable(error: &ImageError, config: &Config) -> Refusal {
    Refusal::plain(match error {
        ImageError::Limits(_) => {
            format!("the picture is too large: at most {} pixels a side are taken", config.max_picture_side)
        }
        ImageError::Unsupported(_) => "the picture is of a kind that is not read: PNG and JPEG are".to_owned(),
        _ => "the picture cannot be read: it is broken or cut off".to_owned(),
    })
}

/// The picture made smaller or larger by a whole factor, and the pixels of the picture along a side of the new ones.
fn at_reading_size(picture: DynamicImage) -> (RgbaImage, f64) {
    let side = picture.width().max(picture.height());
    if side < SHORTEST_SIDE {
        let factor = SHORTEST_SIDE / side + 1;
        let (width, height) = (picture.width() * factor, picture.height() * factor);
        let larger = imageops::resize(&picture.into_rgba8(), width, height, imageops::FilterType::Triangle);
        return (larger, 1.0 / f64::from(factor));
    }
    let factor = side.div_ceil(LONGEST_SIDE as u32);
    let smaller = match picture {
        DynamicImage::ImageLuma8(picture) => reduced(&picture, factor),
        DynamicImage::ImageRgb8(picture) => reduced(&picture, factor),
        DynamicImage::ImageRgba8(picture) => reduced(&picture, factor),
        other => reduced(&other.into_rgba8(), factor),
    };
    (smaller, f64::from(factor))
}

/// Every square of `factor` pixels a side as one pixel of its mean colour.
fn reduced<P: Pixel<Subpixel = u8>>(picture: &ImageBuffer<P, Vec<u8>>, factor: u32) -> RgbaImage {
    let [columns, rows] = [picture.width(), picture.height()].map(|side| side.div_ceil(factor));
    // Sums of red, green and blue, each times its opacity, of opacity, and of pixels.
    let mut sums = vec![[0u64; 5]; columns as usize];
    let mut smaller = RgbaImage::new(columns, rows);
    let mut lines = picture.rows();
    for row in 0..rows {
        sums.fill([0; 5]);
        for line in lines.by_ref().take(factor as usize) {
            for (x, pixel) in line.enumerate() {
                let [r, g, b, a] = pixel.to_rgba().0.map(u64::from);
                let sum = &mut sums[x / factor as usize];
                *sum = [sum[0] + r * a, sum[1] + g * a, sum[2] + b * a, sum[3] + a, sum[4] + 1];
            }
        }
        for (column, [r, g, b, a, n]) in sums.iter().copied().enumerate() {
            let colour = [r, g, b].map(|sum| sum.checked_div(a).unwrap_or(0) as u8);
            let opacity = a.checked_div(n).unwrap_or(0) as u8;
            smaller.put_pixel(column as u32, row, image::Rgba([colour[0], colour[1], colour[2], opacity]));
        }
    }
    smaller
}

/// The picture turned as its orientation says, and how much of what lies `beyond` its right and lower border lies beyond
/// the left and upper one then.
fn shown(pixels: RgbaImage, orientation: Orientation, [right, below]: [f64; 2]) -> (RgbaImage, [f64; 2]) {
    let mut picture = DynamicImage::ImageRgba8(pixels);
    picture.apply_orientation(orientation);
    let before = match orientation {
        Orientation::NoTransforms | Orientation::Rotate90FlipH => [0.0, 0.0],
        Orientation::FlipHorizontal => [right, 0.0],
        Orientation::FlipVertical => [0.0, below],
        Orientation::Rotate180 => [right, below],
        Orientation::Rotate90 => [below, 0.0],
        Orientation::Rotate270 => [0.0, right],
        Orientation::Rotate270FlipH => [below, right],
    };
    (picture.into_rgba8(), before)
}
