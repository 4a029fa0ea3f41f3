//! What was read of a drawing, over the drawing itself.

use std::fmt::Write;

use image::ImageError;
use resvg::tiny_skia::{PixmapMut, Transform};

use super::png::encoded;
use crate::mesh::edges::Edges;
use crate::sketch::{Canvas, Sketch, Warning, WarningCode, YAxis};

/// The share of its colour that the drawing keeps under what was read.
const FADED: f64 = 0.4;

/// Room round what is shown, in parts of its width.
const MARGIN: f64 = 0.04;

/// Widths of the lines, in parts of the picture's width: of triangles, of the outline, of lines within and of marks; and the radius of marks
/// of points.
const TRIANGLE: f64 = 0.0006;
const OUTLINE: f64 = 0.004;
const STROKE: f64 = 0.003;
const MARK: f64 = 0.003;
const POINT: f64 = 0.012;

/// A sketch, what was seen of its upload, where that was a picture, and what was said of it.
pub struct Read<'a> {
    pub canvas: Option<&'a Canvas>,
    pub sketch: &'a Sketch,
    pub warnings: &'a [Warning],
}

/// The part of the upload's plane that is shown, y down, and how many pixels of the picture a unit of it has.
struct View {
    low: [f64; 2],
    scale: f64,
    size: [u32; 2],
}

impl Read<'_> {
    /// The view of all that is seen, `width` pixels wide and at most twice as high.
    fn view(&self, width: u32) -> View {
        let corners = self.canvas.into_iter().flat_map(|canvas| {
            [[0.0; 2], [canvas.width as f64, canvas.height as f64]].map(|corner| canvas.upload_point(corner))
        });
        let vertices = (0..self.sketch.mesh().positions().len()).map(|vertex| self.shown(self.sketch.point(vertex)));
        let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for point in corners.chain(vertices) {
            low = [0, 1].map(|i| low[i].min(point[i]));
            high = [0, 1].map(|i| high[i].max(point[i]));
        }
        let extent = [0, 1].map(|i| high[i] - low[i]);
        let margin = MARGIN * extent[0].max(extent[1]);
        let [across, down] = extent.map(|side| side + 2.0 * margin);
        let scale = (f64::from(width) / across).min(2.0 * f64::from(width) / down);
        View {
            low: low.map(|x| x - margin),
            scale,
            size: [across, down].map(|side| (scale * side).ceil().max(1.0) as u32),
        }
    }

    /// A point of the upload with y down.
    fn shown(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        match self.sketch.y_axis() {
            YAxis::Up => [x, -y],
            YAxis::Down => [x, y],
        }
    }

    /// What was read, as elements of SVG: the triangles, the outline, and a mark for every warning that has a place.
    fn marks(&self, view: &View) -> String {
        let width = f64::from(view.size[0]);
        let place = |point: [f64; 2]| {
            let point = self.shown(point);
            [0, 1].map(|i| view.scale * (point[i] - view.low[i]))
        };
        let mesh = self.sketch.mesh();
        let mut text = format!(
            "<g stroke=\"#2060c0\" fill=\"#4090ff\" fill-opacity=\"0.35\" stroke-width=\"{:.2}\">\n",
            TRIANGLE * width
        );
        for triangle in mesh.triangles() {
            let [a, b, c] = triangle.map(|v| place(self.sketch.point(v as usize)));
            let _ = writeln!(
                text,
                "<path d=\"M{:.1} {:.1} {:.1} {:.1} {:.1} {:.1}z\"/>",
                a[0], a[1], b[0], b[1], c[0], c[1]
            );
        }
        let _ = write!(
            text,
            "</g>\n<path fill=\"none\" stroke=\"#103080\" stroke-linecap=\"round\" stroke-width=\"{:.2}\" d=\"",
            OUTLINE * width
        );
        let edges = Edges::of(mesh.triangles());
        for [from, to] in edges.iter().filter(|edge| edge.half_edges().len() == 1).map(|edge| edge.ends()) {
            let [a, b] = [from, to].map(|v| place(self.sketch.point(v as usize)));
            let _ = write!(text, "M{:.1} {:.1} {:.1} {:.1}", a[0], a[1], b[0], b[1]);
        }
        let _ = write!(
            text,
            "\"/>\n<path fill=\"none\" stroke=\"#a020a0\" stroke-linecap=\"round\" stroke-width=\"{:.2}\" d=\"",
            STROKE * width
        );
        for line in self.sketch.drawn_strokes() {
            // A line of one point is shown as a dot.
            let ends = line.first().into_iter().chain(&line).chain(line.last());
            for (k, point) in ends.enumerate() {
                let [x, y] = place(*point);
                let _ = write!(text, "{}{x:.1} {y:.1}", if k == 0 { "M" } else { " " });
            }
        }
        text.push_str("\"/>\n");
        for warning in self.warnings {
            let colour = colour(warning.code);
            if let Some(point) = warning.point {
                let [x, y] = place(point);
                let _ = writeln!(
                    text,
                    "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{:.1}\" fill=\"{colour}\"/>",
                    POINT * width
                );
            }
            if let Some(bounds) = warning.bounds {
                let [a, b] = bounds.map(place);
                let (low, high) = ([0, 1].map(|i| a[i].min(b[i])), [0, 1].map(|i| a[i].max(b[i])));
                let _ = writeln!(
                    text,
                    "<rect x=\"{:.1}\" y=\"{:.1}\" width=\"{:.1}\" height=\"{:.1}\" fill=\"none\" stroke=\"{colour}\" \
                     stroke-width=\"{:.2}\"/>",
                    low[0],
                    low[1],
                    high[0] - low[0],
                    high[1] - low[1],
                    MARK * width
                );
            }
        }
        text
    }

    /// The drawing, faded on white, by the rows of the picture.
    fn faded(&self, view: &View) -> Vec<[u8; 3]> {
        let [columns, rows] = view.size.map(|side| side as usize);
        let mut pixels = vec![[255; 3]; columns * rows];
        let Some(canvas) = self.canvas else { return pixels };
        for (i, pixel) in pixels.iter_mut().enumerate() {
            let at = [i % columns, i / columns].map(|k| (k as f64 + 0.5) / view.scale);
            let [x, y] = [0, 1].map(|k| (at[k] + view.low[k] - canvas.origin[k]) / canvas.pixel[k]);
            if x >= 0.0 && y >= 0.0 && (x as usize) < canvas.width && (y as usize) < canvas.height {
                let [r, g, b, opacity] = canvas.pixels[y as usize * canvas.width + x as usize];
                let share = FADED * f64::from(opacity) / 255.0;
                *pixel = [r, g, b].map(|value| (255.0 - share * (255.0 - f64::from(value))).round() as u8);
            }
        }
        pixels
    }

    fn document(&self, view: &View, under: &str) -> String {
        let [width, height] = view.size;
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" \
             viewBox=\"0 0 {width} {height}\">\n<title>what was read of the drawing</title>\n{under}{}</svg>\n",
            self.marks(view)
        )
    }
}

