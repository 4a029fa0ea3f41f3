//! The one outline of a picture: its largest piece, holes closed or cut open.

use super::pieces::Pieces;
use super::silhouette::Mask;

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
    Outline { points: field.outline(), inside: Mask { inside: field.cropped(), ..mask.clone() } }
}

/// The picture with one more row and column of empty cells on every side, so that the outside is one and a
/// step from a cell of the figure stays within.
struct Field {
    width: usize,
    cells: Vec<bool>,
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
        let width = mask.side + 2;
        let mut cells = vec![false; width * width];
        for (y, row) in mask.inside.chunks_exact(mask.side.max(1)).enumerate() {
            cells[(y + 1) * width + 1..][..mask.side].copy_from_slice(row);
        }
        Field { width, cells }
    }

    fn cropped(&self) -> Vec<bool> {
        let side = self.width - 2;
        let mut cells = Vec::with_capacity(side * side);
        for row in self.cells.chunks_exact(self.width).skip(1).take(side) {
            cells.extend_from_slice(&row[1..=side]);
        }
        cells
    }

    fn position(&self, cell: usize) -> [usize; 2] {
        [cell % self.width, cell / self.width]
    }

    /// Of pieces joined by sides, or by sides and corners.
    fn keep_largest_piece(&mut self, corners: bool) {
        let pieces = Pieces::of(&self.cells, self.width, corners);
        // The first of equals.
        let largest = (1..pieces.sizes.len()).rev().max_by_key(|&label| pieces.sizes[label]);
        for (cell, &label) in self.cells.iter_mut().zip(&pieces.labels) {
            *cell = Some(label as usize) == largest;
        }
    }

    /// Fills small holes, then cuts the larger ones open.
    fn open_holes(&mut self) {
        let empty: Vec<bool> = self.cells.iter().map(|&cell| !cell).collect();
        let pieces = Pieces::of(&empty, self.width, false);
        // The first cell is outside, hence piece 1 is.
        if pieces.sizes.len() <= 2 {
            return;
        }
        let limit = SMALL_HOLE * pieces.labels.iter().filter(|&&label| label == 0).count() as f64;
        let small: Vec<bool> = pieces.sizes.iter().map(|&size| (size as f64) < limit).collect();
        for (cell, &label) in self.cells.iter_mut().zip(&pieces.labels) {
            *cell |= label > 1 && small[label as usize];
        }
        for way in self.ways_out(&pieces, &small).into_iter().flatten() {
            self.cut(way);
        }
    }

    /// Per piece of the empty cells the shortest way outside, between centres of cells; none for small holes.
    fn ways_out(&self, pieces: &Pieces, small: &[bool]) -> Vec<Option<Way>> {
        let rows = self.nearest_rows(&pieces.labels);
        let mut ways: Vec<Option<Way>> = vec![None; pieces.sizes.len()];
        let large = |&(_, &label): &(usize, &u32)| label > 1 && !small[label as usize];
        for (cell, &label) in pieces.labels.iter().enumerate().filter(large) {
            let [x, y] = self.position(cell);
            let way = &mut ways[label as usize];
            for aside in 0..self.width {
                if way.is_some_and(|way| way.squared <= aside * aside) {
                    break;
                }
                for column in [x.checked_sub(aside), Some(x + aside).filter(|&x| x < self.width)].into_iter().flatten()
                {
                    let row = rows[y * self.width + column];
                    let squared = aside * aside + row.abs_diff(y).pow(2);
                    if way.is_none_or(|way| squared < way.squared) {
                        *way = Some(Way { squared, from: [x, y], to: [column, row] });
                    }
                }
            }
        }
        ways
    }

    /// Per cell the row of the nearest cell outside in its column.
    fn nearest_rows(&self, labels: &[u32]) -> Vec<usize> {
        let width = self.width;
        // The first and the last row are outside.
        let mut rows = vec![0; labels.len()];
        for cell in width..labels.len() {
            rows[cell] = if labels[cell] == 1 { cell / width } else { rows[cell - width] };
        }
        for cell in (0..labels.len().saturating_sub(width)).rev() {
            let (row, above) = (cell / width, rows[cell + width]);
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
                self.cells[y * self.width + x.saturating_sub(1)..=y * self.width + x].fill(false);
            }
        }
    }

    /// Marching squares [LC87] between full and empty cells, from the first cell's lower side on.
    fn outline(&self) -> Vec<[f64; 2]> {
        // Right, up, left, down: a turn to the left is the next one.
        let steps = [1, self.width as isize, -1, -(self.width as isize)];
        let Some(start) = self.cells.iter().position(|&cell| cell) else { return Vec::new() };
        let mut points = Vec::new();
        // A side of a cell, as the direction in which the figure is on the left of it.
        let (mut cell, mut direction) = (start, 0);
        // Every side is passed once at most.
        for _ in 0..4 * self.cells.len() {
            let outward = (direction + 3) % 4;
            let [x, y] = self.position(cell).map(|x| x as f64 - 1.0);
            let [dx, dy] = [[0.5, 0.0], [0.0, 0.5], [-0.5, 0.0], [0.0, -0.5]][outward];
            points.push([x + dx, y + dy]);
            let ahead = cell.wrapping_add_signed(steps[direction]);
            let across = ahead.wrapping_add_signed(steps[outward]);
            (cell, direction) = match (self.cells[ahead], self.cells[across]) {
                (false, _) => (cell, (direction + 1) % 4),
                (true, false) => (ahead, direction),
                (true, true) => (across, outward),
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
        let inside = rows.iter().rev().flat_map(|row| row.chars().map(|c| c == '#')).collect();
        Mask { side: rows.len(), inside, low: [0.0; 2], scale: 1.0 }
    }

    fn area(points: &[[f64; 2]]) -> f64 {
        let next = points.iter().cycle().skip(1);
        points.iter().zip(next).map(|(a, b)| 0.5 * (a[0] * b[1] - a[1] * b[0])).sum()
    }

    /// Numbers of pieces of the inside and of the outside, pixels joined by their sides.
    fn pieces(mask: &Mask) -> [usize; 2] {
        let field = Field::of(mask);
        let empty: Vec<bool> = field.cells.iter().map(|&cell| !cell).collect();
        [&field.cells, &empty].map(|cells| Pieces::of(cells, field.width, false).sizes.len() - 1)
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
        let inside = |pixel: usize| (pixel % 100).abs_diff(50).pow(2) + (pixel / 100).abs_diff(50).pow(2) <= 40 * 40;
        let disc = Mask { side: 100, inside: (0..100 * 100).map(inside).collect(), low: [0.0; 2], scale: 1.0 };
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
        let inside = |pixel: usize| {
            let (x, y) = (pixel % 160, pixel / 160);
            within(x, y, [20, 30, 130, 150]) && !holes.iter().any(|&hole| within(x, y, hole))
        };
        let mask = Mask { side: 160, inside: (0..160 * 160).map(inside).collect(), low: [0.0; 2], scale: 1.0 };
        assert_eq!(pieces(&mask), [1, 5]);
        let outline = single_outline(&mask);
        assert_eq!(pieces(&outline.inside), [1, 1]);
        assert!(outline.inside.inside[131 * 160 + 41], "the small hole is filled");
        // Two cuts across 10 to 20 pixels and one across 45 at most, two or three pixels wide.
        let cut = mask.area() + 4 - outline.inside.area();
        assert!((60..=240).contains(&cut), "{cut}");
        assert!(area(&outline.points) > 0.95 * outline.inside.area() as f64);
    }

    #[test]
    fn any_picture_has_one_outline_round_an_inside_without_holes() {
        let mut source = ChaCha8Rng::seed_from_u64(1);
        for round in 0..60 {
            let inside = (0..40 * 40).map(|_| source.random_bool(0.4 + 0.008 * f64::from(round))).collect();
            let outline = single_outline(&Mask { side: 40, inside, low: [0.0; 2], scale: 1.0 });
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
        assert!(single_outline(&Mask { side: 0, inside: Vec::new(), low: [0.0; 2], scale: 1.0 }).points.is_empty());
    }
}
