//! What of a document is not drawn, though a browser shows it.

use std::cell::LazyCell;
use std::collections::BTreeSet;
use std::str::FromStr;

use simplecss::{DeclarationTokenizer, Rule, StyleSheet};
use usvg::roxmltree::{Document, Node};

use super::calls::is_of_name;
use super::style::{property, sheets};
use super::{nesting, unscaled};
use crate::sketch::refusal::{Fault, Refusal, Warning, WarningCode};

/// Elements that are not drawn.
const KINDS: [&str; 3] = ["text", IMAGE, "foreignObject"];

const IMAGE: &str = "image";

/// Elements whose parts are seen only where another refers to them.
const STORES: [&str; 2] = ["defs", "symbol"];

/// Whether a value of a property changes what is seen.
type Changes = fn(&str) -> bool;

/// Properties that are read of no style, or not as they are written there, and of which values that changes what is seen.
const UNREAD: [(&str, Changes); 14] = [
    ("transform", is_unread_transform),
    ("translate", is_given),
    ("rotate", is_given),
    ("scale", is_given),
    ("transform-box", |value| !["view-box", "border-box"].contains(&value)),
    ("clip-path", |value| is_given(value) && !value.starts_with("url(")),
    ("d", is_given),
    ("r", is_given),
    ("cx", is_given),
    ("cy", is_given),
    ("rx", is_given),
    ("ry", is_given),
    ("x", is_given),
    ("y", is_given),
];

/// Blocks of a style sheet that are passed over, and words of those that are not for a page as it is first seen.
const BLOCKS: [&str; 4] = ["@media", "@supports", "@container", "@layer"];
const OTHER_PAGES: [&str; 5] = ["dark", "print", "hover", "reduce", "contrast"];

/// Selectors whose rules are passed over, and those of rules that are not for a page as it is first seen.
const SELECTORS: [&str; 7] = [":not(", ":is(", ":where(", ":has(", ":nth-child(", ":nth-of-type(", ":last-child"];
const OTHER_STATES: [&str; 3] = [":hover", ":focus", ":active"];

/// What is not drawn of a document as a browser shows it.
pub(in crate::sketch) struct Ignored {
    /// Kinds of element.
    kinds: Vec<&'static str>,
    /// What is not read of its style.
    unread: BTreeSet<&'static str>,
    /// Whether points are those of what is shown, turned, and not of what is written.
    is_turned: bool,
}

impl Ignored {
    /// What is not drawn of this document; elements without a namespace are drawn as those of an SVG too. `is_turned` where its
    /// root is.
    pub fn of(document: &Document, is_turned: bool) -> Ignored {
        // Most drawings have no such element, and nobody needs to know then what is referred to.
        let used = LazyCell::new(|| used(document));
        let is_shown = |kind: &&str| {
            let mut of_kind = document.descendants().filter(|node| is_svg(*node, kind));
            of_kind.any(|node| is_seen(node, &used))
        };
        Ignored { kinds: KINDS.into_iter().filter(is_shown).collect(), unread: unread(document), is_turned }
    }

    /// Why nothing is seen in a document that has nothing else.
    pub fn nothing_else(&self) -> Refusal {
        let all: Vec<&str> = self.kinds.iter().chain(&self.unread).copied().collect();
        Refusal::plain(match &all[..] {
            [] => "the SVG shows nothing: no shape in it is filled or stroked".to_owned(),
            [IMAGE] => "the SVG shows an embedded image only: send that picture itself, as PNG or JPEG".to_owned(),
            all => format!("the SVG shows nothing but what is not drawn here: {}", all.join(", ")),
        })
    }

    /// That they were not looked at.
    pub fn warning(&self) -> Option<Warning> {
        let unread: Vec<&str> = self.unread.iter().copied().collect();
        let lists = [("not drawn", &self.kinds), ("of its style not read", &unread)];
        let listed = lists.iter().filter(|(_, names)| !names.is_empty());
        let mut told: Vec<String> = listed.map(|(what, names)| format!("{what}: {}", names.join(", "))).collect();
        if self.is_turned {
            told.push("the <svg> itself is turned: points are given as it is shown, not in its user units".to_owned());
        }
        (!told.is_empty()).then(|| Warning::new(WarningCode::IgnoredElements, told.join("; ")))
    }

