//! The paths of a document as lines of points.

use i_overlay::core::fill_rule::FillRule;
use i_overlay::float::simplify::SimplifyShape;
use usvg::tiny_skia_path::{PathSegment, Point};
use usvg::{Group, Node, Transform};

use super::Rings;
use super::view::View;
use crate::sketch::refusal::{Fault, Refusal};

/// How far a line may run beside its curve, in parts of the path's size.
pub(super) const FLATNESS: f64 = 2e-4;

/// Most lines that stand for one curve.
const MAX_LINES: f64 = 256.0;

/// A path as it is painted.
pub(super) struct Shape {
    pub subpaths: Vec<Subpath>,
    fill: Option<FillRule>,
    pub is_stroked: bool,
}

/// A line of points, in user units.
#[derive(Default)]
pub(super) struct Subpath {
    pub points: Vec<[f64; 2]>,
    /// Whether the last point is joined to the first.
    pub is_closed: bool,
}

/// All visible paths, in the order of painting.
///
/// # Errors
/// When they have more than `max_points` points together.
pub(super) fn shapes(tree: &usvg::Tree, view: &View, max_points: usize) -> Result<Vec<Shape>, Refusal> {
    let mut shapes = Vec::new();
    let mut left = max_points;
    let mut groups: Vec<&Group> = vec![tree.root()];
    while let Some(group) = groups.pop() {
        for node in group.children() {
            match node {
                Node::Group(group) => groups.push(group),
                Node::Path(path) if path.is_visible() => {
                    let shape = Shape::of(path, view, left).ok_or_else(|| {
                        Refusal::plain(format!("the curves of the SVG need more than {max_points} points"))
                    })?;
                    left -= shape.subpaths.iter().map(|subpath| subpath.points.len()).sum::<usize>();
                    shapes.push(shape);
                }
                _ => {}
            }
        }
    }
    Ok(shapes)
}

impl Shape {
    /// The path in lines; none where they have more than `max_points` points.
    fn of(path: &usvg::Path, view: &View, max_points: usize) -> Option<Self> {
        let bounds = path.abs_bounding_box();
        let tolerance = FLATNESS * view.length(f64::from(bounds.width().max(bounds.height())));
        let mut pen = Pen { transform: path.abs_transform(), view, tolerance, left: max_points, subpaths: Vec::new() };
        path.data().segments().try_for_each(|segment| pen.draw(segment))?;
        let fill = path.fill().filter(|fill| fill.opacity().get() > 0.0).map(|fill| match fill.rule() {
            usvg::FillRule::NonZero => FillRule::NonZero,
            usvg::FillRule::EvenOdd => FillRule::EvenOdd,
        });
        let is_stroked = path.stroke().is_some_and(|stroke| stroke.opacity().get() > 0.0);
        Some(Self { subpaths: pen.subpaths, fill, is_stroked })
    }

    /// The lines that bound what is filled; none where it is not.
    pub fn filled_lines(&self) -> impl Iterator<Item = &[[f64; 2]]> {
        self.subpaths.iter().filter(|_| self.fill.is_some()).map(|subpath| subpath.points.as_slice())
    }

    /// The figures that the fill covers; none where it is not filled or covers nothing.
    pub fn filled(&self) -> Option<Vec<Rings>> {
        let contours: Rings = self.subpaths.iter().map(|subpath| subpath.points.clone()).collect();
        let areas = contours.simplify_shape_as::<i64>(self.fill?);
        (!areas.is_empty()).then_some(areas)
    }
}

impl Subpath {
    /// The gap between the ends, as a fault; none where the line is closed, or its ends are nearer than this part of
    /// its size.
    pub fn gap(&self, nearly_closed: f64) -> Option<Fault> {
        let (&[x, y], &[u, v]) = (self.points.first()?, self.points.last()?);
        let gap = (u - x).hypot(v - y);
        let size = self.points.iter().map(|p| (p[0] - x).hypot(p[1] - y)).fold(0.0, f64::max);
        let is_open = !self.is_closed && gap > nearly_closed * size;
        is_open.then(|| {
            Fault::plain(format!("a stroke is open: it starts here and ends at ({u}, {v}); close it or fill it"))
                .at([x, y])
        })
    }
}

/// Follows the segments of a path until its points are used up.
struct Pen<'a> {
    transform: Transform,
    view: &'a View,
    tolerance: f64,
    /// Points that may still be set.
    left: usize,
    subpaths: Vec<Subpath>,
}

impl Pen<'_> {
    fn draw(&mut self, segment: PathSegment) -> Option<()> {
        match segment {
            PathSegment::MoveTo(p) => self.move_to(self.user(p)),
            PathSegment::LineTo(p) => self.curve_to(&[self.user(p)]),
            PathSegment::QuadTo(p, q) => self.curve_to(&[p, q].map(|p| self.user(p))),
            PathSegment::CubicTo(p, q, r) => self.curve_to(&[p, q, r].map(|p| self.user(p))),
            PathSegment::Close => {
                if let Some(subpath) = self.subpaths.last_mut() {
                    subpath.is_closed = true;
                }
                Some(())
            }
        }
    }

    fn user(&self, mut point: Point) -> [f64; 2] {
        self.transform.map_point(&mut point);
        self.view.user(point)
    }

    fn move_to(&mut self, point: [f64; 2]) -> Option<()> {
        self.left = self.left.checked_sub(1)?;
        self.subpaths.push(Subpath { points: vec![point], is_closed: false });
        Some(())
    }

    /// A line or Bézier curve from the present point, in lines that stay within the tolerance of it.
    fn curve_to(&mut self, controls: &[[f64; 2]]) -> Option<()> {
        // A path starts with a move: there is always a point.
        let subpath = self.subpaths.last_mut()?;
        let &start = subpath.points.last()?;
        let polygon: Vec<[f64; 2]> = std::iter::once(start).chain(controls.iter().copied()).collect();
        // Within a step h a curve leaves its chord by at most h²/8 of its second derivative, and that by at most
        // d (d − 1) of the second differences of its d + 1 control points.
        let degree = controls.len() as f64;
        let bend = polygon.windows(3).map(|w| [0, 1].map(|i| w[0][i] - 2.0 * w[1][i] + w[2][i]));
        let bend = bend.map(|[x, y]| x.hypot(y)).fold(0.0, f64::max) * degree * (degree - 1.0);
        let lines = (bend / (8.0 * self.tolerance)).sqrt().ceil().clamp(1.0, MAX_LINES);
        self.left = self.left.checked_sub(lines as usize)?;
        subpath.points.extend((1..=lines as usize).map(|i| on_curve(&polygon, i as f64 / lines)));
        Some(())
    }
}

/// The point of a Bézier curve at t, by de Casteljau's scheme.
fn on_curve(controls: &[[f64; 2]], t: f64) -> [f64; 2] {
    let mut points = controls.to_vec();
    for last in (1..points.len()).rev() {
        for i in 0..last {
            points[i] = [0, 1].map(|axis| (1.0 - t) * points[i][axis] + t * points[i + 1][axis]);
        }
    }
    points[0]
}
