//! Who is still to be told of the end of a job.

use sqlx::{AssertSqlSafe, Row};

use super::{Job, Store, StoreError};
use crate::access::Tenant;

/// How often somebody is called who does not listen: for about a day, as the rests between are.
pub const MAX_CALLS: i64 = 30;

/// The longest rest between two calls.
const LONGEST_REST_MS: i64 = 3_600_000;

/// A call that is to be made.
#[derive(Clone, Debug)]
pub struct Webhook {
    /// The job that has ended.
    pub job: Job,
    /// The address to call.
    pub url: String,
    /// How often it was called, this time included.
    pub tries: i64,
}

/// What of `waiting`, `jobs` and `clock` is due. No rest is longer than the longest: what seems so was begun before the clock was
/// set back.
fn due() -> String {
    format!(
        "FROM webhooks AS waiting JOIN jobs ON jobs.id = waiting.job CROSS JOIN clock \
         WHERE jobs.state IN ('succeeded', 'failed', 'cancelled') \
         AND (waiting.due_ms <= now_ms OR waiting.due_ms > now_ms + {LONGEST_REST_MS})"
    )
}

impl Store {
    /// The next call that is due, whosever it is, which then rests: 30 s after the first time, twice as long after each, up to an
    /// hour. So it is made again where whoever makes it dies, and by nobody else meanwhile.
    ///
    /// # Errors
    /// What the database said.
    pub async fn due_webhook(&self) -> Result<Option<Webhook>, StoreError> {
        // Whoever finds nothing is not to keep writers waiting.
        let due = due();
        let any = format!("SELECT waiting.job {due} LIMIT 1");
        if sqlx::query(AssertSqlSafe(any)).fetch_optional(&self.pool).await?.is_none() {
            return Ok(None);
        }
        let sql = format!(
            "UPDATE webhooks SET tries = tries + 1, due_ms = (SELECT now_ms FROM clock) + \
             CASE WHEN tries >= 7 THEN $1 ELSE 30000 << CAST(tries AS INTEGER) END \
             WHERE job = (SELECT waiting.job {due} ORDER BY waiting.due_ms, waiting.job LIMIT 1 {}) \
             RETURNING job, url, tries",
            self.engine.for_update_of("waiting")
        );
        let taken = sqlx::query(AssertSqlSafe(sql)).bind(LONGEST_REST_MS).fetch_all(&self.pool).await?;
        let Some(row) = taken.first() else { return Ok(None) };
        let sql = format!("SELECT {} FROM jobs WHERE id = $1", Job::COLUMNS);
        let query = sqlx::query_as(AssertSqlSafe(sql)).bind(row.try_get::<&str, _>("job")?);
        // It may have been deleted meanwhile, and the call with it.
        let job: Option<Job> = query.fetch_optional(&self.pool).await?;
        let (url, tries) = (row.try_get("url")?, row.try_get("tries")?);
        Ok(job.map(|job| Webhook { job, url, tries }))
    }

    /// Forgets a call that was made, or is given up.
    ///
    /// # Errors
    /// What the database said.
    pub async fn forget_webhook(&self, webhook: &Webhook) -> Result<(), StoreError> {
        let sql = "DELETE FROM webhooks WHERE job = $1 AND tries = $2";
        sqlx::query(sql).bind(&webhook.job.id).bind(webhook.tries).execute(&self.pool).await?;
        Ok(())
    }

    /// Number of calls that are still to be made, whosever they are, of jobs that have ended.
    ///
    /// # Errors
    /// What the database said.
    pub async fn webhooks_waiting(&self) -> Result<i64, StoreError> {
        let sql = "SELECT count(*) FROM webhooks JOIN jobs ON jobs.id = webhooks.job \
                   WHERE jobs.state IN ('succeeded', 'failed', 'cancelled')";
        Ok(sqlx::query_scalar(sql).fetch_one(&self.pool).await?)
    }

    /// What the calls of a tenant are signed with.
    ///
    /// # Errors
    /// As [`Store::secret`].
    pub async fn webhook_secret(&self, tenant: &Tenant) -> Result<[u8; 32], StoreError> {
        self.secret(&secret_name(tenant)).await
    }
}

/// The name of the secret that signs the calls of a tenant.
pub(super) fn secret_name(tenant: &Tenant) -> String {
    format!("webhooks/{tenant}")
}

#[cfg(test)]
mod tests {
    use bytes::Bytes;

    use super::*;
    use crate::store::testing::{ALL, make_webhooks_due, on_every_database};
    use crate::store::{NewJob, Places, Submitted};

