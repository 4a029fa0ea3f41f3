//! The tree of a document that does not ask too much of those who read it: what is expanded or compared more than once is counted
//! before.
//!
//! The libraries that read XML and style sheets take time and memory for products: references × what they stand for,
//! attributes × attributes of an element, rules × elements. None of them can be asked to stop, so that every product is
//! bounded here, in the text where the parser itself multiplies and in its tree where the next library does.

use std::collections::{BTreeMap, BTreeSet};

use usvg::roxmltree::{Document, Error, ParsingOptions};

use super::{nesting, style, view};
use crate::sketch::refusal::Refusal;

/// Most bytes that references to entities become: as many as a document may have that spells them out.
const MAX_EXPANSION: usize = 16 << 20;

/// Most entities; each reference is looked for among all of them.
const MAX_ENTITIES: usize = 256;

/// References to entities within entities go ten deep in the parser, and no deeper.
const ENTITY_DEPTH: usize = 10;

/// How an entity is declared, and what separates the words of that.
const DECLARATION: &str = "<!ENTITY";
const SPACES: [char; 4] = [' ', '\t', '\r', '\n'];

/// Most attributes of an element; each is compared with all others.
const MAX_ATTRIBUTES: usize = 500;

/// Most prefixes of namespaces, which all elements look for theirs among. Editors write about ten.
const MAX_PREFIXES: usize = 256;

/// Most tags and attributes, as the parser counts them for the memory it takes at once.
const MAX_MARKUP: usize = 4_000_000;

/// The tree of a document that is cheap to read and to draw.
///
/// # Errors
/// Text that is not XML, and what would take long or much to read.
pub(super) fn parsed(text: &str) -> Result<Document<'_>, Refusal> {
    check_markup(text)?;
    check_entities(text)?;
    let parsing = ParsingOptions { allow_dtd: true, nodes_limit: nesting::MAX_ELEMENTS as u32, ..Default::default() };
    let document = Document::parse_with_options(text, parsing).map_err(unreadable)?;
    let root = document.root_element().tag_name().name();
    if root != "svg" {
        return Err(Refusal::plain(format!("this is no SVG: it begins with <{root}>; send its <svg> element alone")));
    }
    view::check(&document)?;
    let extent = nesting::checked(&document)?;
    style::check(&document, &extent)?;
    Ok(document)
}

/// Why text is no XML.
fn unreadable(error: Error) -> Refusal {
    Refusal::plain(match error {
        Error::UnclosedRootNode | Error::UnexpectedEndOfStream => {
            "the file is cut off: the SVG ends before its elements are closed".to_owned()
        }
        error => format!("the SVG cannot be read: {error}"),
    })
}

/// Refuses tags of too many attributes, too many of both, and too many prefixes.
fn check_markup(text: &str) -> Result<(), Refusal> {
    if text.bytes().filter(|byte| matches!(byte, b'<' | b'=')).count() > MAX_MARKUP {
        return Err(Refusal::plain(format!("the SVG has more than {MAX_MARKUP} tags and attributes")));
    }
    // No attribute holds a `<`: a tag begins at one and is over before the next.
    if text.split('<').skip(1).any(|tag| attributes(tag) > MAX_ATTRIBUTES) {
        return Err(Refusal::plain(format!("an element of the SVG has more than {MAX_ATTRIBUTES} attributes")));
    }
    let named = text.split("xmlns:").skip(1).map(|rest| rest.split(['=', ' ', '\t', '\r', '\n']).next());
    if named.collect::<BTreeSet<_>>().len() > MAX_PREFIXES {
        return Err(Refusal::plain(format!("the SVG has more than {MAX_PREFIXES} prefixes of namespaces")));
    }
    Ok(())
}

/// The number of attributes in a tag that begins here.
fn attributes(tag: &str) -> usize {
    let (mut quote, mut found) = (None, 0);
    for byte in tag.bytes() {
        match (quote, byte) {
            (None, b'"' | b'\'') => quote = Some(byte),
            (None, b'=') => found += 1,
            (None, b'>') => break,
            (Some(open), _) if open == byte => quote = None,
            _ => {}
        }
    }
    found
}

