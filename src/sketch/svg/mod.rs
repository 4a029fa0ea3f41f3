//! The largest figure of an SVG document.

mod bounds;
mod crossings;
mod nesting;
mod shape;
mod style;
mod view;

use std::panic::{AssertUnwindSafe, catch_unwind};

use i_overlay::core::fill_rule::FillRule;
use i_overlay::float::simplify::SimplifyShape;
use i_overlay::mesh::float::outline::offset::OutlineOffset;
use i_overlay::mesh::float::style::OutlineStyle;
use usvg::roxmltree::Document;

use super::outline::Drawing;
use super::refusal::{Refusal, Warning, WarningCode};
use super::ring::signed_area;
use super::{Config, TINY_HOLE};
use shape::{Shape, Subpath};
use view::View;

/// Elements that are not looked at, though they may show something.
const IGNORED: [&str; 6] = ["text", "image", "foreignObject", "clipPath", "mask", "filter"];

/// Figures of less than this part of the largest one are specks: left out without a word.
const SPECK: f64 = 1e-3;

/// Ends of a stroke nearer than this part of its size nearly meet.
const NEARLY_CLOSED: f64 = 0.05;

/// Share of the canvas that a rectangle has to cover to be paper.
const PAPER: f64 = 0.98;

/// Half the width, in parts of the figure's size, of the bridge where parts touch in a point.
const BRIDGE: f64 = 5e-4;

/// An outline and the holes in it.
type Rings = Vec<Vec<[f64; 2]>>;

/// The outline and holes of the document's largest figure in user units of the `viewBox`, y down, and what was left
/// out.
///
/// The figure is the union of all filled shapes, whatever their colour; a rectangle that covers the whole canvas is
/// paper where there is anything beside it. Where nothing is filled, it is the union of what closed strokes enclose.
/// Curves are followed within [`shape::FLATNESS`]. Text, images, clipping, masks and filters are not looked at, and
/// nothing outside of the document is ever read.
///
/// # Errors
/// Not an SVG document; one too large or nested too deeply; no shape in it, or open strokes only: with their gap.
pub(super) fn drawing(bytes: &[u8], config: &Config) -> Result<(Drawing, Vec<Warning>), Refusal> {
    if bytes.len() > config.max_document_bytes {
        let detail = format!("the SVG has {} bytes; at most {} are taken", bytes.len(), config.max_document_bytes);
        return Err(Refusal::plain(detail));
    }
    let text = std::str::from_utf8(bytes).map_err(|_| Refusal::plain("the SVG is not plain text in UTF-8"))?;
    let document = bounds::parsed(text)?;
    let tree = tree(&document)?;
    let view = View::of(&document, tree.size());
    let shapes = shape::shapes(&tree, &view, 4 * config.max_points)?;
    let mut warnings: Vec<Warning> = ignored(&document).into_iter().collect();
    let contours = figures(&shapes, &view, &mut warnings)?;
    let drawing = largest(contours.simplify_shape_as::<i64>(FillRule::NonZero), &mut warnings)?;
    Ok((drawing, warnings))
}

/// The drawing a little fatter, so that parts which touch in a point are joined there.
pub(super) fn joined(drawing: &Drawing) -> Result<(Drawing, Vec<Warning>), Refusal> {
    let rings: Rings = std::iter::once(&drawing.outline).chain(&drawing.holes).cloned().collect();
    let xs = |axis: usize| drawing.outline.iter().map(move |p| p[axis]);
    let span = |axis: usize| xs(axis).fold(f64::NEG_INFINITY, f64::max) - xs(axis).fold(f64::INFINITY, f64::min);
    let fatter = rings.outline_as::<i64>(&OutlineStyle::new(BRIDGE * span(0).max(span(1))));
    let detail = "parts that touch in single points were joined there";
    let mut warnings = vec![Warning::new(WarningCode::TouchingParts, detail)];
    Ok((largest(fatter, &mut warnings)?, warnings))
}

/// The document as it is drawn.
fn tree(document: &Document) -> Result<usvg::Tree, Refusal> {
    // Numbers near the ends of their range, wherever they stand, make usvg panic.
    let drawn = catch_unwind(AssertUnwindSafe(|| usvg::Tree::from_xmltree(document, &options())));
    let drawn =
        drawn.map_err(|_| Refusal::plain("the SVG cannot be drawn: it has numbers that are too large or too small"))?;
    drawn.map_err(|error| Refusal::plain(format!("the SVG cannot be read: {error}")))
}

/// Options that let nothing in but the document.
fn options() -> usvg::Options<'static> {
    usvg::Options {
        image_href_resolver: usvg::ImageHrefResolver {
            resolve_data: Box::new(|_, _, _| None),
            resolve_string: Box::new(|_, _| None),
        },
        ..usvg::Options::default()
    }
}

fn ignored(document: &Document) -> Option<Warning> {
    let is_present = |name: &&&str| document.descendants().any(|node| node.has_tag_name((nesting::SVG, **name)));
    let present: Vec<&str> = IGNORED.iter().filter(is_present).copied().collect();
    let detail = format!("not looked at: {}", present.join(", "));
    (!present.is_empty()).then(|| Warning::new(WarningCode::IgnoredElements, detail))
}