    async fn asked(store: &Store, url: &str) -> Job {
        let job = NewJob { webhook: Some(url), ..NewJob::of("match", "{}") };
        match store.submit(&job, Places { queue: 9, of_kind: 9 }).await.unwrap() {
            Submitted::Taken(job) => *job,
            refused => panic!("{refused:?}"),
        }
    }

    #[tokio::test]
    async fn the_end_of_a_job_is_told_until_it_was_heard() {
        on_every_database(async |place, store| {
            let acme = store.of(&"acme".parse().unwrap());
            let (done, waits, ended) =
                (asked(&acme, "https://a/").await, asked(&acme, "https://b/").await, asked(&store, "https://c/").await);
            assert!(store.due_webhook().await.unwrap().is_none());
            let lease = store.claim(&["match"], ALL).await.unwrap().unwrap();
            assert_eq!(lease.job.id, done.id);
            store.of(&lease.job.tenant).succeed(&lease, Bytes::new()).await.unwrap();
            store.cancel(&ended.id).await.unwrap();
            let mut told = Vec::new();
            while let Some(webhook) = store.due_webhook().await.unwrap() {
                told.push((webhook.job.id.clone(), webhook.url.clone(), webhook.tries));
            }
            told.sort();
            let mut expected =
                vec![(done.id.clone(), "https://a/".to_owned(), 1), (ended.id.clone(), "https://c/".to_owned(), 1)];
            expected.sort();
            assert_eq!(told, expected);
            // Whoever was to tell died: another does.
            drop((acme, store));
            let store = place.open().await;
            for tries in 2..=3 {
                make_webhooks_due(&store).await;
                let again = store.due_webhook().await.unwrap().unwrap();
                assert_eq!(again.tries, tries);
                store.due_webhook().await.unwrap().unwrap();
                assert!(store.due_webhook().await.unwrap().is_none());
            }
            make_webhooks_due(&store).await;
            let (heard, late) =
                (store.due_webhook().await.unwrap().unwrap(), store.due_webhook().await.unwrap().unwrap());
            store.forget_webhook(&heard).await.unwrap();
            make_webhooks_due(&store).await;
            let last = store.due_webhook().await.unwrap().unwrap();
            // Who comes late takes nothing away.
            for (webhook, left) in [(late, 1), (last, 0)] {
                store.forget_webhook(&webhook).await.unwrap();
                let sql = "SELECT count(*) FROM webhooks WHERE job <> $1";
                let found = sqlx::query_scalar::<_, i64>(sql).bind(&waits.id).fetch_one(&store.pool).await.unwrap();
                assert_eq!(found, left);
            }
        })
        .await;
    }

    #[tokio::test]
    async fn calls_rest_longer_and_longer_and_go_with_their_job() {
        on_every_database(async |_, store| {
            let job = asked(&store, "https://a/").await;
            store.cancel(&job.id).await.unwrap();
            for (tries, seconds) in [(0, 30), (1, 60), (6, 1920), (7, 3600), (29, 3600)] {
                let sql = "UPDATE webhooks SET due_ms = 0, tries = $1";
                sqlx::query(sql).bind(i64::from(tries)).execute(&store.pool).await.unwrap();
                assert_eq!(store.due_webhook().await.unwrap().unwrap().tries, i64::from(tries) + 1);
                let rest = "SELECT due_ms - now_ms FROM webhooks, clock";
                let rest: i64 = sqlx::query_scalar(rest).fetch_one(&store.pool).await.unwrap();
                assert!(rest <= 1000 * seconds && rest > 1000 * seconds - 900, "{rest}");
            }
            assert!(store.delete(&job.id).await.unwrap());
            let left: i64 = sqlx::query_scalar("SELECT count(*) FROM webhooks").fetch_one(&store.pool).await.unwrap();
            assert_eq!(left, 0);
        })
        .await;
    }

    #[tokio::test]
    async fn every_tenant_has_a_secret_of_its_own() {
        on_every_database(async |_, store| {
            let [acme, umbrella] = &["acme", "umbrella"].map(|name| name.parse::<Tenant>().unwrap());
            let secret = store.webhook_secret(acme).await.unwrap();
            assert_ne!(secret, store.webhook_secret(umbrella).await.unwrap());
            assert_eq!(secret, store.keys().webhook_secret(acme, false).await.unwrap());
            let renewed = store.keys().webhook_secret(acme, true).await.unwrap();
            assert_ne!(secret, renewed);
            assert_eq!(renewed, store.webhook_secret(acme).await.unwrap());
        })
        .await;
    }
}
