//! Pictures of projected triangles.

use super::bitmap::Bitmap;
use crate::geometry::axes::longest;

/// Longer side of the picture, border included, in pixels.
const SIDE: usize = 256;

/// Empty border round the figure, in pixels.
pub const MARGIN: f64 = 10.0;

/// A square picture in black and white, and where it lies in the plane.
#[derive(Clone, Debug, PartialEq)]
pub struct Mask {
    /// Rows in the direction of +y: whether a pixel belongs to the figure.
    pub inside: Bitmap,
    /// Lower left corner of the figure's bounding box, in units of the points.
    pub low: [f64; 2],
    /// Pixels per unit of the points. Centres of pixels are at whole numbers, and the point p at
    /// (p − `low`) · `scale` + the border of 10 pixels.
    pub scale: f64,
}

impl Mask {
    /// Pixels of the figure.
    pub fn area(&self) -> usize {
        self.inside.area()
    }

    /// The direction (length 1) in which the figure extends most: the first principal axis of its pixels.
    pub fn longest_axis(&self) -> [f64; 2] {
        let pixels = || (0..SIDE * SIDE).filter(|&k| self.inside.get(k % SIDE, k / SIDE)).map(|k| [k % SIDE, k / SIDE]);
        let count = self.area().max(1) as f64;
        let middle = [0, 1].map(|axis| pixels().map(|pixel| pixel[axis] as f64).sum::<f64>() / count);
        let [mut squares, mut product] = [0.0; 2];
        for pixel in pixels() {
            let [x, y] = [0, 1].map(|axis| pixel[axis] as f64 - middle[axis]);
            squares += x * x - y * y;
            product += x * y;
        }
        let (sin, cos) = longest(squares, product).sin_cos();
        [cos, sin]
    }

    /// The point of the plane at a place in the picture.
    pub fn point(&self, pixel: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|axis| (pixel[axis] - MARGIN) / self.scale + self.low[axis])
    }
}

/// The union of the triangles, m × 3 valid indices into `points`, as a picture of 256 × 256 pixels that it fills but for a
/// border of 10. Corners are rounded to centres of pixels; a triangle has the pixels of its edges and those between
/// them, so that triangles thinner than a pixel leave their trace. Points of no triangle do not count. The orientation
/// of a triangle has no meaning.
pub fn silhouette(points: &[[f64; 2]], triangles: &[[u32; 3]]) -> Mask {
    let (low, extent) = bounds(points, triangles);
    let scale = (SIDE as f64 - 2.0 * MARGIN) / extent;
    // A figure without extent is a dot at any scale.
    let scale = if scale.is_finite() && scale > 0.0 { scale } else { 1.0 };
    let pixel = |p: &[f64; 2]| {
        [0, 1].map(|axis| ((p[axis] - low[axis]) * scale + MARGIN + 0.5).clamp(0.0, SIDE as f64 - 1.0) as i32)
    };
    let pixels: Vec<[i32; 2]> = points.iter().map(pixel).collect();
    let mut pen = Pen { inside: Bitmap::new(SIDE, SIDE), spans: [EMPTY; SIDE] };
    for triangle in triangles {
        pen.fill(triangle.map(|v| pixels[v as usize]));
    }
    Mask { inside: pen.inside, low, scale }
}

/// The lower left corner and the longer side of the bounding box of all corners of triangles.
fn bounds(points: &[[f64; 2]], triangles: &[[u32; 3]]) -> ([f64; 2], f64) {
    let mut corner = vec![false; points.len()];
    triangles.as_flattened().iter().for_each(|&v| corner[v as usize] = true);
    let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
    for (point, _) in points.iter().zip(&corner).filter(|&(_, &corner)| corner) {
        for axis in 0..2 {
            low[axis] = low[axis].min(point[axis]);
            high[axis] = high[axis].max(point[axis]);
        }
    }
    if triangles.is_empty() { ([0.0; 2], 0.0) } else { (low, (high[0] - low[0]).max(high[1] - low[1])) }
}

/// First and last pixel of a triangle in a row that it does not reach.
const EMPTY: [i32; 2] = [i32::MAX, i32::MIN];

/// The picture in work, and room for the rows of one triangle.
struct Pen {
    inside: Bitmap,
    /// First and last pixel of the triangle in hand by row; empty between triangles.
    spans: [[i32; 2]; SIDE],
}

impl Pen {
    fn fill(&mut self, [a, b, c]: [[i32; 2]; 3]) {
        let least = |axis: usize| a[axis].min(b[axis]).min(c[axis]);
        let most = |axis: usize| a[axis].max(b[axis]).max(c[axis]);
        let (left, right, bottom, top) = (least(0), most(0), least(1), most(1));
        // Most triangles of a fine mesh are all corners.
        if right - left <= 1 && top - bottom <= 1 {
            [a, b, c].into_iter().for_each(|[x, y]| self.inside.set(x as usize, y as usize));
            return;
        }
        let rows = bottom as usize..=top as usize;
        // Of the far side of a body little is left to do.
        if rows.clone().all(|y| self.inside.full(y, left as usize, right as usize + 1)) {
            return;
        }
        for (p, q) in [(a, b), (b, c), (c, a)] {
            self.edge(p, q);
        }
        for y in rows {
            let [from, to] = std::mem::replace(&mut self.spans[y], EMPTY);
            self.inside.fill(y, from as usize, to as usize + 1, true);
        }
    }

