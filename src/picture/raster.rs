//! Figures as pixels: a z-buffer of samples, several to a pixel.

use super::colour::Colour;
use super::figure::Figure;
use crate::geometry::distance_to_segment;

/// Samples along each side of a pixel.
pub const SAMPLES: usize = 2;

/// Half the width of an outline, in pixels.
pub const HALF_LINE: f64 = 0.7;

/// The colour of outlines: a dark grey.
pub const INK: f64 = 0.32;

/// The sample shows nothing; or an outline.
const NOTHING: u32 = u32::MAX;
const LINE: u32 = u32::MAX - 1;

/// Which triangle is in front at every sample of a figure's window.
pub struct Raster {
    /// Samples in a row, and rows.
    width: usize,
    height: usize,
    front: Vec<u32>,
    /// Towards the viewer, in pixels.
    depth: Vec<f32>,
}

impl Raster {
    /// The triangles of the figure as they hide each other, both sides of each seen. 8 bytes a sample.
    pub fn of(figure: &Figure) -> Raster {
        let [width, height] = [figure.window.width, figure.window.height].map(|side| side as usize * SAMPLES);
        let empty = (vec![NOTHING; width * height], vec![f32::NEG_INFINITY; width * height]);
        let mut raster = Raster { width, height, front: empty.0, depth: empty.1 };
        for (t, triangle) in figure.triangles.iter().enumerate() {
            raster.draw(t as u32, triangle.map(|v| figure.points[v as usize]));
        }
        raster
    }

    fn draw(&mut self, triangle: u32, corners: [[f64; 3]; 3]) {
        let flat = corners.map(|[x, y, _]| [x, y]);
        let columns = samples(flat.map(|p| p[0]), self.width);
        for row in samples(flat.map(|p| p[1]), self.height) {
            for column in columns.clone() {
                let Some(weights) = barycentric(flat, [centre(column), centre(row)]) else { return };
                if weights.iter().any(|&w| w < -1e-9) {
                    continue;
                }
                let depth = (0..3).map(|i| weights[i] * corners[i][2]).sum::<f64>() as f32;
                let at = row * self.width + column;
                if depth > self.depth[at] {
                    self.depth[at] = depth;
                    self.front[at] = triangle;
                }
            }
        }
    }

    /// The farthest depth within a pixel of a point: endless where nothing is drawn.
    pub fn farthest_around(&self, point: [f64; 2]) -> f64 {
        let [column, row] = point.map(|x| x * SAMPLES as f64 - 0.5);
        let around = |x: f64, end: usize| {
            let reach = SAMPLES as f64;
            ((x - reach).ceil().max(0.0) as usize)..((x + reach).floor() + 1.0).clamp(0.0, end as f64) as usize
        };
        let columns = around(column, self.width);
        let rows = around(row, self.height).flat_map(|row| columns.clone().map(move |column| (row, column)));
        rows.map(|(row, column)| self.depth[row * self.width + column]).fold(f32::INFINITY, f32::min).into()
    }

    /// Flags: which of the figure's triangles are seen at any sample.
    pub fn seen(&self, triangles: usize) -> Vec<bool> {
        let mut seen = vec![false; triangles];
        for &t in &self.front {
            if let Some(seen) = seen.get_mut(t as usize) {
                *seen = true;
            }
        }
        seen
    }

    /// The colours of the window's pixels by rows, on white: the mean of its samples.
    pub fn pixels(mut self, figure: &Figure) -> Vec<Colour> {
        figure.lines.iter().for_each(|&line| self.stroke(line));
        let columns = self.width / SAMPLES;
        let pixel = |i: usize| {
            let (row, column) = (i / columns * SAMPLES, i % columns * SAMPLES);
            let mut sum = [0.0; 3];
            for (down, right) in (0..SAMPLES * SAMPLES).map(|s| (row + s / SAMPLES, column + s % SAMPLES)) {
                let Colour(colour) = self.colour(figure, down, right);
                (0..3).for_each(|i| sum[i] += colour[i] / (SAMPLES * SAMPLES) as f64);
            }
            Colour(sum)
        };
        (0..columns * (self.height / SAMPLES)).map(pixel).collect()
    }

    fn colour(&self, figure: &Figure, row: usize, column: usize) -> Colour {
        let front = self.front[row * self.width + column];
        let Some(triangle) = figure.triangles.get(front as usize) else {
            return if front == LINE { Colour::grey(INK) } else { Colour::WHITE };
        };
        let flat = triangle.map(|v| [0, 1].map(|i| figure.points[v as usize][i]));
        let weights = barycentric(flat, [centre(column), centre(row)]).unwrap_or([1.0 / 3.0; 3]);
        Colour::mean(triangle.map(|v| figure.colours[v as usize]), weights)
    }

    /// Draws a line over everything.
    fn stroke(&mut self, [a, b]: [[f64; 2]; 2]) {
        let reach = |axis: usize| [a[axis].min(b[axis]) - HALF_LINE, a[axis].max(b[axis]) + HALF_LINE];
        let columns = samples(reach(0), self.width);
        for row in samples(reach(1), self.height) {
            for column in columns.clone() {
                if distance_to_segment([centre(column), centre(row)], [a, b]) <= HALF_LINE {
                    self.front[row * self.width + column] = LINE;
                }
            }
        }
    }
}

/// The place of a sample's centre, in pixels.
fn centre(sample: usize) -> f64 {
    (sample as f64 + 0.5) / SAMPLES as f64
}

/// The samples whose centres lie between the least and the largest of some places in pixels.
fn samples<const N: usize>(places: [f64; N], end: usize) -> std::ops::Range<usize> {
    let least = places.into_iter().fold(f64::INFINITY, f64::min) * SAMPLES as f64 - 0.5;
    let most = places.into_iter().fold(f64::NEG_INFINITY, f64::max) * SAMPLES as f64 - 0.5;
    (least.ceil().max(0.0) as usize)..((most.floor() + 1.0).clamp(0.0, end as f64) as usize)
}

/// The weights of the corners at a point, nothing where the triangle is seen edge-on.
fn barycentric([a, b, c]: [[f64; 2]; 3], [x, y]: [f64; 2]) -> Option<[f64; 3]> {
    let doubled = (b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1]);
    if doubled == 0.0 {
        return None;
    }
    let part = |p: [f64; 2], q: [f64; 2]| ((p[0] - x) * (q[1] - y) - (q[0] - x) * (p[1] - y)) / doubled;
    Some([part(b, c), part(c, a), part(a, b)])
}