    /// Why the rest of the document is not taken: with a picture in it that is likely all that a person sees.
    pub fn told_with(&self, mut refusal: Refusal) -> Refusal {
        if self.kinds.contains(&IMAGE) {
            let detail =
                "the SVG has an embedded picture, which is not drawn here: send that picture itself, as PNG or JPEG";
            refusal.faults.insert(0, Fault::plain(detail));
        }
        refusal
    }
}

fn is_svg(node: Node, kind: &str) -> bool {
    let tag = node.tag_name();
    tag.name() == kind && matches!(tag.namespace(), None | Some(nesting::SVG))
}

/// The ids that something refers to.
fn used<'a>(document: &'a Document) -> BTreeSet<&'a str> {
    let values = document.descendants().flat_map(|node| node.attributes().map(|attribute| attribute.value()));
    values.chain(sheets(document)).flat_map(nesting::references).collect()
}

/// Whether an element is shown where it stands, or it or what it is a part of where something refers to it.
fn is_seen(element: Node, used: &BTreeSet<&str>) -> bool {
    for node in element.ancestors() {
        if property(node, "display") == Some("none") {
            return false;
        }
        if node.attribute("id").is_some_and(|id| used.contains(id)) {
            return true;
        }
        if STORES.iter().any(|store| is_svg(node, store)) {
            return false;
        }
    }
    true
}

/// The names of what is not read of the styles of a document.
fn unread(document: &Document) -> BTreeSet<&'static str> {
    let mut found: BTreeSet<&str> = document.descendants().flat_map(unread_of_element).collect();
    for sheet in sheets(document) {
        let selectors = SELECTORS.into_iter().filter(|selector| sheet.contains(selector));
        found.extend(selectors.map(|selector| selector.trim_end_matches('(')));
        found.extend(blocks(sheet));
        found.extend(StyleSheet::parse(sheet).rules.iter().flat_map(unread_of_rule));
    }
    found
}

/// The names of what is not read of an element's own style and transform.
fn unread_of_element<'a>(node: Node<'a, 'a>) -> impl Iterator<Item = &'static str> {
    let transform = node.attribute("transform").and_then(|value| unread_name("transform", value));
    let style = DeclarationTokenizer::from(node.attribute("style").unwrap_or_default());
    transform.into_iter().chain(style.filter_map(|declaration| unread_name(declaration.name, declaration.value)))
}

/// The names of what is not read of a rule. What lines are given by it is not looked up for each of them.
fn unread_of_rule(rule: &Rule) -> Vec<&'static str> {
    let selector = rule.selector.to_string();
    if OTHER_STATES.iter().any(|state| selector.contains(state)) {
        return Vec::new();
    }
    let name = |name: &str, value| match name {
        unscaled::PROPERTY if value == unscaled::EFFECT => Some(unscaled::PROPERTY),
        _ => unread_name(name, value),
    };
    rule.declarations.iter().filter_map(|declaration| name(declaration.name, declaration.value)).collect()
}

/// The name of a property that is not read, where its value is one that changes what is seen.
fn unread_name(name: &str, value: &str) -> Option<&'static str> {
    UNREAD.iter().find(|(unread, changes)| *unread == name && changes(value)).map(|(unread, _)| *unread)
}

fn is_given(value: &str) -> bool {
    value != "none"
}

fn is_unread_transform(value: &str) -> bool {
    is_given(value) && svgtypes::Transform::from_str(value).is_err()
}

/// The names of the blocks in a style sheet that are passed over.
fn blocks(sheet: &str) -> impl Iterator<Item = &'static str> {
    sheet.match_indices('@').filter_map(|(at, mark)| {
        let block = &sheet[at..];
        let name = block[mark.len()..].find(|c| !is_of_name(c)).map(|end| &block[..mark.len() + end])?;
        let condition = &block[name.len()..];
        let condition = &condition[..condition.find(['@', '{', ';'])?];
        let is_other = OTHER_PAGES.iter().any(|word| condition.contains(word));
        BLOCKS.into_iter().find(|passed| *passed == name && !is_other)
    })
}
