//! The middle lines of what is thin.

use super::bitmap::Bitmap;

/// The eight neighbours of a pixel, clockwise from the one above.
const AROUND: [[isize; 2]; 8] = [[0, -1], [1, -1], [1, 0], [1, 1], [0, 1], [-1, 1], [-1, 0], [-1, -1]];

/// The middle lines of a picture, in pixels, each from end to end, from crossing to crossing or once round; those of what has
/// no length are of one point.
pub fn middle_lines(picture: &Bitmap) -> Vec<Vec<[usize; 2]>> {
    traced(thinned(picture))
}

/// The picture worn down from all sides until its lines are one pixel wide [Zhang and Suen 1984].
fn thinned(picture: &Bitmap) -> Bitmap {
    let mut thin = picture.framed(1);
    let mut pixels = set_pixels(&thin);
    loop {
        let before = pixels.len();
        for side in [0, 1] {
            let worn: Vec<[usize; 2]> = pixels.iter().copied().filter(|&at| wears_off(&thin, at, side)).collect();
            let before = thin.clone();
            worn.iter().for_each(|&[x, y]| thin.fill(y, x, x + 1, false));
            // Of what would wear off altogether, four pixels in a square, the first stays.
            for [x, y] in worn {
                let around = || AROUND.iter().filter_map(|&step| neighbour(&before, [x, y], step));
                if around().all(|[u, v]| !thin.get(u, v) && (v, u) > (y, x)) {
                    thin.set(x, y);
                }
            }
            pixels.retain(|&[x, y]| thin.get(x, y));
        }
        if pixels.len() == before {
            return thin.cropped(1);
        }
    }
}

fn set_pixels(picture: &Bitmap) -> Vec<[usize; 2]> {
    (0..picture.height()).flat_map(|y| picture.runs(y).flatten().map(move |x| [x, y])).collect()
}

/// Whether a pixel is taken in the half step for this side: one of a rim, with which no line is parted or shortened.
fn wears_off(picture: &Bitmap, at: [usize; 2], side: usize) -> bool {
    let around = AROUND.map(|step| neighbour(picture, at, step).is_some());
    let set = around.iter().filter(|&&set| set).count();
    let rises = (0..8).filter(|&k| !around[k] && around[(k + 1) % 8]).count();
    let [north, _, east, _, south, _, west, _] = around;
    let is_of_side = if side == 0 { !(east && south && (north || west)) } else { !(north && west && (east || south)) };
    (2..=6).contains(&set) && rises == 1 && is_of_side
}

/// The pixel one step away, where it is set.
fn neighbour(picture: &Bitmap, [x, y]: [usize; 2], [dx, dy]: [isize; 2]) -> Option<[usize; 2]> {
    let (x, y) = (x.checked_add_signed(dx)?, y.checked_add_signed(dy)?);
    (x < picture.width() && y < picture.height() && picture.get(x, y)).then_some([x, y])
}

/// The lines that pixels make, ends and crossings first, then what runs round.
fn traced(mut thin: Bitmap) -> Vec<Vec<[usize; 2]>> {
    let pixels = set_pixels(&thin);
    let degree = |picture: &Bitmap, at| AROUND.iter().filter_map(|&step| neighbour(picture, at, step)).count();
    let (ends, inner): (Vec<_>, Vec<_>) = pixels.into_iter().partition(|&at| degree(&thin, at) != 2);
    let mut lines = Vec::new();
    for start in ends.into_iter().chain(inner) {
        if thin.get(start[0], start[1]) {
            lines.push(line_from(&mut thin, start));
        }
    }
    lines
}

/// The line from a pixel, straight on before round a corner, taken out of the picture.
fn line_from(thin: &mut Bitmap, start: [usize; 2]) -> Vec<[usize; 2]> {
    let mut line = vec![start];
    let mut at = start;
    loop {
        thin.fill(at[1], at[0], at[0] + 1, false);
        let straight = AROUND.iter().step_by(2).chain(AROUND.iter().skip(1).step_by(2));
        let Some(next) = straight.filter_map(|&step| neighbour(thin, at, step)).next() else { return line };
        line.push(next);
        at = next;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn picture(rows: &[&str]) -> Bitmap {
        let mut picture = Bitmap::new(rows[0].len(), rows.len());
        for (y, row) in rows.iter().enumerate() {
            row.bytes().enumerate().filter(|&(_, byte)| byte == b'#').for_each(|(x, _)| picture.set(x, y));
        }
        picture
    }

    #[test]
    fn a_bar_has_one_line_along_its_middle() {
        let lines = middle_lines(&picture(&["..........", ".########.", ".########.", ".########.", ".........."]));
        assert_eq!(lines.len(), 1);
        assert!(lines[0].iter().all(|p| p[1] == 2), "{lines:?}");
        assert!(lines[0].len() >= 5, "{lines:?}");
    }

    #[test]
    fn a_ring_is_gone_round_once() {
        let mut ring = Bitmap::new(60, 60);
        for (y, x) in (0..60).flat_map(|y| (0..60).map(move |x| (y, x))) {
            let radius = (x as f64 - 30.0).hypot(y as f64 - 30.0);
            if (16.0..20.0).contains(&radius) {
                ring.set(x, y);
            }
        }
        let lines = middle_lines(&ring);
        assert_eq!(lines.iter().filter(|line| line.len() > 2).count(), 1, "{lines:?}");
        for &[x, y] in &lines[0] {
            let radius = (x as f64 - 30.0).hypot(y as f64 - 30.0);
            assert!((radius - 18.0).abs() < 1.6, "{radius}");
        }
    }

    #[test]
    fn what_is_one_pixel_wide_stays_as_it_is() {
        let cross = picture(&["....#....", "....#....", "#########", "....#....", "....#...."]);
        let mut pixels: Vec<_> = middle_lines(&cross).concat();
        pixels.sort_unstable();
        let mut set = set_pixels(&cross);
        set.sort_unstable();
        assert_eq!(pixels, set);
        assert!(middle_lines(&cross).len() >= 2);
    }

    #[test]
    fn a_dot_is_a_line_of_few_points_and_nothing_is_none() {
        assert!(middle_lines(&picture(&["...", "...", "..."])).is_empty());
        let dot = middle_lines(&picture(&[".....", ".###.", ".###.", ".###.", "....."]));
        assert_eq!(dot, vec![vec![[2, 2]]]);
    }
}
