//! Warnings as they are kept.

use serde::de::DeserializeOwned;
use serde::{Deserialize, Deserializer};
use serde_json::Value;

/// Warnings of the kinds there are: those stored by an earlier version may be of kinds that are no warnings any more.
pub fn known<'de, D, W>(deserializer: D) -> Result<Vec<W>, D::Error>
where
    D: Deserializer<'de>,
    W: DeserializeOwned,
{
    let stored = Vec::<Value>::deserialize(deserializer)?;
    Ok(stored.into_iter().filter_map(|warning| serde_json::from_value(warning).ok()).collect())
}
