//! What goes by itself when its time is over.

use std::time::Duration;

use sqlx::Row;

use super::{Deletion, MEMORY, Shape, ShapeKind, Store, StoreError, milliseconds};
use crate::access::Tenant;

/// How long things are kept; for ever where nothing is said.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Retention {
    /// Results, from the end of their jobs on; of the jobs it is told still.
    pub results: Option<Duration>,
    /// Jobs with their results, from their end on.
    pub jobs: Option<Duration>,
    /// Uploads, from when they were last uploaded or a job last asked for them.
    pub uploads: Option<Duration>,
    /// Answers under a key, up to [`MEMORY`].
    pub answers: Option<Duration>,
}

/// How many things went.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Gone {
    pub results: usize,
    pub jobs: usize,
    pub uploads: usize,
}

/// How long a temporary upload is kept. With the minute in which it is found it is less than an hour.
const TEMPORARY: Duration = Duration::from_secs(55 * 60);

/// How many rows are looked at together.
const BATCH: i64 = 100;

impl Store {
    /// Deletes what was kept for as long as it is to be, whosever it is, and what was temporary. Others may do the same at the
    /// same time.
    ///
    /// # Errors
    /// What the database or the disk said.
    pub async fn let_go(&self, retention: &Retention) -> Result<Gone, StoreError> {
        let mut gone = Gone::default();
        if let Some(keep) = retention.results {
            gone.results = self.let_go_of_results(keep).await?;
        }
        if let Some(keep) = retention.jobs {
            gone.jobs = self.let_go_of_jobs(keep).await?;
        }
        gone.uploads = self.let_go_of_uploads(retention.uploads).await?;
        if let Some(keep) = retention.answers {
            let sql = "DELETE FROM answers WHERE expires_ms <= (SELECT now_ms FROM clock) + $1";
            sqlx::query(sql).bind(milliseconds(MEMORY.saturating_sub(keep))).execute(&self.pool).await?;
        }
        self.forget_usage().await?;
        Ok(gone)
    }

    async fn let_go_of_results(&self, keep: Duration) -> Result<usize, StoreError> {
        let mut gone = 0;
        loop {
            let sql = "SELECT id, result FROM jobs WHERE result IS NOT NULL \
                       AND finished_ms <= (SELECT now_ms FROM clock) - $1 ORDER BY finished_ms LIMIT $2";
            let over = sqlx::query(sql).bind(milliseconds(keep)).bind(BATCH).fetch_all(&self.pool).await?;
            for row in &over {
                let (id, blob): (&str, &str) = (row.try_get("id")?, row.try_get("result")?);
                // Whoever reads it meanwhile finds out that it is gone: the row goes before the blob.
                let sql = "UPDATE jobs SET result = NULL, bytes = 0 WHERE id = $1 AND result = $2";
                let taken = sqlx::query(sql).bind(id).bind(blob).execute(&self.pool).await?.rows_affected();
                if taken == 1 {
                    self.blobs.delete(blob).await?;
                    gone += 1;
                }
            }
            if over.len() < BATCH as usize {
                return Ok(gone);
            }
        }
    }

    async fn let_go_of_jobs(&self, keep: Duration) -> Result<usize, StoreError> {
        let mut gone = 0;
        loop {
            let sql = "SELECT id, tenant FROM jobs WHERE finished_ms <= (SELECT now_ms FROM clock) - $1 \
                       ORDER BY finished_ms LIMIT $2";
            let over = sqlx::query(sql).bind(milliseconds(keep)).bind(BATCH).fetch_all(&self.pool).await?;
            for row in &over {
                let tenant: Tenant = row.try_get::<&str, _>("tenant")?.parse().map_err(sqlx::Error::decode)?;
                gone += usize::from(self.of(&tenant).delete(row.try_get("id")?).await?);
            }
            if over.len() < BATCH as usize {
                return Ok(gone);
            }
        }
    }

