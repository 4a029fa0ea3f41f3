use std::collections::BTreeSet;
use std::time::Duration;

use bytes::Bytes;
use serde_json::Value;
use sqlx::AssertSqlSafe;
use uuid::Uuid;

use super::idempotency::MEMORY_MS;
use super::{Beat, Job, JobKind, Lease, Page, State, Store, StoreError, problem};

/// How long a job stays with a worker that does not report.
pub const LEASE: Duration = Duration::from_secs(30);

/// How often a job is tried whose worker dies or asks for another try: often enough that a few deaths of a process do not
/// fail the jobs it happened to run, seldom enough that a job that kills its process does not do so for ever.
pub const MAX_TRIES: i64 = 8;

const LEASE_MS: i64 = LEASE.as_millis() as i64;

impl Store {
    /// Puts a job into the queue, its payload in JSON; an unfinished job with the same `dedupe` is returned instead of a
    /// new one.
    ///
    /// # Errors
    /// What the database said.
    pub async fn submit(&self, kind: JobKind, payload: &str, dedupe: Option<&str>) -> Result<Job, StoreError> {
        let sql = format!(
            "INSERT INTO jobs (id, kind, payload, dedupe, priority, state, created_ms) \
             VALUES ($1, $2, $3, $4, $5, 'queued', (SELECT now_ms FROM clock)) \
             ON CONFLICT (dedupe) WHERE state IN ('queued', 'running') \
             DO UPDATE SET dedupe = excluded.dedupe RETURNING {}",
            Job::COLUMNS
        );
        let query = sqlx::query_as(AssertSqlSafe(sql))
            .bind(Uuid::now_v7().to_string())
            .bind(kind.as_str())
            .bind(payload)
            .bind(dedupe)
            .bind(kind.priority());
        // A RETURNING statement is committed when it is read to its end, which `fetch_one` need not do.
        let jobs: Vec<Job> = query.fetch_all(&self.pool).await?;
        self.announce();
        jobs.into_iter().next().ok_or(StoreError::Database(sqlx::Error::RowNotFound))
    }

    /// Puts a job into the queue, unless one was put there under the same key within the last 24 hours: that one is
    /// returned then, whatever has become of it.
    ///
    /// # Errors
    /// What the database said.
    pub async fn submit_once(&self, kind: JobKind, payload: &str, key: &str) -> Result<Job, StoreError> {
        let insert = "INSERT INTO jobs (id, kind, payload, dedupe, priority, state, created_ms) \
                      SELECT $1, $2, $3, $4, $5, 'queued', now_ms FROM clock \
                      WHERE NOT EXISTS (SELECT 1 FROM jobs WHERE dedupe = $4 AND created_ms > now_ms - $6) \
                      ON CONFLICT (dedupe) WHERE state IN ('queued', 'running') DO NOTHING";
        let query = sqlx::query(insert).bind(Uuid::now_v7().to_string()).bind(kind.as_str()).bind(payload);
        query.bind(key).bind(kind.priority()).bind(MEMORY_MS).execute(&self.pool).await?;
        self.announce();
        let latest =
            format!("SELECT {} FROM jobs WHERE dedupe = $1 ORDER BY created_ms DESC, id DESC LIMIT 1", Job::COLUMNS);
        Ok(sqlx::query_as(AssertSqlSafe(latest)).bind(key).fetch_one(&self.pool).await?)
    }

    /// Number of jobs that wait for a worker.
    ///
    /// # Errors
    /// What the database said.
    pub async fn queued(&self) -> Result<i64, StoreError> {
        Ok(sqlx::query_scalar("SELECT count(*) FROM jobs WHERE state = 'queued'").fetch_one(&self.pool).await?)
    }

    /// The job as it stands, if there is one.
    ///
    /// # Errors
    /// What the database said.
    pub async fn job(&self, id: &str) -> Result<Option<Job>, StoreError> {
        let sql = format!("SELECT {} FROM jobs WHERE id = $1", Job::COLUMNS);
        Ok(sqlx::query_as(AssertSqlSafe(sql)).bind(id).fetch_optional(&self.pool).await?)
    }

    /// Jobs of one kind, newest first.
    ///
    /// # Errors
    /// [`StoreError::Cursor`], or what the database said.
    pub async fn jobs(&self, kind: JobKind, page: &Page) -> Result<Vec<Job>, StoreError> {
        let (created_ms, id) = page.bound()?;
        let sql = format!(
            "SELECT {} FROM jobs WHERE kind = $1 AND (created_ms, id) < ($2, $3) \
             ORDER BY created_ms DESC, id DESC LIMIT $4",
            Job::COLUMNS
        );
        let query = sqlx::query_as(AssertSqlSafe(sql))
            .bind(kind.as_str())
            .bind(created_ms)
            .bind(id)
            .bind(i64::from(page.limit));
        Ok(query.fetch_all(&self.pool).await?)
    }

