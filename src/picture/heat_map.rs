//! A functional map as a picture: red where an entry is positive, blue where it is negative, white at 0.

use std::fmt::Write;

use image::ImageError;

use super::colour::{Colour, diverging};
use super::png::encoded;
use super::svg::{document, embedded};

/// Longer side of the matrix in pixels, at most.
const SIDE: u32 = 640;
/// Round the matrix; holds the names of the axes in SVG.
const MARGIN: u32 = 56;
/// Between the matrix and the bar of colours, the width of the bar, and the room for its numbers in SVG.
const GAP: u32 = 28;
const BAR: u32 = 20;
const NUMBERS: u32 = 76;
/// Width of the frames.
const FRAME: u32 = 1;

/// Entries up to which each is a rectangle of its own in SVG.
const RECTANGLES: usize = 10_000;

/// What a matrix and its picture have in common.
struct Layout<'a> {
    /// By rows.
    values: &'a [Vec<f64>],
    rows: u32,
    columns: u32,
    /// Of the matrix in the picture, in pixels.
    size: [u32; 2],
    /// The largest absolute value, which has the full colour.
    largest: f64,
}

/// The matrix as a PNG picture: a square per entry, a frame, and beside it a bar of the colours from the largest
/// absolute value down to its opposite. A matrix of m × n has squares of s = ⌊640 / max(m, n)⌋ pixels (of more than 640
/// rows or columns some are left out), and the picture is n s + 160 pixels wide and m s + 112 high.
///
/// # Errors
/// What the PNG encoder reports.
pub fn png(values: &[Vec<f64>]) -> Result<Vec<u8>, ImageError> {
    let layout = Layout::of(values);
    let [width, height] = layout.picture(0);
    let pixels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
    encoded(width, height, pixels.map(|(x, y)| layout.pixel(x, y).bytes()))
}

/// The same as SVG, with the names of the axes and the numbers of the bar; matrices of more than 10,000 entries are an
/// embedded picture of a pixel per entry.
///
/// # Errors
/// What the PNG encoder reports.
pub fn svg(values: &[Vec<f64>]) -> Result<String, ImageError> {
    let layout = Layout::of(values);
    let [width, height] = layout.picture(NUMBERS);
    let mut content = layout.entries()?;
    layout.legend(&mut content);
    Ok(document(width, height, "the functional map from the sketch to the mesh", &content))
}

