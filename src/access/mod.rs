//! Who may do what: tenants, scopes, and the keys that open them.

mod key;
pub mod key_file;
mod scope;
mod signature;
mod tenant;
mod watched_file;

pub use key::{Key, NoKey};
pub use scope::{NoScopes, Scope, Scopes};
pub use signature::Signer;
pub use tenant::{NoTenant, Tenant};
pub use watched_file::{KeyFileError, WatchedFile};

/// What a key opens: whose things, and what may be done with them.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Grant {
    pub tenant: Tenant,
    pub scopes: Scopes,
    /// What the key is called in the log: of one in the database its id, of one in a file its name or its place.
    pub key: String,
}
