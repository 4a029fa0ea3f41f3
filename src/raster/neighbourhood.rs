//! What lies within a distance of the pixels set, and what keeps a distance from all others.

use super::bitmap::Bitmap;

/// The pixels within `reach` pixels of one that is set.
pub fn dilated(picture: &Bitmap, reach: f64) -> Bitmap {
    let (width, height) = (picture.width(), picture.height());
    let mut wide = picture.clone();
    let rows = reach.max(0.0) as usize;
    let half_widths: Vec<usize> =
        (0..=rows).map(|dy| (reach * reach - (dy * dy) as f64).max(0.0).sqrt() as usize).collect();
    for y in 0..height {
        for run in picture.runs(y) {
            for near in y.saturating_sub(rows)..(y + rows + 1).min(height) {
                let half = half_widths[near.abs_diff(y)];
                wide.fill(near, run.start.saturating_sub(half), (run.end + half).min(width), true);
            }
        }
    }
    wide
}

/// The pixels farther than `reach` pixels from all that are not set; what is beyond the border counts as set.
pub fn eroded(picture: &Bitmap, reach: f64) -> Bitmap {
    dilated(&picture.complement(), reach).complement()
}

/// The picture with everything filled that no disc of this radius gets into from outside of it.
pub fn closed(picture: &Bitmap, radius: f64) -> Bitmap {
    eroded(&dilated(picture, radius), radius).or(picture)
}

/// The part of the picture that discs of this radius within it cover.
pub fn opened(picture: &Bitmap, radius: f64) -> Bitmap {
    dilated(&eroded(picture, radius), radius).and(picture)
}

/// How many pixels set have one beside them that is not.
pub fn rim(picture: &Bitmap) -> usize {
    picture.area() - eroded(picture, 1.0).area()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A picture of rows of `#` and others.
    fn picture(rows: &[&str]) -> Bitmap {
        let mut picture = Bitmap::new(rows[0].len(), rows.len());
        for (y, row) in rows.iter().enumerate() {
            row.match_indices('#').for_each(|(x, _)| picture.set(x, y));
        }
        picture
    }

    #[test]
    fn discs_reach_as_far_as_their_radius() {
        let mut dot = Bitmap::new(15, 15);
        dot.set(7, 7);
        for reach in [1.0, 1.5, 2.0, 3.3, 6.0] {
            let wide = dilated(&dot, reach);
            for (x, y) in (0..225).map(|i| (i % 15, i / 15)) {
                let [dx, dy] = [x, y].map(|place: usize| place.abs_diff(7) as f64);
                assert_eq!(wide.get(x, y), dx.hypot(dy) <= reach, "({x}, {y}) within {reach}");
            }
            assert_eq!(eroded(&wide, reach), dot);
        }
    }

    #[test]
    fn opening_takes_what_is_thin() {
        let square = picture(&["........", ".####...", ".####...", ".#######", ".####...", "........"]);
        let open = opened(&square, 1.0);
        assert!(open.get(2, 2) && open.get(4, 3) && !open.get(7, 3) && !open.get(6, 3));
        assert_eq!(open.without(&square).area(), 0);
    }

    #[test]
    fn the_rim_is_one_pixel_wide() {
        let mut square = Bitmap::new(10, 10);
        (2..8).for_each(|y| square.fill(y, 2, 8, true));
        assert_eq!(rim(&square), 20);
    }
}
