//! Jobs as they are read, cancelled and deleted; beside it how they come into the queue, who has them, and what becomes of those
//! whose process ended.

mod deaths;
mod lease;
mod submission;

use std::time::Duration;

use bytes::Bytes;
use sqlx::AssertSqlSafe;

use super::measures::{Operation, timed};
use super::{Job, Page, State, Store, StoreError, idempotency, is_text, milliseconds};
pub(super) use lease::LEASE_MS;
pub use lease::{LEASE, MAX_TRIES};
pub(super) use submission::enqueue;

impl Store {
    /// What a job does, in JSON, if there is such a job.
    ///
    /// # Errors
    /// What the database said.
    pub async fn payload(&self, id: &str) -> Result<Option<String>, StoreError> {
        let sql = "SELECT payload FROM jobs WHERE id = $1 AND tenant = $2";
        Ok(sqlx::query_scalar(sql).bind(id).bind(self.tenant.as_str()).fetch_optional(&self.pool).await?)
    }

    /// Why the latest job of this name failed, if it did so within `lately`.
    ///
    /// # Errors
    /// What the database said.
    pub async fn late_failure(&self, dedupe: &str, lately: Duration) -> Result<Option<Job>, StoreError> {
        let sql = format!(
            "SELECT {} FROM jobs WHERE id = (SELECT id FROM jobs WHERE dedupe = $1 ORDER BY created_ms DESC, id DESC LIMIT 1) \
             AND state = 'failed' AND finished_ms > (SELECT now_ms FROM clock) - $2",
            Job::COLUMNS
        );
        let query = sqlx::query_as(AssertSqlSafe(sql)).bind(self.tenant.own(dedupe)).bind(milliseconds(lately));
        Ok(query.fetch_optional(&self.pool).await?)
    }

    /// Number of jobs of a kind that wait for a worker, whose they are.
    ///
    /// # Errors
    /// What the database said.
    pub async fn queued(&self, kind: &str) -> Result<i64, StoreError> {
        let sql = "SELECT count(*) FROM jobs WHERE state = 'queued' AND kind = $1";
        Ok(sqlx::query_scalar(sql).bind(kind).fetch_one(&self.pool).await?)
    }

    /// How long the one that waits longest of the jobs of a kind has waited, whose they are; nothing where none waits.
    ///
    /// # Errors
    /// What the database said.
    pub async fn longest_wait(&self, kind: &str) -> Result<Duration, StoreError> {
        let sql = "SELECT COALESCE((SELECT now_ms FROM clock) - min(created_ms), 0) FROM jobs WHERE state = 'queued' AND kind = $1";
        let ms: i64 = sqlx::query_scalar(sql).bind(kind).fetch_one(&self.pool).await?;
        Ok(Duration::from_millis(u64::try_from(ms).unwrap_or(0)))
    }

    /// The job as it stands, if there is one.
    ///
    /// # Errors
    /// What the database said.
    pub async fn job(&self, id: &str) -> Result<Option<Job>, StoreError> {
        if !is_text(id) {
            return Ok(None);
        }
        let sql = format!("SELECT {} FROM jobs WHERE id = $1 AND tenant = $2", Job::COLUMNS);
        Ok(sqlx::query_as(AssertSqlSafe(sql)).bind(id).bind(self.tenant.as_str()).fetch_optional(&self.pool).await?)
    }

    /// Jobs of one kind, newest first.
    ///
    /// # Errors
    /// [`StoreError::Cursor`], or what the database said.
    pub async fn jobs(&self, kind: &str, page: &Page) -> Result<Vec<Job>, StoreError> {
        let (created_ms, id) = page.bound()?;
        let sql = format!(
            "SELECT {} FROM jobs WHERE tenant = $5 AND kind = $1 AND (created_ms, id) < ($2, $3) \
             ORDER BY created_ms DESC, id DESC LIMIT $4",
            Job::COLUMNS
        );
        let query = sqlx::query_as(AssertSqlSafe(sql)).bind(kind).bind(created_ms).bind(id).bind(i64::from(page.limit));
        let query = query.bind(self.tenant.as_str());
        Ok(query.fetch_all(&self.pool).await?)
    }

