//! Functions of CSS that the library does not know, replaced in the text of a document by what they stand for.

use std::borrow::Cow;

/// Longest arguments of a call, in bytes, and how deep parentheses go in them. What goes deeper is no call, so that the
/// text is gone over no more often than this.
const LONGEST: usize = 1000;
const DEEPEST: usize = 8;

/// What a call says in older words, by its arguments; nothing where there are none.
pub(super) type Conversion = fn(&str) -> Option<String>;

/// How often as long as it was a text may become in older words: few of them are longer, a matrix is.
const LONGER: usize = 4;

/// The text with all calls of these functions that can be said in older words.
pub(super) fn in_older_words<'a>(text: &'a str, functions: &[(&str, Conversion)]) -> Cow<'a, str> {
    functions.iter().fold(Cow::Borrowed(text), |text, (function, meaning)| {
        if !text.contains(function) {
            return text;
        }
        let said = replaced(&text, function, LONGER * text.len(), meaning).map(Cow::into_owned);
        said.map_or(text, Cow::Owned)
    })
}

/// The text with what stands for each call of a function, by its arguments; a call that has no value stays. None where
/// that has more than `most` bytes.
pub(super) fn replaced<'a>(
    text: &'a str,
    function: &str,
    most: usize,
    value: &dyn Fn(&str) -> Option<String>,
) -> Option<Cow<'a, str>> {
    let (mut done, mut rest) = (String::new(), text);
    while let Some(at) = rest.find(function) {
        let (before, after) = (&rest[..at], &rest[at + function.len()..]);
        let is_whole = !text[..text.len() - rest.len() + at].ends_with(is_of_name);
        let arguments = after.strip_prefix('(').filter(|_| is_whole).and_then(arguments);
        done.push_str(before);
        match arguments.and_then(|found| Some((found, value(found)?))) {
            Some((found, value)) => {
                done.push_str(&value);
                rest = &after[found.len() + "()".len()..];
            }
            None => {
                done.push_str(function);
                rest = after;
            }
        }
        if done.len() > most {
            return None;
        }
    }
    if rest.len() == text.len() {
        return Some(Cow::Borrowed(text));
    }
    done.push_str(rest);
    (done.len() <= most).then_some(Cow::Owned(done))
}

/// Whether a name of CSS may have this character in it.
pub(super) fn is_of_name(c: char) -> bool {
    c.is_ascii_alphanumeric() || matches!(c, '-' | '_') || !c.is_ascii()
}

/// The text as far as the parenthesis that closes one open before it.
fn arguments(text: &str) -> Option<&str> {
    let mut depth = 1;
    for (at, byte) in text.bytes().enumerate().take(LONGEST) {
        match byte {
            b'(' => depth += 1,
            b')' => depth -= 1,
            b'<' | b'{' | b'}' => return None,
            _ => {}
        }
        if depth == 0 {
            return Some(&text[..at]);
        }
        if depth > DEEPEST {
            return None;
        }
    }
    None
}

/// The first of several arguments.
pub(super) fn first(arguments: &str) -> &str {
    let mut depth = 0;
    let end = arguments.bytes().position(|byte| {
        match byte {
            b'(' => depth += 1,
            b')' => depth -= 1,
            _ => {}
        }
        depth == 0 && byte == b','
    });
    &arguments[..end.unwrap_or(arguments.len())]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whole_calls_are_replaced_and_no_others() {
        fn of(text: &str) -> Option<Cow<'_, str>> {
            replaced(text, "f", 40, &|arguments| (arguments != "no").then(|| arguments.to_uppercase()))
        }
        let open = "f(a".repeat(9);
        assert_eq!(of("f(a)g f(f(b), c)f f(no) ff(d) f(e").as_deref(), Some("Ag F(B), Cf f(no) ff(d) f(e"));
        assert!(matches!(of("a g(b)"), Some(Cow::Borrowed(_))));
        assert_eq!(of(&open).as_deref(), Some(&*open));
        assert_eq!(of(&"f(abcde)".repeat(9)), None);
        assert_eq!(first("rgb(1, 2, 3), red"), "rgb(1, 2, 3)");
        assert_eq!(first("red"), "red");
    }
}