/// Red for what is left out, orange for what the figure lies on or beside, green for what was drawn in.
fn colour(code: WarningCode) -> &'static str {
    match code {
        WarningCode::LeftOut => "#d01010",
        WarningCode::OtherFigure | WarningCode::Background => "#e09000",
        _ => "#10a030",
    }
}

/// What was read, as SVG.
///
/// # Errors
/// What the PNG encoder reports.
pub fn svg(read: &Read<'_>, width: u32) -> Result<String, ImageError> {
    let view = read.view(width);
    let [width, height] = view.size;
    let file = encoded(width, height, read.faded(&view))?;
    Ok(read.document(&view, &super::svg::embedded(&file, [0, 0, width, height])))
}

/// What was read, as PNG.
///
/// # Errors
/// What the PNG encoder reports.
pub fn png(read: &Read<'_>, width: u32) -> Result<Vec<u8>, ImageError> {
    let view = read.view(width);
    let [width, height] = view.size;
    let mut pixels: Vec<u8> = read.faded(&view).into_iter().flat_map(|[r, g, b]| [r, g, b, 255]).collect();
    let drawn = usvg::Tree::from_str(&read.document(&view, ""), &usvg::Options::default());
    if let (Ok(drawn), Some(mut pixmap)) = (drawn, PixmapMut::from_bytes(&mut pixels, width, height)) {
        resvg::render(&drawn, Transform::identity(), &mut pixmap);
    }
    encoded(width, height, pixels.chunks_exact(4).map(|pixel| [pixel[0], pixel[1], pixel[2]]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sketch::{Choice, Config, canvas_of_svg, from_svg};

    #[test]
    fn what_is_marked_is_what_the_warnings_list() {
        let head = r#"<circle cx="200" cy="95" r="40"/><path d="M150 150H250V450H150Z"/><path d="M20 20H60V40H20Z"/>"#;
        let text = format!(r#"<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 400 500">{head}</svg>"#);
        let config = Config::default();
        let read = from_svg(text.as_bytes(), Choice { vertices: 100, figure: 0 }, &config).unwrap();
        let canvas = canvas_of_svg(text.as_bytes(), &config).unwrap();
        let placed = read.warnings.iter().filter(|warning| warning.bounds.is_some()).count();
        assert!(placed >= 2, "{:?}", read.warnings);
        let of = Read { canvas: Some(&canvas), sketch: &read.sketch, warnings: &read.warnings };
        let drawn = svg(&of, 400).unwrap();
        assert_eq!(drawn.matches("<rect ").count(), placed);
        assert_eq!(drawn.matches("z\"/>").count(), read.sketch.mesh().triangles().len());
        let picture = image::load_from_memory(&png(&of, 400).unwrap()).unwrap().into_rgb8();
        assert_eq!(picture.width(), 400);
        // Blue within the figure, white beside it.
        assert!(picture.pixels().any(|pixel| pixel.0[2] > pixel.0[0].saturating_add(40)));
        assert_eq!(picture.get_pixel(0, picture.height() - 1).0, [255; 3]);
    }
}
