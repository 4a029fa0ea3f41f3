//! PNG and JPEG pictures as they are shown.

use std::io::Cursor;

use image::metadata::Orientation;
use image::{
    DynamicImage, ImageBuffer, ImageDecoder, ImageError, ImageFormat, ImageReader, Limits, Pixel, RgbaImage, imageops,
};

use super::Config;
use super::foreign;
use super::reading::canvas::{Canvas, LONGEST_SIDE};
use super::refusal::Refusal;
use crate::raster::PixelBox;

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
    let size = [picture.width(), picture.height()];
    let mut shown = DynamicImage::ImageRgba8(at_reading_size(picture));
    let reading_size = [shown.width(), shown.height()];
    shown.apply_orientation(orientation);
    let mut pixel = [0, 1].map(|i| f64::from(size[i]) / f64::from(reading_size[i]));
    if [shown.width(), shown.height()] != reading_size {
        pixel.reverse();
    }
    let shown = shown.into_rgba8();
    let [width, height] = [shown.width(), shown.height()].map(|side| side as usize);
    Ok(Canvas {
        width,
        height,
        own: PixelBox { low: [0; 2], high: [width, height] },
        pixels: shown.pixels().map(|pixel| pixel.0).collect(),
        cut: [[false; 2]; 2],
        origin: [0.0; 2],
        pixel,
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
    if !matches!(reader.format(), Some(ImageFormat::Png | ImageFormat::Jpeg)) {
        let named = foreign::name(bytes).map(|foreign| foreign.to_string());
        return Err(Refusal::plain(named.unwrap_or_else(|| "this is not a PNG or JPEG picture".to_owned())));
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

/// The picture made smaller where it is larger than is looked at, or larger by a whole factor where it is small.
fn at_reading_size(picture: DynamicImage) -> RgbaImage {
    let side = picture.width().max(picture.height());
    if side < SHORTEST_SIDE {
        let factor = SHORTEST_SIDE / side + 1;
        let (width, height) = (picture.width() * factor, picture.height() * factor);
        return imageops::resize(&picture.into_rgba8(), width, height, imageops::FilterType::Triangle);
    }
    let longest = side.min(LONGEST_SIDE as u32);
    let [width, height] = [picture.width(), picture.height()].map(|own| (own * longest).div_ceil(side));
    match picture {
        DynamicImage::ImageLuma8(picture) => reduced(&picture, width, height),
        DynamicImage::ImageRgb8(picture) => reduced(&picture, width, height),
        DynamicImage::ImageRgba8(picture) => reduced(&picture, width, height),
        other => reduced(&other.into_rgba8(), width, height),
    }
}

/// The picture in so many pixels or fewer, each of the mean colour of those that fall into it.
fn reduced<P: Pixel<Subpixel = u8>>(picture: &ImageBuffer<P, Vec<u8>>, width: u32, height: u32) -> RgbaImage {
    let column: Vec<usize> = (0..picture.width()).map(|x| (x * width / picture.width()) as usize).collect();
    let mut reduced = RgbaImage::new(width, height);
    // Sums of red, green and blue, each times its opacity, of opacity, and of pixels.
    let mut sums = vec![[0u64; 5]; width as usize];
    for (y, line) in (0..).zip(picture.rows()) {
        for (pixel, &column) in line.zip(&column) {
            let [r, g, b, a] = pixel.to_rgba().0.map(u64::from);
            let sum = &mut sums[column];
            *sum = [sum[0] + r * a, sum[1] + g * a, sum[2] + b * a, sum[3] + a, sum[4] + 1];
        }
        let row = y * height / picture.height();
        if (y + 1) * height / picture.height() > row {
            for (pixel, [r, g, b, a, n]) in reduced.rows_mut().nth(row as usize).into_iter().flatten().zip(&sums) {
                let [r, g, b] = [r, g, b].map(|sum| sum.checked_div(*a).unwrap_or(0) as u8);
                pixel.0 = [r, g, b, a.checked_div(*n).unwrap_or(0) as u8];
            }
            sums.fill([0; 5]);
        }
    }
    reduced
}
