use std::collections::HashMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, Weak};
use std::time::Duration;

use sqlx::{Any, Row, Transaction};
use tokio::sync::OwnedMutexGuard;
use tokio::time::sleep;

use super::{Claim, Store, StoreError};

/// How long an answer is remembered.
pub const MEMORY: Duration = Duration::from_secs(24 * 60 * 60);

/// How often a request whose key is in use at another node looks again.
const PATIENCE: Duration = Duration::from_millis(50);

/// The keys under which requests are being carried out.
#[derive(Default)]
pub(super) struct Turns(Mutex<HashMap<String, Weak<tokio::sync::Mutex<()>>>>);

impl Turns {
    fn keys(&self) -> MutexGuard<'_, HashMap<String, Weak<tokio::sync::Mutex<()>>>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// The right to be the only one to carry out a request under a key; it ends when it is dropped.
pub struct Turn {
    turns: Arc<Turns>,
    key: String,
    guard: Option<OwnedMutexGuard<()>>,
    _claim: Option<Claim>,
}

impl Drop for Turn {
    fn drop(&mut self) {
        self.guard = None;
        let mut keys = self.turns.keys();
        if keys.get(&self.key).is_some_and(|waiting| waiting.strong_count() == 0) {
            keys.remove(&self.key);
        }
    }
}

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
    /// The turn of a request under this key: one after the other, at whichever node they came, on one node in their order.
    pub async fn turn(&self, key: &str) -> Turn {
        let key = self.tenant.own(key);
        let mutex = {
            let mut keys = self.turns.keys();
            let waiting = keys.entry(key.clone()).or_default();
            waiting.upgrade().unwrap_or_else(|| {
                let mutex = Arc::default();
                *waiting = Arc::downgrade(&mutex);
                mutex
            })
        };
        let guard = Some(mutex.lock_owned().await);
        let _claim = if self.is_shared() { self.turn_of_node(&key).await } else { None };
        Turn { turns: self.turns.clone(), key, guard, _claim }
    }

    /// The claim of the key among all nodes; nothing where the database cannot be asked, as who has the turn finds out next.
    async fn turn_of_node(&self, key: &str) -> Option<Claim> {
        let name = format!("answer/{key}");
        loop {
            match self.take(&name).await {
                Ok(None) => sleep(PATIENCE).await,
                taken => return taken.ok().flatten(),
            }
        }
    }

    /// What was answered to `key` within the last 24 hours; `fingerprint` tells one request from another.
    ///
    /// # Errors
    /// What the database said.
    pub async fn remembered(&self, key: &str, fingerprint: &str) -> Result<Remembered, StoreError> {
        let sql = "SELECT fingerprint, status, location, body FROM answers \
                   WHERE key = $1 AND expires_ms > (SELECT now_ms FROM clock)";
        let Some(row) = sqlx::query(sql).bind(self.tenant.own(key)).fetch_optional(&self.pool).await? else {
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

    /// Keeps an answer for 24 hours, unless one is there: the first of two equal requests is the one remembered. It is
    /// forgotten with the `resource` it names.
    ///
    /// # Errors
    /// What the database said.
    pub async fn remember(
        &self,
        key: &str,
        fingerprint: &str,
        status: u16,
        location: Option<&str>,
        body: &[u8],
    ) -> Result<(), StoreError> {
        let resource = location.and_then(|location| location.rsplit('/').next());
        sqlx::query("DELETE FROM answers WHERE expires_ms <= (SELECT now_ms FROM clock)").execute(&self.pool).await?;
        let sql = "INSERT INTO answers (key, fingerprint, status, location, body, expires_ms, resource) \
                   VALUES ($1, $2, $3, $4, $5, (SELECT now_ms FROM clock) + $6, $7) \
                   ON CONFLICT (key) DO NOTHING";
        sqlx::query(sql)
            .bind(self.tenant.own(key))
            .bind(fingerprint)
            .bind(i64::from(status))
            .bind(location)
            .bind(body)
            .bind(i64::try_from(MEMORY.as_millis()).unwrap_or(i64::MAX))
            .bind(resource)
            .execute(&self.pool)
            .await?;
        Ok(())
    }
}

/// Forgets the answers that name a resource which is deleted.
pub(super) async fn forget(transaction: &mut Transaction<'_, Any>, resource: &str) -> Result<(), StoreError> {
    let sql = "DELETE FROM answers WHERE resource = $1";
    sqlx::query(sql).bind(resource).execute(&mut **transaction).await?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use futures::FutureExt;

    use super::*;
    use crate::store::testing::{fresh, fresh_shared, on_every_database};

    #[tokio::test]
    async fn the_first_answer_is_remembered_for_its_key_and_request() {
        on_every_database(async |_, store| {
            assert_eq!(store.remembered("k", "f").await.unwrap(), Remembered::New);
            store.remember("k", "f", 202, Some("/there"), b"\xff body").await.unwrap();
            store.remember("k", "f", 500, None, b"late").await.unwrap();
            let same =
                Remembered::Same { status: 202, location: Some("/there".to_owned()), body: b"\xff body".to_vec() };
            assert_eq!(store.remembered("k", "f").await.unwrap(), same);
            assert_eq!(store.remembered("k", "other").await.unwrap(), Remembered::Different);
            assert_eq!(store.remembered("other", "f").await.unwrap(), Remembered::New);
        })
        .await;
    }

    #[tokio::test]
    async fn requests_under_one_key_take_turns() {
        let (_directory, store) = fresh().await;
        let first = store.turn("key").await;
        assert!(store.turn("other").now_or_never().is_some());
        assert!(store.turn("key").now_or_never().is_none());
        drop(first);
        assert!(store.turn("key").now_or_never().is_some());
        assert!(store.turns.keys().is_empty());
    }

    #[tokio::test]
    async fn requests_under_one_key_take_turns_at_two_nodes() {
        let Some((place, store)) = fresh_shared().await else { return };
        let other = place.open().await;
        let first = store.turn("key").await;
        let mut second = Box::pin(other.turn("key"));
        for _ in 0..3 {
            assert!(tokio::time::timeout(PATIENCE, &mut second).await.is_err());
        }
        drop(first);
        second.await;
    }

    #[tokio::test]
    async fn an_answer_is_forgotten_with_what_it_names() {
        on_every_database(async |_, store| {
            store.remember("k", "f", 202, Some("/there/one"), b"").await.unwrap();
            let mut transaction = store.pool.begin().await.unwrap();
            forget(&mut transaction, "other").await.unwrap();
            transaction.commit().await.unwrap();
            assert_ne!(store.remembered("k", "f").await.unwrap(), Remembered::New);
            let mut transaction = store.pool.begin().await.unwrap();
            forget(&mut transaction, "one").await.unwrap();
            transaction.commit().await.unwrap();
            assert_eq!(store.remembered("k", "f").await.unwrap(), Remembered::New);
        })
        .await;
    }

    #[tokio::test]
    async fn an_answer_is_forgotten_after_its_day() {
        on_every_database(async |_, store| {
            store.remember("k", "f", 200, None, b"").await.unwrap();
            sqlx::query("UPDATE answers SET expires_ms = 0").execute(&store.pool).await.unwrap();
            assert_eq!(store.remembered("k", "other").await.unwrap(), Remembered::New);
            store.remember("k", "other", 201, None, b"").await.unwrap();
            let again = store.remembered("k", "other").await.unwrap();
            assert_eq!(again, Remembered::Same { status: 201, location: None, body: Vec::new() });
        })
        .await;
    }
}
