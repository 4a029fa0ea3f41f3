//! SVG documents as they are shown.

mod calls;
mod colours;
mod encoding;
mod hairlines;
mod ignored;
mod nesting;
mod painting;
mod parsing;
mod snippet;
mod style;
mod transforms;
mod unscaled;
mod variables;
mod view;

use std::panic::{AssertUnwindSafe, catch_unwind};

use usvg::roxmltree::Document;

use super::Config;
use super::foreign;
use super::reading::canvas::Canvas;
use super::refusal::Refusal;
use ignored::Ignored;
use view::View;

/// The document on a canvas, in user units of the `viewBox`, y down, and what is not drawn of it.
///
/// Fills, strokes, gradients, patterns, opacity, clipping, masks and filters are drawn as a browser does. Text and images
/// are not, and nothing outside of the document is ever read. It may be compressed with gzip, and lack what browsers do
/// without.
///
/// # Errors
/// Not an SVG document; one too large, nested too deeply or painted over too often; one with nothing in it but what is not
/// drawn.
pub(super) fn canvas(bytes: &[u8], config: &Config) -> Result<(Canvas, Ignored), Refusal> {
    let bytes = encoding::unpacked(bytes, config.max_document_bytes)?;
    if let Some(foreign) = foreign::name(&bytes).filter(|&foreign| foreign != foreign::SVG) {
        return Err(Refusal::plain(foreign.to_string()));
    }
    let text = encoding::text(&bytes)?;
    let text = snippet::mended(&text);
    let text = variables::resolved(&text)?;
    let text = colours::plain(&text);
    let text = transforms::plain(&text);
    let text = unscaled::spelled_out(&text)?;
    let document = parsing::parsed(&text)?;
    let tree = tree(&document)?;
    let view = View::of(&document, tree.size());
    let ignored = Ignored::of(&document, view.is_turned);
    if !tree.root().has_children() {
        return Err(ignored.nothing_else());
    }
    let canvas = painting::canvas(&tree, &view)?;
    Ok((canvas, ignored))
}

/// The document as it is drawn.
fn tree(document: &Document) -> Result<usvg::Tree, Refusal> {
    // Numbers near the ends of their range, wherever they stand, make usvg panic.
    let drawn = catch_unwind(AssertUnwindSafe(|| usvg::Tree::from_xmltree(document, &options())));
    let drawn =
        drawn.map_err(|_| Refusal::plain("the SVG cannot be drawn: it has numbers that are too large or too small"))?;
    drawn.map_err(|error| Refusal::plain(format!("the SVG cannot be read: {error}")))
}

/// Lines of dashes are lines: who draws so does not mean as many spots.
const SOLID: &str = "* { stroke-dasharray: none !important }";

/// Options that let nothing in but the document.
fn options() -> usvg::Options<'static> {
    usvg::Options {
        image_href_resolver: usvg::ImageHrefResolver {
            resolve_data: Box::new(|_, _, _| None),
            resolve_string: Box::new(|_, _| None),
        },
        style_sheet: Some(SOLID.to_owned()),
        ..usvg::Options::default()
    }
}

#[cfg(test)]
mod tests;
