//! How a shape comes to be kept: the file and the geometry as blobs, then the row that names them.

use bytes::Bytes;
use serde_json::Value;
use sqlx::{Any, AssertSqlSafe, Transaction};
use uuid::Uuid;

use super::geometry::{self, Encoded};
use super::queue::enqueue;
use super::shapes::{Shape, ShapeKind};
use super::{NewJob, Places, Store, StoreError, Submitted, blocking};
use crate::access::Tenant;
use crate::mesh::file_mesh::FileMesh;
use crate::sketch::Sketch;

/// A file as it came, and how it was read.
#[derive(Clone, Debug)]
pub struct Source {
    pub bytes: Bytes,
    /// The media type it was read as.
    pub media_type: String,
    /// What was asked of the reading beside the bytes, the same for the same; empty where nothing can be asked.
    pub parameters: String,
    /// What the file is called: the name of a new shape that is given none.
    pub file_name: Option<String>,
}

impl Source {
    /// The id of an upload: the kind, an underscore and 32 hexadecimal digits of a hash of the file, of how it was read,
    /// and of the geometry that was read, so that an id stands for one geometry even where another version of this
    /// program reads the file otherwise. Every tenant has a hash of its own, the default one that of before there were
    /// tenants.
    fn id(&self, kind: ShapeKind, geometry: &str, tenant: &Tenant) -> String {
        let mut hasher = if *tenant == Tenant::default() {
            blake3::Hasher::new()
        } else {
            blake3::Hasher::new_derive_key(&format!("sketchmatch 2026 id of a shape of the tenant {tenant}"))
        };
        for part in [&self.media_type, &self.parameters, geometry] {
            hasher.update(&(part.len() as u64).to_le_bytes()).update(part.as_bytes());
        }
        let hash = hasher.update(&self.bytes).finalize();
        format!("{}_{}", kind.as_str(), &hash.to_hex()[..32])
    }
}

/// A shape that has its id and is not kept yet.
pub struct Unkept {
    id: String,
    tenant: Tenant,
    kind: ShapeKind,
    geometry: Encoded,
    source: Source,
    /// What is told of it.
    body: Value,
}

impl Unkept {
    /// The id it will have once it is kept.
    pub fn id(&self) -> &str {
        &self.id
    }

    /// Bytes that keeping it takes: its file and what was read of it.
    pub fn bytes(&self) -> usize {
        self.source.bytes.len() + self.geometry.bytes.len()
    }

    /// Names a shape of a tenant, whose geometry `encode` takes its time to write.
    async fn of(
        tenant: &Tenant,
        kind: ShapeKind,
        encode: impl FnOnce() -> Result<Encoded, StoreError> + Send + 'static,
        source: Source,
        body: Value,
    ) -> Result<Unkept, StoreError> {
        let tenant = tenant.clone();
        let named = move || {
            let geometry = encode()?;
            Ok(Unkept { id: source.id(kind, &geometry.name, &tenant), tenant, kind, geometry, source, body })
        };
        blocking(named).await
    }
}

/// The blobs of an upload as they are written before its row names them.
struct Written {
    geometry: String,
    file: String,
    /// Whether they are its alone: else they are those of the row that was there.
    fresh: bool,
}

impl Store {
    /// Keeps a mesh, the file it was read of, and what is told of it; the shape and whether this upload is new. One that
    /// is known is told of anew, and called `name` from now on where there is one.
    ///
    /// # Errors
    /// What the disk or the database said.
    pub async fn insert_mesh(
        &self,
        mesh: FileMesh,
        source: Source,
        name: Option<&str>,
        body: Value,
    ) -> Result<(Shape, bool), StoreError> {
        self.insert(ShapeKind::Mesh, move || geometry::of_mesh(&mesh), source, name, body).await
    }

    /// Keeps a sketch as [`insert_mesh`](Self::insert_mesh) keeps a mesh.
    ///
    /// # Errors
    /// What the disk or the database said.
    pub async fn insert_sketch(
        &self,
        sketch: Sketch,
        source: Source,
        name: Option<&str>,
        body: Value,
    ) -> Result<(Shape, bool), StoreError> {
        self.insert(ShapeKind::Sketch, move || geometry::of_sketch(&sketch), source, name, body).await
    }

    /// A sketch that was drawn in a request, as [`insert_sketch`](Self::insert_sketch) would keep it.
    ///
    /// # Errors
    /// Where its geometry cannot be written.
    pub async fn unkept(&self, sketch: Sketch, source: Source, body: Value) -> Result<Unkept, StoreError> {
        Unkept::of(&self.tenant, ShapeKind::Sketch, move || geometry::of_sketch(&sketch), source, body).await
    }

    /// Keeps a shape whose geometry `encode` takes its time to write.
    async fn insert(
        &self,
        kind: ShapeKind,
        encode: impl FnOnce() -> Result<Encoded, StoreError> + Send + 'static,
        source: Source,
        name: Option<&str>,
        body: Value,
    ) -> Result<(Shape, bool), StoreError> {
        let shape = Unkept::of(&self.tenant, kind, encode, source, body).await?;
        let (store, name) = (self.clone(), name.map(str::to_owned));
        // Carried through even where who asked for it hangs up: a blob is not to be left without its row.
        let kept = tokio::spawn(async move { store.keep(&shape, name.as_deref()).await });
        kept.await.unwrap_or_else(|error| Err(StoreError::damaged("a background task", error)))
    }

