//! Lines as wide as they are on the page, however what they belong to is scaled: usvg would scale them with it, and a line of
//! two pixels covers all of a drawing that is eight units wide.

use std::borrow::Cow;
use std::str::FromStr;

use usvg::roxmltree::Node;

use super::parsing;
use super::style::property;
use super::view::View;
use crate::sketch::reading::canvas::LONGEST_SIDE;
use crate::sketch::refusal::Refusal;

/// The property that says so, and its value.
pub(super) const PROPERTY: &str = "vector-effect";
pub(super) const EFFECT: &str = "non-scaling-stroke";

/// The elements that it means something for: others do not hand it down.
const SHAPES: [&str; 7] = ["path", "line", "polyline", "polygon", "rect", "circle", "ellipse"];

/// The text with the widths of such lines in the units that they are drawn in: those that say so by themselves, not by a rule
/// of a style sheet.
///
/// # Errors
/// What [`parsing::parsed`] and [`super::tree`] refuse.
pub(super) fn spelled_out(text: &str) -> Result<Cow<'_, str>, Refusal> {
    if !text.contains(EFFECT) {
        return Ok(Cow::Borrowed(text));
    }
    let document = parsing::parsed(text)?;
    let (root, tree) = (document.root_element(), super::tree(&document)?);
    let is_sized = ["width", "height"].iter().any(|side| root.attribute(*side).is_some_and(|size| !size.contains('%')));
    // A document without a size of its own is as large as its page.
    let size = tree.size();
    let of_page = if is_sized { 1.0 } else { LONGEST_SIDE as f64 / f64::from(size.width().max(size.height())) };
    let of_view = of_page * View::of(&document, size).pixels_per_unit();
    let shapes = document.descendants().filter(|node| SHAPES.contains(&node.tag_name().name()));
    let lines = shapes.filter(|shape| property(*shape, PROPERTY) == Some(EFFECT));
    let mut widths: Vec<(usize, String)> = lines.filter_map(|line| width(line, text, of_view)).collect();
    widths.sort_unstable();
    widths.dedup();
    let (mut done, mut from) = (String::with_capacity(text.len()), 0);
    // What an entity stands for lies before the root, and may stand for parts of several drawings.
    for (at, width) in widths.into_iter().filter(|(at, _)| *at > root.range().start) {
        done.push_str(&text[from..at]);
        done.push_str(&width);
        from = at;
    }
    done.push_str(&text[from..]);
    Ok(Cow::Owned(done))
}

/// The width of a line in its own units, as what is to be added to the text, and where.
fn width(line: Node, text: &str, of_view: f64) -> Option<(usize, String)> {
    let width = line.ancestors().find_map(|node| property(node, "stroke-width")).unwrap_or("1");
    let number = width.trim_end_matches(|c: char| c.is_ascii_alphabetic() || c == '%');
    let unit = &width[number.len()..];
    let number = number.parse::<f64>().ok()? / (of_view * scale(line));
    let width = number.is_finite().then(|| format!("stroke-width:{number}{unit}"))?;
    Some(match line.attribute_node("style") {
        Some(style) => (style.range_value().end, format!(";{width}")),
        None => {
            let name = line.range().start + 1;
            let length = text[name..].find(|c: char| c.is_ascii_whitespace() || matches!(c, '/' | '>'))?;
            (name + length, format!(r#" style="{width}""#))
        }
    })
}

/// How much larger the transforms within the root make a line; turned or leant, as much as its area.
fn scale(line: Node) -> f64 {
    let within = line.ancestors().filter(|node| node.parent_element().is_some());
    let transforms = within.filter_map(|node| svgtypes::Transform::from_str(property(node, "transform")?).ok());
    transforms.map(|t| (t.a * t.d - t.b * t.c).abs().sqrt()).product()
}
