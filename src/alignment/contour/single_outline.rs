//! The one outline of a picture: its largest piece, holes closed or cut open.

use crate::raster::bitmap::Bitmap;
use crate::raster::pieces::Pieces;
use crate::raster::silhouette::Mask;

/// Holes of less than this part of the piece's area are accidents of the drawing and filled.
const SMALL_HOLE: f64 = 4e-4;

/// A picture without holes and the line round it.
#[derive(Clone, Debug, PartialEq)]
pub struct Outline {
    /// Closed, counter-clockwise, the first not repeated: half-way between the centres of the pixels on either side, in
    /// pixels. Empty for an empty picture.
    pub points: Vec<[f64; 2]>,
    /// What the outline encloses: pixels joined by their sides, without a hole.
    pub inside: Mask,
}

/// The outline of the picture's largest piece (of pixels that meet by sides or corners). Its small holes are filled; a
/// larger one is joined to the outside by a cut of two pixels along the shortest way, so that one line runs round all.
pub fn single_outline(mask: &Mask) -> Outline {
    let mut field = Field::of(mask);
    field.keep_largest_piece(true);
    field.open_holes();
    // A cut may part what is thin. Every gap now reaches the outside, and keeps reaching it when pieces go.
    field.keep_largest_piece(false);
    Outline { points: field.outline(), inside: Mask { inside: field.cells.cropped(1), ..*mask } }
}

/// The picture with one more row and column of empty cells on every side, so that the outside is one and a
/// step from a cell of the figure stays within.
struct Field {
    cells: Bitmap,
}

/// The shortest way from a hole to the outside.
#[derive(Clone, Copy)]
struct Way {
    squared: usize,
    from: [usize; 2],
    to: [usize; 2],
}

impl Field {
    fn of(mask: &Mask) -> Field {
        Field { cells: mask.inside.framed(1) }
    }

    /// Of pieces joined by sides, or by sides and corners.
    fn keep_largest_piece(&mut self, corners: bool) {
        let pieces = Pieces::of(&self.cells, corners);
        // The first of equals.
        let largest = (0..pieces.sizes.len()).rev().max_by_key(|&piece| pieces.sizes[piece]);
        for run in pieces.runs.iter().filter(|run| Some(run.piece) != largest) {
            self.cells.fill(run.y, run.from, run.to, false);
        }
    }

    /// Fills small holes, then cuts the larger ones open.
    fn open_holes(&mut self) {
        let gaps = Pieces::of(&self.cells.complement(), false);
        // The first cell is outside, hence piece 0 is.
        if gaps.sizes.len() <= 1 {
            return;
        }
        let limit = SMALL_HOLE * self.cells.area() as f64;
        let small: Vec<bool> = gaps.sizes.iter().map(|&size| (size as f64) < limit).collect();
        for run in gaps.runs.iter().filter(|run| run.piece > 0 && small[run.piece]) {
            self.cells.fill(run.y, run.from, run.to, true);
        }
        if small[1..].contains(&false) {
            for way in self.ways_out(&gaps, &small).into_iter().flatten() {
                self.cut(way);
            }
        }
    }

    /// Per gap the shortest way outside, between centres of cells; none for small holes.
    fn ways_out(&self, gaps: &Pieces, small: &[bool]) -> Vec<Option<Way>> {
        let rows = self.nearest_rows(gaps);
        let width = self.cells.width();
        let mut ways: Vec<Option<Way>> = vec![None; gaps.sizes.len()];
        for run in gaps.runs.iter().filter(|run| run.piece > 0 && !small[run.piece]) {
            let (y, way) = (run.y, &mut ways[run.piece]);
            for x in run.from..run.to {
                for aside in 0..width {
                    if way.is_some_and(|way| way.squared <= aside * aside) {
                        break;
                    }
                    let columns = [x.checked_sub(aside), Some(x + aside).filter(|&x| x < width)];
                    for column in columns.into_iter().flatten() {
                        let row = usize::from(rows[y * width + column]);
                        let squared = aside * aside + row.abs_diff(y).pow(2);
                        if way.is_none_or(|way| squared < way.squared) {
                            *way = Some(Way { squared, from: [x, y], to: [column, row] });
                        }
                    }
                }
            }
        }
        ways
    }

