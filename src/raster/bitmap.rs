//! Pictures in black and white, a bit a pixel.

use std::ops::Range;

/// Pixels in a word.
const WORD: usize = 64;

/// Rows of pixels that are set or not.
#[derive(Clone, Debug, PartialEq)]
pub struct Bitmap {
    width: usize,
    /// Words of a row; the bits behind its end are never set.
    stride: usize,
    words: Vec<u64>,
}

impl Bitmap {
    /// A picture without a pixel set.
    pub fn new(width: usize, height: usize) -> Bitmap {
        let stride = width.div_ceil(WORD);
        Bitmap { width, stride, words: vec![0; stride * height] }
    }

    /// Pixels in a row.
    pub fn width(&self) -> usize {
        self.width
    }

    pub fn height(&self) -> usize {
        self.words.len() / self.stride.max(1)
    }

    /// How many pixels are set.
    pub fn area(&self) -> usize {
        self.words.iter().map(|word| word.count_ones() as usize).sum()
    }

    /// Whether the pixel, which is in the picture, is set.
    #[inline(always)]
    pub fn get(&self, x: usize, y: usize) -> bool {
        self.words[y * self.stride + x / WORD] >> (x % WORD) & 1 == 1
    }

    pub fn set(&mut self, x: usize, y: usize) {
        self.words[y * self.stride + x / WORD] |= 1 << (x % WORD);
    }

    /// Sets or clears the pixels `from`..`to` of a row.
    #[inline(always)]
    pub fn fill(&mut self, y: usize, from: usize, to: usize, value: bool) {
        for (word, mask) in stretch(y * self.stride, from, to) {
            if value {
                self.words[word] |= mask;
            } else {
                self.words[word] &= !mask;
            }
        }
    }

    /// Whether all the pixels `from`..`to` of a row are set.
    #[inline(always)]
    pub fn full(&self, y: usize, from: usize, to: usize) -> bool {
        stretch(y * self.stride, from, to).all(|(word, mask)| self.words[word] & mask == mask)
    }

    /// The first pixel of a row at `x` or behind that is set, or not; the width where there is none.
    pub fn next(&self, y: usize, x: usize, value: bool) -> usize {
        let row = self.row(y);
        let flip = if value { 0 } else { u64::MAX };
        let mut passed = u64::MAX << (x % WORD);
        for (k, &word) in row.iter().enumerate().skip(x / WORD) {
            let here = (word ^ flip) & passed;
            if here != 0 {
                return (k * WORD + here.trailing_zeros() as usize).min(self.width);
            }
            passed = u64::MAX;
        }
        self.width
    }

    /// The stretches of set pixels of a row.
    pub fn runs(&self, y: usize) -> impl Iterator<Item = Range<usize>> {
        let mut end = 0;
        std::iter::from_fn(move || {
            let start = self.next(y, end, true);
            end = self.next(y, start, false);
            (start < self.width).then_some(start..end)
        })
    }

    /// The picture in a frame of `border` empty pixels, fewer than 64, on every side.
    pub fn framed(&self, border: usize) -> Bitmap {
        let mut framed = Bitmap::new(self.width + 2 * border, self.height() + 2 * border);
        for y in 0..self.height() {
            let row = &mut framed.words[(y + border) * framed.stride..][..framed.stride];
            or_moved_up(row, self.row(y), border);
        }
        framed
    }

    /// The picture without `border` pixels, fewer than 64, on every side.
    pub fn cropped(&self, border: usize) -> Bitmap {
        let mut cropped = Bitmap::new(self.width - 2 * border, self.height() - 2 * border);
        for y in 0..cropped.height() {
            let row = &mut cropped.words[y * cropped.stride..][..cropped.stride];
            or_moved_down(row, self.row(y + border), border);
            trim(row, cropped.width);
        }
        cropped
    }

