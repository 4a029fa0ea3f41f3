//! Where a ground has got into a figure over a soft edge: a shadow as grey as the figure's feet, a shaded rim as dark as the
//! ground.

use super::Sheet;
use super::colours::apart;
use crate::raster::bitmap::Bitmap;
use crate::raster::pieces::{Pieces, Run};

/// What differs from the ground at the border of the sheet by more has drifted away from it, in 255ths: as much as ink
/// differs from it at least.
const DRIFT: u8 = 18;

/// How far from the border the ground is taken for the border's, in parts of the sheet's side.
const BORDER: f64 = 0.02;

/// The width of the widest hard edge, in pixels, and how far its colours may lie off those on both sides.
const EDGE: isize = 4;
const OFF_EDGE: f32 = 1.25;

/// How much the colours beside a hard edge change within its width on both sides together, in parts of what they do across it.
const FLAT: f32 = 0.5;

/// A figure has a hard edge along this share at least of its rim where that is a way to the ground; shadows and vignettes
/// fade all round.
const HARD: f64 = 0.15;

/// Fewer pixels that have drifted are no figure, as a share of the sheet.
const LEAST: f64 = 0.001;

/// The pixels of a ground that belong to a figure: pieces that have drifted and end in a hard edge.
pub(super) fn leaks(colours: &[[u8; 3]], ground: &Bitmap, sheet: &Sheet) -> Bitmap {
    let drifted = drifted(colours, ground, sheet);
    let pieces = Pieces::of(&drifted, false);
    let least = LEAST * (ground.width() * ground.height()) as f64;
    let mut rims = vec![Rim::default(); pieces.sizes.len()];
    for run in pieces.runs.iter().filter(|run| pieces.sizes[run.piece] as f64 >= least) {
        rims[run.piece].add(colours, ground, &drifted, run);
    }
    pieces.kept(ground, |piece| rims[piece].is_hard())
}

/// The pixels of a ground whose colour is not found again where their row or their column gets to the border.
fn drifted(colours: &[[u8; 3]], ground: &Bitmap, sheet: &Sheet) -> Bitmap {
    let (width, height) = (ground.width(), ground.height());
    let band = ground.and(&sheet.border(BORDER * width.max(height) as f64));
    let mut columns: Vec<Ends> = vec![None; width];
    let mut rows: Vec<Ends> = vec![None; height];
    for (y, row) in rows.iter_mut().enumerate() {
        for x in band.runs(y).flatten() {
            for ends in [&mut *row, &mut columns[x]] {
                let own = colours[y * width + x];
                *ends = Some([ends.map_or(own, |[first, _]| first), own]);
            }
        }
    }
    let mut drifted = Bitmap::new(width, height);
    for (y, row) in rows.iter().enumerate() {
        for x in ground.runs(y).flatten() {
            let ends = row.iter().chain(&columns[x]).flatten();
            let least = ends.map(|&end| apart(colours[y * width + x], end)).min();
            if least.is_some_and(|least| least > DRIFT) {
                drifted.set(x, y);
            }
        }
    }
    drifted
}

/// The first and the last colour of a row or a column that lie at the border of the sheet.
type Ends = Option<[[u8; 3]; 2]>;

/// How a piece that has drifted ends: at how many pixels it fades into the ground, at how many in a hard edge.
#[derive(Clone, Default)]
struct Rim {
    soft: usize,
    hard: usize,
}

impl Rim {
    fn add(&mut self, colours: &[[u8; 3]], ground: &Bitmap, drifted: &Bitmap, run: &Run) {
        let (width, height) = (ground.width() as isize, ground.height() as isize);
        for x in run.from..run.to {
            for [right, down] in [[-1, 0], [1, 0], [0, -1], [0, 1]] {
                let ahead = |k: isize| {
                    let [x, y] = [x as isize + right * k, run.y as isize + down * k];
                    ((0..width).contains(&x) && (0..height).contains(&y)).then_some([x as usize, y as usize])
                };
                // How far ahead the ground is, where that has not drifted.
                let next =
                    (1..=EDGE + 1).map_while(|k| ahead(k).map(|at| (k, at))).find(|&(_, [x, y])| ground.get(x, y));
                let Some((far, _)) = next.filter(|&(_, [x, y])| !drifted.get(x, y)) else { continue };
                if far == 1 {
                    self.soft += 1;
                } else {
                    let colour = |k: isize| ahead(k).map(|[x, y]| colours[y * ground.width() + x]);
                    self.hard += usize::from(is_edge(colour, far));
                }
            }
        }
    }

    fn is_hard(&self) -> bool {
        self.hard > 0 && self.hard as f64 >= HARD * (self.hard + self.soft) as f64
    }
}

/// Whether the colours along a way rise from its place 0 to the place `end` as those of an edge do: those between are mixtures
/// of both, not a line, and before and behind the way is flat, not a slope.
fn is_edge(colour: impl Fn(isize) -> Option<[u8; 3]>, end: isize) -> bool {
    let [Some(a), Some(b)] = [0, end].map(&colour) else { return false };
    let whole = f32::from(apart(a, b));
    let off = |k: isize, from: [u8; 3]| colour(k).map_or(0.0, |colour| f32::from(apart(colour, from)));
    whole > f32::from(DRIFT)
        && (1..end).all(|k| off(k, a) + off(k, b) <= OFF_EDGE * whole)
        && off(-EDGE, a) + off(end + EDGE, b) <= FLAT * whole
}
