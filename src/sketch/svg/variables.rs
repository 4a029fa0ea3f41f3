//! Custom properties of CSS: `var(--name, fallback)` where a colour or a width is wanted, as design programs write it.

use std::borrow::Cow;
use std::collections::BTreeMap;

use super::calls::{is_of_name, replaced};
use crate::sketch::refusal::Refusal;

/// Most bytes of the text with all values in it: as many as a document may have that spells them out.
const MAX_RESOLVED: usize = 16 << 20;

/// Longest value of a property, in bytes: a colour, a width, a list of dashes.
const LONGEST_VALUE: usize = 500;

/// Most properties that are looked at.
const MAX_PROPERTIES: usize = 4000;

/// Properties that stand for others go so deep.
const DEPTH: usize = 8;

/// What stands for a property without a value: a page would have given the colour of its text.
const OF_PAGE: &str = "currentColor";

type Values<'a> = BTreeMap<&'a str, String>;

/// The text with the values of properties, or else their fallbacks, in place of all references to them.
///
/// # Errors
/// Text that becomes too long.
pub(super) fn resolved(text: &str) -> Result<Cow<'_, str>, Refusal> {
    if !text.contains("var(") {
        return Ok(Cow::Borrowed(text));
    }
    let mut values = declared(text);
    for _ in 0..DEPTH {
        let deeper = |value: &String| substituted(value, &values, LONGEST_VALUE).map(Cow::into_owned);
        values = values.iter().map(|(&name, value)| (name, deeper(value).unwrap_or_default())).collect();
    }
    substituted(text, &values, MAX_RESOLVED)
        .ok_or_else(|| Refusal::plain(format!("the properties of the SVG stand for more than {MAX_RESOLVED} bytes")))
}

/// The text with the values that are known so far.
fn substituted<'a>(text: &'a str, values: &Values, most: usize) -> Option<Cow<'a, str>> {
    replaced(text, "var", most, &|arguments| {
        let (name, fallback) = arguments.split_once(',').map_or((arguments, None), |(name, rest)| (name, Some(rest)));
        let name = name.trim();
        if !name.starts_with("--") {
            return None;
        }
        let of_fallback = || match fallback {
            Some(fallback) => substituted(fallback.trim(), values, LONGEST_VALUE).map(Cow::into_owned),
            None => Some(OF_PAGE.to_owned()),
        };
        values.get(name).cloned().or_else(of_fallback)
    })
}

/// The properties and their values wherever they are declared. The first value counts: what follows is for dark pages, for
/// print, for a pointer above.
fn declared(text: &str) -> Values<'_> {
    let mut values = Values::new();
    for (at, _) in text.match_indices("--") {
        // Only where a name begins it is looked through: a row of dashes is one name, and not one from each dash on.
        if text[..at].ends_with(|c: char| is_of_name(c) || c == '!') {
            continue;
        }
        let property = &text[at..];
        let end = property.find(|c: char| !is_of_name(c));
        let value = end.and_then(|end| property[end..].trim_start().strip_prefix(':')).and_then(value);
        if let (Some(end), Some(value)) = (end, value)
            && values.len() < MAX_PROPERTIES
        {
            values.entry(&property[..end]).or_insert_with(|| value.to_owned());
        }
    }
    values
}

/// The value of a declaration from here on: of none that would be another thing in an attribute than in a style sheet.
fn value(text: &str) -> Option<&str> {
    let mut places = text.char_indices().take(LONGEST_VALUE);
    let (end, last) = places.find(|(_, c)| matches!(c, ';' | '{' | '}' | '<' | '&' | '"' | '\''))?;
    (!matches!(last, '{' | '&')).then(|| text[..end].trim())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_value_of_the_sheet_counts_before_the_fallback() {
        let text = |shape: &str| {
            format!(
                "<svg><!--a: b--><style>:root{{--line:#c60; --w:6px;--own: var( --line , red)}}\
                 @media (prefers-color-scheme: dark){{:root{{--line:#fff}}}}</style>{shape}</svg>"
            )
        };
        for (shape, shown) in [
            (r#"<path stroke="var(--line)"/>"#, r##"<path stroke="#c60"/>"##),
            (r#"<path stroke="var(--own)"/>"#, r##"<path stroke="#c60"/>"##),
            (r#"<path fill="var(--fill-0, #C84)"/>"#, r##"<path fill="#C84"/>"##),
            (r#"<path fill="var(--a,var(--b, rgb(1, 2, 3)))"/>"#, r#"<path fill="rgb(1, 2, 3)"/>"#),
            (r#"<path style="stroke:var(--none);--x:1"/>"#, r#"<path style="stroke:currentColor;--x:1"/>"#),
        ] {
            let found = text(shape);
            assert!(resolved(&found).unwrap().contains(shown), "{shape}");
        }
    }

    #[test]
    fn a_long_row_of_dashes_is_looked_through_once() {
        let dashes = "-".repeat(4 << 20);
        let text = format!("<style>a{{--x:red;fill:var(--x)}}</style><desc>{dashes}</desc>");
        assert!(resolved(&text).unwrap().contains("fill:red"));
    }

    #[test]
    fn properties_that_grow_or_go_round_end() {
        assert!(resolved("a{--a:var(--a);fill:var(--a)}").unwrap().contains("fill:var(--a)"));
        let twice: String = (0..64).map(|k| format!("--a{k}:var(--a{0}) var(--a{0});", k + 1)).collect();
        assert!(resolved(&format!("a{{{twice} fill:var(--a0)}}")).unwrap().len() < 64 * (LONGEST_VALUE + 20));
        let long = format!("a{{--a:{};}}{}", "a".repeat(400), "var(--a)".repeat(50_000));
        assert!(resolved(&long).unwrap_err().to_string().contains("stand for more than"));
    }
}