impl Layout<'_> {
    fn of(values: &[Vec<f64>]) -> Layout<'_> {
        let count = |length: usize| u32::try_from(length).unwrap_or(u32::MAX).max(1);
        let (rows, columns) = (count(values.len()), count(values.iter().map(Vec::len).max().unwrap_or(0)));
        let cell = (SIDE / rows.max(columns)).max(1);
        let size = [columns, rows].map(|n| (n.min(SIDE)) * cell);
        let largest = values.iter().flatten().fold(0.0, |most, x| f64::max(most, x.abs()));
        Layout { values, rows, columns, size, largest }
    }

    /// The size of the picture with so much room for numbers.
    fn picture(&self, numbers: u32) -> [u32; 2] {
        let [width, height] = self.size;
        [MARGIN + width + GAP + BAR + numbers + MARGIN, height + 2 * MARGIN]
    }

    /// The left edge of the bar of colours.
    fn bar(&self) -> u32 {
        MARGIN + self.size[0] + GAP
    }

    /// The colour of an entry; white where there is none.
    fn entry(&self, row: usize, column: usize) -> Colour {
        let value = self.values.get(row).and_then(|row| row.get(column)).copied().unwrap_or(0.0);
        diverging(if self.largest > 0.0 { value / self.largest } else { 0.0 })
    }

    fn pixel(&self, x: u32, y: u32) -> Colour {
        let [width, height] = self.size;
        let Some(down) = inside(y, MARGIN, height) else { return Colour::WHITE };
        let (matrix, bar) = (inside(x, MARGIN, width), inside(x, self.bar(), BAR));
        match (down, matrix, bar) {
            (Place::Frame, Some(_), _) | (Place::Frame, _, Some(_)) => frame(),
            (_, Some(Place::Frame), _) | (_, _, Some(Place::Frame)) => frame(),
            (Place::At(y), Some(Place::At(x)), _) => {
                let entry =
                    |place: u32, size: u32, n: u32| (u64::from(place) * u64::from(n) / u64::from(size)) as usize;
                self.entry(entry(y, height, self.rows), entry(x, width, self.columns))
            }
            (Place::At(y), None, Some(_)) => diverging(1.0 - 2.0 * (f64::from(y) + 0.5) / f64::from(height)),
            _ => Colour::WHITE,
        }
    }

    /// The entries as SVG.
    fn entries(&self) -> Result<String, ImageError> {
        let [width, height] = self.size;
        let (rows, columns) = (self.rows as usize, self.columns as usize);
        let places = (0..rows).flat_map(|i| (0..columns).map(move |j| (i, j)));
        if rows.saturating_mul(columns) > RECTANGLES {
            let shown = [self.columns.min(SIDE), self.rows.min(SIDE)];
            let sampled = |i: u32, shown: u32, n: u32| (u64::from(i) * u64::from(n) / u64::from(shown)) as usize;
            let places = (0..shown[1]).flat_map(|i| (0..shown[0]).map(move |j| (i, j)));
            let colour = |(i, j)| self.entry(sampled(i, shown[1], self.rows), sampled(j, shown[0], self.columns));
            let file = encoded(shown[0], shown[1], places.map(|place| colour(place).bytes()))?;
            return Ok(embedded(&file, [MARGIN, MARGIN, width, height]));
        }
        let cell = width / self.columns;
        let mut text = format!("<g transform=\"translate({MARGIN} {MARGIN})\" shape-rendering=\"crispEdges\">\n");
        for (i, j) in places {
            let [x, y] = [j, i].map(|at| at as u32 * cell);
            let fill = self.entry(i, j).hex();
            // Writing to a string cannot fail.
            let _ = writeln!(text, "<rect x=\"{x}\" y=\"{y}\" width=\"{cell}\" height=\"{cell}\" fill=\"{fill}\"/>");
        }
        text.push_str("</g>\n");
        Ok(text)
    }

    /// Frames, the bar of colours, names and numbers, as SVG.
    fn legend(&self, text: &mut String) {
        const STEPS: u32 = 10;
        let ([width, height], bar) = (self.size, self.bar());
        let stop = |i: u32| {
            let share = f64::from(i) / f64::from(STEPS);
            format!("<stop offset=\"{share}\" stop-color=\"{}\"/>", diverging(1.0 - 2.0 * share).hex())
        };
        let stops: String = (0..=STEPS).map(stop).collect();
        let ink = frame().hex();
        let (middle, bottom) = (MARGIN + width / 2, MARGIN + height);
        let (centre, numbers) = (MARGIN + height / 2, bar + BAR + 8);
        let (below, left) = (bottom + 28, MARGIN - 22);
        let (top, last) = (MARGIN + 10, bottom);
        let largest = self.largest;
        let _ = write!(
            text,
            "<defs><linearGradient id=\"scale\" x2=\"0\" y2=\"1\">{stops}</linearGradient></defs>\n\
             <rect x=\"{bar}\" y=\"{MARGIN}\" width=\"{BAR}\" height=\"{height}\" fill=\"url(#scale)\"/>\n\
             <g fill=\"none\" stroke=\"{ink}\">\n\
             <rect x=\"{MARGIN}\" y=\"{MARGIN}\" width=\"{width}\" height=\"{height}\"/>\n\
             <rect x=\"{bar}\" y=\"{MARGIN}\" width=\"{BAR}\" height=\"{height}\"/>\n</g>\n\
             <g font-family=\"sans-serif\" font-size=\"15\" fill=\"{ink}\">\n\
             <text x=\"{middle}\" y=\"{below}\" text-anchor=\"middle\">eigenfunctions of the sketch</text>\n\
             <text transform=\"translate({left} {centre}) rotate(-90)\" text-anchor=\"middle\">\
             eigenfunctions of the mesh</text>\n\
             <text x=\"{numbers}\" y=\"{top}\">{largest:.3}</text>\n\
             <text x=\"{numbers}\" y=\"{zero}\">0</text>\n\
             <text x=\"{numbers}\" y=\"{last}\">−{largest:.3}</text>\n</g>\n",
            zero = centre + 5
        );
    }
}

