//! JSON bodies, read strictly: UTF-8, no duplicate key, nothing after the value, every failure with its pointer.

mod tree;

use std::fmt;

use serde::Deserialize;
use serde::de::{DeserializeOwned, Deserializer, Error as _, IgnoredAny, MapAccess, SeqAccess, Visitor};
use serde_json::de::StrRead;
use serde_json::{Map, Number, Value};
use serde_path_to_error::{Path, Segment};

use super::{Fault, Untaken};
use tree::Tree;

/// Bytes of memory per byte of JSON that its tree takes at most, about: members of objects take most.
pub const MEMORY_OF_TREE: usize = 40;

/// Members of the largest object whose variants a tag tells apart, and more: in larger ones no member is looked for.
const MOST_MEMBERS: usize = 16;

/// Integers up to here have one spelling as a double.
const LARGEST_EXACT_INTEGER: f64 = 9_007_199_254_740_992.0;

/// The members that tell the variants of a tagged object apart.
const TAGS: [&str; 2] = ["method", "type"];

/// Types of Rust in the messages of serde, and what a client knows them as.
const TYPES: [(&str, &str); 6] = [
    ("usize", "a whole number from 0 on"),
    ("a sequence", "a list"),
    ("variant identifier", "a name"),
    ("u32", "a whole number from 0 to 4294967295"),
    ("i32", "a whole number from -2147483648 to 2147483647"),
    ("f64", "a number"),
];

/// Types of Rust that are objects in JSON, before their names.
const OBJECTS: [&str; 4] = ["struct ", "struct variant ", "internally tagged enum ", "enum "];

/// The value a JSON body stands for, by way of its tree.
///
/// # Errors
/// Malformed where the bytes are not JSON or a key occurs twice, unacceptable where they are JSON of another shape.
pub fn parsed<T: DeserializeOwned>(bytes: &[u8]) -> Result<T, Untaken> {
    let mut tree = tree(bytes)?;
    shaped(&mut tree).map_err(misshapen)
}

/// The value a JSON body stands for, and that of one of its members where it is an object, in whose place the first has an
/// empty text.
///
/// # Errors
/// As of [`parsed`].
pub fn parsed_apart<T: DeserializeOwned, P: DeserializeOwned>(
    bytes: &[u8],
    member: &str,
) -> Result<(T, Option<P>), Untaken> {
    let mut tree = tree(bytes)?;
    let part = tree.get_mut(member).filter(|part| part.is_object());
    let part = part.map(|part| std::mem::replace(part, Value::from("")));
    let value = shaped(&mut tree).map_err(misshapen)?;
    let part = part.map(|mut part| shaped(&mut part).map_err(|fault| misshapen(fault).below(&format!("/{member}"))));
    Ok((value, part.transpose()?))
}

/// The value that a JSON object stands for, without a tree: for what may be long, and has no objects whose variants a tag
/// tells apart.
///
/// # Errors
/// As of [`parsed`].
pub fn typed<T: DeserializeOwned>(bytes: &[u8]) -> Result<T, Untaken> {
    let text = text(bytes)?;
    if !text.trim_start().starts_with('{') {
        // An array would be taken for the members in their order.
        serde_json::from_str::<IgnoredAny>(text)
            .map_err(|error| Untaken::malformed(Fault::at_pointer("", error.to_string())))?;
        return Err(misshapen(Fault::at_pointer("", "invalid type: expected an object")));
    }
    let mut deserializer = serde_json::Deserializer::from_str(text);
    let value = serde_path_to_error::deserialize(&mut deserializer).map_err(|error| {
        let (at, error) = (pointer(error.path()), error.into_inner());
        let detail = error.to_string();
        if !error.is_data() || detail.starts_with("duplicate field") {
            return Untaken::malformed(Fault::at_pointer(at, detail));
        }
        let place = format!(" at line {} column {}", error.line(), error.column());
        let detail = detail.trim_end_matches(&place).to_owned();
        let at = named_field(&detail).map(|field| field_pointer(&at, field)).unwrap_or(at);
        misshapen(Fault::at_pointer(at, worded(detail)))
    })?;
    ended(deserializer)?;
    Ok(value)
}

