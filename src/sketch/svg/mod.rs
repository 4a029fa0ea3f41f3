//! SVG documents as they are shown.

mod bounds;
mod encoding;
mod nesting;
mod painting;
mod style;
mod view;

use std::panic::{AssertUnwindSafe, catch_unwind};

use usvg::roxmltree::Document;

use super::Config;
use super::reading::canvas::Canvas;
use super::refusal::{Refusal, Warning, WarningCode};
use view::View;

/// Elements that are not drawn, though a browser shows them.
const IGNORED: [&str; 3] = ["text", "image", "foreignObject"];

/// The document on a canvas, in user units of the `viewBox`, y down, and what is not drawn of it.
///
/// Fills, strokes, gradients, patterns, opacity, clipping, masks and filters are drawn as a browser does. Text and images
/// are not, and nothing outside of the document is ever read.
///
/// # Errors
/// Not an SVG document; one too large, nested too deeply or painted over too often; one with nothing in it but what is not
/// drawn.
pub(super) fn canvas(bytes: &[u8], config: &Config) -> Result<(Canvas, Vec<Warning>), Refusal> {
    if bytes.len() > config.max_document_bytes {
        let detail = format!("the SVG has {} bytes; at most {} are taken", bytes.len(), config.max_document_bytes);
        return Err(Refusal::plain(detail));
    }
    let text = encoding::text(bytes)?;
    let document = bounds::parsed(&text)?;
    let tree = tree(&document)?;
    let ignored = ignored(&document);
    if !tree.root().has_children() {
        return Err(Refusal::plain(match &ignored[..] {
            [] => "the SVG shows nothing: no shape in it is filled or stroked".to_owned(),
            ["image"] => "the SVG shows an embedded image only: send that picture itself, as PNG or JPEG".to_owned(),
            ignored => format!("the SVG shows nothing but what is not drawn here: {}", ignored.join(", ")),
        }));
    }
    let canvas = painting::canvas(&tree, &View::of(&document, tree.size()))?;
    let detail = format!("not drawn: {}", ignored.join(", "));
    let warnings = if ignored.is_empty() { None } else { Some(Warning::new(WarningCode::IgnoredElements, detail)) };
    Ok((canvas, warnings.into_iter().collect()))
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

/// The kinds of element in the document that are not drawn.
fn ignored(document: &Document) -> Vec<&'static str> {
    let is_present = |name: &&str| document.descendants().any(|node| node.has_tag_name((nesting::SVG, *name)));
    IGNORED.into_iter().filter(is_present).collect()
}