/// Where a pixel lies along one side of a framed rectangle.
#[derive(Clone, Copy, PartialEq)]
enum Place {
    Frame,
    At(u32),
}

/// Nothing outside of the rectangle and its frame.
fn inside(pixel: u32, start: u32, size: u32) -> Option<Place> {
    let place = (pixel + FRAME).checked_sub(start)?;
    match place.checked_sub(FRAME) {
        Some(at) if at < size => Some(Place::At(at)),
        _ if place < size + 2 * FRAME => Some(Place::Frame),
        _ => None,
    }
}

fn frame() -> Colour {
    Colour::grey(0.4)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pixel(picture: &image::RgbImage, row: u32, column: u32, cell: u32) -> [u8; 3] {
        picture.get_pixel(MARGIN + column * cell + cell / 2, MARGIN + row * cell + cell / 2).0
    }

    fn decoded(values: &[Vec<f64>]) -> image::RgbImage {
        image::load_from_memory(&png(values).unwrap()).unwrap().into_rgb8()
    }

    #[test]
    fn entries_stand_where_they_are_in_the_matrix() {
        let picture = decoded(&[vec![0.0, 2.0, 1.0], vec![-2.0, 0.0, -1.0]]);
        assert_eq!(picture.dimensions(), (3 * 213 + 160, 2 * 213 + 112));
        assert_eq!(pixel(&picture, 0, 0, 213), [255; 3]);
        assert_eq!(pixel(&picture, 0, 1, 213), diverging(1.0).bytes());
        assert_eq!(pixel(&picture, 0, 2, 213), diverging(0.5).bytes());
        assert_eq!(pixel(&picture, 1, 0, 213), diverging(-1.0).bytes());
        let ([red, _, blue], [dark_red, _, dark_blue]) = (diverging(1.0).bytes(), diverging(-1.0).bytes());
        assert!(red > 150 && blue < 80 && dark_red < 80 && dark_blue > 150);
        // The bar, from the largest value at the top to its opposite.
        let bar = MARGIN + 3 * 213 + GAP + BAR / 2;
        let ends = [MARGIN, MARGIN + 2 * 213 - 1].map(|y| picture.get_pixel(bar, y).0);
        let near = |a: [u8; 3], b: [u8; 3]| a.iter().zip(b).all(|(x, y)| x.abs_diff(y) < 4);
        assert!(near(ends[0], diverging(1.0).bytes()) && near(ends[1], diverging(-1.0).bytes()));
        assert_eq!(picture.get_pixel(MARGIN - 1, MARGIN).0, frame().bytes());
        assert_eq!(picture.get_pixel(0, 0).0, [255; 3]);
    }

    #[test]
    fn large_matrices_stay_within_bounds() {
        for (rows, columns) in [(1000, 700), (500, 500), (1, 2000)] {
            let picture = decoded(&vec![vec![1.0; columns]; rows]);
            assert!(picture.width() <= SIDE + 160 && picture.height() <= SIDE + 112, "{:?}", picture.dimensions());
            let text = svg(&vec![vec![1.0; columns]; rows]).unwrap();
            assert!(text.len() < 200_000, "{}", text.len());
            usvg::roxmltree::Document::parse(&text).unwrap();
        }
    }

    #[test]
    fn nothing_is_white() {
        assert_eq!(pixel(&decoded(&vec![vec![0.0; 2]; 2]), 1, 1, 320), [255; 3]);
        assert_eq!(decoded(&[]).width(), 640 + 160);
    }

    #[test]
    fn the_drawing_has_a_rectangle_per_entry() {
        let text = svg(&[vec![0.0, 2.0], vec![-2.0, 0.0]]).unwrap();
        let document = usvg::roxmltree::Document::parse(&text).unwrap();
        let fills: Vec<&str> = document.descendants().filter_map(|node| node.attribute("fill")).collect();
        let expected = [diverging(1.0).hex(), diverging(-1.0).hex()];
        assert!(expected.iter().all(|fill| fills.contains(&fill.as_str())));
        assert!(text.contains(">2.000<") && text.contains(">−2.000<"));
    }
}
