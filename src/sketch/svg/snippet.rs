//! What browsers forgive in a document that was cut out of a page, mended in its text: XML forgives nothing.

use std::borrow::Cow;
use std::collections::BTreeSet;

use super::parsing::entities;

/// The prefix that elements refer with, and its namespace.
const LINKS: (&str, &str) = ("xlink", "http://www.w3.org/1999/xlink");

/// Prefixes that need no declaration.
const BUILT_IN: [&str; 2] = ["xml", "xmlns"];

/// Names of entities that need no declaration.
const CHARACTERS: [&str; 5] = ["amp", "lt", "gt", "quot", "apos"];

/// Most prefixes that are declared here. Editors write about ten.
const MAX_PREFIXES: usize = 100;

/// The text of a document without blanks before its declaration, with all its prefixes declared, and with blanks instead of
/// characters by names that only web pages know: text is not drawn.
pub(super) fn mended(text: &str) -> Cow<'_, str> {
    let text = text.trim_start();
    match (with_prefixes(text), text.contains('&')) {
        (text, false) => text,
        (text, true) => Cow::Owned(without_unknown(&text)),
    }
}

/// The text with declarations at its root of the prefixes that it declares nowhere.
fn with_prefixes(text: &str) -> Cow<'_, str> {
    let declared =
        text.split("xmlns:").skip(1).map(|rest| &rest[..rest.find(|c| !is_of_name(c)).unwrap_or(rest.len())]);
    let declared: BTreeSet<&str> = declared.chain(BUILT_IN).collect();
    let used: BTreeSet<&str> = text.split('<').skip(1).flat_map(prefixes).collect();
    let missing: Vec<&str> = used.difference(&declared).copied().take(MAX_PREFIXES).collect();
    let mut roots = text.match_indices("<svg").map(|(at, found)| at + found.len());
    let root = roots.find(|&end| !text[end..].starts_with(|c| is_of_name(c) || c == ':'));
    let Some(root) = root.filter(|_| !missing.is_empty()) else { return Cow::Borrowed(text) };
    let namespace =
        |prefix: &str| if prefix == LINKS.0 { LINKS.1.to_owned() } else { format!("urn:undeclared:{prefix}") };
    let declarations: String =
        missing.into_iter().map(|prefix| format!(r#" xmlns:{prefix}="{}""#, namespace(prefix))).collect();
    Cow::Owned([&text[..root], &declarations, &text[root..]].concat())
}

/// The prefixes of the names in a tag that begins here.
fn prefixes(tag: &str) -> BTreeSet<&str> {
    // A name has one prefix: what follows its first colon begins none, and is not looked through again.
    let (mut quote, mut start, mut found) = (None, Some(0), BTreeSet::new());
    if tag.starts_with(['!', '?']) {
        return found;
    }
    for (at, byte) in tag.bytes().enumerate() {
        match (quote, byte) {
            (Some(open), _) if open == byte => (quote, start) = (None, Some(at + 1)),
            (Some(_), _) => {}
            (None, b'"' | b'\'') => quote = Some(byte),
            (None, b'>') => break,
            (None, b':') => {
                let prefix = start.take().map(|start| &tag[start..at]);
                let is_name = |prefix: &&str| {
                    prefix.starts_with(|c: char| c.is_ascii_alphabetic()) && prefix.chars().all(is_of_name)
                };
                found.extend(prefix.filter(is_name));
            }
            (None, byte) if byte.is_ascii_whitespace() || matches!(byte, b'=' | b'/') => start = Some(at + 1),
            (None, _) => {}
        }
    }
    found
}

/// Whether a prefix may have this character in it.
fn is_of_name(c: char) -> bool {
    c.is_ascii_alphanumeric() || matches!(c, '-' | '_' | '.')
}

/// The text with a blank for every `&` that begins no reference, and for every reference to what is not declared.
fn without_unknown(text: &str) -> String {
    let known: BTreeSet<&str> = entities(text).into_iter().map(|(name, _)| name).chain(CHARACTERS).collect();
    let (mut done, mut rest) = (String::with_capacity(text.len()), text);
    while let Some(at) = rest.find('&') {
        done.push_str(&rest[..at]);
        rest = &rest[at + 1..];
        let end = rest.find(|c: char| !(is_of_name(c) || matches!(c, '#' | ':') || !c.is_ascii()));
        let name = end.filter(|&end| rest[end..].starts_with(';')).map(|end| &rest[..end]);
        match name {
            Some(name) if name.starts_with('#') || known.contains(name) => done.push('&'),
            Some(name) => {
                done.push(' ');
                rest = &rest[name.len() + 1..];
            }
            None => done.push(' '),
        }
    }
    done.push_str(rest);
    done
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_whole_stays() {
        let whole = r#"<svg xmlns="a" xmlns:b="c" b:d="e:f" xml:space="preserve"><b:g h='i j:k'/>l:m</svg>"#;
        assert!(matches!(mended(whole), Cow::Borrowed(text) if text == whole));
        let entities = r#"<!DOCTYPE svg [<!ENTITY a "b">]><svg>&a;&amp;&#160;&#xe9;</svg>"#;
        assert_eq!(mended(entities), entities);
    }

    #[test]
    fn pages_forgive_more_than_documents() {
        assert_eq!(mended("\n\n  <?xml version='1.0'?><svg/>"), "<?xml version='1.0'?><svg/>");
        assert_eq!(mended("<svg><title>a&nbsp;b & c&d</title></svg>"), "<svg><title>a b   c d</title></svg>");
        let linked = mended("<svg><use xlink:href='#a'/><g inkscape:label='b c:d'/></svg>");
        assert!(linked.starts_with(
            r#"<svg xmlns:inkscape="urn:undeclared:inkscape" xmlns:xlink="http://www.w3.org/1999/xlink"><use"#
        ));
    }

    #[test]
    fn a_long_name_of_many_colons_is_looked_through_once() {
        let (name, colons) = ("a".repeat(2 << 20), ":".repeat(2 << 20));
        let tag = format!("{name}{colons} b:c='d'/>");
        assert_eq!(prefixes(&tag), BTreeSet::from([&*name, "b"]));
    }
}
