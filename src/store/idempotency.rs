use sqlx::Row;

use super::{Store, StoreError};

/// How long an answer is remembered: 24 hours.
pub(super) const MEMORY_MS: i64 = 24 * 60 * 60 * 1000;

/// What is known of an idempotency key.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Remembered {
    /// Nothing: carry the request out.
    New,
    /// This very request was answered before, so.
    Same { status: u16, location: Option<String>, body: Vec<u8> },
    /// Another request had this key.
    Different,
}

impl Store {
    /// What was answered to `key` on `route` within the last 24 hours; `fingerprint` tells one request from another.
    ///
    /// # Errors
    /// What the database said.
    pub async fn remembered(&self, key: &str, route: &str, fingerprint: &str) -> Result<Remembered, StoreError> {
        let sql = "SELECT fingerprint, status, location, body FROM answers \
                   WHERE key = $1 AND route = $2 AND expires_ms > (SELECT now_ms FROM clock)";
        let Some(row) = sqlx::query(sql).bind(key).bind(route).fetch_optional(&self.pool).await? else {
            return Ok(Remembered::New);
        };
        if row.try_get::<&str, _>("fingerprint")? != fingerprint {
            return Ok(Remembered::Different);
        }
        let status: i64 = row.try_get("status")?;
        Ok(Remembered::Same {
            status: u16::try_from(status).map_err(|error| StoreError::damaged("a remembered answer", error))?,
            location: row.try_get("location")?,
            body: row.try_get("body")?,
        })
    }

    /// Keeps an answer for 24 hours, unless one is there: the first of two equal requests is the one remembered.
    ///
    /// # Errors
    /// What the database said.
    pub async fn remember(
        &self,
        key: &str,
        route: &str,
        fingerprint: &str,
        status: u16,
        location: Option<&str>,
        body: &[u8],
    ) -> Result<(), StoreError> {
        sqlx::query("DELETE FROM answers WHERE expires_ms <= (SELECT now_ms FROM clock)").execute(&self.pool).await?;
        let sql = "INSERT INTO answers (key, route, fingerprint, status, location, body, expires_ms) \
                   VALUES ($1, $2, $3, $4, $5, $6, (SELECT now_ms FROM clock) + $7) \
                   ON CONFLICT (key, route) DO NOTHING";
        sqlx::query(sql)
            .bind(key)
            .bind(route)
            .bind(fingerprint)
            .bind(i64::from(status))
            .bind(location)
            .bind(body)
            .bind(MEMORY_MS)
            .execute(&self.pool)
            .await?;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::store::testing::fresh;

    #[tokio::test]
    async fn the_first_answer_is_remembered_for_its_key_route_and_request() {
        let (_directory, store) = fresh().await;
        assert_eq!(store.remembered("k", "/r", "f").await.unwrap(), Remembered::New);
        store.remember("k", "/r", "f", 202, Some("/there"), b"\xff body").await.unwrap();
        store.remember("k", "/r", "f", 500, None, b"late").await.unwrap();
        let same = Remembered::Same { status: 202, location: Some("/there".to_owned()), body: b"\xff body".to_vec() };
        assert_eq!(store.remembered("k", "/r", "f").await.unwrap(), same);
        assert_eq!(store.remembered("k", "/r", "other").await.unwrap(), Remembered::Different);
        assert_eq!(store.remembered("k", "/other", "f").await.unwrap(), Remembered::New);
        assert_eq!(store.remembered("other", "/r", "f").await.unwrap(), Remembered::New);
    }

    #[tokio::test]
    async fn an_answer_is_forgotten_after_its_day() {
        let (_directory, store) = fresh().await;
        store.remember("k", "/r", "f", 200, None, b"").await.unwrap();
        sqlx::query("UPDATE answers SET expires_ms = 0").execute(&store.pool).await.unwrap();
        assert_eq!(store.remembered("k", "/r", "other").await.unwrap(), Remembered::New);
        store.remember("k", "/r", "other", 201, None, b"").await.unwrap();
        let again = store.remembered("k", "/r", "other").await.unwrap();
        assert_eq!(again, Remembered::Same { status: 201, location: None, body: Vec::new() });
    }
}
