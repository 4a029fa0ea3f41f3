//! How deep and how large a document becomes when its references are followed: usvg does so by recursion.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;

use usvg::roxmltree::{Document, Node};

use crate::sketch::refusal::Refusal;

pub(super) const SVG: &str = "http://www.w3.org/2000/svg";

/// Most elements, references followed.
pub(super) const MAX_ELEMENTS: usize = 500_000;

/// Deepest nesting, references followed; far from what a thread's stack holds.
const MAX_DEPTH: usize = 128;

/// The size of a part of a document, references followed.
#[derive(Clone, Copy, Default)]
struct Extent {
    depth: usize,
    elements: usize,
}

/// # Errors
/// When the document is too deep or too large, or an element refers to one that it is a part of.
pub(super) fn check(document: &Document) -> Result<(), Refusal> {
    let ids: BTreeMap<&str, Node> =
        document.descendants().filter_map(|node| Some((node.attribute("id")?, node))).collect();
    let mut extents = BTreeMap::new();
    let root = extent(document.root_element(), &ids, &mut extents)?;
    // A style sheet may add its references to any element, each once on the way down.
    let mut styled = Extent::default();
    for node in document.descendants().filter(|node| node.has_tag_name("style")) {
        for id in node.text().into_iter().flat_map(references) {
            let Some(&target) = ids.get(id) else { continue };
            let target = extent(target, &ids, &mut extents)?;
            styled.depth = styled.depth.saturating_add(target.depth);
            styled.elements = styled.elements.saturating_add(target.elements);
        }
    }
    let elements = root.elements.saturating_mul(styled.elements.saturating_add(1));
    if root.depth.saturating_add(styled.depth) > MAX_DEPTH {
        return Err(Refusal::plain(format!("the SVG is nested too deeply: at most {MAX_DEPTH} levels are taken")));
    }
    if elements > MAX_ELEMENTS {
        return Err(Refusal::plain(format!("the SVG is too large: at most {MAX_ELEMENTS} elements are taken")));
    }
    Ok(())
}

/// The extent of an element, from those of its children and of what it refers to; `known` is filled on the way.
fn extent<'a>(
    element: Node<'a, 'a>,
    ids: &BTreeMap<&str, Node<'a, 'a>>,
    known: &mut BTreeMap<usize, Option<Extent>>,
) -> Result<Extent, Refusal> {
    // Depth first with a stack of our own; an element that is not known yet when it is met again refers to itself.
    let mut stack = vec![(element, false)];
    while let Some((node, is_ready)) = stack.pop() {
        let parts = || {
            let referred = node.attributes().flat_map(|attribute| references(attribute.value()));
            node.children().filter(Node::is_element).chain(referred.filter_map(|id| ids.get(id).copied()))
        };
        if is_ready {
            let mut extent = Extent { depth: 0, elements: 1 };
            for part in parts() {
                let Some(part) = known.get(&index(part)).copied().flatten() else {
                    return Err(Refusal::plain("an element of the SVG refers to one that it is a part of"));
                };
                extent.depth = extent.depth.max(part.depth);
                extent.elements = extent.elements.saturating_add(part.elements);
            }
            known.insert(index(node), Some(Extent { depth: extent.depth + 1, ..extent }));
        } else if let Entry::Vacant(unknown) = known.entry(index(node)) {
            unknown.insert(None);
            stack.push((node, true));
            stack.extend(parts().map(|part| (part, false)));
        }
    }
    Ok(known.get(&index(element)).copied().flatten().unwrap_or_default())
}

fn index(node: Node) -> usize {
    node.id().get_usize()
}

/// Names after every `#` that starts the value or stands in `url(…)`.
fn references(value: &str) -> impl Iterator<Item = &str> {
    let starts = value.match_indices('#').filter(|&(at, _)| {
        let before = value[..at].trim_end_matches(['"', '\'', ' ']);
        before.is_empty() || before.ends_with("url(")
    });
    starts.map(|(at, _)| {
        let name = &value[at + 1..];
        &name[..name.find([')', '"', '\'']).unwrap_or(name.len())]
    })
}
