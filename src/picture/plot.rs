//! Curves over axes, one plot or several beside each other.

use std::fmt::Write;

use image::ImageError;
use resvg::tiny_skia::{Pixmap, Transform};

use super::colour::Colour;
use super::lettering::{Anchor, LINE, SIZE, Writing, width};
use super::png::encoded;
use super::svg::document;

/// The frame of a plot in pixels, and the room round it: for the numbers on the left, the title above, the numbers and the
/// names of axes and curves below.
const FRAME: [f64; 2] = [440.0, 320.0];
const LEFT: f64 = 56.0;
const RIGHT: f64 = 24.0;
const ABOVE: f64 = 40.0;
const BELOW: f64 = 56.0;
/// Height of a line of the legend.
const ROW: f64 = 20.0;
/// Steps between the numbers of an axis.
const TICKS: usize = 5;
/// Dashes of curves that share a colour: none, long, short.
const DASHES: [&str; 3] = ["", "9 5", "3 4"];
/// Lightness, chroma and hues of the curves, in turns; far enough apart to be told from each other also without colour.
const HUES: [(f64, f64); 6] = [(0.5, 0.07), (0.5, 0.71), (0.6, 0.4), (0.7, 0.2), (0.35, 0.85), (0.62, 0.57)];
const CHROMA: f64 = 0.16;

/// Curves over two axes.
#[derive(Clone, Debug, PartialEq)]
pub struct Plot {
    pub title: String,
    pub across: Axis,
    pub up: Axis,
    pub curves: Vec<Curve>,
}

/// What is told along one side of a plot.
#[derive(Clone, Debug, PartialEq)]
pub struct Axis {
    pub name: String,
    /// Least and largest value; what is beyond is cut off.
    pub range: [f64; 2],
}

#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    pub name: String,
    /// Curves of the same number have the same colour and other dashes.
    pub colour: usize,
    pub points: Vec<[f64; 2]>,
}

/// The plots in rows of `columns`, as SVG.
pub fn svg(plots: &[Plot], columns: usize) -> String {
    let sheet = Sheet::of(plots, columns);
    let mut content = sheet.lines;
    let _ = writeln!(content, "<g font-family=\"Noto Sans Mono, monospace\" font-size=\"{SIZE}\">");
    sheet.writing.iter().for_each(|writing| content.push_str(&writing.svg()));
    content.push_str("</g>\n");
    document(sheet.size[0], sheet.size[1], "plots", &content)
}

/// The same as PNG.
///
/// # Errors
/// What the encoder reports; plots that are too many for a picture.
pub fn png(plots: &[Plot], columns: usize) -> Result<Vec<u8>, ImageError> {
    let Sheet { size: [width, height], lines, writing } = Sheet::of(plots, columns);
    let unseen = |error: String| ImageError::IoError(std::io::Error::other(error));
    let text = document(width, height, "plots", &lines);
    let tree = usvg::Tree::from_str(&text, &usvg::Options::default()).map_err(|error| unseen(error.to_string()))?;
    let mut painted = Pixmap::new(width, height).ok_or_else(|| unseen("the picture is too large".to_owned()))?;
    resvg::render(&tree, Transform::default(), &mut painted.as_mut());
    let mut pixels: Vec<[u8; 3]> = painted.pixels().iter().map(|p| [p.red(), p.green(), p.blue()]).collect();
    writing.iter().for_each(|writing| writing.write(&mut pixels, width));
    encoded(width, height, pixels)
}

/// The lines of plots as SVG, and what is written beside them.
struct Sheet {
    size: [u32; 2],
    lines: String,
    writing: Vec<Writing>,
}

impl Sheet {
    fn of(plots: &[Plot], columns: usize) -> Sheet {
        let columns = columns.clamp(1, plots.len().max(1));
        let legend = plots.iter().map(|plot| plot.curves.len()).max().unwrap_or(0) as f64 * ROW;
        let cell = [LEFT + FRAME[0] + RIGHT, ABOVE + FRAME[1] + BELOW + legend];
        let rows = plots.len().div_ceil(columns);
        let size = [(columns as f64 * cell[0]) as u32, (rows.max(1) as f64 * cell[1]) as u32];
        let mut sheet = Sheet { size, lines: String::new(), writing: Vec::new() };
        for (i, plot) in plots.iter().enumerate() {
            let corner = [(i % columns) as f64 * cell[0] + LEFT, (i / columns) as f64 * cell[1] + ABOVE];
            sheet.axes(plot, corner);
            sheet.curves(plot, corner);
        }
        sheet
    }

    fn write(&mut self, at: [f64; 2], anchor: Anchor, text: impl Into<String>) {
        self.writing.push(Writing { at, anchor, text: text.into() });
    }

    fn line(&mut self, points: &[[f64; 2]], colour: Colour, width: f64, dashes: &str) {
        let points: Vec<String> = points.iter().map(|[x, y]| format!("{x:.1},{y:.1}")).collect();
        let dashes = if dashes.is_empty() { String::new() } else { format!(" stroke-dasharray=\"{dashes}\"") };
        // Writing to a string cannot fail.
        let _ = writeln!(
            self.lines,
            "<polyline fill=\"none\" stroke=\"{}\" stroke-width=\"{width}\"{dashes} points=\"{}\"/>",
            colour.hex(),
            points.join(" ")
        );
    }

