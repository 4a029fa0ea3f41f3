//! The largest figure of a PNG or JPEG picture.

use std::io::Cursor;

use image::{DynamicImage, ImageDecoder, ImageError, ImageReader, Limits};

use super::contour::{self, Field};
use super::outline::Drawing;
use super::refusal::{Refusal, Warning, WarningCode};
use super::ring::signed_area;
use super::simplification::{looks, simplified};
use super::{Config, TINY_HOLE};

/// Memory a decoder may take beside its output.
const MAX_DECODER_BYTES: u64 = 1 << 30;

/// Bytes per pixel beside the decoded picture: six of the coefficients of a progressive JPEG, and what the figure is
/// found with: two of brightness and opacity, six of the field and its masks, eight of the front that floods it.
const WORKING_BYTES_PER_PIXEL: u64 = 22;

/// A figure of fewer pixels has no shape to speak of.
const MIN_FIGURE_PIXELS: usize = 100;

/// Least difference between the darkest and the lightest pixel of a picture that shows something.
const MIN_CONTRAST: u8 = 16;

/// Corners of the contour that cut off less are noise of the pixel grid, in squared pixels.
const PIXEL_NOISE: f64 = 0.5;

/// Longest contour that is looked at, in points before simplification per point allowed after it.
const RAW_POINTS_PER_POINT: usize = 20;

/// The outline and holes of the picture's largest figure in pixels, y down, pixel centres at whole numbers and a half,
/// and what was left out.
///
/// Opacity tells the figure where the picture has transparent and opaque parts; else brightness does, split where it
/// separates two kinds of pixels best [Ots79], and what most of the border is made of is the background.
///
/// # Errors
/// Not a picture, cut off, too large, blank, or nothing in it larger than a speck.
pub(super) fn drawing(bytes: &[u8], config: &Config) -> Result<(Drawing, Vec<Warning>), Refusal> {
    let field = field(decoded(bytes, config)?)?;
    let figure = contour::largest_figure(&field);
    if figure.pixels < MIN_FIGURE_PIXELS {
        let detail =
            format!("the largest figure has {} pixels; at least {MIN_FIGURE_PIXELS} are needed", figure.pixels);
        return Err(Refusal::plain(detail));
    }
    let rings = figure.contours(&field, RAW_POINTS_PER_POINT * config.max_points);
    let Some(mut rings) = rings else {
        return Err(Refusal::plain("the figure's contour is too long: the picture is too noisy"));
    };
    let mut warnings = figure.warnings(&field);
    warnings.extend(fill_tiny_holes(&mut rings));
    let mut rings = simplified(&rings, PIXEL_NOISE, &mut looks(&rings)).into_iter();
    let outline = rings.next().unwrap_or_default();
    Ok((Drawing { outline, holes: rings.collect() }, warnings))
}

/// Bytes of memory that a picture takes at its peak, about, by its header; none where [`drawing`] refuses that.
pub(super) fn memory(bytes: &[u8], config: &Config) -> usize {
    let Ok(decoder) = decoder(bytes, config) else { return 0 };
    let (width, height) = decoder.dimensions();
    let working = u64::from(width) * u64::from(height) * WORKING_BYTES_PER_PIXEL;
    usize::try_from(decoder.total_bytes().saturating_add(working)).unwrap_or(usize::MAX)
}