/// `application/json` and its kin.
pub fn is_json(media_type: &str) -> bool {
    media_type == "application/json" || (media_type.starts_with("application/") && media_type.ends_with("+json"))
}

fn misshapen(fault: Fault) -> Untaken {
    Untaken::unacceptable("the body does not have the shape asked for", vec![fault])
}

/// The bytes without a byte order mark, which some editors put before a text.
pub fn without_mark(bytes: &[u8]) -> &[u8] {
    bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes)
}

fn text(bytes: &[u8]) -> Result<&str, Untaken> {
    std::str::from_utf8(without_mark(bytes)).map_err(|error| {
        Untaken::malformed(Fault::at_place(format!("byte {}", error.valid_up_to()), "the body is not UTF-8"))
    })
}

/// Refuses what comes after a value.
fn ended<'a>(mut deserializer: serde_json::Deserializer<StrRead<'a>>) -> Result<(), Untaken> {
    deserializer.end().map_err(|error| Untaken::malformed(Fault::at_pointer("", error.to_string())))
}

/// The tree of a JSON text, in which every number without a fraction is an integer, as JSON Schema has it.
fn tree(bytes: &[u8]) -> Result<Value, Untaken> {
    let mut deserializer = serde_json::Deserializer::from_str(text(bytes)?);
    let Strict(tree) = serde_path_to_error::deserialize(&mut deserializer)
        .map_err(|error| Untaken::malformed(Fault::at_pointer(pointer(error.path()), error.inner().to_string())))?;
    ended(deserializer)?;
    Ok(tree)
}

/// `tree` as a `T`, or the fault with the pointer of what is to blame, for which members are taken out and put back.
fn shaped<T: DeserializeOwned>(tree: &mut Value) -> Result<T, Fault> {
    serde_path_to_error::deserialize(Tree(tree)).map_err(|error| {
        let (at, detail) = (pointer(error.path()), error.inner().to_string());
        let at = match named_field(&detail) {
            Some(field) => field_pointer(&at, field),
            None => culprit::<T>(tree, &at, &detail).unwrap_or(at),
        };
        Fault::at_pointer(at, worded(detail))
    })
}

/// A message of serde with the type it expected in words.
fn worded(detail: String) -> String {
    let Some((found, expected)) = detail.rsplit_once("expected ") else { return detail };
    match TYPES.iter().find(|(name, _)| *name == expected) {
        Some((_, words)) => format!("{found}expected {words}"),
        None if is_of_object(expected) => format!("{found}expected an object"),
        None => detail,
    }
}

/// Whether what serde expected is an object in JSON.
fn is_of_object(expected: &str) -> bool {
    OBJECTS.iter().any(|kind| expected.starts_with(kind))
}

/// The field that is missing, unknown or repeated by the words of serde.
pub fn named_field(detail: &str) -> Option<&str> {
    let field = ["missing", "unknown", "duplicate"].iter().find_map(|what| detail.strip_prefix(what))?;
    field.strip_prefix(" field `")?.split('`').next()
}

/// `at` with `field` appended, unless it ends there already.
fn field_pointer(at: &str, field: &str) -> String {
    let field = escaped(field);
    if at.rsplit('/').next() == Some(&field) && at.contains('/') { at.to_owned() } else { format!("{at}/{field}") }
}

/// The pointer of the member of the object at `at` that makes reading it fail with `detail`.
///
/// serde buffers an internally tagged enum before reading it, which loses the path below the enum: the member is found
/// by leaving out one at a time until the failure changes. Without its tag an object always fails in another way, so that
/// the tag is to blame only where nothing else is. An object that is itself of the wrong type has no such member.
fn culprit<T: DeserializeOwned>(tree: &mut Value, at: &str, detail: &str) -> Option<String> {
    let members = tree.pointer(at)?.as_object()?;
    if members.len() > MOST_MEMBERS || detail.starts_with("invalid type: map") {
        return None;
    }
    let is_tag = |key: &&String| TAGS.contains(&key.as_str());
    let tags_last = members.keys().filter(|key| !is_tag(key)).chain(members.keys().filter(is_tag));
    let tags_last: Vec<String> = tags_last.cloned().collect();
    let to_blame = tags_last.into_iter().find(|key| {
        let Some(member) = tree.pointer_mut(at).and_then(|object| object.as_object_mut()?.remove(key)) else {
            return false;
        };
        let failure = serde_path_to_error::deserialize::<_, T>(Tree(tree)).err();
        if let Some(Value::Object(object)) = tree.pointer_mut(at) {
            object.insert(key.clone(), member);
        }
        failure.is_none_or(|error| error.inner().to_string() != detail)
    })?;
    Some(format!("{at}/{}", escaped(&to_blame)))
}