    async fn let_go_of_uploads(&self, keep: Option<Duration>) -> Result<usize, StoreError> {
        let keep_ms = keep.map_or(i64::MAX, milliseconds);
        let mut gone = 0;
        loop {
            let sql = "SELECT id, kind, tenant FROM shapes WHERE (used_ms <= (SELECT now_ms FROM clock) - $1 \
                       OR expires_ms <= (SELECT now_ms FROM clock)) AND NOT EXISTS (SELECT 1 FROM jobs \
                       WHERE state IN ('queued', 'running') AND (mesh = shapes.id OR sketch = shapes.id)) LIMIT $2";
            let over = sqlx::query(sql).bind(keep_ms).bind(BATCH).fetch_all(&self.pool).await?;
            for row in &over {
                let tenant: Tenant = row.try_get::<&str, _>("tenant")?.parse().map_err(sqlx::Error::decode)?;
                let kind = if row.try_get::<&str, _>("kind")? == ShapeKind::Mesh.as_str() {
                    ShapeKind::Mesh
                } else {
                    ShapeKind::Sketch
                };
                let id = row.try_get("id")?;
                // Unless it was asked for again meanwhile.
                let deletion = self.of(&tenant).delete_shape_unused(kind, id, Some(keep_ms)).await?;
                gone += usize::from(deletion == Deletion::Done);
            }
            if over.len() < BATCH as usize {
                return Ok(gone);
            }
        }
    }

    /// Lets an upload go within the hour where it is `new`, or was temporary before.
    ///
    /// # Errors
    /// What the database said.
    pub async fn make_temporary(&self, shape: Shape, new: bool) -> Result<Shape, StoreError> {
        let sql = "UPDATE shapes SET expires_ms = (SELECT now_ms FROM clock) + $3 \
                   WHERE id = $1 AND tenant = $2 AND ($4 = 1 OR expires_ms IS NOT NULL)";
        let query = sqlx::query(sql).bind(&shape.id).bind(self.tenant().as_str()).bind(milliseconds(TEMPORARY));
        query.bind(i64::from(new)).execute(&self.pool).await?;
        self.again(shape).await
    }

    /// Keeps an upload that was temporary.
    ///
    /// # Errors
    /// What the database said.
    pub async fn make_lasting(&self, shape: Shape) -> Result<Shape, StoreError> {
        let sql = "UPDATE shapes SET expires_ms = NULL WHERE id = $1 AND tenant = $2";
        sqlx::query(sql).bind(&shape.id).bind(self.tenant().as_str()).execute(&self.pool).await?;
        self.again(shape).await
    }

    /// The shape as it stands now, or as it stood if it is gone.
    async fn again(&self, shape: Shape) -> Result<Shape, StoreError> {
        Ok(self.shape(shape.kind, &shape.id).await?.unwrap_or(shape))
    }
}

#[cfg(test)]
mod tests {
    use bytes::Bytes;
    use serde_json::json;
    use sqlx::query;

    use super::*;
    use crate::mesh::TriangleMesh;
    use crate::store::testing::{ALL, Place, on_every_database, source};
    use crate::store::{NewJob, Page, Places, Remembered, Submitted};

    const HOUR: Duration = Duration::from_secs(3600);
    const PLACES: Places = Places { queue: 99, of_kind: 99 };

    async fn mesh(store: &Store, x: f64) -> String {
        shape(store, x).await.id
    }

    async fn shape(store: &Store, x: f64) -> Shape {
        let corners = vec![[x, 0.0, 0.0], [x + 1.0, 0.0, 0.0], [x + 0.3, 1.0, 0.0]];
        let mesh = TriangleMesh::new(corners, vec![[0, 1, 2]]).unwrap();
        store.insert_mesh(mesh.into(), source("v"), None, json!({})).await.unwrap().0
    }

    /// The id of a job that needs this mesh.
    async fn job(store: &Store, mesh: &str) -> String {
        let job = NewJob { mesh: Some(mesh), ..NewJob::of("match", "{}") };
        let Submitted::Taken(job) = store.submit(&job, PLACES).await.unwrap() else { panic!("there is place") };
        job.id
    }

    async fn finished(store: &Store, mesh: &str) -> String {
        let id = job(store, mesh).await;
        let lease = store.claim(&["match"], ALL).await.unwrap().unwrap();
        assert!(store.succeed(&lease, Bytes::from("result")).await.unwrap());
        id
    }

    async fn age(store: &Store, sql: &'static str) {
        query(sql).execute(&store.pool).await.unwrap();
    }

