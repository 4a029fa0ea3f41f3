//! Keys in a file: one a line, or a list in JSON.

use std::time::{Duration, SystemTime};

use blake3::Hash;
use serde::Deserialize;
use serde_json::Value;

use super::{Grant, Key, Scopes, Tenant};

/// Characters of a key below which it may be guessed.
const SHORTEST_SAFE: usize = 20;

/// The keys of a file.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct KeyFile {
    entries: Vec<Entry>,
    /// Where keys stand that are short enough to be guessed.
    pub guessable: Vec<String>,
}

#[derive(Clone, Debug, PartialEq, Eq)]
struct Entry {
    hash: Hash,
    grant: Grant,
    expires: Option<SystemTime>,
}

/// What is wrong with a file of keys, and where. It repeats nothing of the file, which is secret.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{place}: {reason}")]
pub struct Unreadable {
    /// The line, or the number of the entry in a list.
    pub place: String,
    pub reason: String,
}

/// A key and what is said of it, as an entry of a list in JSON.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Fields {
    key: String,
    tenant: Option<String>,
    scopes: Option<Vec<String>>,
    expires: Option<String>,
    name: Option<String>,
}

impl KeyFile {
    /// The keys in a text. Lines that are empty or begin with `#` are left out. A line is
    /// `[tenant:]key[:scopes] [expires=TIME] [name=NAME]`; of a line of nothing but a key the tenant is the default one, who
    /// may do everything. A text that begins with `[` or `{` is JSON: a list of such lines, or of objects with the members
    /// `key`, `tenant`, `scopes`, `expires` and `name`; or an object whose member `keys` is that list.
    ///
    /// # Errors
    /// The first line or entry that cannot be read.
    pub fn read(text: &str) -> Result<KeyFile, Unreadable> {
        let text = text.trim_start_matches('\u{feff}');
        let mut file = KeyFile::default();
        if text.trim_start().starts_with(['[', '{']) {
            for (i, entry) in list(text)?.into_iter().enumerate() {
                let place = format!("entry {}", i + 1);
                let fields = match entry {
                    Value::String(line) => Fields::of_line(&line),
                    entry => serde_json::from_value(entry).map_err(|error| shape_of(&error)),
                };
                file.add(&place, fields)?;
            }
            return Ok(file);
        }
        for (i, line) in text.lines().enumerate() {
            let line = line.trim();
            if !line.is_empty() && !line.starts_with('#') {
                file.add(&format!("line {}", i + 1), Fields::of_line(line))?;
            }
        }
        Ok(file)
    }

    fn add(&mut self, place: &str, fields: Result<Fields, String>) -> Result<(), Unreadable> {
        let (entry, length) = fields.and_then(|fields| fields.entry(place)).map_err(|reason| at(place, reason))?;
        if let Some(same) = self.entries.iter().find(|other| other.hash == entry.hash) {
            return Err(at(place, format!("this key is there already, as {}", same.grant.key)));
        }
        if length < SHORTEST_SAFE {
            self.guessable.push(place.to_owned());
        }
        self.entries.push(entry);
        Ok(())
    }

    pub fn is_empty(&self) -> bool {
        self.entries.is_empty()
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.entries.len()
    }

    /// What the key of this hash opens at this time, if it is one of these. Every key is compared, each in the same time.
    pub fn grant(&self, hash: &Hash, now: SystemTime) -> Option<&Grant> {
        let found =
            self.entries.iter().fold(None, |found, entry| if entry.hash == *hash { Some(entry) } else { found })?;
        found.expires.is_none_or(|expires| now < expires).then_some(&found.grant)
    }
}

impl Fields {
    fn of_line(line: &str) -> Result<Fields, String> {
        let mut words = line.split_whitespace();
        let parts: Vec<&str> = words.next().unwrap_or_default().split(':').collect();
        let (tenant, key, scopes) = match parts.as_slice() {
            [key] => (None, *key, None),
            [tenant, key] => (Some(*tenant), *key, None),
            [tenant, key, scopes] => (Some(*tenant), *key, Some(*scopes)),
            _ => return Err("a line is key, tenant:key or tenant:key:scopes".to_owned()),
        };
        let (mut expires, mut name) = (None, None);
        for word in words {
            match word.split_once('=') {
                Some(("expires", time)) if expires.is_none() => expires = Some(time.to_owned()),
                Some(("name", text)) if name.is_none() => name = Some(text.to_owned()),
                _ => return Err("behind the key stand expires=TIME and name=NAME, each once at most".to_owned()),
            }
        }
        let scopes = match (tenant, scopes) {
            (None, _) => Some(vec![Scopes::all().to_string()]),
            (_, scopes) => scopes.map(|scopes| vec![scopes.to_owned()]),
        };
        Ok(Fields { key: key.to_owned(), tenant: tenant.map(str::to_owned), scopes, expires, name })
    }

    /// The entry, and how long its key is.
    fn entry(self, place: &str) -> Result<(Entry, usize), String> {
        let key: Key = self.key.parse().map_err(text)?;
        let tenant = self.tenant.map_or(Ok(Tenant::default()), |tenant| tenant.parse().map_err(text))?;
        let scopes = self.scopes.map_or(Ok(Scopes::default()), |scopes| scopes.join(",").parse().map_err(text))?;
        let expires = self.expires.as_deref().map(time).transpose()?;
        let grant = Grant { tenant, scopes, key: self.name.unwrap_or_else(|| place.to_owned()) };
        Ok((Entry { hash: key.hash(), grant, expires }, key.length()))
    }
}

