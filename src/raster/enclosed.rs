//! What a picture encloses.

use super::bitmap::Bitmap;
use super::pieces::Pieces;

/// Most pieces that are told apart.
const MOST_PARTS: usize = 64;

/// The picture with its holes.
pub fn filled(picture: &Bitmap) -> Bitmap {
    outside(picture).complement()
}

/// What is not set and joined with the border by its sides.
pub fn outside(picture: &Bitmap) -> Bitmap {
    let (width, height) = (picture.width(), picture.height());
    let free = picture.complement();
    let pieces = Pieces::of(&free, false);
    let mut open = vec![false; pieces.sizes.len()];
    for run in &pieces.runs {
        open[run.piece] |= run.y == 0 || run.y + 1 == height || run.from == 0 || run.to == width;
    }
    pieces.kept(picture, |piece| open[piece])
}

/// The pieces of a picture with at least so many pixels, each a picture, largest first and no more than [`MOST_PARTS`].
pub fn parts(picture: &Bitmap, least: usize) -> Vec<Bitmap> {
    let pieces = Pieces::of(picture, false);
    let mut order: Vec<usize> = (0..pieces.sizes.len()).filter(|&piece| pieces.sizes[piece] >= least).collect();
    order.sort_by_key(|&piece| (std::cmp::Reverse(pieces.sizes[piece]), piece));
    order.truncate(MOST_PARTS);
    let mut parts = vec![Bitmap::new(picture.width(), picture.height()); order.len()];
    let mut place = vec![None; pieces.sizes.len()];
    order.iter().enumerate().for_each(|(k, &piece)| place[piece] = Some(k));
    for run in &pieces.runs {
        if let Some(k) = place[run.piece] {
            parts[k].fill(run.y, run.from, run.to, true);
        }
    }
    parts
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rings_are_filled_and_open_ones_are_not() {
        let mut ring = Bitmap::new(20, 12);
        for y in 2..9 {
            ring.fill(y, 3, 12, true);
        }
        for y in 3..8 {
            ring.fill(y, 4, 11, false);
        }
        assert_eq!(filled(&ring).area(), 7 * 9);
        ring.fill(5, 11, 12, false);
        assert_eq!(filled(&ring), ring);
    }

    #[test]
    fn parts_come_largest_first() {
        let mut picture = Bitmap::new(30, 5);
        picture.fill(1, 1, 4, true);
        picture.fill(1, 10, 20, true);
        picture.fill(3, 25, 26, true);
        let sizes: Vec<usize> = parts(&picture, 2).iter().map(Bitmap::area).collect();
        assert_eq!(sizes, [10, 3]);
    }
}
