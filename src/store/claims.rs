//! What one of all nodes does at a time: a name in the database, held for as long as its holder lives.

use tokio::runtime::Handle;
use tokio::time::{Instant, MissedTickBehavior, interval_at};
use tokio_util::task::AbortOnDropHandle;
use uuid::Uuid;

use super::{LEASE, Store, StoreError};

const LEASE_MS: i64 = LEASE.as_millis() as i64;

/// The right to be the only one to do something, of all that use the same database. It is given up when it is dropped, and
/// runs out a [`LEASE`] after its process died.
pub struct Claim {
    store: Store,
    name: String,
    holder: String,
    runtime: Handle,
    _beat: AbortOnDropHandle<()>,
}

impl Store {
    /// The claim of this name; nothing while somebody else has it. One that ends later than any that is given runs out too: the
    /// clock was set back since, and whoever lives has extended it within seconds.
    ///
    /// # Errors
    /// What the database said.
    pub async fn take(&self, name: &str) -> Result<Option<Claim>, StoreError> {
        let holder = Uuid::now_v7().to_string();
        let sql = "INSERT INTO claims (name, holder, until_ms) VALUES ($1, $2, (SELECT now_ms FROM clock) + $3) \
                   ON CONFLICT (name) DO UPDATE SET holder = excluded.holder, until_ms = excluded.until_ms \
                   WHERE claims.until_ms <= (SELECT now_ms FROM clock) \
                   OR claims.until_ms > (SELECT now_ms FROM clock) + $3";
        let query = sqlx::query(sql).bind(name).bind(&holder).bind(LEASE_MS);
        if query.execute(&self.pool).await?.rows_affected() == 0 {
            return Ok(None);
        }
        let beat = tokio::spawn(extended(self.clone(), name.to_owned(), holder.clone()));
        let (store, name, runtime) = (self.clone(), name.to_owned(), Handle::current());
        Ok(Some(Claim { store, name, holder, runtime, _beat: AbortOnDropHandle::new(beat) }))
    }

    /// Forgets all claims: for a process that knows to be the only one.
    pub(super) async fn forget_claims(&self) -> Result<(), StoreError> {
        sqlx::query("DELETE FROM claims").execute(&self.pool).await?;
        Ok(())
    }
}

/// Extends a claim for as long as it is held.
async fn extended(store: Store, name: String, holder: String) {
    let mut timer = interval_at(Instant::now() + LEASE / 3, LEASE / 3);
    timer.set_missed_tick_behavior(MissedTickBehavior::Delay);
    loop {
        timer.tick().await;
        let sql = "UPDATE claims SET until_ms = (SELECT now_ms FROM clock) + $3 WHERE name = $1 AND holder = $2";
        if let Err(error) = sqlx::query(sql).bind(&name).bind(&holder).bind(LEASE_MS).execute(&store.pool).await {
            tracing::warn!(%error, name, "a claim cannot be extended");
        }
    }
}

impl Drop for Claim {
    fn drop(&mut self) {
        let (store, name, holder) = (self.store.clone(), self.name.clone(), self.holder.clone());
        self.runtime.spawn(async move {
            let sql = "DELETE FROM claims WHERE name = $1 AND holder = $2";
            // What cannot be given up runs out.
            if let Err(error) = sqlx::query(sql).bind(&name).bind(&holder).execute(&store.pool).await {
                tracing::warn!(%error, name, "a claim cannot be given up");
            }
        });
    }
}

#[cfg(test)]
mod tests {
    use tokio::task::yield_now;

    use super::*;
    use crate::store::testing::on_every_database;

    /// The claim, as soon as whoever dropped it has given it up.
    async fn taken(store: &Store, name: &str) -> Claim {
        loop {
            if let Some(claim) = store.take(name).await.unwrap() {
                return claim;
            }
            yield_now().await;
        }
    }

    #[tokio::test]
    async fn a_claim_is_held_by_one_until_it_is_dropped() {
        on_every_database(async |_, store| {
            let first = store.take("spectrum").await.unwrap();
            assert!(first.is_some() && store.take("spectrum").await.unwrap().is_none());
            assert!(store.take("other").await.unwrap().is_some());
            drop(first);
            taken(&store, "spectrum").await;
        })
        .await;
    }

    #[tokio::test]
    async fn a_claim_whose_holder_died_runs_out_and_its_late_end_takes_nothing_away() {
        on_every_database(async |_, store| {
            let dead = store.take("spectrum").await.unwrap().unwrap();
            sqlx::query("UPDATE claims SET until_ms = 0").execute(&store.pool).await.unwrap();
            let second = store.take("spectrum").await.unwrap();
            assert!(second.is_some());
            drop(dead);
            for _ in 0..100 {
                yield_now().await;
            }
            assert!(store.take("spectrum").await.unwrap().is_none());
        })
        .await;
    }

    #[tokio::test(flavor = "multi_thread", worker_threads = 4)]
    async fn of_many_at_once_one_has_it() {
        on_every_database(async |_, store| {
            let takers: Vec<_> = (0..20)
                .map(|_| {
                    let store = store.clone();
                    tokio::spawn(async move { store.take("spectrum").await.unwrap() })
                })
                .collect();
            let mut held = Vec::new();
            for taker in takers {
                held.extend(taker.await.unwrap());
            }
            assert_eq!(held.len(), 1);
        })
        .await;
    }
}
