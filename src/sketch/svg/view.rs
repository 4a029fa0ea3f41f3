//! The way from the canvas, which usvg draws on, back to the user units of the `viewBox`.

use std::str::FromStr;

use simplecss::{AttributeOperator, Element, PseudoClass, StyleSheet};
use svgtypes::{LengthUnit, Transform, TransformOrigin, ViewBox};
use usvg::Size;
use usvg::roxmltree::{Document, Node};
use usvg::tiny_skia_path::Point;

use super::style::{declared, sheets};
use crate::sketch::refusal::Refusal;

/// Canvas = scale · user + shift, per axis.
pub(super) struct View {
    scale: [f64; 2],
    shift: [f64; 2],
    /// Whether the root is turned or leant by a transform of its own, which no scale of the axes undoes: user units are those of
    /// what is shown then.
    pub is_turned: bool,
}

impl View {
    /// The view of a document that is drawn on a canvas of this size: the rules of `viewBox` and
    /// `preserveAspectRatio`, and the transform of the root. Without a `viewBox` user units are those of the canvas.
    pub fn of(document: &Document, size: Size) -> Self {
        let canvas = [f64::from(size.width()), f64::from(size.height())];
        let (scale, shift) = of_view_box(document.root_element(), canvas);
        let transform = of_root(document, canvas);
        let is_turned = transform.b.abs().max(transform.c.abs()) > STRAIGHT * transform.a.abs().max(transform.d.abs());
        if is_turned {
            return Self { scale, shift, is_turned };
        }
        let (by, to) = ([transform.a, transform.d], [transform.e, transform.f]);
        let shift = [0, 1].map(|i| by[i] * shift[i] + to[i]);
        Self { scale: [0, 1].map(|i| by[i] * scale[i]), shift, is_turned }
    }

    /// A point of the canvas in user units.
    pub fn user(&self, point: Point) -> [f64; 2] {
        let point = [point.x, point.y].map(f64::from);
        [0, 1].map(|i| (point[i] - self.shift[i]) / self.scale[i])
    }

    /// Pixels of the canvas along one user unit.
    pub fn pixels_per_unit(&self) -> f64 {
        (self.scale[0] * self.scale[1]).abs().sqrt()
    }
}

/// What of a transform may lie across an axis where it lies along the axes, in parts of what lies along them: turned by half, by
/// a number with few digits.
const STRAIGHT: f64 = 1e-6;

/// Scale and shift of the `viewBox` on its canvas.
fn of_view_box(root: Node, canvas: [f64; 2]) -> ([f64; 2], [f64; 2]) {
    let Some([x, y, width, height]) = root.attribute("viewBox").and_then(numbers) else {
        return ([1.0; 2], [0.0; 2]);
    };
    let aspect = root.attribute("preserveAspectRatio").unwrap_or("xMidYMid meet");
    let fit = [canvas[0] / width, canvas[1] / height];
    let scale = if aspect.starts_with("none") {
        fit
    } else if aspect.ends_with("slice") {
        [fit[0].max(fit[1]); 2]
    } else {
        [fit[0].min(fit[1]); 2]
    };
    let placed = ["x", "Y"].map(|axis| {
        let is = |place: &str| aspect.contains(&format!("{axis}{place}"));
        if aspect.starts_with("none") || is("Min") {
            0.0
        } else if is("Max") {
            1.0
        } else {
            0.5
        }
    });
    let (low, extent) = ([x, y], [width, height]);
    let shift = [0, 1].map(|i| placed[i] * (canvas[i] - scale[i] * extent[i]) - scale[i] * low[i]);
    (scale, shift)
}

/// Largest number of a `viewBox`, and one over the least extent: what is drawn has single precision.
const LARGEST: f64 = 1e12;

/// Refuses a `viewBox` that is too large, too far away or too small to draw on.
pub(super) fn check(document: &Document) -> Result<(), Refusal> {
    let view_box = document.root_element().attribute("viewBox").and_then(numbers);
    let is_extreme = |[x, y, width, height]: [f64; 4]| {
        [x, y, width, height].iter().any(|number| number.abs() > LARGEST) || width.min(height) < 1.0 / LARGEST
    };
    if view_box.is_some_and(is_extreme) {
        return Err(Refusal::plain(format!(
            "the numbers of the SVG's viewBox are too extreme: at most {LARGEST:e} are taken"
        )));
    }
    Ok(())
}

/// The four numbers of a `viewBox` that has an extent.
fn numbers(text: &str) -> Option<[f64; 4]> {
    let view_box = ViewBox::from_str(text).ok()?;
    Some([view_box.x, view_box.y, view_box.w, view_box.h])
}

/// The transform that the root has on the canvas, about its middle where nothing else is said.
fn of_root(document: &Document, canvas: [f64; 2]) -> Transform {
    let told = told_of_root(document, "transform").and_then(|told| Transform::from_str(told).ok());
    let Some(told) = told else { return Transform::default() };
    let origin = told_of_root(document, "transform-origin").and_then(|told| TransformOrigin::from_str(told).ok());
    let [x, y] = match origin {
        None => canvas.map(|side| 0.5 * side),
        Some(origin) => {
            let along = |offset: svgtypes::Length, side: f64| match offset.unit {
                LengthUnit::Percent => offset.number / 100.0 * side,
                _ => offset.number,
            };
            [along(origin.x_offset, canvas[0]), along(origin.y_offset, canvas[1])]
        }
    };
    let moved = [x - told.a * x - told.c * y, y - told.b * x - told.d * y];
    Transform { e: told.e + moved[0], f: told.f + moved[1], ..told }
}

/// The value of a property of the root: the last that is declared by its own style, by a style sheet, or as an attribute.
fn told_of_root<'a>(document: &'a Document, name: &str) -> Option<&'a str> {
    let root = document.root_element();
    let by_sheet = || {
        let rules = sheets(document).flat_map(|sheet| StyleSheet::parse(sheet).rules);
        let for_root = rules.filter(|rule| rule.selector.matches(&Root(root)));
        let declared = for_root.flat_map(|rule| rule.declarations).filter(|declared| declared.name == name);
        declared.last().map(|declared| declared.value)
    };
    declared(root, name).or_else(by_sheet).or_else(|| root.attribute(name))
}

/// The root as style sheets ask for it.
struct Root<'a>(Node<'a, 'a>);

impl Element for Root<'_> {
    fn parent_element(&self) -> Option<Self> {
        None
    }

    fn prev_sibling_element(&self) -> Option<Self> {
        None
    }

    fn has_local_name(&self, name: &str) -> bool {
        self.0.tag_name().name() == name
    }

    fn attribute_matches(&self, name: &str, operator: AttributeOperator<'_>) -> bool {
        self.0.attribute(name).is_some_and(|value| operator.matches(value))
    }

    fn pseudo_class_matches(&self, class: PseudoClass<'_>) -> bool {
        class == PseudoClass::FirstChild
    }
}
