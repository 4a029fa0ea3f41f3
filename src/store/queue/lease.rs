//! The right to work on a job: claimed, extended, given back or used up.

use std::time::Duration;

use bytes::Bytes;
use serde_json::Value;
use sqlx::AssertSqlSafe;

use crate::store::measures::{Operation, timed};
use crate::store::{Heartbeat, Job, Lease, Room, State, Store, StoreError, milliseconds};

/// How long a job stays with a worker that does not report.
pub const LEASE: Duration = Duration::from_secs(30);

/// [`LEASE`] in milliseconds, as the tables have time.
pub(in crate::store) const LEASE_MS: i64 = LEASE.as_millis() as i64;

/// How often a job is tried that asks for another try.
pub const MAX_TRIES: i64 = 8;

/// How long a job rests after its first try; every further try doubles it, up to [`LONGEST_REST`].
const FIRST_REST: Duration = Duration::from_secs(1);

/// How long a job rests at most before it is tried again.
const LONGEST_REST: Duration = Duration::from_secs(60);

/// [`LONGEST_REST`] in milliseconds.
pub(super) const LONGEST_REST_MS: i64 = LONGEST_REST.as_millis() as i64;

/// How long a batch job stands behind those that somebody waits for, before it takes its turn among them.
const LONGEST_BATCH_WAIT_MS: i64 = 3_600_000;

/// How often a node looks again that finds the jobs of the tenant whose turn it is taken by others at the same moment: it is
/// another tenant's turn then.
const LOOKS: usize = 8;

/// Which of `waiting` are of the kind $1 and may be taken now. No rest is longer than the longest: what seems so was begun before
/// the clock was set back.
fn due() -> String {
    format!(
        "waiting.state = 'queued' AND waiting.kind = $1 AND (waiting.due_ms <= (SELECT now_ms FROM clock) \
         OR waiting.due_ms > (SELECT now_ms FROM clock) + {LONGEST_REST_MS})"
    )
}

/// The priority of one of `waiting` now.
fn rank() -> String {
    format!(
        "CASE WHEN waiting.created_ms > (SELECT now_ms FROM clock) - {LONGEST_BATCH_WAIT_MS} THEN waiting.priority ELSE 0 END"
    )
}

/// The tenant whose turn it is of those with jobs of the kind $1 that may be taken.
fn tenant() -> String {
    format!(
        "SELECT tenant FROM (SELECT waiting.tenant, min({}) AS best, min(waiting.created_ms) AS oldest FROM jobs AS waiting \
         WHERE {} GROUP BY waiting.tenant) AS tenants ORDER BY best, (SELECT count(*) FROM jobs AS others \
         WHERE others.tenant = tenants.tenant AND others.state = 'running'), COALESCE((SELECT max(started_ms) FROM jobs AS others \
         WHERE others.tenant = tenants.tenant AND others.started_ms IS NOT NULL), 0), oldest LIMIT 1",
        rank(),
        due()
    )
}

/// Rest after so many tries.
pub(super) fn rest(tries: i64) -> Duration {
    let doublings = u32::try_from(tries - 1).unwrap_or(0).min(16);
    FIRST_REST.saturating_mul(1 << doublings).min(LONGEST_REST)
}

impl Store {
    /// The job whose turn it is of the first of `kinds` that has one, leased to the caller for [`LEASE`]; `None` when nothing
    /// waits that may be taken, or where there is no room for the one whose turn it is: others do not overtake it, or it would
    /// wait for ever.
    ///
    /// Jobs that somebody waits for come before batch jobs, unless these have waited an hour; of tenants the one that has fewest
    /// jobs running, else the one that was served longest ago; of a tenant's jobs the oldest.
    ///
    /// # Errors
    /// What the database said.
    pub async fn claim(&self, kinds: &[&str], room: Room) -> Result<Option<Lease>, StoreError> {
        let sql = format!(
            "UPDATE jobs SET state = 'running', attempt = attempt + 1, tries = tries + 1, \
             revision = revision + 1, started_ms = (SELECT now_ms FROM clock), \
             lease_ms = (SELECT now_ms FROM clock) + $2 \
             WHERE state = 'queued' AND ($3 OR (memory <= $4 AND deaths = 0)) AND id = (SELECT waiting.id \
             FROM jobs AS waiting WHERE {} AND waiting.tenant = ({}) \
             ORDER BY {}, waiting.created_ms, waiting.id LIMIT 1 {}) RETURNING {}, payload, tries, memory, deaths",
            due(),
            tenant(),
            rank(),
            self.engine.for_update_of("waiting"),
            Job::COLUMNS
        );
        let memory = i64::try_from(room.memory).unwrap_or(i64::MAX);
        for kind in kinds {
            for _ in 0..LOOKS {
                let query = sqlx::query_as(AssertSqlSafe(sql.clone())).bind(*kind).bind(LEASE_MS);
                let query = query.bind(room.alone).bind(memory);
                // A RETURNING statement is committed when it is read to its end, which `fetch_one` need not do.
                let leases: Vec<Lease> = timed(Operation::Claim, query.fetch_all(&self.pool)).await?;
                if let Some(lease) = leases.into_iter().next() {
                    self.changes.tell_of_job(&lease.job.id, Some(State::Running));
                    return Ok(Some(lease));
                }
                if !self.is_due(kind).await? {
                    break;
                }
                if !room.alone {
                    return Ok(None);
                }
            }
        }
        Ok(None)
    }

    /// Whether a job of this kind waits that may be taken.
    async fn is_due(&self, kind: &str) -> Result<bool, StoreError> {
        let sql = format!("SELECT waiting.id FROM jobs AS waiting WHERE {} LIMIT 1", due());
        Ok(sqlx::query(AssertSqlSafe(sql)).bind(kind).fetch_optional(&self.pool).await?.is_some())
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
        if timed(Operation::Beat, query.execute(&self.pool)).await?.rows_affected() == 1 {
            self.changes.tell_of_job(id, Some(State::Running));
            return Ok(Heartbeat::Held);
        }
        self.ended(lease).await
    }

    /// Why an attempt no longer holds its job.
    pub(in crate::store) async fn ended(&self, lease: &Lease) -> Result<Heartbeat, StoreError> {
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
}

/// How a job goes back into the queue: with some tries given back, if it has used up fewer than `limit`, to rest before
/// it is taken again.
struct Requeue {
    given_back: i64,
    limit: i64,
    rest: Duration,
}
