use std::collections::BTreeSet;
use std::fmt;
use std::str::FromStr;

/// What may be done.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Scope {
    /// To look at what the tenant has.
    Read,
    /// To upload, to ask for jobs, to rename and to delete.
    Write,
    /// To read the measures of the whole server.
    Admin,
}

impl Scope {
    const ALL: [Scope; 3] = [Scope::Read, Scope::Write, Scope::Admin];

    pub const fn as_str(self) -> &'static str {
        match self {
            Scope::Read => "read",
            Scope::Write => "write",
            Scope::Admin => "admin",
        }
    }
}

/// What a key may do; none of it implies another.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Scopes(BTreeSet<Scope>);

/// A text that names no scopes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("scopes are read, write and admin, at least one of them, with commas between")]
pub struct NoScopes;

impl Default for Scopes {
    /// Those of a key of which nothing is said.
    fn default() -> Scopes {
        Scopes([Scope::Read, Scope::Write].into())
    }
}

impl Scopes {
    pub fn of(scope: Scope) -> Scopes {
        Scopes([scope].into())
    }

    pub fn all() -> Scopes {
        Scopes(Scope::ALL.into())
    }

    pub fn allow(&self, scope: Scope) -> bool {
        self.0.contains(&scope)
    }
}

impl fmt::Display for Scopes {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let names: Vec<&str> = self.0.iter().map(|scope| scope.as_str()).collect();
        out.write_str(&names.join(","))
    }
}

impl FromStr for Scopes {
    type Err = NoScopes;

    fn from_str(text: &str) -> Result<Scopes, NoScopes> {
        let named = |name: &str| Scope::ALL.into_iter().find(|scope| scope.as_str() == name).ok_or(NoScopes);
        text.split(',').map(|name| named(name.trim())).collect::<Result<_, _>>().map(Scopes)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scopes_are_read_as_they_are_written() {
        for text in ["read", "read,write", "admin", "read,write,admin"] {
            assert_eq!(text.parse::<Scopes>().unwrap().to_string(), text);
        }
        assert_eq!("write, read".parse::<Scopes>().unwrap(), Scopes::default());
        for text in ["", "read,", "root", "READ"] {
            assert_eq!(text.parse::<Scopes>(), Err(NoScopes), "{text:?}");
        }
    }
}
