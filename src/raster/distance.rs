//! The distance of every pixel from the nearest that is set [FH12].

use super::bitmap::Bitmap;

/// Farther than any two pixels of a picture are from each other, squared.
const FAR: f32 = 1e12;

/// Per pixel, row by row, the squared distance between its centre and that of the nearest pixel set; 1e12 where there is
/// none.
pub fn squared(picture: &Bitmap) -> Vec<f32> {
    let (width, height) = (picture.width(), picture.height());
    let mut distances = vec![FAR; width * height];
    // Down and up the columns first, all at once, row by row.
    let mut above = vec![FAR; width];
    for y in 0..height {
        step(picture, y, &mut above);
        distances[y * width..][..width].copy_from_slice(&above);
    }
    let mut below = vec![FAR; width];
    for y in (0..height).rev() {
        step(picture, y, &mut below);
        let row = &mut distances[y * width..][..width];
        row.iter_mut().zip(&below).for_each(|(own, &below)| *own = own.min(below));
    }
    let mut envelope = Envelope { vertices: vec![0; width], bounds: vec![0.0; width + 1] };
    for row in distances.chunks_exact_mut(width.max(1)) {
        row.iter_mut().for_each(|d| *d = if *d >= FAR.sqrt() { FAR } else { *d * *d });
        envelope.lower(row);
    }
    distances
}

/// The distance along the column to the last row that was passed with a pixel set there.
fn step(picture: &Bitmap, y: usize, distances: &mut [f32]) {
    distances.iter_mut().for_each(|d| *d += 1.0);
    picture.runs(y).for_each(|run| distances[run].fill(0.0));
}

/// The parabolas of a row that are lowest somewhere, and the places where one takes over from the last.
struct Envelope {
    vertices: Vec<usize>,
    bounds: Vec<f32>,
}

impl Envelope {
    /// Puts the least of `row[q] + (p − q)²` over all q in the place of every `row[p]`.
    fn lower(&mut self, row: &mut [f32]) {
        let heights = row.to_vec();
        let mut last = 0;
        self.vertices[0] = 0;
        (self.bounds[0], self.bounds[1]) = (f32::NEG_INFINITY, f32::INFINITY);
        let height = |q: usize| heights[q] + (q * q) as f32;
        for q in 1..heights.len() {
            let meeting = |p: usize| (height(q) - height(p)) / (2.0 * (q - p) as f32);
            let mut at = meeting(self.vertices[last]);
            while at <= self.bounds[last] && last > 0 {
                last -= 1;
                at = meeting(self.vertices[last]);
            }
            if at > self.bounds[last] {
                last += 1;
            }
            self.vertices[last] = q;
            self.bounds[last] = if last == 0 { f32::NEG_INFINITY } else { at };
            self.bounds[last + 1] = f32::INFINITY;
        }
        let mut k = 0;
        for (p, value) in row.iter_mut().enumerate() {
            while self.bounds[k + 1] < p as f32 {
                k += 1;
            }
            let q = self.vertices[k];
            *value = heights[q] + (p.abs_diff(q) * p.abs_diff(q)) as f32;
        }
    }
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::*;

    #[test]
    fn distances_are_those_to_the_nearest_of_all() {
        let mut source = ChaCha8Rng::seed_from_u64(3);
        for (width, height, density) in [(1, 1, 1.0), (37, 21, 0.01), (64, 9, 0.2), (50, 50, 0.001)] {
            let mut picture = Bitmap::new(width, height);
            picture.set(width / 2, height / 3);
            for pixel in 0..width * height {
                if source.random_bool(density) {
                    picture.set(pixel % width, pixel / width);
                }
            }
            let distances = squared(&picture);
            for (pixel, &distance) in distances.iter().enumerate() {
                let from =
                    |x: usize, y: usize| (x.abs_diff(pixel % width).pow(2) + y.abs_diff(pixel / width).pow(2)) as f32;
                let all = (0..height).flat_map(|y| picture.runs(y).flatten().map(move |x| (x, y)));
                let nearest = all.map(|(x, y)| from(x, y)).fold(f32::INFINITY, f32::min);
                assert_eq!(distance, nearest);
            }
        }
        assert!(squared(&Bitmap::new(4, 4)).iter().all(|&distance| distance >= 1e11));
    }
}
