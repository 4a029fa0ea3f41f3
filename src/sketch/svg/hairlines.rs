//! Lines too thin to be seen, as laser cutters and CAD programs want them, painted a pixel wide.

use resvg::tiny_skia::{Color, Paint, Pixmap, Stroke, Transform};
use usvg::tiny_skia_path::Rect;
use usvg::{Node, Path, Tree};

/// Width in pixels below which a line is too faint to be told from its ground.
const FAINT: f32 = 0.3;

/// Width in pixels that such a line is given.
const SEEN: f32 = 1.0;

/// Most comparisons of a line with what is painted later; with more, lines stay as thin as they are.
const MAX_COMPARISONS: usize = 20_000_000;

/// Paints the hairlines of a document over what is painted of it, `placed` as that is.
pub(super) fn paint(tree: &Tree, placed: Transform, pixmap: &mut Pixmap) {
    for line in uncovered(tree, placed) {
        let Some(usvg::Paint::Color(colour)) = line.stroke().map(|stroke| stroke.paint()) else { continue };
        let Some(path) = line.data().clone().transform(line.abs_transform().post_concat(placed)) else { continue };
        let mut paint = Paint::default();
        paint.set_color(Color::from_rgba8(colour.red, colour.green, colour.blue, 255));
        let stroke = Stroke { width: SEEN, ..Stroke::default() };
        pixmap.stroke_path(&path, &paint, &stroke, Transform::identity(), None);
    }
}

/// The hairlines that nothing painted later can cover. Those in groups that are clipped, masked or transparent stay as they
/// are.
fn uncovered(tree: &Tree, placed: Transform) -> Vec<&Path> {
    let (mut lines, mut comparisons): (Vec<&Path>, usize) = (Vec::new(), 0);
    let mut nodes: Vec<&Node> = tree.root().children().iter().rev().collect();
    while let Some(node) = nodes.pop() {
        let cover = match node {
            Node::Group(group) if !group.should_isolate() => {
                nodes.extend(group.children().iter().rev());
                None
            }
            Node::Group(group) => Some(group.abs_layer_bounding_box().to_rect()),
            Node::Path(path) if path.is_visible() && path.fill().is_some() => Some(path.abs_bounding_box()),
            _ => None,
        };
        if let Some(cover) = cover {
            comparisons += lines.len();
            lines.retain(|line| !overlap(line.abs_stroke_bounding_box(), cover));
        }
        if comparisons > MAX_COMPARISONS {
            return Vec::new();
        }
        if let Node::Path(path) = node
            && is_hairline(path, placed)
        {
            lines.push(path);
        }
    }
    lines
}

fn overlap(a: Rect, b: Rect) -> bool {
    a.left() < b.right() && b.left() < a.right() && a.top() < b.bottom() && b.top() < a.bottom()
}

/// Whether the line of a path is painted thinner than [`FAINT`], and as opaque as any: a faint one is meant so.
fn is_hairline(path: &Path, placed: Transform) -> bool {
    let transform = path.abs_transform().post_concat(placed);
    let scale = (transform.sx * transform.sy - transform.kx * transform.ky).abs().sqrt();
    path.is_visible()
        && path.stroke().is_some_and(|stroke| stroke.width().get() * scale < FAINT && stroke.opacity().get() == 1.0)
}
