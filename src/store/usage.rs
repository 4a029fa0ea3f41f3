use std::time::Duration;

use sqlx::Row;

use super::{Store, StoreError};

/// What a tenant takes now.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Usage {
    /// Jobs that wait.
    pub queued: u64,
    /// Bytes of uploads and results.
    pub bytes: u64,
    /// Processor time of jobs within the last hour, to the minute.
    pub cpu: Duration,
}

impl Store {
    /// What the tenant takes now.
    ///
    /// # Errors
    /// What the database said.
    pub async fn usage(&self) -> Result<Usage, StoreError> {
        let sql = "SELECT (SELECT count(*) FROM jobs WHERE tenant = $1 AND state = 'queued') AS queued, \
                   (SELECT CAST(COALESCE(sum(bytes), 0) AS BIGINT) FROM shapes WHERE tenant = $1) AS uploads, \
                   (SELECT CAST(COALESCE(sum(bytes), 0) AS BIGINT) FROM jobs WHERE tenant = $1 AND bytes > 0) AS results, \
                   (SELECT CAST(COALESCE(sum(cpu_ms), 0) AS BIGINT) FROM usage \
                    WHERE tenant = $1 AND minute > now_ms / 60000 - 60) AS cpu_ms FROM clock";
        let row = sqlx::query(sql).bind(self.tenant().as_str()).fetch_one(&self.pool).await?;
        let number = |column| row.try_get::<i64, _>(column).map(|number| u64::try_from(number).unwrap_or(0));
        let (uploads, results) = (number("uploads")?, number("results")?);
        let cpu = Duration::from_millis(number("cpu_ms")?);
        Ok(Usage { queued: number("queued")?, bytes: uploads.saturating_add(results), cpu })
    }

    /// Adds processor time that a job of the tenant took.
    ///
    /// # Errors
    /// What the database said.
    pub async fn charge(&self, cpu: Duration) -> Result<(), StoreError> {
        let sql = "INSERT INTO usage (tenant, minute, cpu_ms) SELECT $1, now_ms / 60000, $2 FROM clock WHERE true \
                   ON CONFLICT (tenant, minute) DO UPDATE SET cpu_ms = usage.cpu_ms + excluded.cpu_ms";
        let cpu_ms = i64::try_from(cpu.as_millis()).unwrap_or(i64::MAX);
        sqlx::query(sql).bind(self.tenant().as_str()).bind(cpu_ms).execute(&self.pool).await?;
        Ok(())
    }

    /// Forgets the processor time of hours that are over, whosever it was.
    ///
    /// # Errors
    /// What the database said.
    pub(super) async fn forget_usage(&self) -> Result<(), StoreError> {
        let sql = "DELETE FROM usage WHERE minute <= (SELECT now_ms / 60000 - 60 FROM clock)";
        sqlx::query(sql).execute(&self.pool).await?;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::store::testing::{Place, on_every_database};

    #[tokio::test]
    async fn processor_time_counts_for_an_hour() {
        on_every_database(charged).await;
    }

    async fn charged(_: Place, store: Store) {
        let [acme, umbrella] = ["acme", "umbrella"].map(|tenant| store.of(&tenant.parse().unwrap()));
        for seconds in [1, 2] {
            acme.charge(Duration::from_secs(seconds)).await.unwrap();
        }
        umbrella.charge(Duration::from_secs(9)).await.unwrap();
        assert_eq!(acme.usage().await.unwrap(), Usage { cpu: Duration::from_secs(3), ..Usage::default() });
        let sql = "UPDATE usage SET minute = minute - 60 WHERE tenant = 'acme'";
        sqlx::query(sql).execute(&store.pool).await.unwrap();
        assert_eq!(acme.usage().await.unwrap(), Usage::default());
        store.forget_usage().await.unwrap();
        let left: i64 = sqlx::query_scalar("SELECT count(*) FROM usage").fetch_one(&store.pool).await.unwrap();
        assert_eq!(left, 1);
    }
}
