//! Connected pieces of a picture.

/// Cells of a picture by the piece they belong to.
pub(super) struct Pieces {
    /// Per cell its piece, from 1 in the order of first cells; 0 is no piece.
    pub labels: Vec<u32>,
    /// Cells per piece; the first entry is that of no piece.
    pub sizes: Vec<usize>,
}

/// A stretch of chosen cells within a row.
struct Run {
    from: usize,
    to: usize,
    /// A run of the same piece that is not later; itself for the first one.
    earlier: usize,
}

impl Pieces {
    /// The pieces of the cells chosen, in rows of `width` > 0, joined by their sides or else by sides and corners.
    pub fn of(chosen: &[bool], width: usize, corners: bool) -> Pieces {
        let runs = runs(chosen, width, usize::from(corners));
        let mut pieces = Pieces { labels: vec![0; chosen.len()], sizes: vec![0] };
        let mut labels: Vec<u32> = Vec::with_capacity(runs.len());
        for (k, run) in runs.iter().enumerate() {
            if run.earlier == k {
                labels.push(pieces.sizes.len() as u32);
                pieces.sizes.push(0);
            } else {
                labels.push(labels[run.earlier]);
            }
            pieces.labels[run.from..run.to].fill(labels[k]);
            pieces.sizes[labels[k] as usize] += run.to - run.from;
        }
        pieces
    }
}

/// The runs of chosen cells, in order. Runs of neighbouring rows are joined where they overlap when one is widened by
/// `reach` cells.
fn runs(chosen: &[bool], width: usize, reach: usize) -> Vec<Run> {
    let mut runs: Vec<Run> = Vec::new();
    let mut present = 0;
    for (y, row) in chosen.chunks_exact(width).enumerate() {
        // Those of the row before begin at `candidate` and end at `present`.
        let mut candidate = std::mem::replace(&mut present, runs.len());
        let mut end = 0;
        while let Some(skipped) = row[end..].iter().position(|&chosen| chosen) {
            let from = end + skipped;
            end = row[from..].iter().position(|&chosen| !chosen).map_or(width, |length| from + length);
            let (from, to, k) = (y * width + from, y * width + end, runs.len());
            runs.push(Run { from, to, earlier: k });
            while candidate < present && runs[candidate].to + width + reach <= from {
                candidate += 1;
            }
            let mut other = candidate;
            while other < present && runs[other].from + width < to + reach {
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
            let cells: Vec<bool> = rows.concat().chars().map(|c| c == '#').collect();
            let pieces = Pieces::of(&cells, 5, corners);
            for (label, &size) in pieces.sizes.iter().enumerate().skip(1) {
                assert_eq!(pieces.labels.iter().filter(|&&own| own as usize == label).count(), size);
            }
            assert!(cells.iter().zip(&pieces.labels).all(|(&chosen, &label)| chosen == (label > 0)));
            pieces.sizes
        };
        let scattered = ["#.#.#", "...#.", "###..", "#.#.#", "#.#.#"];
        assert_eq!(sizes(scattered, false), [0, 1, 1, 1, 1, 7, 2]);
        assert_eq!(sizes(scattered, true), [0, 1, 10, 2]);
        let spiral = ["#....", "#.###", "#.#.#", "#...#", "#####"];
        assert_eq!(sizes(spiral, false), [0, 15]);
    }
}
