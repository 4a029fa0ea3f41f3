//! A document as it is painted.

use std::panic::{AssertUnwindSafe, catch_unwind};

use resvg::tiny_skia::{Pixmap, Transform};
use usvg::tiny_skia_path::{Point, Rect};
use usvg::{Group, Node, Paint, Tree};

use super::view::View;
use crate::sketch::reading::canvas::{Canvas, LONGEST_SIDE};
use crate::sketch::refusal::Refusal;

/// Most pixels that are painted, each as often as something covers it: about as many as a second paints.
const MOST_PAINTED: f64 = 1e9;

/// What a pixel of a layer of its own, and of a step of a filter, costs, in painted ones.
const OF_LAYER: f64 = 4.0;
const OF_FILTER: f64 = 100.0;

/// Room round what is drawn, in parts of its size.
const ROOM: f64 = 0.04;

/// What a browser shows of a document, on a canvas that shows what is drawn as large as it may be.
///
/// # Errors
/// A document that paints the same places too often.
pub(super) fn canvas(tree: &Tree, view: &View) -> Result<Canvas, Refusal> {
    let [low, high] = window(tree);
    let extent = [0, 1].map(|i| high[i] - low[i]);
    let scale = (LONGEST_SIDE - 1) as f32 / extent[0].max(extent[1]);
    // Whole pixels to every side: what covers the document covers the canvas, its last row and column too.
    let [width, height] = extent.map(|side| ((side * scale).round() as u32).max(1));
    let scales = [width as f32 / extent[0], height as f32 / extent[1]];
    let visible = Rect::from_ltrb(low[0], low[1], high[0], high[1]);
    let painted = visible.map_or(0.0, |visible| painted(tree.root(), visible)) * f64::from(scale) * f64::from(scale);
    if painted > MOST_PAINTED {
        return Err(Refusal::plain("the SVG paints the same places too many times over: it has too many large shapes"));
    }
    let undrawable = || Refusal::plain("the SVG cannot be drawn: it has numbers that are too large or too small");
    let mut pixmap = Pixmap::new(width, height).ok_or_else(undrawable)?;
    let placed = Transform::from_row(scales[0], 0.0, 0.0, scales[1], -low[0] * scales[0], -low[1] * scales[1]);
    // Numbers near the ends of their range make the painter panic.
    catch_unwind(AssertUnwindSafe(|| resvg::render(tree, placed, &mut pixmap.as_mut()))).map_err(|_| undrawable())?;
    let plain = pixmap.pixels().iter().map(|pixel| pixel.demultiply());
    let origin = view.user(Point::from_xy(low[0], low[1]));
    let beside = view.user(Point::from_xy(low[0] + extent[0], low[1] + extent[1]));
    let pixel = [0, 1].map(|i| (beside[i] - origin[i]) / f64::from(extent[i] * scales[i]));
    Ok(Canvas {
        width: width as usize,
        height: height as usize,
        pixels: plain.map(|p| [p.red(), p.green(), p.blue(), p.alpha()]).collect(),
        origin,
        pixel,
    })
}

/// Lowest and highest corner of what is drawn, with some room round it, within the document's canvas.
fn window(tree: &Tree) -> [[f32; 2]; 2] {
    let canvas = [tree.size().width(), tree.size().height()];
    let drawn = tree.root().abs_layer_bounding_box();
    let (low, high) = ([drawn.left(), drawn.top()], [drawn.right(), drawn.bottom()]);
    let room = ROOM as f32 * (high[0] - low[0]).max(high[1] - low[1]);
    let low = [0, 1].map(|i| (low[i] - room).clamp(0.0, canvas[i]));
    let high = [0, 1].map(|i| (high[i] + room).clamp(0.0, canvas[i]));
    // What lies beside the canvas altogether is not seen: nor is anything then.
    if (0..2).all(|i| low[i] < high[i]) { [low, high] } else { [[0.0; 2], canvas] }
}

/// How much is painted within a window, in units of area.
fn painted(root: &Group, window: Rect) -> f64 {
    let seen = |bounds: Rect| {
        let [width, height] = [
            bounds.right().min(window.right()) - bounds.left().max(window.left()),
            bounds.bottom().min(window.bottom()) - bounds.top().max(window.top()),
        ];
        f64::from(width.max(0.0)) * f64::from(height.max(0.0))
    };
    let mut sum = 0.0;
    let mut groups = vec![root];
    while let Some(group) = groups.pop() {
        let own = seen(group.abs_layer_bounding_box().to_rect());
        let filters: usize = group.filters().iter().map(|filter| filter.primitives().len()).sum();
        if group.should_isolate() {
            sum += own * (OF_LAYER + OF_FILTER * filters as f64);
        }
        groups.extend(group.clip_path().map(|clip| clip.root()));
        groups.extend(group.mask().map(|mask| mask.root()));
        for node in group.children() {
            match node {
                Node::Group(group) => groups.push(group),
                Node::Path(path) => {
                    let paints = [path.fill().map(|fill| fill.paint()), path.stroke().map(|stroke| stroke.paint())];
                    sum += seen(path.abs_stroke_bounding_box());
                    groups.extend(paints.into_iter().flatten().filter_map(|paint| match paint {
                        Paint::Pattern(pattern) => Some(pattern.root()),
                        _ => None,
                    }));
                }
                _ => {}
            }
        }
    }
    sum
}
