//! What becomes of a job whose process ended before it did.

use serde_json::Value;
use sqlx::AssertSqlSafe;

use super::LEASE_MS;
use super::lease::LONGEST_REST_MS;
use crate::store::{Store, StoreError, problem};

/// How often in a row a job is to blame for the end of its process before it fails. It is where it ran alone, as it does after the first
/// time, and no other job's process has ended since its own did last: where those of others end too, something else ends them.
pub const MAX_BLAMED: i64 = 3;

/// How often the process of a job may end before it does, whatever ends it: so often that a job is not failed whose processes are
/// killed all the time, and seldom enough that of many bad jobs that excuse each other each is over.
pub const MAX_DEATHS: i64 = 20;

impl Store {
    /// Takes jobs from workers whose lease ran out: back into the queue, to run alone then, or failed after [`MAX_BLAMED`] and
    /// [`MAX_DEATHS`]. Returns how many.
    ///
    /// # Errors
    /// What the database said.
    pub async fn reap(&self) -> Result<u64, StoreError> {
        self.reap_until(None).await
    }

    /// [`Store::reap`], of every lease: for a process that knows to be the only one.
    pub(in crate::store) async fn reap_all(&self) -> Result<u64, StoreError> {
        self.reap_until(Some(i64::MAX)).await
    }

    /// Reaps the leases that end by `end_ms`, by default now, and those that end later than any that is given: the clock was set
    /// back since.
    async fn reap_until(&self, end_ms: Option<i64>) -> Result<u64, StoreError> {
        let mut transaction = self.pool.begin().await?;
        // The times of others are those before this statement, or its own where it has come to them before.
        let sql = format!(
            "UPDATE jobs SET state = 'queued', revision = revision + 1, lease_ms = NULL, stage = NULL, fraction = 0, \
             started_ms = NULL, tries = tries - 1, deaths = deaths + 1, died_ms = (SELECT now_ms FROM clock), \
             due_ms = (SELECT now_ms FROM clock) + CASE WHEN deaths = 0 THEN 0 WHEN deaths > 6 THEN {LONGEST_REST_MS} \
             ELSE 1000 << CAST(deaths - 1 AS INTEGER) END, \
             blamed = CASE WHEN deaths > 0 AND NOT EXISTS (SELECT 1 FROM jobs AS others \
             WHERE others.id <> jobs.id AND others.died_ms > jobs.died_ms) \
             AND NOT EXISTS (SELECT 1 FROM jobs AS others WHERE others.id <> jobs.id AND others.state = 'running' \
             AND others.lease_ms <= COALESCE($1, (SELECT now_ms FROM clock))) THEN blamed + 1 ELSE 0 END \
             WHERE state = 'running' AND (lease_ms <= COALESCE($1, (SELECT now_ms FROM clock)) \
             OR lease_ms > (SELECT now_ms FROM clock) + $2)"
        );
        let reaped = sqlx::query(AssertSqlSafe(sql))
            .bind(end_ms)
            .bind(LEASE_MS)
            .execute(&mut *transaction)
            .await?
            .rows_affected();
        if reaped == 0 {
            return Ok(0);
        }
        let sql = "UPDATE jobs SET state = 'failed', error = $3, finished_ms = (SELECT now_ms FROM clock) \
                   WHERE state = 'queued' AND (blamed >= $1 OR deaths >= $2)";
        let query = sqlx::query(sql).bind(MAX_BLAMED).bind(MAX_DEATHS).bind(abandoned().to_string());
        query.execute(&mut *transaction).await?;
        transaction.commit().await?;
        self.changes.tell_of_queue();
        self.changes.tell_of_all_jobs();
        Ok(reaped)
    }
}

fn abandoned() -> Value {
    let detail = "again and again the process that the job was tried in ended before it did, also with no other job beside it: it \
                  takes more memory than there is, or makes the program fail";
    problem(500, "Internal Server Error", detail)
}
