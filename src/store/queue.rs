use std::time::Duration;

use bytes::Bytes;
use serde_json::Value;
use sqlx::{Any, AssertSqlSafe, Transaction};
use uuid::Uuid;

use super::{
    Heartbeat, Job, Lease, NewJob, Page, Places, Room, State, Store, StoreError, Submitted, idempotency, milliseconds,
    problem,
};
use crate::access::Tenant;

/// How long a job stays with a worker that does not report.
pub const LEASE: Duration = Duration::from_secs(30);

/// How often a job is tried that asks for another try.
pub const MAX_TRIES: i64 = 8;

/// How often the process of a job may end before it does. After the first time the job runs alone, so that it takes no other with
/// it and what ends the process is most likely its own doing: seldom enough that it is soon over, often enough that a job is not
/// failed whose process others killed a few times.
pub const MAX_DEATHS: i64 = 6;

pub(super) const LEASE_MS: i64 = LEASE.as_millis() as i64;

/// How long a job rests after its first try; every further try doubles it, up to [`LONGEST_REST`].
const FIRST_REST: Duration = Duration::from_secs(1);

const LONGEST_REST: Duration = Duration::from_secs(60);

/// Rest after so many tries.
fn rest(tries: i64) -> Duration {
    let doublings = u32::try_from(tries - 1).unwrap_or(0).min(16);
    FIRST_REST.saturating_mul(1 << doublings).min(LONGEST_REST)
}

impl Store {
    /// Puts a job into the queue, if there is a place for it: of many that come at the same moment no more are taken than
    /// there are places.
    ///
    /// # Errors
    /// What the database said.
    pub async fn submit(&self, job: &NewJob<'_>, places: Places) -> Result<Submitted, StoreError> {
        let mut transaction = self.engine.alone(&self.pool).await?;
        let submitted = enqueue(&mut transaction, &self.tenant, job, places).await?;
        transaction.commit().await?;
        if matches!(submitted, Submitted::Taken(_)) {
            self.changes.tell_of_queue();
        }
        Ok(submitted)
    }

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

