//! The eyes of a figure: one dot or two drawn within it, away from all other lines.

use super::Sketch;
use crate::geometry::distance_to_segment;
use crate::mesh::connectivity::boundary_edges;
use crate::mesh::flat::nearest;

/// Length of the longest line that is a dot, and how far every other line and the outline are from it at least, in parts of the
/// figure's longer side: what is left of a disc in its middle, and no piece of a line that ends there.
const DOT: f64 = 0.01;
const APART: f64 = 0.03;
const WITHIN: f64 = 0.035;

/// A face has so many, so far from each other at most; others are spots.
const MOST: usize = 2;
const TOGETHER: f64 = 0.25;

/// The vertices of the sketch nearest to its eyes; none where none can be told.
pub(super) fn eyes(sketch: &Sketch) -> Vec<u32> {
    let places: Vec<[f64; 2]> = sketch.mesh().positions().iter().map(|&[x, y, _]| [x, y]).collect();
    let extent = |axis: usize| {
        let along = places.iter().map(|p| p[axis]);
        along.clone().fold(f64::NEG_INFINITY, f64::max) - along.fold(f64::INFINITY, f64::min)
    };
    let side = extent(0).max(extent(1));
    let lines = sketch.strokes();
    let rim: Vec<[[f64; 2]; 2]> =
        boundary_edges(sketch.mesh()).into_iter().map(|edge| edge.map(|v| places[v as usize])).collect();
    let is_clear = |line: &[[f64; 2]], other: [[f64; 2]; 2], room: f64| {
        line.iter().all(|&point| distance_to_segment(point, other) >= room * side)
    };
    let is_dot = |&i: &usize| {
        let length: f64 = segments(&lines[i]).map(|[a, b]| (a[0] - b[0]).hypot(a[1] - b[1])).sum();
        let mut others = lines.iter().enumerate().filter(|&(j, _)| j != i).flat_map(|(_, other)| segments(other));
        length <= DOT * side
            && others.all(|other| is_clear(&lines[i], other, APART))
            && rim.iter().all(|&edge| is_clear(&lines[i], edge, WITHIN))
    };
    let dots: Vec<[f64; 2]> = (0..lines.len()).filter(is_dot).filter_map(|i| lines[i].first().copied()).collect();
    let reach = |p: [f64; 2]| dots.iter().map(|q| (p[0] - q[0]).hypot(p[1] - q[1])).fold(0.0, f64::max);
    if dots.len() > MOST || dots.iter().any(|&dot| reach(dot) > TOGETHER * side) {
        return Vec::new();
    }
    dots.into_iter().filter_map(|dot| nearest(sketch.mesh(), dot)).map(|(vertex, _)| vertex as u32).collect()
}

/// The stretches of a line; of a dot the one point it has.
fn segments(line: &[[f64; 2]]) -> impl Iterator<Item = [[f64; 2]; 2]> {
    let next = line.iter().skip(1).chain(line.last());
    line.iter().zip(next).map(|(&a, &b)| [a, b])
}

#[cfg(test)]
mod tests {
    use crate::sketch::{Choice, Config, Sketch, from_svg};

    /// A body with a head on its right, with this drawn on it.
    fn animal(marks: &str) -> Sketch {
        let figure = r##"<path fill="#cde" stroke="black" stroke-width="4" d="M20 90V60H140L150 20H190V50L165 60V130H145V95H45V130H25Z"/>"##;
        let text = format!(r#"<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 200 150">{figure}{marks}</svg>"#);
        from_svg(text.as_bytes(), Choice { vertices: 400, figure: 0 }, &Config::default()).unwrap().sketch
    }

    /// Where the eyes are, in the coordinates of the drawing.
    fn eyes(marks: &str) -> Vec<[f64; 2]> {
        let sketch = animal(marks);
        sketch.eyes().into_iter().map(|v| sketch.point(v as usize)).collect()
    }

    const EYE: &str = r#"<circle cx="170" cy="36" r="3"/>"#;

    #[test]
    fn a_dot_is_an_eye() {
        let found = eyes(EYE);
        let [[x, y]] = found[..] else { panic!("{found:?}") };
        assert!((x - 170.0).hypot(y - 36.0) < 8.0, "{x} {y}");
        assert_eq!(eyes(&format!(r#"{EYE}<path d="M60 70V85" stroke="black" stroke-width="3"/>"#)).len(), 1);
    }

    #[test]
    fn lines_spots_and_dots_far_apart_are_none() {
        let spots = r#"<circle cx="60" cy="75" r="3"/><circle cx="80" cy="80" r="3"/>"#;
        let line = r#"<path d="M160 36H178" stroke="black" stroke-width="3"/>"#;
        let rump = r#"<circle cx="40" cy="75" r="3"/>"#;
        for marks in [String::new(), line.to_owned(), format!("{EYE}{spots}"), format!("{EYE}{rump}")] {
            assert_eq!(eyes(&marks), Vec::<[f64; 2]>::new(), "{marks}");
        }
    }
}
