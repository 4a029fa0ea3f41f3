use bytes::Bytes;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use sqlx::any::AnyRow;
use sqlx::{Any, AssertSqlSafe, FromRow, Row, Transaction};
use uuid::Uuid;

use super::geometry::{self, Encoded};
use super::queue::enqueue;
use super::{NewJob, Page, Places, Store, StoreError, Submitted, blocking, idempotency, page};
use crate::access::Tenant;
use crate::mesh::file_mesh::FileMesh;
use crate::sketch::Sketch;

/// What was uploaded.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Kind {
    Mesh,
    Sketch,
}

impl Kind {
    /// The name it is stored under, and how its ids begin.
    pub const fn as_str(self) -> &'static str {
        match self {
            Kind::Mesh => "mesh",
            Kind::Sketch => "sketch",
        }
    }
}

/// A file as it came, and how it was read.
#[derive(Clone, Debug)]
pub struct Source {
    pub bytes: Bytes,
    /// The media type it was read as.
    pub media_type: String,
    /// What was asked of the reading beside the bytes, the same for the same; empty where nothing can be asked.
    pub parameters: String,
}

impl Source {
    /// The id of an upload: the kind, an underscore and 32 hexadecimal digits of a hash of the file, of how it was read,
    /// and of the geometry that was read, so that an id stands for one geometry even where another version of this
    /// program reads the file otherwise. Every tenant has a hash of its own, the default one that of before there were
    /// tenants.
    fn id(&self, kind: Kind, geometry: &str, tenant: &Tenant) -> String {
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
    kind: Kind,
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
        kind: Kind,
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

/// What became of a shape that was to be deleted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Deletion {
    Done,
    /// An unfinished job needs it: it stays.
    Needed,
    /// There is no such shape.
    Missing,
}

/// A file that was uploaded.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SourceFile {
    pub bytes: Bytes,
    /// The media type it was read as.
    pub media_type: String,
}

/// What is known of an uploaded shape, beside its geometry and its file.
#[derive(Clone, Debug, PartialEq)]
pub struct Shape {
    /// The kind, an underscore and 32 hexadecimal digits; opaque.
    pub id: String,
    pub kind: Kind,
    /// What it was called last.
    pub name: Option<String>,
    /// What its GET answers.
    pub body: Value,
    pub vertices: usize,
    pub triangles: usize,
    /// Milliseconds since 1970 by the database's clock.
    pub created_ms: i64,
    /// When it goes by itself, likewise; nothing where it stays.
    pub expires_ms: Option<i64>,
    /// Which geometry was read of it.
    geometry: String,
    /// The blob it is in.
    geometry_blob: String,
    /// The blob with its bytes and their media type; nothing of what was uploaded before files were kept.
    file: Option<(String, String)>,
}

impl Shape {
    const COLUMNS: &str =
        "id, kind, name, body, created_ms, expires_ms, geometry, geometry_blob, file, media_type, vertices, triangles";

    /// The `Page::after` of the page that begins behind this shape.
    pub fn cursor(&self) -> String {
        page::cursor(self.created_ms, &self.id)
    }

    /// The error where a blob of this shape is damaged: it names the upload that mends it.
    fn damaged_by(&self, error: StoreError) -> StoreError {
        let StoreError::Damaged { what, reason } = error else { return error };
        let name = self.name.as_ref().map(|name| format!(" ({name})")).unwrap_or_default();
        StoreError::DamagedShape {
            shape: format!("{} {}{name}", self.kind.as_str(), self.id),
            reason: format!("{what}: {reason}"),
        }
    }
}