/// Contours whose non-zero union is the figures.
///
/// # Errors
/// Nothing is shown; all strokes are open; lines cross more often than the union is worth.
fn figures(shapes: &[Shape], view: &View, warnings: &mut Vec<Warning>) -> Result<Rings, Refusal> {
    crossings::check(shapes.iter().flat_map(Shape::filled_lines))?;
    let filled = shapes.iter().filter_map(Shape::filled);
    let (paper, inked): (Vec<_>, Vec<_>) = filled.partition(|areas| covers(areas, view));
    let strokes: Vec<&Subpath> = shapes.iter().filter(|shape| shape.is_stroked).flat_map(|s| &s.subpaths).collect();
    let strokes = if inked.is_empty() { enclosed(&strokes, warnings) } else { Ok(Vec::new()) };
    let contours: Rings = match strokes {
        Ok(strokes) if inked.is_empty() && !strokes.is_empty() => {
            crossings::check(strokes.iter().map(Vec::as_slice))?;
            strokes
        }
        _ if !inked.is_empty() => inked.into_iter().flatten().flatten().collect(),
        _ if !paper.is_empty() => return Ok(paper.into_iter().flatten().flatten().collect()),
        Err(refusal) => return Err(refusal),
        Ok(_) => return Err(Refusal::plain("the SVG shows no shape: nothing is filled and nothing is stroked")),
    };
    if !paper.is_empty() {
        let detail = "a rectangle that covers the whole canvas was taken for paper";
        warnings.push(Warning::new(WarningCode::Background, detail));
    }
    Ok(contours)
}

/// Whether a filled shape is one rectangle, rounded perhaps, over the whole canvas.
fn covers(areas: &[Rings], view: &View) -> bool {
    let [[contour]] = areas.iter().map(Vec::as_slice).collect::<Vec<_>>()[..] else { return false };
    let (low, high) = view.canvas();
    let span = |axis: usize| {
        let xs = || contour.iter().map(|p| p[axis]);
        (xs().fold(f64::INFINITY, f64::min), xs().fold(f64::NEG_INFINITY, f64::max))
    };
    let spans = [0, 1].map(span);
    let is_full = |axis: usize| {
        let (from, to) = spans[axis];
        to.min(high[axis]) - from.max(low[axis]) >= PAPER * (high[axis] - low[axis])
    };
    let box_area: f64 = spans.iter().map(|(from, to)| to - from).product();
    is_full(0) && is_full(1) && signed_area(contour).abs() >= PAPER * box_area
}

/// What the closed strokes enclose, each oriented alike. Open ones are closed where their ends nearly meet.
///
/// # Errors
/// When all strokes are open: the gaps.
fn enclosed(strokes: &[&Subpath], warnings: &mut Vec<Warning>) -> Result<Rings, Refusal> {
    let (mut contours, mut mended, mut open) = (Vec::new(), 0, Vec::new());
    for stroke in strokes {
        match stroke.gap(NEARLY_CLOSED) {
            Some(fault) => open.push(fault),
            None => {
                mended += usize::from(!stroke.is_closed);
                contours.push(oriented(&stroke.points));
            }
        }
    }
    if contours.is_empty() && !open.is_empty() {
        open.truncate(super::refusal::MAX_FAULTS);
        return Err(Refusal { faults: open });
    }
    if mended > 0 {
        let detail = format!("{mended} open strokes whose ends nearly meet were closed");
        warnings.push(Warning::new(WarningCode::ClosedStroke, detail));
    }
    if !open.is_empty() {
        let detail = format!("{} open strokes were left out; the first: {}", open.len(), open[0]);
        warnings.push(Warning::new(WarningCode::OpenStrokes, detail));
    }
    Ok(contours)
}

fn oriented(points: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let mut points = points.to_vec();
    if signed_area(&points) < 0.0 {
        points.reverse();
    }
    points
}

/// The figure of the largest area without its tiny holes.
fn largest(mut figures: Vec<Rings>, warnings: &mut Vec<Warning>) -> Result<Drawing, Refusal> {
    let area = |rings: &Rings| rings.iter().map(|ring| signed_area(ring)).sum::<f64>().abs();
    let Some(index) = (0..figures.len()).max_by(|&a, &b| area(&figures[a]).total_cmp(&area(&figures[b]))) else {
        return Err(Refusal::plain("the shapes of the SVG have no area"));
    };
    let figure = figures.swap_remove(index);
    let size = area(&figure);
    let others = figures.iter().filter(|other| area(other) >= SPECK * size).count();
    if others > 0 {
        let detail = format!("{others} smaller figures beside the largest one were left out");
        warnings.push(Warning::new(WarningCode::SmallerFigures, detail));
    }
    let mut rings = figure.into_iter();
    let outline = rings.next().unwrap_or_default();
    let (holes, tiny): (Rings, Rings) = rings.partition(|hole| signed_area(hole).abs() >= TINY_HOLE * size);
    if !tiny.is_empty() {
        warnings.push(Warning::new(WarningCode::TinyHoles, format!("{} tiny holes were filled", tiny.len())));
    }
    Ok(Drawing { outline, holes })
}
