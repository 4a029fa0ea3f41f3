//! Connected pieces of a picture.

use std::ops::Range;

use super::PixelBox;
use super::bitmap::Bitmap;

/// The pieces that the set pixels of a picture make.
pub struct Pieces {
    pub runs: Vec<Run>,
    /// Pixels per piece, in the order of first pixels.
    pub sizes: Vec<usize>,
}

/// A stretch of set pixels within a row.
pub struct Run {
    pub y: usize,
    pub from: usize,
    pub to: usize,
    pub piece: usize,
    /// A run of the same piece that is not later; itself for the first one.
    earlier: usize,
}

impl Pieces {
    /// The pieces of the pixels set, joined by their sides or else by sides and corners.
    pub fn of(picture: &Bitmap, corners: bool) -> Pieces {
        let mut runs = runs(picture, usize::from(corners));
        let mut sizes = Vec::new();
        for k in 0..runs.len() {
            if runs[k].earlier == k {
                runs[k].piece = sizes.len();
                sizes.push(0);
            } else {
                runs[k].piece = runs[runs[k].earlier].piece;
            }
            sizes[runs[k].piece] += runs[k].to - runs[k].from;
        }
        Pieces { runs, sizes }
    }

    /// Those of the pieces that are kept, in a picture of the same size as this one.
    pub fn kept(&self, picture: &Bitmap, is_kept: impl Fn(usize) -> bool) -> Bitmap {
        let mut kept = Bitmap::new(picture.width(), picture.height());
        let runs = self.runs.iter().filter(|run| is_kept(run.piece));
        runs.for_each(|run| kept.fill(run.y, run.from, run.to, true));
        kept
    }

    /// The boxes the pieces lie in, in the order of the pieces.
    pub fn boxes(&self) -> Vec<PixelBox> {
        let mut boxes: Vec<Option<PixelBox>> = vec![None; self.sizes.len()];
        for run in &self.runs {
            let own = PixelBox { low: [run.from, run.y], high: [run.to, run.y + 1] };
            boxes[run.piece] = Some(boxes[run.piece].map_or(own, |all| all.with(own)));
        }
        boxes.into_iter().flatten().collect()
    }
}

/// The picture without its pieces of fewer than `least` pixels, joined by sides and corners.
pub fn without_specks(picture: &Bitmap, least: usize) -> Bitmap {
    let pieces = Pieces::of(picture, true);
    pieces.kept(picture, |piece| pieces.sizes[piece] >= least)
}

/// The runs of set pixels, in order. Runs of neighbouring rows are joined where they overlap when one is widened by
/// `reach` pixels.
fn runs(picture: &Bitmap, reach: usize) -> Vec<Run> {
    let mut runs: Vec<Run> = Vec::new();
    let mut present = 0;
    for y in 0..picture.height() {
        // Those of the row before begin at `candidate` and end at `present`.
        let mut candidate = std::mem::replace(&mut present, runs.len());
        for Range { start: from, end: to } in picture.runs(y) {
            let k = runs.len();
            runs.push(Run { y, from, to, piece: 0, earlier: k });
            while candidate < present && runs[candidate].to + reach <= from {
                candidate += 1;
            }
            let mut other = candidate;
            while other < present && runs[other].from < to + reach {
                join(&mut runs, k, other);
                other += 1;
            }
        }
    }
    runs
}

/// Makes two runs of the same piece.
fn join(runs: &mut [Run], a: usize, b: usize) {
    let (a, b) = (first(runs, a), first(runs, b));
    runs[a.max(b)].earlier = a.min(b);
}

/// The first run of the piece.
fn first(runs: &mut [Run], mut run: usize) -> usize {
    while runs[run].earlier != run {
        // Halves the way for those who come after.
        runs[run].earlier = runs[runs[run].earlier].earlier;
        run = runs[run].earlier;
    }
    run
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pieces_meet_by_sides_or_corners() {
        let sizes = |rows: [&str; 5], corners| {
            let mut picture = Bitmap::new(5, 5);
            for (y, row) in rows.iter().enumerate() {
                row.match_indices('#').for_each(|(x, _)| picture.set(x, y));
            }
            let Pieces { runs, sizes } = Pieces::of(&picture, corners);
            for (piece, &size) in sizes.iter().enumerate() {
                let own = runs.iter().filter(|run| run.piece == piece);
                assert_eq!(own.map(|run| run.to - run.from).sum::<usize>(), size);
            }
            let mut again = Bitmap::new(5, 5);
            runs.iter().for_each(|run| again.fill(run.y, run.from, run.to, true));
            assert_eq!(again, picture);
            sizes
        };
        let scattered = ["#.#.#", "...#.", "###..", "#.#.#", "#.#.#"];
        assert_eq!(sizes(scattered, false), [1, 1, 1, 1, 7, 2]);
        assert_eq!(sizes(scattered, true), [1, 10, 2]);
        let spiral = ["#....", "#.###", "#.#.#", "#...#", "#####"];
        assert_eq!(sizes(spiral, false), [15]);
    }
}
