//! How deep and how large a document becomes when its references are followed: usvg does so by recursion, and reads what
//! it finds each time anew.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;

use usvg::roxmltree::{Attribute, Document, Node};

use crate::sketch::refusal::Refusal;

pub(super) const SVG: &str = "http://www.w3.org/2000/svg";

/// Most elements, references followed.
pub(super) const MAX_ELEMENTS: usize = 500_000;

/// Deepest nesting, references followed; far from what a thread's stack holds.
const MAX_DEPTH: usize = 128;

/// Most numbers and commands of paths, references followed. So many are read, and their strokes measured, in about two
/// seconds; a sketch has at most some ten thousand points, of six numbers each where they are curves.
const MAX_NUMBERS: usize = 2_000_000;

/// Most bytes of style that elements have of their own and from those around them: each reads all of it.
const MAX_INHERITED: usize = 1 << 29;

/// Most bytes of an id: as many names as there are may be compared with it.
const LONGEST_ID: usize = 1000;

/// Attributes without style, which no other element inherits.
const OF_ELEMENT: [&str; 6] = ["d", "points", "href", "id", "class", "viewBox"];

/// The size of a part of a document, references followed.
#[derive(Clone, Copy, Default)]
pub(super) struct Extent {
    pub depth: usize,
    pub elements: usize,
    /// Numbers and commands of paths.
    numbers: usize,
    /// Bytes of style times the elements that inherit them.
    inherited: usize,
}

/// The extent of a document.
///
/// # Errors
/// When the document is too deep or too large, or an element refers to one that it is a part of.
pub(super) fn checked(document: &Document) -> Result<Extent, Refusal> {
    let ids: BTreeMap<&str, Node> =
        document.descendants().filter_map(|node| Some((node.attribute("id")?, node))).collect();
    if ids.keys().any(|id| id.len() > LONGEST_ID) {
        return Err(Refusal::plain(format!(
            "the SVG has too long a name: at most {LONGEST_ID} bytes of an id are taken"
        )));
    }
    let mut extents = BTreeMap::new();
    let root = extent(document.root_element(), &ids, &mut extents)?;
    // A style sheet may add its references to any element, each once on the way down.
    let mut styled = Extent::default();
    for node in document.descendants().filter(|node| node.has_tag_name("style")) {
        for id in node.text().into_iter().flat_map(references) {
            let Some(&target) = ids.get(id) else { continue };
            styled = styled.beside(extent(target, &ids, &mut extents)?);
        }
    }
    let of_all = |added: usize| root.elements.saturating_mul(added);
    let whole = Extent {
        depth: root.depth.saturating_add(styled.depth),
        elements: root.elements.saturating_add(of_all(styled.elements)),
        numbers: root.numbers.saturating_add(of_all(styled.numbers)),
        inherited: root.inherited.saturating_add(of_all(styled.inherited)),
    };
    let too = |what: &str, most: usize, of_what: &str| {
        Err(Refusal::plain(format!("the SVG is {what}, uses followed: at most {most} {of_what} are taken")))
    };
    match whole {
        Extent { depth, .. } if depth > MAX_DEPTH => too("nested too deeply", MAX_DEPTH, "levels"),
        Extent { elements, .. } if elements > MAX_ELEMENTS => too("too large", MAX_ELEMENTS, "elements"),
        Extent { numbers, .. } if numbers > MAX_NUMBERS => {
            too("too large", MAX_NUMBERS, "numbers and commands of paths")
        }
        Extent { inherited, .. } if inherited > MAX_INHERITED => {
            too("too large", MAX_INHERITED, "bytes of style, over all elements that inherit them,")
        }
        whole => Ok(whole),
    }
}

impl Extent {
    /// Both, one nested in the other.
    fn beside(self, other: Extent) -> Extent {
        Extent { depth: self.depth.saturating_add(other.depth), ..self.with(other) }
    }

    /// Both, side by side.
    fn with(self, part: Extent) -> Extent {
        Extent {
            depth: self.depth.max(part.depth),
            elements: self.elements.saturating_add(part.elements),
            numbers: self.numbers.saturating_add(part.numbers),
            inherited: self.inherited.saturating_add(part.inherited),
        }
    }
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
            let mut extent = Extent { elements: 1, ..Extent::default() };
            for part in parts() {
                let Some(part) = known.get(&index(part)).copied().flatten() else {
                    return Err(Refusal::plain("an element of the SVG refers to one that it is a part of"));
                };
                extent = extent.with(part);
            }
            let (numbers, style) =
                node.attributes().map(measured).fold((0, 0), |sum, one| (sum.0 + one.0, sum.1 + one.1));
            let own = Extent { depth: 1, elements: 0, numbers, inherited: extent.elements.saturating_mul(style) };
            known.insert(index(node), Some(extent.beside(own)));
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

/// The numbers and commands of an attribute that draws, the bytes of one that may be style.
fn measured(attribute: Attribute) -> (usize, usize) {
    let value = attribute.value();
    match attribute.name() {
        "d" | "points" => (numbers(value), 0),
        name if OF_ELEMENT.contains(&name) || attribute.namespace().is_some() => (0, 0),
        _ => (0, value.len()),
    }
}

/// Not fewer than the numbers and commands in the data of a path: every letter, every point, and every run of digits.
fn numbers(data: &str) -> usize {
    let bytes = data.as_bytes();
    let begins = |i: usize| match bytes[i] {
        b'.' => true,
        b'0'..=b'9' => i == 0 || !matches!(bytes[i - 1], b'0'..=b'9' | b'.'),
        byte => byte.is_ascii_alphabetic(),
    };
    (0..bytes.len()).filter(|&i| begins(i)).count()
}

/// Names after every `#` that starts the value or stands in `url(…)`, where they may be ids.
pub(super) fn references(value: &str) -> impl Iterator<Item = &str> {
    let starts = value.match_indices('#').filter(|&(at, _)| {
        let before = value[..at].trim_end_matches(['"', '\'', ' ']);
        before.is_empty() || before.ends_with("url(")
    });
    let mut end = 0;
    let names = starts.map(move |(at, _)| {
        // Names within one that nothing closes end where that does, which is looked for once.
        let start = at + 1;
        if end < start {
            end = value[start..].find([')', '"', '\'']).map_or(value.len(), |length| start + length);
        }
        &value[start..end]
    });
    names.filter(|name| name.len() <= LONGEST_ID)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_found_wherever_they_may_be_followed() {
        let found = |value| references(value).collect::<Vec<_>>();
        assert_eq!(found("#a"), ["a"]);
        assert_eq!(found("url( '#a' ) url(#b) red #c"), ["a", "b"]);
        assert_eq!(found("/*url(#*/url(#a)"), ["*/url(#a", "a"]);
        assert_eq!(found("url(#url(#a"), ["url(#a", "a"]);
        assert_eq!(found("url(#"), [""]);
    }

    #[test]
    fn names_within_a_long_name_cost_no_more_than_it() {
        let name = "url(#".repeat(800_000);
        assert_eq!(references(&name).count(), LONGEST_ID / "url(#".len() + 1);
        let of_id = |id: &str| {
            let text = format!(r#"<svg><g id="{id}"/><path fill="{name}"/></svg>"#);
            let document = Document::parse(&text).unwrap();
            checked(&document).map(|extent| extent.elements)
        };
        assert_eq!(of_id("a").unwrap(), 3);
        assert!(of_id(&name).unwrap_err().to_string().contains("bytes of an id"));
    }
}
