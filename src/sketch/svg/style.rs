//! What style says, and how much a style sheet asks: usvg compares every rule with every element, and gives those it is for its declarations.

use simplecss::{DeclarationTokenizer, Rule, StyleSheet};
use usvg::roxmltree::{Document, Node};

use super::nesting::Extent;
use crate::sketch::refusal::Refusal;

/// Most rules times bytes: where a rule is wrong, its line is counted from the start of the sheet.
const MAX_PARSING: usize = 1 << 30;

/// Most rules times sheets: with each sheet all rules are sorted again.
const MAX_SORTING: usize = 20_000_000;

/// Most selectors of a rule times its declarations: each has its own copy of all.
const MAX_COPIES: usize = 2_000_000;

/// Most comparisons of a selector with an element, about 50 ns each.
const MAX_COMPARISONS: usize = 20_000_000;

/// Most declarations given to elements, and their bytes.
const MAX_GIVEN: usize = 20_000_000;
const MAX_GIVEN_BYTES: usize = 1 << 30;

/// Refuses style sheets that are much work to apply to a document of this extent.
pub(super) fn check(document: &Document, extent: &Extent) -> Result<(), Refusal> {
    let too_many = |what: &str| {
        let detail = format!("the style sheet of the SVG is too large for its {} elements: {what}", extent.elements);
        Err(Refusal::plain(detail))
    };
    let sheets: Vec<&str> = sheets(document).collect();
    let rules = |sheet: &str| sheet.bytes().filter(|byte| matches!(byte, b'{' | b',')).count();
    let sorting = sheets.iter().map(|sheet| rules(sheet)).sum::<usize>().saturating_mul(sheets.len());
    let is_long = |sheet: &&str| rules(sheet).saturating_mul(sheet.len()) > MAX_PARSING || copies(sheet) > MAX_COPIES;
    if sorting > MAX_SORTING || sheets.iter().any(is_long) {
        return too_many("it has too many rules");
    }
    let (mut comparisons, mut given, mut bytes) = (0usize, 0usize, 0usize);
    for sheet in sheets {
        for rule in StyleSheet::parse(sheet).rules {
            comparisons = comparisons.saturating_add(comparisons_with_an_element(&rule, extent.depth));
            given = given.saturating_add(rule.declarations.len());
            bytes = bytes.saturating_add(rule.declarations.iter().map(|one| one.value.len()).sum());
        }
    }
    let over_all = |of_one: usize| of_one.saturating_mul(extent.elements);
    if over_all(comparisons) > MAX_COMPARISONS {
        return too_many(&format!("more than {MAX_COMPARISONS} comparisons"));
    }
    if over_all(given) > MAX_GIVEN || over_all(bytes) > MAX_GIVEN_BYTES {
        return too_many("its rules are too long");
    }
    Ok(())
}

/// The style sheets of a document.
pub(super) fn sheets<'a>(document: &'a Document) -> impl Iterator<Item = &'a str> {
    document.descendants().filter(|node| node.has_tag_name("style")).filter_map(|node| node.text())
}

/// The value of a property of an element, by its own style or else as its attribute.
pub(super) fn property<'a>(node: Node<'a, 'a>, name: &str) -> Option<&'a str> {
    declared(node, name).or_else(|| node.attribute(name))
}

/// The value of a property by an element's own style.
pub(super) fn declared<'a>(node: Node<'a, 'a>, name: &str) -> Option<&'a str> {
    let declarations = DeclarationTokenizer::from(node.attribute("style")?);
    declarations.filter(|declaration| declaration.name == name).last().map(|declaration| declaration.value)
}

/// The most copies of declarations that the rules of a sheet make.
fn copies(sheet: &str) -> usize {
    let rule = |text: &str| {
        let count = |mark: char| text.matches(mark).count() + 1;
        count(',').saturating_mul(count(';'))
    };
    sheet.split('}').map(rule).fold(0, usize::saturating_add)
}

/// The most elements looked at to tell whether a rule is for one: every ancestor, for every selector left of a space.
fn comparisons_with_an_element(rule: &Rule, depth: usize) -> usize {
    let text = rule.selector.to_string();
    let joined = text.matches([' ', '>', '+']).count();
    let next_of_kin = text.matches(['>', '+']).count();
    let ancestors = u32::try_from(joined.saturating_sub(3 * next_of_kin)).unwrap_or(u32::MAX);
    depth.max(2).saturating_pow(ancestors).saturating_add(next_of_kin)
}
