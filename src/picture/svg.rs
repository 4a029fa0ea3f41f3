//! Figures as SVG.

use std::fmt::Write;

use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use image::ImageError;

use super::colour::Colour;
use super::figure::Figure;
use super::png;
use super::raster::{HALF_LINE, INK, Raster};

/// Triangles in sight up to which a figure is drawn as polygons, about a megabyte of them. Finer ones are smaller than a
/// few pixels, and their figure comes as a picture.
const POLYGONS: usize = 20_000;

/// The document of a picture of this width and height, in pixels, that is called `title`. `content` is SVG already.
pub fn document(width: u32, height: u32, title: &str, content: &str) -> String {
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" \
         viewBox=\"0 0 {width} {height}\">\n<title>{title}</title>\n\
         <rect width=\"{width}\" height=\"{height}\" fill=\"#fff\"/>\n{content}</svg>\n"
    )
}

/// An element that shows a PNG file in a rectangle, its pixels as they are.
pub fn embedded(png: &[u8], [x, y, width, height]: [u32; 4]) -> String {
    let data = BASE64_STANDARD.encode(png);
    format!(
        "<image x=\"{x}\" y=\"{y}\" width=\"{width}\" height=\"{height}\" preserveAspectRatio=\"none\" \
         style=\"image-rendering:pixelated\" href=\"data:image/png;base64,{data}\"/>\n"
    )
}

/// A figure: the triangles that are in sight as polygons, the farthest first, and its outlines; where there are too
/// many, as an embedded picture.
///
/// # Errors
/// What the PNG encoder reports.
pub fn figure(figure: &Figure) -> Result<String, ImageError> {
    let raster = Raster::of(figure);
    let seen = raster.seen(figure.triangles.len());
    let mut order: Vec<usize> = (0..seen.len()).filter(|&t| seen[t]).collect();
    let window = figure.window;
    if order.len() > POLYGONS {
        let pixels = raster.pixels(figure);
        let file = png::encoded(window.width, window.height, pixels.iter().map(|pixel| pixel.bytes()))?;
        return Ok(embedded(&file, [window.left, window.top, window.width, window.height]));
    }
    let depth = |t: usize| figure.triangles[t].iter().map(|&v| figure.points[v as usize][2]).sum::<f64>();
    order.sort_by(|&a, &b| depth(a).total_cmp(&depth(b)));
    // Strokes of the fill's colour close the seams between neighbours. Writing to a string cannot fail.
    let mut text = format!(
        "<g transform=\"translate({} {})\" stroke-linejoin=\"round\" stroke-linecap=\"round\">\n\
         <g fill=\"currentColor\" stroke=\"currentColor\" stroke-width=\"0.7\">\n",
        window.left, window.top
    );
    for t in order {
        let [a, b, c] = figure.triangles[t].map(|v| figure.points[v as usize]);
        let colour = Colour::mean(figure.triangles[t].map(|v| figure.colours[v as usize]), [1.0 / 3.0; 3]);
        let _ = writeln!(
            text,
            "<path color=\"{}\" d=\"M{:.1} {:.1} {:.1} {:.1} {:.1} {:.1}z\"/>",
            colour.hex(),
            a[0],
            a[1],
            b[0],
            b[1],
            c[0],
            c[1]
        );
    }
    let _ = write!(
        text,
        "</g>\n<path fill=\"none\" stroke=\"{}\" stroke-width=\"{}\" d=\"",
        Colour::grey(INK).hex(),
        2.0 * HALF_LINE
    );
    for [a, b] in &figure.lines {
        let _ = write!(text, "M{:.1} {:.1} {:.1} {:.1}", a[0], a[1], b[0], b[1]);
    }
    text.push_str("\"/>\n</g>\n");
    Ok(text)
}
