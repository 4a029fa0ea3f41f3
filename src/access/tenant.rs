use std::fmt;
use std::str::FromStr;
use std::sync::Arc;

/// Characters of a name at most.
const LONGEST: usize = 64;

/// Whose something is. Its name is 1 to 64 ASCII letters, digits, dots, dashes and underscores.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Tenant(Arc<str>);

/// A text that names no tenant.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("a tenant's name is 1 to 64 letters, digits, dots, dashes and underscores")]
pub struct NoTenant;

impl Default for Tenant {
    /// The one tenant of a server that asks for no keys, and of keys that name none.
    fn default() -> Tenant {
        Tenant("default".into())
    }
}

impl Tenant {
    pub fn as_str(&self) -> &str {
        &self.0
    }
}

impl fmt::Display for Tenant {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str(&self.0)
    }
}

impl FromStr for Tenant {
    type Err = NoTenant;

    fn from_str(text: &str) -> Result<Tenant, NoTenant> {
        let fits = |byte: u8| byte.is_ascii_alphanumeric() || matches!(byte, b'.' | b'-' | b'_');
        let named = (1..=LONGEST).contains(&text.len()) && text.bytes().all(fits);
        if named { Ok(Tenant(text.into())) } else { Err(NoTenant) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_is_plain() {
        for text in ["a", "Acme-2.de_", &"x".repeat(64)] {
            assert_eq!(text.parse::<Tenant>().unwrap().as_str(), text);
        }
        for text in ["", "a b", "a/b", "ä", "a\n", &"x".repeat(65)] {
            assert_eq!(text.parse::<Tenant>(), Err(NoTenant), "{text:?}");
        }
    }
}