    #[tokio::test]
    async fn what_is_over_goes_with_its_blobs_and_the_rest_stays() {
        on_every_database(over).await;
    }

    async fn over(_: Place, store: Store) {
        let acme = store.of(&"acme".parse().unwrap());
        let (old, young) = (mesh(&acme, 0.0).await, mesh(&acme, 1.0).await);
        let (done, waits) = (finished(&acme, &old).await, job(&acme, &young).await);
        acme.remember("k", "f", 201, None, b"").await.unwrap();
        assert_eq!(store.let_go(&Retention::default()).await.unwrap(), Gone::default());
        let all = Some(2 * HOUR);
        let retention = Retention { results: Some(HOUR), jobs: all, uploads: all, answers: all };
        assert_eq!(store.let_go(&retention).await.unwrap(), Gone::default());

        age(&store, "UPDATE jobs SET finished_ms = finished_ms - 3600000 WHERE finished_ms IS NOT NULL").await;
        assert_eq!(store.let_go(&retention).await.unwrap(), Gone { results: 1, ..Gone::default() });
        assert_eq!((acme.result(&done).await.unwrap(), acme.usage().await.unwrap().queued), (None, 1));
        assert!(acme.job(&done).await.unwrap().is_some() && store.blobs.names("results").await.unwrap().is_empty());

        age(&store, "UPDATE jobs SET finished_ms = finished_ms - 3600000 WHERE finished_ms IS NOT NULL").await;
        age(&store, "UPDATE shapes SET used_ms = used_ms - 7200000").await;
        age(&store, "UPDATE answers SET expires_ms = expires_ms - 7200000").await;
        assert_eq!(store.let_go(&retention).await.unwrap(), Gone { results: 0, jobs: 1, uploads: 1 });
        assert_eq!(acme.job(&done).await.unwrap(), None);
        assert_eq!(acme.remembered("k", "f").await.unwrap(), Remembered::New);
        // A job that has not ended needs the other.
        assert!(acme.mesh(&young).await.unwrap().is_some() && acme.mesh(&old).await.unwrap().is_none());
        acme.cancel(&waits).await.unwrap();
        assert_eq!(store.let_go(&retention).await.unwrap().uploads, 1);
        for folder in ["shapes", "files", "results"] {
            assert_eq!(store.blobs.names(folder).await.unwrap(), Vec::<String>::new());
        }
        assert_eq!(acme.usage().await.unwrap().bytes, 0);
    }

    #[tokio::test]
    async fn a_shape_that_is_asked_for_again_stays() {
        on_every_database(asked_for_again).await;
    }

    async fn asked_for_again(_: Place, store: Store) {
        let retention = Retention { uploads: Some(HOUR), ..Retention::default() };
        let id = mesh(&store, 0.0).await;
        for again in [true, false] {
            age(&store, "UPDATE shapes SET used_ms = used_ms - 7200000").await;
            if again {
                mesh(&store, 0.0).await;
            } else {
                let asked = job(&store, &id).await;
                store.cancel(&asked).await.unwrap();
            }
            assert_eq!(store.let_go(&retention).await.unwrap().uploads, 0);
        }
    }

    #[tokio::test]
    async fn a_temporary_upload_goes_within_the_hour_unless_it_is_uploaded_to_stay() {
        on_every_database(temporary).await;
    }

    async fn temporary(_: Place, store: Store) {
        let one = store.make_temporary(shape(&store, 0.0).await, true).await.unwrap();
        let other = store.make_temporary(shape(&store, 1.0).await, true).await.unwrap();
        assert!(one.expires_ms.unwrap() - one.created_ms < 3_600_000);
        let other = store.make_lasting(other).await.unwrap();
        assert_eq!(store.make_temporary(other, false).await.unwrap().expires_ms, None);
        assert_eq!(store.let_go(&Retention::default()).await.unwrap().uploads, 0);
        age(&store, "UPDATE shapes SET expires_ms = expires_ms - 3600000").await;
        assert_eq!(store.let_go(&Retention::default()).await.unwrap().uploads, 1);
        assert_eq!(store.shapes(ShapeKind::Mesh, &Page { after: None, limit: 9 }).await.unwrap().len(), 1);
    }
}