    /// The picture and every pixel beside, above or below it.
    pub fn widened(&self) -> Bitmap {
        let mut wide = self.clone();
        for y in 0..self.height() {
            let own = &mut wide.words[y * self.stride..][..self.stride];
            or_moved_up(own, self.row(y), 1);
            or_moved_down(own, self.row(y), 1);
            for beside in [y.wrapping_sub(1), y + 1].into_iter().filter(|&y| y < self.height()) {
                own.iter_mut().zip(self.row(beside)).for_each(|(own, beside)| *own |= beside);
            }
            trim(own, self.width);
        }
        wide
    }

    /// The pixels about which the square of 2 · `reach` + 1 pixels, fewer than 64, is set as a whole.
    pub fn narrowed(&self, reach: usize) -> Bitmap {
        let mut narrow = Bitmap::new(self.width, self.height());
        let mut across = self.complement();
        for y in 0..self.height() {
            let (row, own) = (self.complement_row(y), &mut across.words[y * self.stride..][..self.stride]);
            for step in 1..=reach {
                or_moved_up(own, &row, step);
                or_moved_down(own, &row, step);
            }
        }
        for y in reach..self.height().saturating_sub(reach) {
            let own = &mut narrow.words[y * self.stride..][..self.stride];
            for near in y - reach..=y + reach {
                own.iter_mut().zip(across.row(near)).for_each(|(own, near)| *own |= near);
            }
            own.iter_mut().for_each(|word| *word = !*word);
            trim(own, self.width.saturating_sub(reach));
        }
        // What is nearer to the left edge than the reach.
        (0..self.height()).for_each(|y| narrow.fill(y, 0, reach.min(self.width), false));
        narrow
    }

    /// The pixels that are not set.
    pub fn complement(&self) -> Bitmap {
        let words = (0..self.height()).flat_map(|y| self.complement_row(y)).collect();
        Bitmap { words, ..*self }
    }

    /// The pixels that are set in one of two pictures of one size.
    pub fn or(&self, other: &Bitmap) -> Bitmap {
        self.combined(other, |own, other| own | other)
    }

    /// The pixels that are set in both of two pictures of one size.
    pub fn and(&self, other: &Bitmap) -> Bitmap {
        self.combined(other, |own, other| own & other)
    }

    /// The pixels that are set here and not in another picture of the same size.
    pub fn without(&self, other: &Bitmap) -> Bitmap {
        self.combined(other, |own, other| own & !other)
    }

    fn combined(&self, other: &Bitmap, word: impl Fn(u64, u64) -> u64) -> Bitmap {
        let words = self.words.iter().zip(&other.words).map(|(&own, &other)| word(own, other)).collect();
        Bitmap { words, ..*self }
    }

    fn complement_row(&self, y: usize) -> Vec<u64> {
        let mut row: Vec<u64> = self.row(y).iter().map(|word| !word).collect();
        trim(&mut row, self.width);
        row
    }

    fn row(&self, y: usize) -> &[u64] {
        &self.words[y * self.stride..][..self.stride]
    }
}

/// The words, and the bits of each, of the pixels `from`..`to` of the row that begins at word `first`.
#[inline(always)]
fn stretch(first: usize, from: usize, to: usize) -> impl Iterator<Item = (usize, u64)> {
    let words = if from < to { from / WORD..to.div_ceil(WORD) } else { 0..0 };
    words.map(move |k| {
        let (low, high) = (from.saturating_sub(k * WORD), (to - k * WORD).min(WORD));
        (first + k, u64::MAX << low & u64::MAX >> (WORD - high))
    })
}

/// Sets the pixels that are `by` behind those of another row; 0 < `by` < 64.
fn or_moved_up(row: &mut [u64], other: &[u64], by: usize) {
    let mut carried = 0;
    for (k, own) in row.iter_mut().enumerate() {
        let word = other.get(k).copied().unwrap_or(0);
        *own |= word << by | carried;
        carried = word >> (WORD - by);
    }
}