fn text(error: impl ToString) -> String {
    error.to_string()
}

fn at(place: &str, reason: impl Into<String>) -> Unreadable {
    Unreadable { place: place.to_owned(), reason: reason.into() }
}

/// The list in a text of JSON.
fn list(text: &str) -> Result<Vec<Value>, Unreadable> {
    let whole: Value = serde_json::from_str(text)
        .map_err(|error| at(&format!("line {}", error.line()), "this is no JSON, as the file begins like"))?;
    let listed = match whole {
        Value::Object(mut members) if members.len() == 1 => members.remove("keys").unwrap_or_default(),
        whole => whole,
    };
    match listed {
        Value::Array(entries) => Ok(entries),
        _ => Err(at("line 1", "a list of keys is wanted, or an object whose one member `keys` is a list")),
    }
}

/// What is wrong with an entry, without the values that an error of serde may repeat.
fn shape_of(_: &serde_json::Error) -> String {
    "an entry is a line of text, or an object of the members key, tenant, scopes (a list), expires and name".to_owned()
}

/// The time in a text as RFC 3339 writes it, or the begin of a day, in UTC.
///
/// # Errors
/// Why it is none, in words.
pub fn time(text: &str) -> Result<SystemTime, String> {
    let whole = if text.len() == "2027-01-31".len() { format!("{text}T00:00:00Z") } else { text.to_owned() };
    humantime::parse_rfc3339(&whole).map_err(|_| "a time is such as 2027-01-31 or 2027-01-31T12:00:00Z".to_owned())
}

/// A time as milliseconds since 1970.
pub fn milliseconds(time: SystemTime) -> i64 {
    let since = time.duration_since(SystemTime::UNIX_EPOCH).unwrap_or(Duration::ZERO);
    i64::try_from(since.as_millis()).unwrap_or(i64::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;

    const NOW: SystemTime = SystemTime::UNIX_EPOCH;

    /// The tenant, the scopes and the name of the grant of a key.
    fn opened(file: &KeyFile, key: &str) -> Option<(String, String, String)> {
        let grant = file.grant(&key.parse::<Key>().unwrap().hash(), NOW)?;
        Some((grant.tenant.to_string(), grant.scopes.to_string(), grant.key.clone()))
    }

    fn grant(tenant: &str, scopes: &str, key: &str) -> Option<(String, String, String)> {
        Some((tenant.to_owned(), scopes.to_owned(), key.to_owned()))
    }

    #[test]
    fn lines_are_keys() {
        let file = "\u{feff}# ours\r\n\r\nalone\r\n  acme:key-of-acme-0123456789\nacme:reader:read name=ci expires=2999-01-01\n";
        let file = KeyFile::read(file).unwrap();
        assert_eq!(opened(&file, "alone"), grant("default", "read,write,admin", "line 3"));
        assert_eq!(opened(&file, "key-of-acme-0123456789"), grant("acme", "read,write", "line 4"));
        assert_eq!(opened(&file, "reader"), grant("acme", "read", "ci"));
        assert_eq!(opened(&file, "stranger"), None);
        assert_eq!(file.guessable, ["line 3", "line 5"]);
        assert!(KeyFile::read("# nobody\n").unwrap().is_empty());
    }

    #[test]
    fn a_list_in_json_is_keys() {
        let list =
            r#"["alone", "acme:key", {"key": "b", "tenant": "b.org", "scopes": ["read", "admin"], "name": "watch"}]"#;
        for text in [list.to_owned(), format!("{{\"keys\": {list}}}")] {
            let file = KeyFile::read(&text).unwrap();
            assert_eq!(opened(&file, "alone"), grant("default", "read,write,admin", "entry 1"));
            assert_eq!(opened(&file, "key"), grant("acme", "read,write", "entry 2"));
            assert_eq!(opened(&file, "b"), grant("b.org", "read,admin", "watch"));
        }
    }

    #[test]
    fn a_key_expires() {
        let file = KeyFile::read("acme:key expires=1970-01-01T00:01:00Z").unwrap();
        let hash = "key".parse::<Key>().unwrap().hash();
        assert!(file.grant(&hash, NOW + Duration::from_secs(59)).is_some());
        assert_eq!(file.grant(&hash, NOW + Duration::from_secs(60)), None);
    }

    #[test]
    fn what_cannot_be_read_is_named_by_its_place_and_not_repeated() {
        for (text, place) in [
            ("good\nsecret key", "line 2"),
            ("a:secret:read:more", "line 1"),
            ("good\n\na b:secret", "line 3"),
            (":secret", "line 1"),
            ("a:secret:root", "line 1"),
            ("secret expires=soon", "line 1"),
            ("secret name=a name=b", "line 1"),
            ("a:secret\nb:secret", "line 2"),
            ("se=cret", "line 1"),
            ("[\"good\",\n\"secret\"", "line 2"),
            ("[\"good\", 7]", "entry 2"),
            ("[{\"key\": \"secret\", \"colour\": 1}]", "entry 1"),
            ("{\"acme\": \"secret\"}", "line 1"),
        ] {
            let error = KeyFile::read(text).unwrap_err();
            assert_eq!(error.place, place, "{text}: {error}");
            assert!(!error.to_string().contains("secret"), "{error}");
        }
    }
}