/// Refuses references to entities that stand for too much text.
fn check_entities(text: &str) -> Result<(), Refusal> {
    if text.matches(DECLARATION).count() > MAX_ENTITIES {
        return Err(Refusal::plain(format!("the SVG has more than {MAX_ENTITIES} entities")));
    }
    let declared = entities(text);
    let mut sizes: BTreeMap<&str, usize> = BTreeMap::new();
    for _ in 0..ENTITY_DEPTH {
        let mut deeper = BTreeMap::new();
        for &(name, value) in &declared {
            // What is declared more than once counts as all of it.
            let size: &mut usize = deeper.entry(name).or_default();
            *size = size.saturating_add(value.len()).saturating_add(expansion(value, &sizes));
        }
        sizes = deeper;
    }
    if expansion(text, &sizes) > MAX_EXPANSION {
        return Err(Refusal::plain(format!("the entities of the SVG stand for more than {MAX_EXPANSION} bytes")));
    }
    Ok(())
}

/// The names and values of all that reads like a declaration of an entity, wherever it stands.
pub(super) fn entities(text: &str) -> Vec<(&str, &str)> {
    let declarations = text.match_indices(DECLARATION).map(|(at, found)| &text[at + found.len()..]);
    declarations
        .filter_map(|declaration| {
            let named = declaration.strip_prefix(SPACES)?.trim_start_matches(SPACES);
            let named = named.strip_prefix('%').unwrap_or(named).trim_start_matches(SPACES);
            let (name, rest) = named.split_once(SPACES)?;
            let value = rest.trim_start_matches(SPACES);
            let quote = value.chars().next().filter(|quote| ['"', '\''].contains(quote))?;
            Some((name, value[1..].split(quote).next().unwrap_or_default()))
        })
        .collect()
}

/// The bytes that the references in a text stand for.
fn expansion(text: &str, sizes: &BTreeMap<&str, usize>) -> usize {
    if sizes.is_empty() {
        return 0;
    }
    let names = text.split('&').skip(1).filter_map(|rest| Some(rest.split_once(';')?.0));
    names.filter_map(|name| sizes.get(name)).fold(0, |total: usize, size| total.saturating_add(*size))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn entities_as_editors_write_them_are_taken() {
        let text = r##"<?xml version="1.0"?>
<!DOCTYPE svg PUBLIC "-//W3C//DTD SVG 1.1//EN" "http://www.w3.org/Graphics/SVG/1.1/DTD/svg11.dtd" [
    <!ENTITY ns_svg "http://www.w3.org/2000/svg">
    <!ENTITY st0 "fill:#FFFFFF;stroke:none;">
    <!ENTITY both '&st0;stroke-width:2;'>
]>
<svg xmlns="&ns_svg;" viewBox="0 0 9 9"><path style="&both;" d="M0 0h9v9z"/></svg>"##;
        let document = parsed(text).unwrap();
        let path = document.descendants().find(|node| node.has_tag_name((nesting::SVG, "path"))).unwrap();
        assert_eq!(path.attribute("style"), Some("fill:#FFFFFF;stroke:none;stroke-width:2;"));
    }

    #[test]
    fn what_references_become_is_never_counted_short() {
        fn sizes(declared: &str) -> BTreeMap<&str, usize> {
            let mut sizes = BTreeMap::new();
            entities(declared).iter().for_each(|&(name, value)| *sizes.entry(name).or_default() += value.len());
            sizes
        }
        let found = sizes(r#"<!ENTITY a "12"><!ENTITY	b	'3"4'><!ENTITY % c "5"><!ENTITY a ''><!ENTITY d SYSTEM "d">"#);
        assert_eq!(found, BTreeMap::from([("a", 2), ("b", 3), ("c", 1)]));
        assert_eq!(expansion("&a;&b;&&c;&a", &found), 6);
        assert_eq!(sizes(r#"<!ENTITY a "<!ENTITY b '12345'>">"#), BTreeMap::from([("a", 19), ("b", 5)]));
    }

    #[test]
    fn attributes_are_counted_to_the_end_of_their_tag() {
        assert_eq!(attributes(r#"g a="1" b = '>"=' c=""/> d="" "#), 3);
        assert_eq!(attributes("g>a=1"), 0);
        assert_eq!(attributes(r#"g a="b=c"#), 1);
    }
}