    /// Per cell the row of the nearest cell outside in its column.
    fn nearest_rows(&self, gaps: &Pieces) -> Vec<u16> {
        let (width, height) = (self.cells.width(), self.cells.height());
        let mut outside = Bitmap::new(width, height);
        gaps.runs.iter().filter(|run| run.piece == 0).for_each(|run| outside.fill(run.y, run.from, run.to, true));
        // The first and the last row are outside.
        let mut rows = vec![0; width * height];
        for cell in width..width * height {
            let (x, y) = (cell % width, cell / width);
            rows[cell] = if outside.get(x, y) { y as u16 } else { rows[cell - width] };
        }
        for cell in (0..width * (height - 1)).rev() {
            let (row, above) = ((cell / width) as u16, rows[cell + width]);
            if above.abs_diff(row) < rows[cell].abs_diff(row) {
                rows[cell] = above;
            }
        }
        rows
    }

    fn cut(&mut self, Way { from, to, .. }: Way) {
        // Half a pixel at a time, so that the squares of two pixels overlap.
        let steps = 2 * from[0].abs_diff(to[0]).max(from[1].abs_diff(to[1])) + 1;
        for step in 0..=steps {
            let t = step as f64 / steps as f64;
            let [x, y] = [0, 1].map(|axis| (from[axis] as f64 * (1.0 - t) + to[axis] as f64 * t + 0.5) as usize);
            for y in y.saturating_sub(1)..=y {
                self.cells.fill(y, x.saturating_sub(1), x + 1, false);
            }
        }
    }

    /// Marching squares [LC87] between full and empty cells, from the first cell's lower side on.
    fn outline(&self) -> Vec<[f64; 2]> {
        // Right, up, left, down: a turn to the left is the next one.
        let step = |[x, y]: [usize; 2], direction: usize| match direction {
            0 => [x + 1, y],
            1 => [x, y + 1],
            2 => [x - 1, y],
            _ => [x, y - 1],
        };
        let first = |y: usize| Some([self.cells.next(y, 0, true), y]).filter(|cell| cell[0] < self.cells.width());
        let Some(start) = (0..self.cells.height()).find_map(first) else { return Vec::new() };
        let mut points = Vec::with_capacity(4 * self.cells.width());
        // A side of a cell, as the direction in which the figure is on the left of it.
        let (mut cell, mut direction) = (start, 0);
        // Every side is passed once at most.
        for _ in 0..4 * self.cells.width() * self.cells.height() {
            let outward = (direction + 3) % 4;
            let [x, y] = cell.map(|x| x as f64 - 1.0);
            let [dx, dy] = [[0.5, 0.0], [0.0, 0.5], [-0.5, 0.0], [0.0, -0.5]][outward];
            points.push([x + dx, y + dy]);
            let ahead = step(cell, direction);
            let across = step(ahead, outward);
            (cell, direction) = match [ahead, across].map(|[x, y]| self.cells.get(x, y)) {
                [false, _] => (cell, (direction + 1) % 4),
                [true, false] => (ahead, direction),
                [true, true] => (across, outward),
            };
            if (cell, direction) == (start, 0) {
                break;
            }
        }
        points
    }
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::*;

    /// A picture of these rows, the last one lowest; `#` is inside.
    fn picture(rows: &[&str]) -> Mask {
        mask(rows.len(), |x, y| rows[rows.len() - 1 - y].as_bytes()[x] == b'#')
    }

    fn mask(side: usize, mut inside: impl FnMut(usize, usize) -> bool) -> Mask {
        let mut picture = Bitmap::new(side, side);
        for (x, y) in (0..side * side).map(|pixel| (pixel % side, pixel / side)) {
            if inside(x, y) {
                picture.set(x, y);
            }
        }
        Mask { inside: picture, low: [0.0; 2], scale: 1.0 }
    }

