//! A document as it is painted.

use std::panic::{AssertUnwindSafe, catch_unwind};

use resvg::tiny_skia::{Pixmap, Transform};
use usvg::tiny_skia_path::{Point, Rect};
use usvg::{Group, Node, Paint, Tree};

use super::hairlines;
use super::view::View;
use crate::raster::PixelBox;
use crate::sketch::reading::canvas::{Canvas, LONGEST_SIDE};
use crate::sketch::refusal::Refusal;

/// Most pixels that are painted, each as often as something covers it: about as many as a second paints.
const MOST_PAINTED: f64 = 1e9;

/// What a pixel of a layer of its own, and of a step of a filter, costs, in painted ones.
const OF_LAYER: f64 = 4.0;
const OF_FILTER: f64 = 100.0;

/// Room round what is drawn, in parts of its size.
const ROOM: f64 = 0.04;

/// What goes on over a side of the document's canvas does so by this part of its size: the ends of lines go less far.
const CUT: f64 = 0.02;

/// Pixels along the longer side of the small canvas on which it is seen where anything is painted: shapes that are clipped,
/// masked or transparent are smaller than their boxes, or nowhere.
const LOOK: usize = 160;

/// Where less than this share of a window's longer side is painted, a smaller one is taken.
const FILLED: f32 = 0.9;

/// What a browser shows of a document, on a canvas that shows what is drawn as large as it may be.
///
/// # Errors
/// A document that paints the same places too often.
pub(super) fn canvas(tree: &Tree, view: &View) -> Result<Canvas, Refusal> {
    let of_shapes = Window::of_shapes(tree);
    let window = of_shapes.about(&of_shapes.painted(tree, LOOK)?);
    let pixmap = window.painted(tree, LONGEST_SIDE)?;
    let (width, height) = (pixmap.width() as usize, pixmap.height() as usize);
    let plain = pixmap.pixels().iter().map(|pixel| pixel.demultiply());
    let [origin, end] = [window.low, window.high].map(|[x, y]| view.user(Point::from_xy(x, y)));
    Ok(Canvas {
        width,
        height,
        pixels: plain.map(|p| [p.red(), p.green(), p.blue(), p.alpha()]).collect(),
        own: PixelBox { low: [0; 2], high: [width, height] },
        cut: cut(tree),
        origin,
        pixel: [(end[0] - origin[0]) / width as f64, (end[1] - origin[1]) / height as f64],
    })
}

/// The sides of the document's canvas over which its shapes go on.
fn cut(tree: &Tree) -> [[bool; 2]; 2] {
    let (drawn, size) = (tree.root().abs_layer_bounding_box(), tree.size());
    let beyond = CUT as f32 * size.width().max(size.height());
    [
        [drawn.left() < -beyond, drawn.right() > size.width() + beyond],
        [drawn.top() < -beyond, drawn.bottom() > size.height() + beyond],
    ]
}

/// A part of a document's canvas.
#[derive(Clone, Copy)]
struct Window {
    low: [f32; 2],
    high: [f32; 2],
}

impl Window {
    /// The boxes of all shapes, with some room round them, within the document's canvas.
    fn of_shapes(tree: &Tree) -> Window {
        let canvas = [tree.size().width(), tree.size().height()];
        let drawn = tree.root().abs_layer_bounding_box();
        let shapes = Window { low: [drawn.left(), drawn.top()], high: [drawn.right(), drawn.bottom()] };
        let all = Window { low: [0.0; 2], high: canvas };
        // What lies beside the canvas altogether is not seen: nor is anything then.
        shapes.with_room_within(&all).unwrap_or(all)
    }

    /// A part of this window with some room about all that is painted in it; this one where that fills it.
    fn about(self, painted: &Pixmap) -> Window {
        let width = painted.width() as usize;
        let places = painted.pixels().iter().enumerate().filter(|(_, pixel)| pixel.alpha() > 0);
        let (mut first, mut last) = ([usize::MAX; 2], [0; 2]);
        for place in places.map(|(k, _)| [k % width, k / width]) {
            first = [0, 1].map(|i| place[i].min(first[i]));
            last = [0, 1].map(|i| (place[i] + 1).max(last[i]));
        }
        let [extent, size] = [self.extent(), [painted.width(), painted.height()].map(|side| side as f32)];
        let at = |pixel: [usize; 2]| [0, 1].map(|i| self.low[i] + extent[i] * pixel[i] as f32 / size[i]);
        let seen = Window { low: at(first), high: at(last) };
        let fills = first[0] == usize::MAX || seen.side() >= FILLED * self.side();
        if fills { self } else { seen.with_room_within(&self).unwrap_or(self) }
    }

    /// This window with some room at its sides, as far as another reaches; none where they lie apart.
    fn with_room_within(&self, whole: &Window) -> Option<Window> {
        let room = ROOM as f32 * self.side();
        let low = [0, 1].map(|i| (self.low[i] - room).clamp(whole.low[i], whole.high[i]));
        let high = [0, 1].map(|i| (self.high[i] + room).clamp(whole.low[i], whole.high[i]));
        (0..2).all(|i| low[i] < high[i]).then_some(Window { low, high })
    }

    fn extent(&self) -> [f32; 2] {
        [0, 1].map(|i| self.high[i] - self.low[i])
    }

    fn side(&self) -> f32 {
        let [width, height] = self.extent();
        width.max(height)
    }

    /// What is seen in this window, so many pixels along its longer side.
    fn painted(&self, tree: &Tree, side: usize) -> Result<Pixmap, Refusal> {
        let scale = (side - 1) as f32 / self.side();
        // Whole pixels to every side: what covers the document covers the canvas, its last row and column too.
        let [width, height] = self.extent().map(|side| ((side * scale).round() as u32).max(1));
        let [across, down] = [width as f32 / self.extent()[0], height as f32 / self.extent()[1]];
        let visible = Rect::from_ltrb(self.low[0], self.low[1], self.high[0], self.high[1]);
        let cost = visible.map_or(0.0, |visible| cost(tree.root(), visible)) * f64::from(scale) * f64::from(scale);
        if cost > MOST_PAINTED {
            let detail = "the SVG paints the same places too many times over: it has too many large shapes";
            return Err(Refusal::plain(detail));
        }
        let undrawable = || Refusal::plain("the SVG cannot be drawn: it has numbers that are too large or too small");
        let mut pixmap = Pixmap::new(width, height).ok_or_else(undrawable)?;
        let placed = Transform::from_row(across, 0.0, 0.0, down, -self.low[0] * across, -self.low[1] * down);
        // Numbers near the ends of their range make the painter panic.
        catch_unwind(AssertUnwindSafe(|| {
            resvg::render(tree, placed, &mut pixmap.as_mut());
            hairlines::paint(tree, placed, &mut pixmap);
        }))
        .map_err(|_| undrawable())?;
        Ok(pixmap)
    }
}

/// How much is painted within a window, in units of area.
fn cost(root: &Group, window: Rect) -> f64 {
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