fn decoded(bytes: &[u8], config: &Config) -> Result<DynamicImage, Refusal> {
    DynamicImage::from_decoder(decoder(bytes, config)?).map_err(|error| unreadable(&error, config))
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

/// The picture as a field that is above its threshold in figures.
fn field(picture: DynamicImage) -> Result<Field, Refusal> {
    let has_alpha = picture.color().has_alpha();
    let pixels = picture.into_luma_alpha8();
    let [width, height] = [pixels.width(), pixels.height()].map(|side| side as usize);
    let opacity = || pixels.pixels().map(|pixel| pixel.0[1]);
    if has_alpha && is_meaningful(&histogram(opacity())) {
        return Ok(Field { width, height, values: opacity().collect(), threshold: 127 });
    }
    let mut values: Vec<u8> = pixels.pixels().map(|pixel| on_paper(pixel.0)).collect();
    let histogram = histogram(values.iter().copied());
    let contrast = |value: usize| histogram[value] > 0;
    let darkest = (0..256).find(|&value| contrast(value)).unwrap_or(0);
    let lightest = (0..256).rfind(|&value| contrast(value)).unwrap_or(0);
    if lightest < darkest + usize::from(MIN_CONTRAST) {
        return Err(Refusal::plain("the picture is blank: all of it has about one brightness"));
    }
    let mut threshold = between_classes(&histogram);
    if border_is_above(&values, width, height, threshold) {
        values.iter_mut().for_each(|value| *value = 255 - *value);
        threshold = 254 - threshold;
    }
    Ok(Field { width, height, values, threshold })
}

/// Brightness of a pixel on white paper.
fn on_paper([brightness, opacity]: [u8; 2]) -> u8 {
    let (brightness, opacity) = (u32::from(brightness), u32::from(opacity));
    ((brightness * opacity + 255 * (255 - opacity) + 127) / 255) as u8
}

fn histogram(values: impl Iterator<Item = u8>) -> [u64; 256] {
    let mut histogram = [0; 256];
    values.for_each(|value| histogram[usize::from(value)] += 1);
    histogram
}

/// Whether there are both transparent and opaque pixels, a thousandth of the picture each.
fn is_meaningful(opacity: &[u64; 256]) -> bool {
    let all: u64 = opacity.iter().sum();
    let (transparent, opaque): (u64, u64) = (opacity[..64].iter().sum(), opacity[192..].iter().sum());
    transparent.min(opaque) * 1000 >= all
}

/// The value that separates the histogram into the two classes, up to it and above it, of the greatest variance
/// between them [Ots79]; the middle one where several do.
fn between_classes(histogram: &[u64; 256]) -> u8 {
    let all: f64 = histogram.iter().map(|&n| n as f64).sum();
    let total: f64 = histogram.iter().enumerate().map(|(value, &n)| value as f64 * n as f64).sum();
    let (mut below, mut sum) = (0.0, 0.0);
    let (mut best, mut first, mut last) = (-1.0, 0, 0);
    for (value, &n) in histogram.iter().enumerate().take(255) {
        below += n as f64;
        sum += value as f64 * n as f64;
        let above = all - below;
        if below == 0.0 || above == 0.0 {
            continue;
        }
        let apart = sum / below - (total - sum) / above;
        let variance = below * above * apart * apart;
        if variance > best {
            (best, first) = (variance, value);
        }
        if variance >= best {
            last = value;
        }
    }
    ((first + last) / 2) as u8
}

/// Whether most of the picture's border lies above the threshold.
fn border_is_above(values: &[u8], width: usize, height: usize, threshold: u8) -> bool {
    let rows = [0, height - 1].into_iter().flat_map(|y| (0..width).map(move |x| (x, y)));
    let columns = [0, width - 1].into_iter().flat_map(|x| (0..height).map(move |y| (x, y)));
    let (mut above, mut all) = (0, 0);
    for (x, y) in rows.chain(columns) {
        all += 1;
        above += usize::from(values[y * width + x] > threshold);
    }
    2 * above > all
}

/// Takes holes out that are too small to matter; the outline, the first ring, stays.
fn fill_tiny_holes(rings: &mut Vec<Vec<[f64; 2]>>) -> Option<Warning> {
    let areas: Vec<f64> = rings.iter().map(|ring| signed_area(ring).abs()).collect();
    let least = TINY_HOLE * areas.first()?;
    let before = rings.len();
    let mut index = 0;
    rings.retain(|_| {
        index += 1;
        index == 1 || areas[index - 1] >= least
    });
    let filled = before - rings.len();
    (filled > 0).then(|| Warning::new(WarningCode::TinyHoles, format!("{filled} tiny holes were filled")))
}
