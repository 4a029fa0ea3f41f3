//! What the outcome of a running job looks like at first sight.

use bytes::Bytes;

use super::queue::LEASE_MS;
use super::{Heartbeat, Job, Lease, State, Store, StoreError};

/// The stage of a job whose preview has just come.
const STAGE: &str = "preview";

impl Store {
    /// Keeps a preview of the job's outcome until the job ends, tells those who follow it by the stage `preview`, and beats
    /// as [`Store::heartbeat`] does.
    ///
    /// # Errors
    /// What the database said; nothing is kept then.
    pub async fn preview(&self, lease: &Lease, preview: &[u8], fraction: f64) -> Result<Heartbeat, StoreError> {
        let Job { id, attempt, .. } = &lease.job;
        let mut transaction = self.pool.begin().await?;
        let sql = "UPDATE jobs SET revision = revision + 1, stage = $3, fraction = $4, \
                   lease_ms = (SELECT now_ms FROM clock) + $5 WHERE id = $1 AND attempt = $2 AND state = 'running'";
        let query = sqlx::query(sql).bind(id).bind(attempt).bind(STAGE).bind(fraction.clamp(0.0, 1.0)).bind(LEASE_MS);
        if query.execute(&mut *transaction).await?.rows_affected() == 0 {
            drop(transaction);
            return self.ended(lease).await;
        }
        let sql = "INSERT INTO previews (job, attempt, body) VALUES ($1, $2, $3) \
                   ON CONFLICT (job) DO UPDATE SET attempt = excluded.attempt, body = excluded.body";
        sqlx::query(sql).bind(id).bind(attempt).bind(preview).execute(&mut *transaction).await?;
        transaction.commit().await?;
        self.changes.tell_of_job(id, Some(State::Running));
        Ok(Heartbeat::Held)
    }

    /// The preview of the outcome of a job that runs, once there is one.
    ///
    /// # Errors
    /// What the database said.
    pub async fn previewed(&self, id: &str) -> Result<Option<Bytes>, StoreError> {
        let sql = "SELECT body FROM previews JOIN jobs ON jobs.id = previews.job \
                   AND jobs.attempt = previews.attempt AND jobs.state = 'running' WHERE jobs.id = $1 AND jobs.tenant = $2";
        let body: Option<Vec<u8>> =
            sqlx::query_scalar(sql).bind(id).bind(self.tenant.as_str()).fetch_optional(&self.pool).await?;
        Ok(body.map(Bytes::from))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::store::testing::{ALL, on_every_database};
    use crate::store::{NewJob, Places};

    async fn claimed(store: &Store) -> Lease {
        store.submit(&NewJob::of("match", "{}"), Places { queue: 9, of_kind: 9 }).await.unwrap();
        store.claim(&["match"], ALL).await.unwrap().unwrap()
    }

    #[tokio::test]
    async fn a_preview_is_there_as_long_as_its_attempt_runs() {
        on_every_database(async |_, store| {
            let first = claimed(&store).await;
            let id = &first.job.id;
            assert_eq!(store.previewed(id).await.unwrap(), None);
            assert_eq!(store.preview(&first, b"one", 0.4).await.unwrap(), Heartbeat::Held);
            let job = store.job(id).await.unwrap().unwrap();
            assert_eq!((job.stage.as_deref(), job.fraction), (Some("preview"), 0.4));
            assert!(job.revision > first.job.revision);
            assert_eq!(store.previewed(id).await.unwrap().as_deref(), Some(&b"one"[..]));

            assert!(store.release(&first).await.unwrap());
            assert_eq!(store.previewed(id).await.unwrap(), None);
            let second = store.claim(&["match"], ALL).await.unwrap().unwrap();
            assert_eq!(store.preview(&first, b"late", 0.4).await.unwrap(), Heartbeat::Lost);
            assert_eq!(store.previewed(id).await.unwrap(), None);
            assert_eq!(store.preview(&second, b"two", 0.4).await.unwrap(), Heartbeat::Held);
            assert_eq!(store.previewed(id).await.unwrap().as_deref(), Some(&b"two"[..]));
            assert!(store.succeed(&second, Bytes::from_static(b"{}")).await.unwrap());
            assert_eq!(store.previewed(id).await.unwrap(), None);
            let kept: i64 = sqlx::query_scalar("SELECT count(*) FROM previews").fetch_one(&store.pool).await.unwrap();
            assert_eq!(kept, 0);
        })
        .await;
    }

    #[tokio::test]
    async fn a_cancelled_job_hears_of_it_by_its_preview() {
        on_every_database(async |_, store| {
            let lease = claimed(&store).await;
            store.cancel(&lease.job.id).await.unwrap();
            assert_eq!(store.preview(&lease, b"late", 0.4).await.unwrap(), Heartbeat::Cancelled);
        })
        .await;
    }
}