    fn axes(&mut self, plot: &Plot, [left, top]: [f64; 2]) {
        let [right, bottom] = [left + FRAME[0], top + FRAME[1]];
        let (faint, dark) = (Colour::grey(0.92), Colour::grey(0.4));
        for i in 0..=TICKS {
            let share = i as f64 / TICKS as f64;
            let [x, y] = [left + share * FRAME[0], bottom - share * FRAME[1]];
            self.line(&[[x, top], [x, bottom]], faint, 1.0, "");
            self.line(&[[left, y], [right, y]], faint, 1.0, "");
            self.write([x, bottom + f64::from(LINE)], Anchor::Middle, plot.across.number(share));
            self.write([left - 6.0, y], Anchor::End, plot.up.number(share));
        }
        self.line(&[[left, top], [right, top], [right, bottom], [left, bottom], [left, top]], dark, 1.0, "");
        self.write([left, top - f64::from(LINE)], Anchor::Start, format!("{} · {}", plot.title, plot.up.name));
        self.write([left + 0.5 * FRAME[0], bottom + 2.0 * ROW], Anchor::Middle, &plot.across.name);
    }

    fn curves(&mut self, plot: &Plot, [left, top]: [f64; 2]) {
        let bottom = top + FRAME[1];
        let mut dashed = [0; HUES.len()];
        for (i, curve) in plot.curves.iter().enumerate() {
            let hue = curve.colour % HUES.len();
            let (colour, dashes) = (colour(hue), DASHES[dashed[hue] % DASHES.len()]);
            dashed[hue] += 1;
            let place =
                |&[x, y]: &[f64; 2]| [left + plot.across.share(x) * FRAME[0], bottom - plot.up.share(y) * FRAME[1]];
            let points: Vec<[f64; 2]> = curve.points.iter().map(place).collect();
            self.line(&points, colour, 2.0, dashes);
            let y = bottom + BELOW + (i as f64 + 0.5) * ROW;
            self.line(&[[left, y], [left + 36.0, y]], colour, 2.0, dashes);
            self.write([left + 46.0, y], Anchor::Start, &curve.name);
        }
    }
}

impl Axis {
    /// How far along the axis a value lies, in `[0, 1]`; what is not a number lies at the start.
    fn share(&self, value: f64) -> f64 {
        let [least, most] = self.range;
        let share = (value - least) / (most - least);
        if share.is_nan() { 0.0 } else { share.clamp(0.0, 1.0) }
    }

    /// The value so far along the axis, as it is written there.
    fn number(&self, share: f64) -> String {
        let [least, most] = self.range;
        let step = (most - least).abs() / TICKS as f64;
        // As many digits as tell a step from the next.
        let digits = (-(step.max(1e-6)).log10().floor()).max(0.0) as usize;
        format!("{:.digits$}", least + share * (most - least))
    }
}

fn colour(number: usize) -> Colour {
    let (lightness, hue) = HUES[number % HUES.len()];
    Colour::of(lightness, CHROMA, hue)
}

/// How many letters of a name of a curve have room in the legend.
pub fn longest_name() -> usize {
    ((FRAME[0] - 46.0 + RIGHT) / f64::from(width("m"))) as usize
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plot(count: usize) -> Plot {
        let curve = |i: usize| Curve {
            name: format!("curve {i}"),
            colour: i / 2,
            points: vec![[0.0, 0.0], [0.25, 0.2 * (i + 1) as f64], [0.5, f64::INFINITY], [9.0, 0.5]],
        };
        Plot {
            title: "errors".to_owned(),
            across: Axis { name: "error".to_owned(), range: [0.0, 0.5] },
            up: Axis { name: "share".to_owned(), range: [0.0, 1.0] },
            curves: (0..count).map(curve).collect(),
        }
    }

    #[test]
    fn curves_run_within_the_frame_and_are_named() {
        let text = svg(&[plot(3)], 1);
        let document = usvg::roxmltree::Document::parse(&text).unwrap();
        let texts: Vec<&str> =
            document.descendants().filter(|node| node.has_tag_name("text")).filter_map(|n| n.text()).collect();
        for wanted in ["errors · share", "error", "0.0", "0.5", "1.0", "curve 2"] {
            assert!(texts.contains(&wanted), "{wanted}: {texts:?}");
        }
        let line = document.descendants().find(|node| node.attribute("stroke-width") == Some("2")).unwrap();
        // A quarter is half of the way across and a fifth of the way up; beyond the frame nothing goes.
        assert_eq!(line.attribute("points"), Some("56.0,360.0 276.0,296.0 496.0,40.0 496.0,200.0"));
        assert_eq!(text.matches("stroke-dasharray").count(), 2);
    }

    #[test]
    fn several_plots_stand_in_rows() {
        let sheet = Sheet::of(&vec![plot(2); 5], 3);
        assert_eq!(sheet.size, [3 * 520, 2 * 456]);
        let picture = image::load_from_memory(&png(&vec![plot(2); 5], 3).unwrap()).unwrap().into_rgb8();
        assert_eq!(picture.dimensions(), (3 * 520, 2 * 456));
        let [red, _, blue] = picture.get_pixel(60, 40 + 320 + 56 + 10).0;
        assert!(red > blue + 60, "{red} {blue}");
        // The first letter of the title.
        assert!((56..66).any(|x| (16..32).any(|y| picture.get_pixel(x, y).0[0] < 100)));
        assert_eq!(picture.get_pixel(1_559, 911).0, [255; 3]);
    }

    #[test]
    fn nothing_is_an_empty_sheet() {
        assert!(png(&[], 3).is_ok());
        assert!(longest_name() > 40);
    }

    #[test]
    fn numbers_have_as_many_digits_as_tell_steps_apart() {
        let written = |range: [f64; 2]| Axis { name: String::new(), range }.number(0.2);
        assert_eq!([written([0.0, 0.5]), written([0.0, 0.2]), written([0.0, 50.0])], ["0.1", "0.04", "10"]);
    }
}