fn pointer(path: &Path) -> String {
    path.iter().fold(String::new(), |pointer, segment| match segment {
        Segment::Seq { index } => format!("{pointer}/{index}"),
        Segment::Map { key } | Segment::Enum { variant: key } => format!("{pointer}/{}", escaped(key)),
        Segment::Unknown => pointer,
    })
}

/// A key as a reference token of RFC 6901.
fn escaped(key: &str) -> String {
    key.replace('~', "~0").replace('/', "~1")
}

/// A JSON value whose objects name no key twice.
struct Strict(Value);

impl<'de> Deserialize<'de> for Strict {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Strict, D::Error> {
        deserializer.deserialize_any(StrictVisitor).map(Strict)
    }
}

struct StrictVisitor;

impl<'de> Visitor<'de> for StrictVisitor {
    type Value = Value;

    fn expecting(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        formatter.write_str("a JSON value")
    }

    fn visit_unit<E>(self) -> Result<Value, E> {
        Ok(Value::Null)
    }

    fn visit_bool<E>(self, value: bool) -> Result<Value, E> {
        Ok(Value::Bool(value))
    }

    fn visit_i64<E>(self, value: i64) -> Result<Value, E> {
        Ok(Value::from(value))
    }

    fn visit_u64<E>(self, value: u64) -> Result<Value, E> {
        Ok(Value::from(value))
    }

    fn visit_f64<E: serde::de::Error>(self, value: f64) -> Result<Value, E> {
        if value.fract() == 0.0 && value.abs() <= LARGEST_EXACT_INTEGER {
            return Ok(Value::from(value as i64));
        }
        Number::from_f64(value).map(Value::Number).ok_or_else(|| E::custom("number out of range"))
    }

    fn visit_str<E>(self, value: &str) -> Result<Value, E> {
        Ok(Value::from(value))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut elements: A) -> Result<Value, A::Error> {
        let mut array = Vec::new();
        while let Some(Strict(element)) = elements.next_element()? {
            array.push(element);
        }
        Ok(Value::Array(array))
    }

    fn visit_map<A: MapAccess<'de>>(self, mut members: A) -> Result<Value, A::Error> {
        let mut object = Map::new();
        while let Some((key, Strict(value))) = members.next_entry::<String, Strict>()? {
            if object.contains_key(&key) {
                return Err(A::Error::custom(format_args!("the key {key:?} occurs twice")));
            }
            object.insert(key, value);
        }
        Ok(Value::Object(object))
    }
}

#[cfg(test)]
mod tests {
    use super::super::Cause::{self, Malformed, Unacceptable};
    use super::*;
    use crate::pipeline::request::MatchRequest;

    fn refusal(text: &str) -> (Cause, Fault) {
        let untaken = parsed::<MatchRequest>(text.as_bytes()).unwrap_err();
        (untaken.cause, untaken.faults[0].clone())
    }

    #[track_caller]
    fn assert_refused(text: &str, cause: Cause, pointer: &str) {
        let (found, fault) = refusal(text);
        assert_eq!((found, fault.pointer.as_deref()), (cause, Some(pointer)), "{}", fault.detail);
    }