    fn area(points: &[[f64; 2]]) -> f64 {
        let next = points.iter().cycle().skip(1);
        points.iter().zip(next).map(|(a, b)| 0.5 * (a[0] * b[1] - a[1] * b[0])).sum()
    }

    /// Numbers of pieces of the inside and of the outside, pixels joined by their sides.
    fn pieces(mask: &Mask) -> [usize; 2] {
        let field = Field::of(mask);
        [&field.cells, &field.cells.complement()].map(|cells| Pieces::of(cells, false).sizes.len())
    }

    #[test]
    fn the_line_runs_round_the_largest_piece() {
        let Outline { points, inside } = single_outline(&picture(&["#..#", "..##", "..##", "#..."]));
        assert_eq!(inside, picture(&["...#", "..##", "..##", "...."]));
        let expected = [[2.0, 0.5], [3.0, 0.5], [3.5, 1.0], [3.5, 2.0], [3.5, 3.0], [3.0, 3.5], [2.5, 3.0], [2.0, 2.5]];
        assert_eq!(points[..8], expected);
        assert_eq!(points[8..], [[1.5, 2.0], [1.5, 1.0]]);
    }

    #[test]
    fn a_disc_has_its_area() {
        let disc = mask(100, |x, y| x.abs_diff(50).pow(2) + y.abs_diff(50).pow(2) <= 40 * 40);
        let outline = single_outline(&disc);
        assert_eq!(outline.inside, disc);
        // The corners of the pixels are cut.
        let missing = disc.area() as f64 - area(&outline.points);
        assert!(missing > 0.0 && missing < 0.25 * outline.points.len() as f64);
    }

    #[test]
    fn small_holes_go_and_large_ones_open() {
        let within = |x: usize, y: usize, [left, low, right, high]: [usize; 4]| {
            (left..right).contains(&x) && (low..high).contains(&y)
        };
        let holes = [[50, 50, 90, 90], [60, 94, 70, 104], [100, 40, 110, 140], [40, 130, 42, 132]];
        let inside = |x, y| within(x, y, [20, 30, 130, 150]) && !holes.iter().any(|&hole| within(x, y, hole));
        let mask = mask(160, inside);
        assert_eq!(pieces(&mask), [1, 5]);
        let outline = single_outline(&mask);
        assert_eq!(pieces(&outline.inside), [1, 1]);
        assert!(outline.inside.inside.get(41, 131), "the small hole is filled");
        // Two cuts across 10 to 20 pixels and one across 45 at most, two or three pixels wide.
        let cut = mask.area() + 4 - outline.inside.area();
        assert!((60..=240).contains(&cut), "{cut}");
        assert!(area(&outline.points) > 0.95 * outline.inside.area() as f64);
    }

    #[test]
    fn any_picture_has_one_outline_round_an_inside_without_holes() {
        let mut source = ChaCha8Rng::seed_from_u64(1);
        for round in 0..60 {
            let outline = single_outline(&mask(40, |_, _| source.random_bool(0.4 + 0.008 * f64::from(round))));
            assert_eq!(pieces(&outline.inside), [1, 1]);
            // Pick's theorem on the figure with its corners cut, a point per side.
            let sides = outline.points.len() as f64;
            let cells = outline.inside.area() as f64;
            assert!(area(&outline.points) <= cells && area(&outline.points) >= cells - 0.25 * sides);
        }
    }

    #[test]
    fn an_empty_picture_has_no_outline_and_a_dot_has_one() {
        let empty = single_outline(&picture(&["..", ".."]));
        assert_eq!((empty.points.len(), empty.inside.area()), (0, 0));
        let dot = single_outline(&picture(&["#"]));
        assert_eq!(dot.points, [[0.0, -0.5], [0.5, 0.0], [0.0, 0.5], [-0.5, 0.0]]);
        assert!(single_outline(&mask(0, |_, _| false)).points.is_empty());
    }
}