    /// Cancels a job that has not ended and returns it as it now stands; whoever works on it is told at once, in another
    /// process at its next beat.
    ///
    /// # Errors
    /// What the database said.
    pub async fn cancel(&self, id: &str) -> Result<Option<Job>, StoreError> {
        let sql = "UPDATE jobs SET state = 'cancelled', revision = revision + 1, lease_ms = NULL, \
                   finished_ms = (SELECT now_ms FROM clock) \
                   WHERE id = $1 AND tenant = $2 AND state IN ('queued', 'running')";
        self.changed(id, State::Cancelled, sqlx::query(sql).bind(id).bind(self.tenant.as_str())).await?;
        self.job(id).await
    }

    /// Forgets a finished job, its result and the answers under a key that name it; false when there is no such job or it has not ended.
    ///
    /// # Errors
    /// What the database or the disk said.
    pub async fn delete(&self, id: &str) -> Result<bool, StoreError> {
        let sql = "DELETE FROM jobs WHERE id = $1 AND tenant = $2 AND state IN ('succeeded', 'failed', 'cancelled') \
                   RETURNING result";
        let mut transaction = self.pool.begin().await?;
        let results: Vec<Option<String>> =
            sqlx::query_scalar(sql).bind(id).bind(self.tenant.as_str()).fetch_all(&mut *transaction).await?;
        if results.is_empty() {
            return Ok(false);
        }
        idempotency::forget(&mut transaction, id).await?;
        transaction.commit().await?;
        for name in results.iter().flatten() {
            self.blobs.delete(name).await?;
        }
        self.changes.tell_of_job(id, None);
        Ok(true)
    }

    /// The result of a job that succeeded.
    ///
    /// # Errors
    /// [`StoreError::LostResult`]; what the database or the disk said.
    pub async fn result(&self, id: &str) -> Result<Option<Bytes>, StoreError> {
        let sql = "SELECT result FROM jobs WHERE id = $1 AND tenant = $2 AND result IS NOT NULL";
        let name: Option<String> =
            sqlx::query_scalar(sql).bind(id).bind(self.tenant.as_str()).fetch_optional(&self.pool).await?;
        let Some(name) = name else { return Ok(None) };
        let lost = |reason: String| StoreError::LostResult { job: id.to_owned(), reason };
        match self.blobs.read(&name).await {
            // It was let go of since its name was read.
            Ok(None) if !self.names_result(id, &name).await? => Ok(None),
            Ok(None) => Err(lost(format!("{name} is missing"))),
            Err(StoreError::Damaged { what, reason }) => Err(lost(format!("{what}: {reason}"))),
            read => read,
        }
    }

    /// Whether this blob is the result of the job.
    async fn names_result(&self, id: &str, blob: &str) -> Result<bool, StoreError> {
        let sql = "SELECT count(*) FROM jobs WHERE id = $1 AND result = $2";
        Ok(sqlx::query_scalar::<_, i64>(sql).bind(id).bind(blob).fetch_one(&self.pool).await? > 0)
    }

    /// Carries out a change of one job to `state`, which ends its preview, tells those who wait, and returns whether there was
    /// one.
    async fn changed(
        &self,
        id: &str,
        state: State,
        query: sqlx::query::Query<'_, sqlx::Any, sqlx::any::AnyArguments>,
    ) -> Result<bool, StoreError> {
        let changing = async {
            let mut transaction = self.pool.begin().await?;
            let changed = query.execute(&mut *transaction).await?.rows_affected() > 0;
            if changed {
                sqlx::query("DELETE FROM previews WHERE job = $1").bind(id).execute(&mut *transaction).await?;
                transaction.commit().await?;
            }
            Ok::<_, StoreError>(changed)
        };
        let changed = timed(Operation::Change, changing).await?;
        if changed {
            self.changes.tell_of_job(id, Some(state));
            self.changes.tell_of_queue();
        }
        Ok(changed)
    }
}

#[cfg(test)]
mod tests;
