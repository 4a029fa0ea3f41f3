use super::Store;
use crate::access::Tenant;

impl Store {
    /// The same store, of what this tenant has.
    #[must_use]
    pub fn of(&self, tenant: &Tenant) -> Store {
        Store { tenant: tenant.clone(), ..self.clone() }
    }

    /// The same store, whose spectra and preparations are those of all tenants: what one has computed is there for the others,
    /// who can tell by that that somebody has computed it.
    #[must_use]
    pub fn with_shared_caches(self) -> Store {
        Store { shared_caches: true, ..self }
    }

    /// Whose shapes, jobs and answers these are.
    pub fn tenant(&self) -> &Tenant {
        &self.tenant
    }

    /// Where what `name` says is kept among the caches: a tenant's own or, where they are shared, that of all.
    pub(super) fn cached_as(&self, name: &str) -> String {
        if self.shared_caches || self.tenant == Tenant::default() {
            name.to_owned()
        } else {
            format!("tenants/{}/{name}", self.tenant)
        }
    }
}

impl Tenant {
    /// What a name of this tenant's choosing is stored under, which no name of another tenant's is. Names of the default
    /// tenant are stored as they are, as they were before there were tenants; no name of a client's has a space.
    pub(super) fn own(&self, name: &str) -> String {
        if *self == Tenant::default() { name.to_owned() } else { format!("{self} {name}") }
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
    use crate::store::{Config, Deletion, NewJob, Page, Places, Remembered, ShapeKind, State, Submitted, database};

    const WHOLE: Page = Page { after: None, limit: 100 };
    const PLACES: Places = Places { queue: 9, of_kind: 9 };

    fn tenants(store: &Store) -> [Store; 3] {
        ["default", "acme", "umbrella"].map(|tenant| store.of(&tenant.parse().unwrap()))
    }

    fn triangle() -> TriangleMesh {
        TriangleMesh::new(vec![[0.0; 3], [1.0, 0.0, 0.0], [0.3, 1.0, 0.0]], vec![[0, 1, 2]]).unwrap()
    }

    #[tokio::test]
    async fn one_upload_is_a_shape_of_each_tenant() {
        on_every_database(uploaded).await;
    }

    async fn uploaded(_: Place, store: Store) {
        let mut ids = Vec::new();
        for tenant in tenants(&store) {
            for new in [true, false] {
                let inserted = tenant.insert_mesh(triangle().into(), source("v"), None, json!({})).await.unwrap();
                assert_eq!(inserted.1, new, "{}", tenant.tenant());
                ids.push(inserted.0.id);
            }
        }
        ids.dedup();
        assert_eq!(ids.len(), 3, "{ids:?}");
        for (tenant, id) in tenants(&store).iter().zip(&ids) {
            assert_eq!(tenant.shapes(ShapeKind::Mesh, &WHOLE).await.unwrap().len(), 1);
            for other in ids.iter().filter(|other| *other != id) {
                assert_eq!(tenant.shape(ShapeKind::Mesh, other).await.unwrap(), None);
                assert_eq!(tenant.mesh(other).await.unwrap(), None);
                assert_eq!(tenant.rename(ShapeKind::Mesh, other, Some("mine")).await.unwrap(), None);
                assert_eq!(tenant.delete_shape(ShapeKind::Mesh, other).await.unwrap(), Deletion::Missing);
                let job = NewJob { mesh: Some(other), ..NewJob::of("match", "{}") };
                assert_eq!(tenant.submit(&job, PLACES).await.unwrap(), Submitted::Gone);
            }
        }
        for (tenant, id) in tenants(&store).iter().zip(&ids) {
            assert_eq!(tenant.mesh(id).await.unwrap(), Some(triangle().into()));
            assert_eq!(tenant.delete_shape(ShapeKind::Mesh, id).await.unwrap(), Deletion::Done);
        }
    }

    #[tokio::test]
    async fn a_job_is_its_tenants_alone_and_any_workers() {
        on_every_database(worked_on).await;
    }

    async fn worked_on(_: Place, store: Store) {
        let [_, acme, umbrella] = tenants(&store);
        let job = NewJob { dedupe: Some("once"), ..NewJob::of("match", "{}") };
        let mut ids = Vec::new();
        for tenant in [&acme, &umbrella, &acme] {
            let Submitted::Taken(job) = tenant.submit(&job, PLACES).await.unwrap() else { panic!("there is place") };
            assert_eq!((job.place, &job.tenant), (Some(1), tenant.tenant()));
            ids.push(job.id);
        }
        assert!(ids[0] == ids[2] && ids[0] != ids[1]);
        assert_eq!((store.job(&ids[0]).await.unwrap(), umbrella.cancel(&ids[0]).await.unwrap()), (None, None));
        assert_eq!(
            (umbrella.payload(&ids[0]).await.unwrap(), umbrella.jobs("match", &WHOLE).await.unwrap().len()),
            (None, 1)
        );

        let lease = store.claim(&["match"], ALL).await.unwrap().unwrap();
        assert_eq!((&lease.job.id, lease.job.tenant.as_str()), (&ids[0], "acme"));
        assert!(store.succeed(&lease, Bytes::from("1")).await.unwrap());
        assert_eq!(
            (acme.result(&ids[0]).await.unwrap(), umbrella.result(&ids[0]).await.unwrap()),
            (Some(Bytes::from("1")), None)
        );
        assert!(!umbrella.delete(&ids[0]).await.unwrap() && acme.delete(&ids[0]).await.unwrap());
    }

    #[tokio::test]
    async fn answers_and_caches_are_each_tenants_own() {
        on_every_database(remembered).await;
    }

    async fn remembered(_: Place, store: Store) {
        let [default, acme, umbrella] = tenants(&store);
        acme.remember("k", "f", 201, None, b"mine").await.unwrap();
        assert_ne!(acme.remembered("k", "f").await.unwrap(), Remembered::New);
        for tenant in [&default, &umbrella] {
            assert_eq!(tenant.remembered("k", "f").await.unwrap(), Remembered::New);
        }
        let held = acme.turn("k").await;
        umbrella.turn("k").await;
        drop(held);
        assert_ne!(acme.cached_as("spectra/1"), umbrella.cached_as("spectra/1"));
        let [_, acme, umbrella] = tenants(&store.with_shared_caches());
        assert_eq!(acme.cached_as("spectra/1"), umbrella.cached_as("spectra/1"));
    }

    #[tokio::test]
    async fn what_was_there_before_there_were_tenants_is_the_default_ones() {
        let directory = tempfile::tempdir().unwrap();
        let file = directory.path().join("data/sketchmatch.db");
        std::fs::create_dir(file.parent().unwrap()).unwrap();
        std::fs::write(&file, "").unwrap();
        let pool = database::testing::file_of_version(&file, 8).await;
        for sql in [
            "INSERT INTO shapes (id, kind, body, created_ms) VALUES ('mesh_1', 'mesh', '{}', 1)",
            "INSERT INTO jobs (id, kind, payload, state, created_ms) VALUES ('1', 'match', '{}', 'queued', 1)",
        ] {
            query(sql).execute(&pool).await.unwrap();
        }
        pool.close().await;
        let [default, acme, _] = tenants(&Store::open(&Config::local(directory.path().join("data"))).await.unwrap());
        assert!(default.shape(ShapeKind::Mesh, "mesh_1").await.unwrap().is_some());
        assert_eq!(default.job("1").await.unwrap().unwrap().state, State::Queued);
        assert_eq!((acme.shape(ShapeKind::Mesh, "mesh_1").await.unwrap(), acme.job("1").await.unwrap()), (None, None));
    }
}