impl<'r> FromRow<'r, AnyRow> for Shape {
    fn from_row(row: &'r AnyRow) -> Result<Shape, sqlx::Error> {
        let kind: &str = row.try_get("kind")?;
        let (file, media_type): (Option<String>, Option<String>) = (row.try_get("file")?, row.try_get("media_type")?);
        let size = |column| usize::try_from(row.try_get::<i64, _>(column)?).map_err(sqlx::Error::decode);
        Ok(Shape {
            id: row.try_get("id")?,
            kind: if kind == Kind::Sketch.as_str() { Kind::Sketch } else { Kind::Mesh },
            name: row.try_get("name")?,
            body: serde_json::from_str(row.try_get("body")?).map_err(sqlx::Error::decode)?,
            vertices: size("vertices")?,
            triangles: size("triangles")?,
            created_ms: row.try_get("created_ms")?,
            expires_ms: row.try_get("expires_ms")?,
            geometry: row.try_get("geometry")?,
            geometry_blob: row.try_get("geometry_blob")?,
            file: file.zip(media_type),
        })
    }
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
        self.insert(Kind::Mesh, move || geometry::of_mesh(&mesh), source, name, body).await
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
        self.insert(Kind::Sketch, move || geometry::of_sketch(&sketch), source, name, body).await
    }

    /// A sketch that was drawn in a request, as [`insert_sketch`](Self::insert_sketch) would keep it.
    ///
    /// # Errors
    /// Where its geometry cannot be written.
    pub async fn unkept(&self, sketch: Sketch, source: Source, body: Value) -> Result<Unkept, StoreError> {
        Unkept::of(&self.tenant, Kind::Sketch, move || geometry::of_sketch(&sketch), source, body).await
    }

    /// Keeps a shape whose geometry `encode` takes its time to write.
    async fn insert(
        &self,
        kind: Kind,
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
        self.blobs.put(&written.geometry, shape.geometry.bytes.clone()).await?;
        self.blobs.put(&written.file, shape.source.bytes.clone()).await?;
        Ok(written)
    }

    /// Deletes blobs that were written for a row that did not come to name them.
    async fn unwrite(&self, written: Written) -> Result<(), StoreError> {
        if written.fresh {
            self.blobs.delete(&written.geometry).await?;
            self.blobs.delete(&written.file).await?;
        }
        Ok(())
    }

    /// Calls a shape by another name, or by none; nothing where there is no such shape.
    ///
    /// # Errors
    /// What the database said.
    pub async fn rename(&self, kind: Kind, id: &str, name: Option<&str>) -> Result<Option<Shape>, StoreError> {
        let sql = "UPDATE shapes SET name = $3 WHERE id = $1 AND kind = $2 AND tenant = $4";
        let query = sqlx::query(sql).bind(id).bind(kind.as_str()).bind(name).bind(self.tenant.as_str());
        query.execute(&self.pool).await?;
        self.shape(kind, id).await
    }

    /// Forgets a shape that no unfinished job needs, the answers under a key that name it, and its blobs where no other
    /// upload shares them.
    ///
    /// # Errors
    /// What the database or the disk said.
    pub async fn delete_shape(&self, kind: Kind, id: &str) -> Result<Deletion, StoreError> {
        self.delete_shape_unused(kind, id, None).await
    }

    /// The same, only where the shape is temporary and its time is over, or where it was not asked for within so many
    /// milliseconds.
    pub(super) async fn delete_shape_unused(
        &self,
        kind: Kind,
        id: &str,
        within_ms: Option<i64>,
    ) -> Result<Deletion, StoreError> {
        let mut transaction = self.engine.alone(&self.pool).await?;
        let sql = format!(
            "DELETE FROM shapes WHERE id = $1 AND kind = $2 AND tenant = $3 AND NOT EXISTS (SELECT 1 FROM jobs \
             WHERE state IN ('queued', 'running') AND (mesh = $1 OR sketch = $1)) \
             AND ($4 IS NULL OR used_ms <= (SELECT now_ms FROM clock) - $4 \
             OR expires_ms <= (SELECT now_ms FROM clock)) RETURNING {}",
            Shape::COLUMNS
        );
        let query = sqlx::query_as(AssertSqlSafe(sql)).bind(id).bind(kind.as_str()).bind(self.tenant.as_str());
        let query = query.bind(within_ms);
        let deleted: Vec<Shape> = query.fetch_all(&mut *transaction).await?;
        let Some(shape) = deleted.into_iter().next() else {
            drop(transaction);
            return Ok(if self.shape(kind, id).await?.is_some() { Deletion::Needed } else { Deletion::Missing });
        };
        idempotency::forget(&mut transaction, id).await?;
        transaction.commit().await?;
        self.delete_blobs(&shape).await?;
        self.free_caches(id).await?;
        Ok(Deletion::Done)
    }

    /// Deletes the blobs of a shape that has no row any more, but for those of an earlier version that another upload shares.
    async fn delete_blobs(&self, shape: &Shape) -> Result<(), StoreError> {
        let shared = "SELECT id FROM shapes WHERE geometry_blob = $1 LIMIT 1";
        if sqlx::query(shared).bind(&shape.geometry_blob).fetch_optional(&self.pool).await?.is_none() {
            self.blobs.delete(&shape.geometry_blob).await?;
        }
        let shared = "SELECT id FROM shapes WHERE file = $1 LIMIT 1";
        if let Some((file, _)) = &shape.file
            && sqlx::query(shared).bind(file).fetch_optional(&self.pool).await?.is_none()
        {
            self.blobs.delete(file).await?;
        }
        Ok(())
    }

    /// The shape with this id, if there is one of this kind.
    ///
    /// # Errors
    /// What the database said.
    pub async fn shape(&self, kind: Kind, id: &str) -> Result<Option<Shape>, StoreError> {
        let sql = format!("SELECT {} FROM shapes WHERE id = $1 AND kind = $2 AND tenant = $3", Shape::COLUMNS);
        let query = sqlx::query_as(AssertSqlSafe(sql)).bind(id).bind(kind.as_str()).bind(self.tenant.as_str());
        Ok(query.fetch_optional(&self.pool).await?)
    }

    /// Shapes of one kind, newest first.
    ///
    /// # Errors
    /// [`StoreError::Cursor`], or what the database said.
    pub async fn shapes(&self, kind: Kind, page: &Page) -> Result<Vec<Shape>, StoreError> {
        let (created_ms, id) = page.bound()?;
        let sql = format!(
            "SELECT {} FROM shapes WHERE tenant = $5 AND kind = $1 AND (created_ms, id) < ($2, $3) \
             ORDER BY created_ms DESC, id DESC LIMIT $4",
            Shape::COLUMNS
        );
        let query = sqlx::query_as(AssertSqlSafe(sql)).bind(kind.as_str()).bind(created_ms).bind(id);
        let query = query.bind(i64::from(page.limit)).bind(self.tenant.as_str());
        Ok(query.fetch_all(&self.pool).await?)
    }

    /// The file a shape was read of; nothing where there is no such shape or its file was not kept.
    ///
    /// # Errors
    /// [`StoreError::DamagedShape`]; what the database or the disk said.
    pub async fn file(&self, kind: Kind, id: &str) -> Result<Option<SourceFile>, StoreError> {
        let Some(shape) = self.shape(kind, id).await? else { return Ok(None) };
        let Some((name, media_type)) = &shape.file else { return Ok(None) };
        let bytes = self.blobs.read(name).await.and_then(there).map_err(|error| shape.damaged_by(error))?;
        Ok(Some(SourceFile { bytes, media_type: media_type.clone() }))
    }

    /// The geometry of a mesh, if there is one with this id.
    ///
    /// # Errors
    /// [`StoreError::DamagedShape`]; what the database or the disk said.
    pub async fn mesh(&self, id: &str) -> Result<Option<FileMesh>, StoreError> {
        self.geometry(Kind::Mesh, id, geometry::mesh).await
    }

    /// The geometry of a sketch, if there is one with this id.
    ///
    /// # Errors
    /// [`StoreError::DamagedShape`]; what the database or the disk said.
    pub async fn sketch(&self, id: &str) -> Result<Option<Sketch>, StoreError> {
        self.geometry(Kind::Sketch, id, geometry::sketch).await
    }

    async fn geometry<T: Send + 'static>(
        &self,
        kind: Kind,
        id: &str,
        decode: fn(&str, &[u8]) -> Result<T, String>,
    ) -> Result<Option<T>, StoreError> {
        let Some(shape) = self.shape(kind, id).await? else { return Ok(None) };
        let (geometry, name) = (shape.geometry.clone(), shape.geometry_blob.clone());
        let decoded = async {
            let bytes = self.blobs.read(&name).await.and_then(there)?;
            blocking(move || decode(&geometry, &bytes).map_err(|reason| StoreError::damaged(name, reason))).await
        };
        decoded.await.map(Some).map_err(|error| shape.damaged_by(error))
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
                   triangles, tenant, bytes, created_ms, used_ms) \
                   SELECT $1, $2, $3, $4, $5, $6, $7, $8, $9, $10, $11, $12, now_ms, now_ms FROM clock WHERE true \
                   ON CONFLICT (id) DO NOTHING";
        let query = sqlx::query(sql).bind(id).bind(kind.as_str()).bind(name).bind(&body).bind(&geometry.name);
        let query = query.bind(&written.geometry).bind(&written.file).bind(&source.media_type);
        let query = query.bind(geometry.vertices as i64).bind(geometry.triangles as i64).bind(tenant.as_str());
        let query = query.bind(shape.bytes() as i64);
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

/// A blob that has to be there.
fn there(blob: Option<Bytes>) -> Result<Bytes, StoreError> {
    blob.ok_or_else(|| StoreError::damaged("a blob", "it is missing"))
}

#[cfg(test)]
mod tests;
