//! Distances on a grid.

use super::{Cancelled, Pace, Watch};

/// Per cell of a grid of these sizes, x fastest, the square of the distance from the nearest cell that is `marked`, in
/// cells; infinite where none is. Exact, O(n) [FH12].
///
/// # Errors
/// [`Cancelled`] by the watcher.
pub fn squared_distances(marked: &[bool], sizes: [usize; 3], watch: &dyn Watch) -> Result<Vec<f32>, Cancelled> {
    let mut pace = Pace::new(watch, 3 * marked.len());
    let mut squared: Vec<f32> = marked.iter().map(|&marked| if marked { 0.0 } else { f32::INFINITY }).collect();
    let strides = [1, sizes[0], sizes[0] * sizes[1]];
    let longest = sizes.into_iter().max().unwrap_or(0);
    let (mut line, mut hull) = (vec![0.0f32; longest], Vec::with_capacity(longest));
    for axis in 0..3 {
        let [u, v] = [(axis + 1) % 3, (axis + 2) % 3];
        for (i, j) in (0..sizes[u]).flat_map(|i| (0..sizes[v]).map(move |j| (i, j))) {
            pace.steps(sizes[axis])?;
            let start = i * strides[u] + j * strides[v];
            let at = |k: usize| start + k * strides[axis];
            let line = &mut line[..sizes[axis]];
            (0..line.len()).for_each(|k| line[k] = squared[at(k)]);
            lower_envelope(line, &mut hull);
            let mut parabola = 0;
            for k in 0..line.len() {
                while hull.get(parabola + 1).is_some_and(|&(_, begins)| begins <= k as f32) {
                    parabola += 1;
                }
                if let Some(&(apex, _)) = hull.get(parabola) {
                    let along = k as f32 - apex as f32;
                    squared[at(k)] = line[apex] + along * along;
                }
            }
        }
    }
    Ok(squared)
}

/// The parabolas with apex k and height `line[k]` that are lowest somewhere, from left to right, each with where it begins
/// to be.
fn lower_envelope(line: &[f32], hull: &mut Vec<(usize, f32)>) {
    hull.clear();
    for (k, &height) in line.iter().enumerate().filter(|(_, height)| height.is_finite()) {
        let mut begins = f32::NEG_INFINITY;
        while let Some(&(apex, before)) = hull.last() {
            let (a, b) = (apex as f32, k as f32);
            begins = ((height + b * b) - (line[apex] + a * a)) / (2.0 * (b - a));
            if begins > before {
                break;
            }
            hull.pop();
            begins = f32::NEG_INFINITY;
        }
        hull.push((k, begins));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numerics::Unwatched;

    #[test]
    fn distances_are_those_to_the_nearest_marked_cell() {
        let sizes = [7, 5, 6];
        let cells: Vec<[usize; 3]> =
            (0..6).flat_map(|z| (0..5).flat_map(move |y| (0..7).map(move |x| [x, y, z]))).collect();
        let marked: Vec<bool> = (0..cells.len()).map(|i| i * 7919 % 53 == 3).collect();
        assert!(marked.contains(&true));
        let naive = |cell: &[usize; 3]| {
            let marked = cells.iter().zip(&marked).filter(|(_, marked)| **marked);
            marked.map(|(other, _)| (0..3).map(|i| cell[i].abs_diff(other[i]).pow(2)).sum::<usize>()).min().unwrap()
        };
        let expected: Vec<f32> = cells.iter().map(|cell| naive(cell) as f32).collect();
        assert_eq!(squared_distances(&marked, sizes, &Unwatched), Ok(expected));
        let of_none = squared_distances(&[false; 210], sizes, &Unwatched).unwrap();
        assert!(of_none.iter().all(|d| d.is_infinite()));
    }
}