    /// Widens the rows by the pixels of an edge: those whose centre is within half a pixel of it, measured across its
    /// longer extent.
    fn edge(&mut self, p: [i32; 2], q: [i32; 2]) {
        let ([x, y], [end, top]) = if p[1] <= q[1] { (p, q) } else { (q, p) };
        let (least, most) = (x.min(end) as f32, x.max(end) as f32);
        let slope = if top > y { (end - x) as f32 / (top - y) as f32 } else { most - least };
        let reach = 0.5 * slope.abs().max(1.0);
        for row in y..=top {
            let centre = x as f32 + (row - y) as f32 * slope;
            let (from, to) = if top > y { (centre - reach, centre + reach) } else { (least, most) };
            let (from, to) = (from.max(least), to.min(most));
            let [first, last] = &mut self.spans[row as usize];
            *first = (*first).min(from as i32 + i32::from(from > from as i32 as f32));
            *last = (*last).max(to as i32);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_square_fills_the_picture_but_for_the_border() {
        let points = [[3.0, 3.0], [5.0, 3.0], [5.0, 5.0], [3.0, 5.0], [900.0, 0.0]];
        let mask = silhouette(&points, &[[0, 1, 2], [3, 0, 2]]);
        assert_eq!((mask.low, mask.scale, mask.inside.width()), ([3.0, 3.0], 118.0, 256));
        for [x, y] in (0..256 * 256).map(|pixel| [pixel % 256, pixel / 256]) {
            assert_eq!(mask.inside.get(x, y), (10..=246).contains(&x) && (10..=246).contains(&y));
        }
        assert_eq!(mask.area(), 237 * 237);
        assert_eq!(mask.point([128.0, 10.0]), [4.0, 3.0]);
    }

    #[test]
    fn a_triangle_is_near_the_pixels_it_covers() {
        let corners = [[0.0, 0.1], [1.0, 0.0], [0.3, 0.8]];
        let mask = silhouette(&corners, &[[0, 2, 1]]);
        let cross = |a: [f64; 2], b: [f64; 2], p: [f64; 2]| {
            ((b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0])) / (b[0] - a[0]).hypot(b[1] - a[1])
        };
        for [x, y] in (0..256 * 256).map(|pixel| [pixel % 256, pixel / 256]) {
            let inside = mask.inside.get(x, y);
            let p = mask.point([x as f64, y as f64]);
            let depth = (0..3).map(|i| cross(corners[i], corners[(i + 1) % 3], p)).fold(f64::INFINITY, f64::min);
            assert!(inside || depth * mask.scale < 1.0, "missed");
            assert!(!inside || depth * mask.scale > -1.2, "{} beyond", depth * mask.scale);
        }
    }

    #[test]
    fn a_figure_extends_along_its_longest_axis() {
        for turn in [-1.2f64, 0.0, 0.4, 1.5] {
            let (sin, cos) = turn.sin_cos();
            let corner = |x: f64, y: f64| [cos * x - sin * y, sin * x + cos * y];
            let bar = [corner(0.0, 0.0), corner(5.0, 0.0), corner(5.0, 1.0), corner(0.0, 1.0)];
            let [x, y] = silhouette(&bar, &[[0, 1, 2], [0, 2, 3]]).longest_axis();
            assert!((x * cos + y * sin).abs() > 0.9999 && (x.hypot(y) - 1.0).abs() < 1e-12);
        }
        let [x, y] = silhouette(&[], &[]).longest_axis();
        assert!((x.hypot(y) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn a_needle_is_a_line_without_a_gap() {
        let mask = silhouette(&[[0.0, 0.0], [1.0, 0.37], [0.5, 0.185]], &[[0, 1, 2]]);
        let columns: Vec<usize> = (0..256).map(|x| (0..256).filter(|&y| mask.inside.get(x, y)).count()).collect();
        assert!(columns[10..=246].iter().all(|&count| count == 1 || count == 2));
    }

    #[test]
    fn nothing_and_a_dot_are_no_trouble() {
        assert_eq!(silhouette(&[], &[]).area(), 0);
        let dot = silhouette(&[[7.0, 8.0]; 3], &[[0, 1, 2]]);
        assert_eq!((dot.area(), dot.point([10.0, 10.0])), (1, [7.0, 8.0]));
        assert_eq!(silhouette(&[[0.0, 0.0], [1e-320, 0.0], [0.0, 1e-320]], &[[0, 1, 2]]).area(), 1);
    }
}
