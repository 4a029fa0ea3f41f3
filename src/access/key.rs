use std::fmt;
use std::str::FromStr;

use base64::Engine;
use base64::prelude::BASE64_URL_SAFE_NO_PAD;
use blake3::Hash;

/// How keys begin that are made here, so that people and scanners of leaks know what they have before them.
const PREFIX: &str = "sketchmatch_";

/// Bytes of chance in a key. Nobody finds one of 2²⁵⁶ by trying, so that one round of a fast hash hides it: what makes
/// hashes for passwords slow would only make every request slow.
const CHANCE: usize = 32;

/// Characters of a key at most.
const LONGEST: usize = 512;

/// A key as its owner sends it. It is never shown: what is kept and compared is its hash, and two hashes are compared in the
/// same time wherever they differ.
#[derive(Clone, PartialEq, Eq)]
pub struct Key(String);

/// A text that is no key; it is not repeated, for it may be most of one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("a key is 1 to 512 letters, digits and the signs -._~+/, with = at its end only")]
pub struct NoKey;

impl Key {
    /// A new key.
    ///
    /// # Errors
    /// Where the system has no chance to offer.
    pub fn random() -> Result<Key, getrandom::Error> {
        let mut chance = [0; CHANCE];
        getrandom::fill(&mut chance)?;
        Ok(Key(format!("{PREFIX}{}", BASE64_URL_SAFE_NO_PAD.encode(chance))))
    }

    pub fn hash(&self) -> Hash {
        blake3::hash(self.0.as_bytes())
    }

    pub fn length(&self) -> usize {
        self.0.len()
    }

    /// The key itself, to be shown to its owner once.
    pub fn reveal(&self) -> &str {
        &self.0
    }
}

impl fmt::Debug for Key {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str("Key")
    }
}

impl FromStr for Key {
    type Err = NoKey;

    /// Reads what a header can carry as a `b64token` of RFC 6750.
    fn from_str(text: &str) -> Result<Key, NoKey> {
        let body = text.trim_end_matches('=');
        let fits = |byte: u8| byte.is_ascii_alphanumeric() || b"-._~+/".contains(&byte);
        let carried = text.len() <= LONGEST && !body.is_empty() && body.bytes().all(fits);
        if carried { Ok(Key(text.to_owned())) } else { Err(NoKey) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn new_keys_differ_and_can_be_sent() {
        let [one, other] = [(); 2].map(|()| Key::random().unwrap());
        assert_ne!(one.hash(), other.hash());
        assert_eq!(one.reveal().parse::<Key>().unwrap().hash(), one.hash());
        assert_eq!(format!("{one:?}"), "Key");
    }

    #[test]
    fn what_a_header_cannot_carry_is_no_key() {
        for text in ["k", "a-._~+/9==", &"x".repeat(512)] {
            assert!(text.parse::<Key>().is_ok(), "{text}");
        }
        for text in ["", "==", "a b", "a=b", "ä", "a:b", "a\r", &"x".repeat(513)] {
            assert_eq!(text.parse::<Key>(), Err(NoKey), "{text:?}");
        }
    }
}