    /// Writes the blobs of a shape and then the row that names them.
    async fn keep(&self, shape: &Unkept, name: Option<&str>) -> Result<(Shape, bool), StoreError> {
        loop {
            let written = self.write(shape).await?;
            let mut transaction = self.engine.alone(&self.pool).await?;
            let named = name_blobs(&mut transaction, shape, &written, name).await?;
            transaction.commit().await?;
            let Some((kept, new)) = named else { continue };
            if !new {
                self.unwrite(written).await?;
            }
            return Ok((kept, new));
        }
    }

    /// Puts a job into the queue together with a shape it needs, which is not kept where the job is not taken.
    ///
    /// # Errors
    /// What the disk or the database said.
    pub async fn submit_with(&self, shape: Unkept, job: &NewJob<'_>, places: Places) -> Result<Submitted, StoreError> {
        loop {
            let written = self.write(&shape).await?;
            let mut transaction = self.engine.alone(&self.pool).await?;
            let Some((_, new)) = name_blobs(&mut transaction, &shape, &written, None).await? else { continue };
            let submitted = enqueue(&mut transaction, &self.tenant, job, places).await?;
            let taken = matches!(submitted, Submitted::Taken(_));
            if taken {
                transaction.commit().await?;
                self.changes.tell_of_queue();
            } else {
                transaction.rollback().await?;
            }
            if !(taken && new) {
                self.unwrite(written).await?;
            }
            return Ok(submitted);
        }
    }

    /// Writes the blobs of a shape under names that nothing else has, so that whoever deletes another shape leaves them alone;
    /// where there is a row, over its own, which mends them.
    async fn write(&self, shape: &Unkept) -> Result<Written, StoreError> {
        let written = match self.shape(shape.kind, &shape.id).await? {
            Some(Shape { geometry_blob, file: Some((file, _)), .. }) => {
                Written { geometry: geometry_blob, file, fresh: false }
            }
            _ => {
                let (id, token) = (&shape.id, Uuid::now_v7().simple());
                let geometry = format!("shapes/{id}/{token}.safetensors");
                Written { geometry, file: format!("files/{id}/{token}"), fresh: true }
            }
        };
        let put = async {
            self.blobs.put(&written.geometry, shape.geometry.bytes.clone()).await?;
            self.blobs.put(&written.file, shape.source.bytes.clone()).await
        };
        match put.await {
            Ok(()) => Ok(written),
            Err(error) => {
                // On a disk that is full the one that found room would keep it. What cannot be deleted either is the sweep's.
                let _ = self.unwrite(written).await;
                Err(error)
            }
        }
    }

    /// Deletes blobs that were written for a row that did not come to name them.
    async fn unwrite(&self, written: Written) -> Result<(), StoreError> {
        if written.fresh {
            self.blobs.delete(&written.geometry).await?;
            self.blobs.delete(&written.file).await?;
        }
        Ok(())
    }
}

/// Has a row name the blobs of an upload; the row and whether it is new. Nothing where the blobs were those of a row that is
/// gone meanwhile: whoever deleted it deletes them too.
async fn name_blobs(
    transaction: &mut Transaction<'_, Any>,
    shape: &Unkept,
    written: &Written,
    name: Option<&str>,
) -> Result<Option<(Shape, bool)>, StoreError> {
    let Unkept { id, tenant, kind, geometry, source, body } = shape;
    let body = body.to_string();
    let mut new = false;
    if written.fresh {
        let sql = "INSERT INTO shapes (id, kind, name, body, geometry, geometry_blob, file, media_type, vertices, \
                   triangles, matched, tenant, bytes, created_ms, used_ms) \
                   SELECT $1, $2, $3, $4, $5, $6, $7, $8, $9, $10, $13, $11, $12, now_ms, now_ms FROM clock WHERE true \
                   ON CONFLICT (id) DO NOTHING";
        let called = name.or(source.file_name.as_deref());
        let query = sqlx::query(sql).bind(id).bind(kind.as_str()).bind(called).bind(&body).bind(&geometry.name);
        let query = query.bind(&written.geometry).bind(&written.file).bind(&source.media_type);
        let query = query.bind(geometry.vertices as i64).bind(geometry.triangles as i64).bind(tenant.as_str());
        let query = query.bind(shape.bytes() as i64).bind(geometry.matched as i64);
        new = query.execute(&mut **transaction).await?.rows_affected() == 1;
    }
    if !new {
        let sql = "UPDATE shapes SET name = COALESCE($2, name), body = $3, used_ms = (SELECT now_ms FROM clock) WHERE id = $1";
        sqlx::query(sql).bind(id).bind(name).bind(&body).execute(&mut **transaction).await?;
    }
    let sql = format!("SELECT {} FROM shapes WHERE id = $1", Shape::COLUMNS);
    let kept = sqlx::query_as(AssertSqlSafe(sql)).bind(id).fetch_optional(&mut **transaction).await?;
    Ok(kept.map(|shape| (shape, new)))
}