    /// The first job of the queue, leased to the caller for [`LEASE`]; `None` when nothing waits.
    ///
    /// # Errors
    /// What the database said.
    pub async fn claim(&self) -> Result<Option<Lease>, StoreError> {
        let sql = "UPDATE jobs SET state = 'running', attempt = attempt + 1, tries = tries + 1, \
                   revision = revision + 1, started_ms = (SELECT now_ms FROM clock), \
                   lease_ms = (SELECT now_ms FROM clock) + $1 \
                   WHERE state = 'queued' AND id = (SELECT id FROM jobs WHERE state = 'queued' \
                   ORDER BY priority, created_ms, id LIMIT 1) RETURNING *";
        let leases: Vec<Lease> = sqlx::query_as(sql).bind(LEASE_MS).fetch_all(&self.pool).await?;
        let lease = leases.into_iter().next();
        if lease.is_some() {
            self.announce();
        }
        Ok(lease)
    }

    /// Reports progress, extends the lease and asks whether to go on, all in one.
    ///
    /// # Errors
    /// What the database said; the lease stands as it stood.
    pub async fn beat(&self, lease: &Lease, stage: &str, fraction: f64) -> Result<Beat, StoreError> {
        // The column takes numbers only.
        let fraction = if fraction.is_nan() { 0.0 } else { fraction.clamp(0.0, 1.0) };
        let sql = "UPDATE jobs SET revision = revision + CASE WHEN stage = $3 AND fraction = $4 THEN 0 ELSE 1 END, \
                   stage = $3, fraction = $4, lease_ms = (SELECT now_ms FROM clock) + $5 \
                   WHERE id = $1 AND attempt = $2 AND state = 'running'";
        let Job { id, attempt, .. } = &lease.job;
        let query = sqlx::query(sql).bind(id).bind(attempt).bind(stage).bind(fraction).bind(LEASE_MS);
        if query.execute(&self.pool).await?.rows_affected() == 1 {
            self.announce();
            return Ok(Beat::Held);
        }
        let ended = self.job(id).await?.filter(|job| job.attempt == *attempt).map(|job| job.state);
        Ok(if ended == Some(State::Cancelled) { Beat::Cancelled } else { Beat::Lost })
    }

    /// Publishes the result and ends the job; false, and nothing published, when the lease was lost.
    ///
    /// # Errors
    /// What the disk or the database said; the job is then still running.
    pub async fn succeed(&self, lease: &Lease, result: Bytes) -> Result<bool, StoreError> {
        let Job { id, attempt, .. } = &lease.job;
        let name = format!("results/{id}/{attempt}");
        self.blobs.put(&name, result).await?;
        let sql = "UPDATE jobs SET state = 'succeeded', result = $3, stage = 'finished', fraction = 1, \
                   revision = revision + 1, lease_ms = NULL, finished_ms = (SELECT now_ms FROM clock) \
                   WHERE id = $1 AND attempt = $2 AND state = 'running'";
        let published = self.changed(sqlx::query(sql).bind(id).bind(attempt).bind(&name)).await?;
        // A lease that published before is refused too, but then the job names this very blob.
        let named = "SELECT id FROM jobs WHERE id = $1 AND result = $2";
        if !published && sqlx::query(named).bind(id).bind(&name).fetch_optional(&self.pool).await?.is_none() {
            self.blobs.delete(&name).await?;
        }
        Ok(published)
    }

    /// Ends the job with an error, or with `retry` puts it back into the queue as long as it has tries left; false
    /// when the lease was lost.
    ///
    /// # Errors
    /// What the database said; the job is then still running.
    pub async fn fail(&self, lease: &Lease, error: &Value, retry: bool) -> Result<bool, StoreError> {
        if retry && self.requeue(lease, 0, MAX_TRIES).await? {
            return Ok(true);
        }
        let sql = "UPDATE jobs SET state = 'failed', error = $3, revision = revision + 1, lease_ms = NULL, \
                   finished_ms = (SELECT now_ms FROM clock) WHERE id = $1 AND attempt = $2 AND state = 'running'";
        self.changed(sqlx::query(sql).bind(&lease.job.id).bind(lease.job.attempt).bind(error.to_string())).await
    }

    /// Gives the job back unfinished without using up a try: for a worker that is told to stop. False when the lease
    /// was lost.
    ///
    /// # Errors
    /// What the database said; the lease then runs out by itself.
    pub async fn release(&self, lease: &Lease) -> Result<bool, StoreError> {
        self.requeue(lease, 1, i64::MAX).await
    }

    /// Puts a leased job back, with some tries given back, if it has used up fewer than `limit`.
    async fn requeue(&self, lease: &Lease, given_back: i64, limit: i64) -> Result<bool, StoreError> {
        let sql = "UPDATE jobs SET state = 'queued', tries = tries - $3, revision = revision + 1, stage = NULL, \
                   fraction = 0, started_ms = NULL, lease_ms = NULL \
                   WHERE id = $1 AND attempt = $2 AND state = 'running' AND tries < $4";
        let query = sqlx::query(sql).bind(&lease.job.id).bind(lease.job.attempt);
        self.changed(query.bind(given_back).bind(limit)).await
    }