    #[test]
    fn reads_integers_written_with_a_fraction_of_zero() {
        let request: MatchRequest = parsed(br#"{"mesh": "m", "sketch": "s", "basis": {"k": 40.0}}"#).unwrap();
        assert_eq!(request.basis.unwrap().k, Some(40));
    }

    #[test]
    fn names_the_place_of_every_defect() {
        assert_refused(r#"{"sketch": "s"}"#, Unacceptable, "/mesh");
        assert_refused(r#"{"mesh": 1, "sketch": "s"}"#, Unacceptable, "/mesh");
        assert_refused(r#"{"mesh": "m", "sketch": "s", "meshes": 1}"#, Unacceptable, "/meshes");
        assert_refused(r#"{"mesh": "m", "sketch": "s", "basis": {"k": -1}}"#, Unacceptable, "/basis/k");
        assert_refused(r#"{"mesh": "m", "sketch": "s", "basis": {"k/": 1}}"#, Unacceptable, "/basis/k~1");
        assert_refused(
            r#"{"mesh": "m", "sketch": "s", "landmarks": [{"sketch": [0], "mesh": 1}]}"#,
            Unacceptable,
            "/landmarks/0/sketch",
        );
        assert_refused("[]", Unacceptable, "");
    }

    #[test]
    fn names_the_member_of_a_tagged_object() {
        let with = |regulariser: &str| format!(r#"{{"mesh": "m", "sketch": "s", "regulariser": {regulariser}}}"#);
        assert_refused(&with(r#"{"type": "l1", "gamma": "large"}"#), Unacceptable, "/regulariser/gamma");
        assert_refused(&with(r#"{"type": "l1", "gama": 1}"#), Unacceptable, "/regulariser/gama");
        assert_refused(&with(r#"{"type": "l3"}"#), Unacceptable, "/regulariser/type");
        assert_refused(&with(r#"{"gamma": 1}"#), Unacceptable, "/regulariser/type");
        assert_refused(&with(r#"{"type": "l1", "max_iterations": 1.5}"#), Unacceptable, "/regulariser/max_iterations");
        assert_refused(&with("7"), Unacceptable, "/regulariser");
    }

    #[test]
    fn names_the_member_beside_the_tag() {
        let with = |regions: &str| format!(r#"{{"mesh": "m", "sketch": "s", "regions": {regions}}}"#);
        let given = r#"{"method": "given", "sketch": [0], "mesh": [4294967296]}"#;
        assert_refused(&with(given), Unacceptable, "/regions/mesh");
        let segmented = r#"{"method": "segmented", "sketch_regions": 6, "mesh_regions": 7, "pairs": [[0, 1, 2]]}"#;
        assert_refused(&with(segmented), Unacceptable, "/regions/pairs");
        assert_refused(&with(r#"{"method": "guessed", "pairs": 1}"#), Unacceptable, "/regions/method");
    }

    #[test]
    fn says_in_words_what_was_expected() {
        for words in [r#""alignment": 7"#, r#""regions": "auto""#, r#""basis": 20"#] {
            let (_, fault) = refusal(&format!(r#"{{"mesh": "m", "sketch": "s", {words}}}"#));
            assert!(fault.detail.ends_with("expected an object"), "{}", fault.detail);
        }
        let (_, fault) = refusal(r#"{"mesh": "m", "sketch": "s", "basis": {"k": 2.5}}"#);
        assert_eq!(fault.detail, "invalid type: floating point `2.5`, expected a whole number from 0 on");
        for words in [r#""basis": [20, 20, "neumann"]"#, r#""regulariser": ["l1", 1]"#, r#""given_map": [[1]]"#] {
            let (_, fault) = refusal(&format!(r#"{{"mesh": "m", "sketch": "s", {words}}}"#));
            assert_eq!(fault.detail, "invalid type: sequence, expected an object", "{words}");
        }
        let (_, fault) = refusal(r#"["m", "s"]"#);
        assert_eq!(fault.detail, "invalid type: sequence, expected an object");
        let (_, fault) = refusal(r#"{"mesh": "m", "sketch": "s", "landmarks": [[[0, 0], 1]]}"#);
        assert_eq!(
            (fault.pointer.as_deref(), &*fault.detail),
            (Some("/landmarks/0"), "invalid type: sequence, expected an object")
        );
        let (_, fault) = refusal("null");
        assert_eq!(fault.detail, "invalid type: null, expected an object");
    }

    #[test]
    fn names_the_members_of_which_there_is_to_be_one() {
        use crate::evaluation::Known;
        let detail = |text: &str| parsed::<Known>(text.as_bytes()).unwrap_err().faults[0].detail.clone();
        let one = "expected an object with one member, `pairs` or `labels`";
        assert_eq!(detail(r#"{"side": true, "points": [], "variants": {}}"#), one);
        assert_eq!(detail("{}"), one);
        assert_eq!(detail(r#"{"pairs": [true, [], {}]}"#), "invalid type: sequence, expected an object");
        let known = parsed::<Known>(br#"{"pairs": {"side": true, "points": [[0, 1]], "variants": {"front": [0]}}}"#);
        assert!(matches!(known.unwrap(), Known::Pairs(_)));
    }

    #[test]
    fn says_what_else_a_member_may_be() {
        let read = |text: &str| parsed_apart::<MatchRequest, IgnoredAny>(text.as_bytes(), "sketch");
        let untaken = read(r#"{"mesh": "m", "sketch": [[0, 0]]}"#).unwrap_err().expecting("/sketch", "an id");
        assert_eq!(untaken.faults, [Fault::at_pointer("/sketch", "invalid type: sequence, expected an id")]);
        let untaken = read(r#"{"mesh": 1, "sketch": "s"}"#).unwrap_err().expecting("/sketch", "an id");
        assert_eq!(untaken.faults[0].detail, "invalid type: integer `1`, expected a string");
    }

    #[test]
    fn reads_what_an_editor_marks_as_text() {
        assert_eq!(parsed::<MatchRequest>(b"\xef\xbb\xbf{\"mesh\": \"m\", \"sketch\": \"s\"}").unwrap().mesh, "m");
        assert_eq!(typed::<MatchRequest>(b"\xef\xbb\xbf{\"mesh\": \"m\", \"sketch\": \"s\"}").unwrap().mesh, "m");
    }

    #[test]
    fn names_the_same_places_without_a_tree() {
        use crate::sketch::outline::OutlineRequest;
        let places = [
            ("", Malformed, ""),
            ("{", Malformed, ""),
            ("[]", Unacceptable, ""),
            ("{}", Unacceptable, "/outline"),
            (r#"{"outline": [], "outline": []}"#, Malformed, ""),
            (r#"{"outline": []} 1"#, Malformed, ""),
            (r#"{"outline": [], "holes": 1}"#, Unacceptable, "/holes"),
            (r#"{"outline": [[0, 1], [0, "1"]]}"#, Unacceptable, "/outline/1/1"),
            (r#"{"outline": [[0, 1e999]]}"#, Malformed, "/outline/0/1"),
            (r#"{"outline": [[0, 1, 2]]}"#, Unacceptable, "/outline/0"),
            (r#"{"outline": [], "out/line": []}"#, Unacceptable, "/out~1line"),
            (r#"{"outline": [], "target_vertices": 1.5}"#, Unacceptable, "/target_vertices"),
            (r#"{"outline": [], "target_vertices": -1}"#, Unacceptable, "/target_vertices"),
        ];
        for (text, cause, pointer) in places {
            let untaken = typed::<OutlineRequest>(text.as_bytes()).unwrap_err();
            let place = untaken.faults[0].pointer.as_deref();
            assert_eq!((untaken.cause, place), (cause, Some(pointer)), "{text}: {}", untaken.faults[0].detail);
            assert_eq!(parsed::<OutlineRequest>(text.as_bytes()).unwrap_err().cause, cause, "{text}");
        }
        let request = typed::<OutlineRequest>(br#"{"outline": [[0, 1]], "target_vertices": 60.0}"#).unwrap();
        assert_eq!((request.outline, request.target_vertices), (vec![[0.0, 1.0]], Some(60)));
    }

    #[test]
    fn refuses_what_is_not_strict_json() {
        assert_refused(r#"{"mesh": "m", "mesh": "n", "sketch": "s"}"#, Malformed, "");
        assert_refused(r#"{"mesh": "m", "sketch": "s"} 1"#, Malformed, "");
        assert_refused("", Malformed, "");
        assert_eq!(refusal(&"[".repeat(10_000)).0, Malformed);
        assert_refused(r#"{"mesh": "m", "sketch": "s", "basis": {"k": 1e999}}"#, Malformed, "/basis/k");
        assert_eq!(parsed::<MatchRequest>(b"{\"mesh\": \"\xff\"}").unwrap_err().cause, Malformed);
    }
}
