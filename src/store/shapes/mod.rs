use bytes::Bytes;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use sqlx::any::AnyRow;
use sqlx::{AssertSqlSafe, FromRow, Row};

use super::{Page, Store, StoreError, blocking, geometry, idempotency, is_text, page};
use crate::mesh::file_mesh::FileMesh;
use crate::sketch::Sketch;

/// What was uploaded.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ShapeKind {
    Mesh,
    Sketch,
}

impl ShapeKind {
    /// The noun in messages, the name it is stored under, and how its ids begin.
    pub const fn as_str(self) -> &'static str {
        match self {
            ShapeKind::Mesh => "mesh",
            ShapeKind::Sketch => "sketch",
        }
    }
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
    pub kind: ShapeKind,
    /// What it was called last.
    pub name: Option<String>,
    /// What its GET answers.
    pub body: Value,
    /// Vertices and triangles as they came.
    pub vertices: usize,
    pub triangles: usize,
    /// Vertices of what is computed on in its place: of a surface that was made coarser, those that are left.
    pub matched: usize,
    /// Milliseconds since 1970 by the database's clock.
    pub created_ms: i64,
    /// When it goes by itself, likewise; nothing where it stays.
    pub expires_ms: Option<i64>,
    /// Which geometry was read of it.
    geometry: String,
    /// The blob it is in.
    pub(super) geometry_blob: String,
    /// The blob with its bytes and their media type; nothing of what was uploaded before files were kept.
    pub(super) file: Option<(String, String)>,
}

impl Shape {
    pub(super) const COLUMNS: &str = "id, kind, name, body, created_ms, expires_ms, geometry, geometry_blob, file, media_type, \
                                      vertices, triangles, matched";

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
        let (vertices, matched) = (size("vertices")?, size("matched")?);
        Ok(Shape {
            id: row.try_get("id")?,
            kind: if kind == ShapeKind::Sketch.as_str() { ShapeKind::Sketch } else { ShapeKind::Mesh },
            name: row.try_get("name")?,
            body: serde_json::from_str(row.try_get("body")?).map_err(sqlx::Error::decode)?,
            vertices,
            triangles: size("triangles")?,
            // A node of the version before, which is still at work while others are put in its place, writes 0.
            matched: if matched == 0 { vertices } else { matched },
            created_ms: row.try_get("created_ms")?,
            expires_ms: row.try_get("expires_ms")?,
            geometry: row.try_get("geometry")?,
            geometry_blob: row.try_get("geometry_blob")?,
            file: file.zip(media_type),
        })
    }
}

impl Store {
    /// Calls a shape by another name, or by none; nothing where there is no such shape.
    ///
    /// # Errors
    /// What the database said.
    pub async fn rename(&self, kind: ShapeKind, id: &str, name: Option<&str>) -> Result<Option<Shape>, StoreError> {
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
    pub async fn delete_shape(&self, kind: ShapeKind, id: &str) -> Result<Deletion, StoreError> {
        self.delete_shape_unused(kind, id, None).await
    }

    /// The same, only where the shape is temporary and its time is over, or where it was not asked for within so many
    /// milliseconds.
    pub(super) async fn delete_shape_unused(
        &self,
        kind: ShapeKind,
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
    pub async fn shape(&self, kind: ShapeKind, id: &str) -> Result<Option<Shape>, StoreError> {
        if !is_text(id) {
            return Ok(None);
        }
        let sql = format!("SELECT {} FROM shapes WHERE id = $1 AND kind = $2 AND tenant = $3", Shape::COLUMNS);
        let query = sqlx::query_as(AssertSqlSafe(sql)).bind(id).bind(kind.as_str()).bind(self.tenant.as_str());
        Ok(query.fetch_optional(&self.pool).await?)
    }

    /// Shapes of one kind, newest first.
    ///
    /// # Errors
    /// [`StoreError::Cursor`], or what the database said.
    pub async fn shapes(&self, kind: ShapeKind, page: &Page) -> Result<Vec<Shape>, StoreError> {
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
    pub async fn file(&self, kind: ShapeKind, id: &str) -> Result<Option<SourceFile>, StoreError> {
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
        self.geometry(ShapeKind::Mesh, id, geometry::mesh).await
    }

    /// The geometry of a sketch, if there is one with this id.
    ///
    /// # Errors
    /// [`StoreError::DamagedShape`]; what the database or the disk said.
    pub async fn sketch(&self, id: &str) -> Result<Option<Sketch>, StoreError> {
        self.geometry(ShapeKind::Sketch, id, geometry::sketch).await
    }

    async fn geometry<T: Send + 'static>(
        &self,
        kind: ShapeKind,
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

/// A blob that has to be there.
fn there(blob: Option<Bytes>) -> Result<Bytes, StoreError> {
    blob.ok_or_else(|| StoreError::damaged("a blob", "it is missing"))
}

#[cfg(test)]
mod tests;