    /// Cancels a job that has not ended and returns it as it now stands; whoever works on it is told at its next beat.
    ///
    /// # Errors
    /// What the database said.
    pub async fn cancel(&self, id: &str) -> Result<Option<Job>, StoreError> {
        let sql = "UPDATE jobs SET state = 'cancelled', revision = revision + 1, lease_ms = NULL, \
                   finished_ms = (SELECT now_ms FROM clock) WHERE id = $1 AND state IN ('queued', 'running')";
        self.changed(sqlx::query(sql).bind(id)).await?;
        self.job(id).await
    }

    /// Forgets a finished job and its result; false when there is no such job or it has not ended.
    ///
    /// # Errors
    /// What the database or the disk said.
    pub async fn delete(&self, id: &str) -> Result<bool, StoreError> {
        let sql = "DELETE FROM jobs WHERE id = $1 AND state IN ('succeeded', 'failed', 'cancelled') RETURNING result";
        let results: Vec<Option<String>> = sqlx::query_scalar(sql).bind(id).fetch_all(&self.pool).await?;
        for name in results.iter().flatten() {
            self.blobs.delete(name).await?;
        }
        if !results.is_empty() {
            self.announce();
        }
        Ok(!results.is_empty())
    }

    /// The result of a job that succeeded.
    ///
    /// # Errors
    /// [`StoreError::LostResult`]; what the database or the disk said.
    pub async fn result(&self, id: &str) -> Result<Option<Bytes>, StoreError> {
        let sql = "SELECT result FROM jobs WHERE id = $1 AND result IS NOT NULL";
        let name: Option<String> = sqlx::query_scalar(sql).bind(id).fetch_optional(&self.pool).await?;
        let Some(name) = name else { return Ok(None) };
        let lost = |reason: String| StoreError::LostResult { job: id.to_owned(), reason };
        match self.blobs.read(&name).await {
            Ok(None) => Err(lost(format!("{name} is missing"))),
            Err(StoreError::Damaged { what, reason }) => Err(lost(format!("{what}: {reason}"))),
            read => read,
        }
    }

    /// Takes jobs from workers whose lease ran out: back into the queue, or failed after [`MAX_TRIES`]. Returns how
    /// many.
    ///
    /// # Errors
    /// What the database said.
    pub async fn reap(&self) -> Result<u64, StoreError> {
        self.reap_until(None).await
    }

    /// [`Store::reap`], of every lease: for a process that knows to be the only one.
    pub(super) async fn reap_all(&self) -> Result<u64, StoreError> {
        self.reap_until(Some(i64::MAX)).await
    }

    /// Reaps the leases that end by `end_ms`, by default now.
    async fn reap_until(&self, end_ms: Option<i64>) -> Result<u64, StoreError> {
        let sql = "UPDATE jobs SET revision = revision + 1, lease_ms = NULL, stage = NULL, fraction = 0, \
                   state = CASE WHEN tries < $1 THEN 'queued' ELSE 'failed' END, \
                   error = CASE WHEN tries < $1 THEN NULL ELSE $2 END, \
                   started_ms = CASE WHEN tries < $1 THEN NULL ELSE started_ms END, \
                   finished_ms = CASE WHEN tries < $1 THEN NULL ELSE (SELECT now_ms FROM clock) END \
                   WHERE state = 'running' AND lease_ms <= COALESCE($3, (SELECT now_ms FROM clock))";
        let query = sqlx::query(sql).bind(MAX_TRIES).bind(abandoned().to_string()).bind(end_ms);
        let reaped = query.execute(&self.pool).await?.rows_affected();
        if reaped > 0 {
            self.announce();
        }
        Ok(reaped)
    }

    /// Deletes results that no job names: those of attempts that died between the blob and the row.
    pub(super) async fn sweep_results(&self) -> Result<(), StoreError> {
        let sql = "SELECT result FROM jobs WHERE result IS NOT NULL";
        let named: Vec<String> = sqlx::query_scalar(sql).fetch_all(&self.pool).await?;
        let named: BTreeSet<String> = named.into_iter().collect();
        for name in self.blobs.names("results").await? {
            if !named.contains(&name) {
                self.blobs.delete(&name).await?;
            }
        }
        Ok(())
    }

    /// Carries out a change of at most one job, tells those who wait, and returns whether there was one.
    async fn changed(
        &self,
        query: sqlx::query::Query<'_, sqlx::Any, sqlx::any::AnyArguments>,
    ) -> Result<bool, StoreError> {
        let changed = query.execute(&self.pool).await?.rows_affected() > 0;
        if changed {
            self.announce();
        }
        Ok(changed)
    }
}

fn abandoned() -> Value {
    let detail = format!("the job was tried {MAX_TRIES} times, and each time its process ended before it did");
    problem(500, "Internal Server Error", detail)
}

#[cfg(test)]
mod tests;