/// Sets the pixels that are `by` before those of another row; 0 < `by` < 64.
fn or_moved_down(row: &mut [u64], other: &[u64], by: usize) {
    for (k, own) in row.iter_mut().enumerate() {
        let [word, next] = [k, k + 1].map(|k| other.get(k).copied().unwrap_or(0));
        *own |= word >> by | next << (WORD - by);
    }
}

/// Clears the bits behind the end of a row.
fn trim(row: &mut [u64], width: usize) {
    for (k, word) in row.iter_mut().enumerate() {
        let left = width.saturating_sub(k * WORD);
        if left < WORD {
            *word &= (1 << left) - 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::*;

    fn picture(width: usize, height: usize, inside: impl FnMut(usize, usize) -> bool) -> Bitmap {
        let (mut bitmap, mut inside) = (Bitmap::new(width, height), inside);
        for (x, y) in (0..width * height).map(|pixel| (pixel % width, pixel / width)) {
            if inside(x, y) {
                bitmap.set(x, y);
            }
        }
        bitmap
    }

    #[test]
    fn rows_are_filled_and_searched_across_words() {
        let mut source = ChaCha8Rng::seed_from_u64(1);
        for width in [1, 63, 64, 65, 130, 256] {
            let mut naive = vec![false; width];
            let mut bitmap = Bitmap::new(width, 2);
            for round in 0..40 {
                let (a, b) = (source.random_range(0..=width), source.random_range(0..=width));
                let (from, to, value) = (a.min(b), a.max(b), round % 3 > 0);
                bitmap.fill(1, from, to, value);
                naive[from..to].fill(value);
                assert!((0..width).all(|x| bitmap.get(x, 1) == naive[x] && !bitmap.get(x, 0)));
                assert_eq!(bitmap.area(), naive.iter().filter(|&&inside| inside).count());
                for x in 0..=width {
                    for value in [false, true] {
                        let next = (x..width).find(|&x| naive[x] == value).unwrap_or(width);
                        assert_eq!(bitmap.next(1, x, value), next);
                    }
                    assert_eq!(bitmap.full(1, a.min(x), a.max(x)), naive[a.min(x)..a.max(x)].iter().all(|&i| i));
                }
            }
        }
    }

    #[test]
    fn neighbourhoods_are_those_of_single_pixels() {
        let mut source = ChaCha8Rng::seed_from_u64(2);
        for (width, height) in [(5, 7), (64, 9), (66, 20), (130, 20)] {
            let bitmap = picture(width, height, |_, _| source.random_bool(0.93));
            let at = |x: isize, y: isize| {
                let within = (0..width as isize).contains(&x) && (0..height as isize).contains(&y);
                within && bitmap.get(x as usize, y as usize)
            };
            let beside = [[0, 0], [1, 0], [-1, 0], [0, 1], [0, -1]];
            let wide = |x: usize, y: usize| beside.iter().any(|[i, j]| at(x as isize + i, y as isize + j));
            assert_eq!(bitmap.widened(), picture(width, height, wide));
            for reach in [1isize, 2, 3] {
                let square = |x: usize, y: usize| {
                    let mut steps = (-reach..=reach).flat_map(|i| (-reach..=reach).map(move |j| [i, j]));
                    steps.all(|[i, j]| at(x as isize + i, y as isize + j))
                };
                assert_eq!(bitmap.narrowed(reach as usize), picture(width, height, square), "{width} {reach}");
            }
            assert_eq!(bitmap.complement(), picture(width, height, |x, y| !bitmap.get(x, y)));
            let framed = bitmap.framed(1);
            assert_eq!((framed.width(), framed.height(), framed.area()), (width + 2, height + 2, bitmap.area()));
            assert!((0..width).all(|x| framed.get(x + 1, 2) == bitmap.get(x, 1)));
            assert_eq!(framed.cropped(1), bitmap);
        }
    }
}
