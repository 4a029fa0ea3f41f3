//! How a job comes into the queue: once under its name, if there is a place for it and the shapes it needs are there.

use sqlx::{Any, AssertSqlSafe, Transaction};
use uuid::Uuid;

use crate::access::Tenant;
use crate::store::measures::{Operation, timed};
use crate::store::{Job, NewJob, Places, Store, StoreError, Submitted, milliseconds};

impl Store {
    /// Puts a job into the queue, if there is a place for it: of many that come at the same moment no more are taken than
    /// there are places.
    ///
    /// # Errors
    /// What the database said.
    pub async fn submit(&self, job: &NewJob<'_>, places: Places) -> Result<Submitted, StoreError> {
        let taking = async {
            let mut transaction = self.engine.alone(&self.pool).await?;
            let submitted = enqueue(&mut transaction, &self.tenant, job, places).await?;
            transaction.commit().await?;
            Ok::<_, StoreError>(submitted)
        };
        self.told_of(taking).await
    }

    /// Puts jobs into the queue, if there is a place for each of them: all or none.
    ///
    /// # Errors
    /// What the database said.
    pub async fn submit_all(&self, jobs: &[NewJob<'_>], places: Places) -> Result<Submitted<Vec<Job>>, StoreError> {
        let taking = async {
            let mut transaction = self.engine.alone(&self.pool).await?;
            let mut taken = Vec::new();
            for job in jobs {
                let refused = match enqueue(&mut transaction, &self.tenant, job, places).await? {
                    Submitted::Taken(job) => {
                        taken.push(*job);
                        continue;
                    }
                    Submitted::Full => Submitted::Full,
                    Submitted::Gone => Submitted::Gone,
                };
                transaction.rollback().await?;
                return Ok(refused);
            }
            transaction.commit().await?;
            Ok::<_, StoreError>(Submitted::Taken(taken))
        };
        self.told_of(taking).await
    }

    /// What becomes of a submission; of what is taken those are told who wait for jobs.
    async fn told_of<T>(
        &self,
        taking: impl Future<Output = Result<Submitted<T>, StoreError>>,
    ) -> Result<Submitted<T>, StoreError> {
        let submitted = timed(Operation::Submit, taking).await?;
        if matches!(submitted, Submitted::Taken(_)) {
            self.changes.tell_of_queue();
        }
        Ok(submitted)
    }
}

/// Puts a job into the queue, if there is a place for it and the shapes it needs are there. The transaction is
/// [`alone`](crate::store::database::Engine::alone), as is that of whoever deletes a shape.
pub(in crate::store) async fn enqueue(
    transaction: &mut Transaction<'_, Any>,
    tenant: &Tenant,
    job: &NewJob<'_>,
    places: Places,
) -> Result<Submitted, StoreError> {
    let NewJob { kind, payload, mesh, sketch, name, dedupe, taken_for, priority, webhook, trace, .. } = *job;
    let (bytes_per_vertex, bytes_besides) = (job.bytes_per_vertex, job.bytes_besides);
    let (id, taken_ms) = (Uuid::now_v7().to_string(), milliseconds(taken_for));
    let dedupe = dedupe.map(|name| tenant.own(name));
    let insert = "INSERT INTO jobs (id, kind, payload, dedupe, mesh, sketch, name, tenant, state, created_ms, memory, priority, trace) \
                  SELECT $1, $2, $3, $4, $5, $6, $10, $11, 'queued', now_ms, \
                  $12 * COALESCE((SELECT max(COALESCE(NULLIF(matched, 0), vertices)) FROM shapes WHERE id IN ($5, $6)), 0) + $15, $13, $14 FROM clock \
                  WHERE (SELECT count(*) FROM jobs WHERE state = 'queued') < $7 \
                  AND (SELECT count(*) FROM jobs WHERE state = 'queued' AND kind = $2) < $8 \
                  AND ($5 IS NULL OR EXISTS (SELECT 1 FROM shapes WHERE id = $5 AND tenant = $11)) \
                  AND ($6 IS NULL OR EXISTS (SELECT 1 FROM shapes WHERE id = $6 AND tenant = $11)) \
                  AND NOT EXISTS (SELECT 1 FROM jobs WHERE dedupe = $4 AND created_ms > now_ms - $9) \
                  ON CONFLICT (dedupe) WHERE state IN ('queued', 'running') DO NOTHING";
    let count = |places: usize| i64::try_from(places).unwrap_or(i64::MAX);
    let query = sqlx::query(insert).bind(&id).bind(kind).bind(payload).bind(&dedupe).bind(mesh).bind(sketch);
    let query = query.bind(count(places.queue)).bind(count(places.of_kind)).bind(taken_ms).bind(name);
    let query = query.bind(tenant.as_str()).bind(count(bytes_per_vertex)).bind(priority.rank()).bind(trace);
    let query = query.bind(count(bytes_besides));
    if query.execute(&mut **transaction).await?.rows_affected() == 1 {
        if let Some(url) = webhook {
            let sql = "INSERT INTO webhooks (job, url) VALUES ($1, $2)";
            sqlx::query(sql).bind(&id).bind(url).execute(&mut **transaction).await?;
        }
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
