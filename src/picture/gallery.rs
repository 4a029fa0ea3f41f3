//! Portraits beside each other.

use super::figure::{Figure, Window};

/// A portrait: its height and its figure, as wide as all others.
pub type Portrait = (u32, Figure);

/// The portraits in rows of `columns`, each `width` pixels wide and at the bottom of its row: width and height of the whole, and
/// the figures in it.
pub fn arranged(portraits: Vec<Portrait>, columns: usize, width: u32) -> (u32, u32, Vec<Figure>) {
    let columns = columns.clamp(1, portraits.len().max(1));
    let heights: Vec<u32> =
        portraits.chunks(columns).map(|row| row.iter().map(|(height, _)| *height).max().unwrap_or(1)).collect();
    let bottoms: Vec<u32> =
        heights.iter().scan(0, |sum, height| Some(std::mem::replace(sum, *sum + height) + height)).collect();
    let placed = portraits.into_iter().enumerate().map(|(i, (height, figure))| {
        let (left, top) = ((i % columns) as u32 * width, bottoms[i / columns] - height);
        Figure { window: Window { left, top, ..figure.window }, ..figure }
    });
    let figures = placed.collect();
    (columns as u32 * width, heights.iter().sum::<u32>().max(1), figures)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_stand_on_their_bottoms() {
        let portrait = |height: u32| {
            let window = Window { left: 0, top: 0, width: 10, height };
            let (points, triangles, colours, lines) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
            (height, Figure { window, points, triangles, colours, lines })
        };
        let (width, height, figures) = arranged([5, 8, 3].map(portrait).into(), 2, 10);
        let corners: Vec<[u32; 2]> = figures.iter().map(|figure| [figure.window.left, figure.window.top]).collect();
        assert_eq!((width, height, corners), (20, 11, vec![[0, 3], [10, 0], [0, 8]]));
    }
}
