use super::{StoreError, is_text};

/// A stretch of a list, newest first.
#[derive(Clone, Debug)]
pub struct Page {
    /// The cursor of the last item before it; `None` for the first stretch.
    pub after: Option<String>,
    /// Number of items at most.
    pub limit: u32,
}

/// Where an item stands in a list: `{created_ms}.{id}`. It stays valid when the item is deleted.
pub(super) fn cursor(created_ms: i64, id: &str) -> String {
    format!("{created_ms}.{id}")
}

impl Page {
    /// The time and id that every item of the page stands before.
    pub(super) fn bound(&self) -> Result<(i64, &str), StoreError> {
        let Some(after) = &self.after else { return Ok((i64::MAX, "")) };
        let (created_ms, id) = after.split_once('.').filter(|(_, id)| is_text(id)).ok_or(StoreError::Cursor)?;
        Ok((created_ms.parse().map_err(|_| StoreError::Cursor)?, id))
    }
}