    /// The job as it stands, if there is one.
    ///
    /// # Errors
    /// What the database said.
    pub async fn job(&self, id: &str) -> Result<Option<Job>, StoreError> {
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

    /// The first job that waits of the first of `kinds` that has one, leased to the caller for [`LEASE`]; `None` when
    /// nothing waits that may be taken, or where there is no room for the one whose turn it is: others do not overtake it, or
    /// it would wait for ever.
    ///
    /// # Errors
    /// What the database said.
    pub async fn claim(&self, kinds: &[&str], room: Room) -> Result<Option<Lease>, StoreError> {
        let sql = format!(
            "UPDATE jobs SET state = 'running', attempt = attempt + 1, tries = tries + 1, \
             revision = revision + 1, started_ms = (SELECT now_ms FROM clock), \
             lease_ms = (SELECT now_ms FROM clock) + $1 \
             WHERE state = 'queued' AND ($3 OR (memory <= $4 AND deaths = 0)) \
             AND id = (SELECT id FROM jobs WHERE state = 'queued' AND kind = $2 \
             AND due_ms <= (SELECT now_ms FROM clock) ORDER BY created_ms, id LIMIT 1 {}) \
             RETURNING {}, payload, tries, memory, deaths",
            self.engine.for_update(),
            Job::COLUMNS
        );
        let memory = i64::try_from(room.memory).unwrap_or(i64::MAX);
        for kind in kinds {
            let query = sqlx::query_as(AssertSqlSafe(sql.clone())).bind(LEASE_MS).bind(*kind);
            // A RETURNING statement is committed when it is read to its end, which `fetch_one` need not do.
            let leases: Vec<Lease> = query.bind(room.alone).bind(memory).fetch_all(&self.pool).await?;
            if let Some(lease) = leases.into_iter().next() {
                self.changes.tell_of_job(&lease.job.id, Some(State::Running));
                return Ok(Some(lease));
            }
            if !room.alone && self.is_due(kind).await? {
                return Ok(None);
            }
        }
        Ok(None)
    }

    /// Whether a job of this kind waits that may be taken.
    async fn is_due(&self, kind: &str) -> Result<bool, StoreError> {
        let sql =
            "SELECT id FROM jobs WHERE state = 'queued' AND kind = $1 AND due_ms <= (SELECT now_ms FROM clock) LIMIT 1";
        Ok(sqlx::query(sql).bind(kind).fetch_optional(&self.pool).await?.is_some())
    }

    /// Reports progress, extends the lease and asks whether to go on, all in one.
    ///
    /// # Errors
    /// What the database said; the lease stands as it stood.
    pub async fn heartbeat(&self, lease: &Lease, stage: &str, fraction: f64) -> Result<Heartbeat, StoreError> {
        // The column takes numbers only.
        let fraction = if fraction.is_nan() { 0.0 } else { fraction.clamp(0.0, 1.0) };
        let sql = "UPDATE jobs SET revision = revision + CASE WHEN stage = $3 AND fraction = $4 THEN 0 ELSE 1 END, \
                   stage = $3, fraction = $4, lease_ms = (SELECT now_ms FROM clock) + $5 \
                   WHERE id = $1 AND attempt = $2 AND state = 'running'";
        let Job { id, attempt, .. } = &lease.job;
        let query = sqlx::query(sql).bind(id).bind(attempt).bind(stage).bind(fraction).bind(LEASE_MS);
        if query.execute(&self.pool).await?.rows_affected() == 1 {
            self.changes.tell_of_job(id, Some(State::Running));
            return Ok(Heartbeat::Held);
        }
        self.ended(lease).await
    }

    /// Why an attempt no longer holds its job.
    pub(super) async fn ended(&self, lease: &Lease) -> Result<Heartbeat, StoreError> {
        let ended = self
            .of(&lease.job.tenant)
            .job(&lease.job.id)
            .await?
            .filter(|job| job.attempt == lease.job.attempt)
            .map(|job| job.state);
        Ok(if ended == Some(State::Cancelled) { Heartbeat::Cancelled } else { Heartbeat::Lost })
    }

    /// Publishes the result and ends the job; false, and nothing published, when the lease was lost.
    ///
    /// # Errors
    /// What the disk or the database said; the job is then still running.
    pub async fn succeed(&self, lease: &Lease, result: Bytes) -> Result<bool, StoreError> {
        let Job { id, attempt, .. } = &lease.job;
        let (name, bytes) = (format!("results/{id}/{attempt}"), i64::try_from(result.len()).unwrap_or(i64::MAX));
        self.blobs.put_once(&name, result).await?;
        let sql = "UPDATE jobs SET state = 'succeeded', result = $3, bytes = $4, stage = 'finished', fraction = 1, \
                   revision = revision + 1, lease_ms = NULL, finished_ms = (SELECT now_ms FROM clock) \
                   WHERE id = $1 AND attempt = $2 AND state = 'running'";
        let query = sqlx::query(sql).bind(id).bind(attempt).bind(&name).bind(bytes);
        let published = self.changed(id, State::Succeeded, query).await?;
        // A lease that published before is refused too, but then the job names this very blob.
        if !published && !self.names_result(id, &name).await? {
            self.blobs.delete(&name).await?;
        }
        Ok(published)
    }

    /// Whether this blob is the result of the job.
    async fn names_result(&self, id: &str, blob: &str) -> Result<bool, StoreError> {
        let sql = "SELECT count(*) FROM jobs WHERE id = $1 AND result = $2";
        Ok(sqlx::query_scalar::<_, i64>(sql).bind(id).bind(blob).fetch_one(&self.pool).await? > 0)
    }

    /// Ends the job with an error; false when the lease was lost.
    ///
    /// # Errors
    /// What the database said; the job is then still running.
    pub async fn fail(&self, lease: &Lease, error: &Value) -> Result<bool, StoreError> {
        let sql = "UPDATE jobs SET state = 'failed', error = $3, revision = revision + 1, lease_ms = NULL, \
                   finished_ms = (SELECT now_ms FROM clock) WHERE id = $1 AND attempt = $2 AND state = 'running'";
        let Job { id, attempt, .. } = &lease.job;
        self.changed(id, State::Failed, sqlx::query(sql).bind(id).bind(attempt).bind(error.to_string())).await
    }

    /// Puts the job back into the queue after a try that failed, to rest longer after every one; ends it with the error
    /// when it has no tries left. What state it is in now; nothing when the lease was lost.
    ///
    /// # Errors
    /// What the database said; the job is then still running.
    pub async fn retry(&self, lease: &Lease, error: &Value) -> Result<Option<State>, StoreError> {
        let requeue = Requeue { given_back: 0, limit: MAX_TRIES, rest: rest(lease.tries) };
        if self.requeue(lease, requeue).await? {
            return Ok(Some(State::Queued));
        }
        Ok(self.fail(lease, error).await?.then_some(State::Failed))
    }

    /// Gives the job back unfinished without using up a try: for a worker that is told to stop. False when the lease
    /// was lost.
    ///
    /// # Errors
    /// What the database said; the lease then runs out by itself.
    pub async fn release(&self, lease: &Lease) -> Result<bool, StoreError> {
        self.requeue(lease, Requeue { given_back: 1, limit: i64::MAX, rest: Duration::ZERO }).await
    }

    /// Gives the job back as [`release`](Self::release) does, to rest longer the more often it was claimed: for a
    /// process that lacks what it takes.
    ///
    /// # Errors
    /// What the database said; the lease then runs out by itself.
    pub async fn postpone(&self, lease: &Lease) -> Result<bool, StoreError> {
        self.requeue(lease, Requeue { given_back: 1, limit: i64::MAX, rest: rest(lease.job.attempt) }).await
    }

    async fn requeue(&self, lease: &Lease, requeue: Requeue) -> Result<bool, StoreError> {
        let sql = "UPDATE jobs SET state = 'queued', tries = tries - $3, revision = revision + 1, stage = NULL, \
                   fraction = 0, started_ms = NULL, lease_ms = NULL, due_ms = (SELECT now_ms FROM clock) + $5 \
                   WHERE id = $1 AND attempt = $2 AND state = 'running' AND tries < $4";
        let Job { id, attempt, .. } = &lease.job;
        let query = sqlx::query(sql).bind(id).bind(attempt).bind(requeue.given_back).bind(requeue.limit);
        self.changed(id, State::Queued, query.bind(milliseconds(requeue.rest))).await
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

    /// Takes jobs from workers whose lease ran out: back into the queue, to run alone then, or failed after [`MAX_DEATHS`].
    /// Returns how many.
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
        let sql = "UPDATE jobs SET revision = revision + 1, lease_ms = NULL, stage = NULL, fraction = 0, deaths = deaths + 1, \
                   state = CASE WHEN deaths + 1 < $1 THEN 'queued' ELSE 'failed' END, \
                   error = CASE WHEN deaths + 1 < $1 THEN NULL ELSE $2 END, \
                   started_ms = CASE WHEN deaths + 1 < $1 THEN NULL ELSE started_ms END, \
                   finished_ms = CASE WHEN deaths + 1 < $1 THEN NULL ELSE (SELECT now_ms FROM clock) END \
                   WHERE state = 'running' AND lease_ms <= COALESCE($3, (SELECT now_ms FROM clock))";
        let query = sqlx::query(sql).bind(MAX_DEATHS).bind(abandoned().to_string()).bind(end_ms);
        let reaped = query.execute(&self.pool).await?.rows_affected();
        if reaped > 0 {
            self.changes.tell_of_queue();
            self.changes.tell_of_all_jobs();
        }
        Ok(reaped)
    }

    /// Carries out a change of one job to `state`, which ends its preview, tells those who wait, and returns whether there was
    /// one.
    async fn changed(
        &self,
        id: &str,
        state: State,
        query: sqlx::query::Query<'_, sqlx::Any, sqlx::any::AnyArguments>,
    ) -> Result<bool, StoreError> {
        let mut transaction = self.pool.begin().await?;
        let changed = query.execute(&mut *transaction).await?.rows_affected() > 0;
        if changed {
            sqlx::query("DELETE FROM previews WHERE job = $1").bind(id).execute(&mut *transaction).await?;
            transaction.commit().await?;
            self.changes.tell_of_job(id, Some(state));
            self.changes.tell_of_queue();
        }
        Ok(changed)
    }
}

/// Puts a job into the queue, if there is a place for it and the shapes it needs are there. The transaction is
/// [`alone`](super::database::Engine::alone), as is that of whoever deletes a shape.
pub(super) async fn enqueue(
    transaction: &mut Transaction<'_, Any>,
    tenant: &Tenant,
    job: &NewJob<'_>,
    places: Places,
) -> Result<Submitted, StoreError> {
    let NewJob { kind, payload, mesh, sketch, name, dedupe, taken_for, bytes_per_vertex } = *job;
    let (id, taken_ms) = (Uuid::now_v7().to_string(), milliseconds(taken_for));
    let dedupe = dedupe.map(|name| tenant.own(name));
    let insert = "INSERT INTO jobs (id, kind, payload, dedupe, mesh, sketch, name, tenant, state, created_ms, memory) \
                  SELECT $1, $2, $3, $4, $5, $6, $10, $11, 'queued', now_ms, \
                  $12 * COALESCE((SELECT max(matched) FROM shapes WHERE id IN ($5, $6)), 0) FROM clock \
                  WHERE (SELECT count(*) FROM jobs WHERE state = 'queued') < $7 \
                  AND (SELECT count(*) FROM jobs WHERE state = 'queued' AND kind = $2) < $8 \
                  AND ($5 IS NULL OR EXISTS (SELECT 1 FROM shapes WHERE id = $5 AND tenant = $11)) \
                  AND ($6 IS NULL OR EXISTS (SELECT 1 FROM shapes WHERE id = $6 AND tenant = $11)) \
                  AND NOT EXISTS (SELECT 1 FROM jobs WHERE dedupe = $4 AND created_ms > now_ms - $9) \
                  ON CONFLICT (dedupe) WHERE state IN ('queued', 'running') DO NOTHING";
    let count = |places: usize| i64::try_from(places).unwrap_or(i64::MAX);
    let query = sqlx::query(insert).bind(&id).bind(kind).bind(payload).bind(&dedupe).bind(mesh).bind(sketch);
    let query = query.bind(count(places.queue)).bind(count(places.of_kind)).bind(taken_ms).bind(name);
    let query = query.bind(tenant.as_str()).bind(count(bytes_per_vertex));
    if query.execute(&mut **transaction).await?.rows_affected() == 1 {
        let sql = format!("SELECT {} FROM jobs WHERE id = $1", Job::COLUMNS);
        let job = sqlx::query_as(AssertSqlSafe(sql)).bind(&id).fetch_one(&mut **transaction).await?;
        let used = "UPDATE shapes SET used_ms = (SELECT now_ms FROM clock) WHERE id = $1 OR id = $2";
        sqlx::query(used).bind(mesh).bind(sketch).execute(&mut **transaction).await?;
        return Ok(Submitted::Taken(Box::new(job)));
    }
    if let Some(dedupe) = &dedupe
        && let Some(same) = named(transaction, dedupe, taken_ms).await?
    {
        return Ok(Submitted::Taken(Box::new(same)));
    }
    let there = "SELECT count(*) FROM clock WHERE ($1 IS NULL OR EXISTS (SELECT 1 FROM shapes WHERE id = $1 AND tenant = $3)) \
                 AND ($2 IS NULL OR EXISTS (SELECT 1 FROM shapes WHERE id = $2 AND tenant = $3))";
    let there = sqlx::query_scalar::<_, i64>(there).bind(mesh).bind(sketch).bind(tenant.as_str());
    let there = there.fetch_one(&mut **transaction).await?;
    Ok(if there == 1 { Submitted::Full } else { Submitted::Gone })
}

/// The job of this name that is unfinished or younger than `taken_ms`.
async fn named(transaction: &mut Transaction<'_, Any>, dedupe: &str, taken_ms: i64) -> Result<Option<Job>, StoreError> {
    let sql = format!(
        "SELECT {} FROM jobs WHERE dedupe = $1 \
         AND (state IN ('queued', 'running') OR created_ms > (SELECT now_ms FROM clock) - $2) \
         ORDER BY created_ms DESC, id DESC LIMIT 1",
        Job::COLUMNS
    );
    let query = sqlx::query_as(AssertSqlSafe(sql)).bind(dedupe).bind(taken_ms);
    Ok(query.fetch_optional(&mut **transaction).await?)
}

/// How a job goes back into the queue: with some tries given back, if it has used up fewer than `limit`, to rest before
/// it is taken again.
struct Requeue {
    given_back: i64,
    limit: i64,
    rest: Duration,
}

fn abandoned() -> Value {
    let alone = MAX_DEATHS - 1;
    let detail = format!(
        "the job was tried {MAX_DEATHS} times, {alone} of them with no other beside it, and each time its process ended \
         before it did: it takes more memory than there is, or makes the program fail"
    );
    problem(500, "Internal Server Error", detail)
}

#[cfg(test)]
mod tests;
