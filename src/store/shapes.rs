use safetensors::tensor::{Dtype, SafeTensorError, SafeTensors};
use serde::{Deserialize, Serialize};
use serde_json::Value;
use sqlx::any::AnyRow;
use sqlx::{FromRow, Row};

use super::tensors::{self, Array};
use super::{Page, Store, StoreError, blocking, page};
use crate::mesh::TriangleMesh;
use crate::mesh::file_mesh::{FileMesh, Sound};
use crate::sketch::{Sketch, YAxis};

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

    /// The id of the content: the kind and 128 bits of the hash.
    fn id(self, content: blake3::Hash) -> String {
        format!("{}_{}", self.as_str(), &content.to_hex()[..32])
    }
}

/// What is known of an uploaded shape, beside its geometry.
#[derive(Clone, Debug, PartialEq)]
pub struct Shape {
    /// The kind, an underscore and 32 hexadecimal digits of the content's hash.
    pub id: String,
    pub kind: Kind,
    /// What the first to upload it called it.
    pub name: Option<String>,
    /// What its GET answers.
    pub body: Value,
    /// Milliseconds since 1970 by the database's clock.
    pub created_ms: i64,
}

impl Shape {
    /// The `Page::after` of the page that begins behind this shape.
    pub fn cursor(&self) -> String {
        page::cursor(self.created_ms, &self.id)
    }
}

impl<'r> FromRow<'r, AnyRow> for Shape {
    fn from_row(row: &'r AnyRow) -> Result<Shape, sqlx::Error> {
        let kind: &str = row.try_get("kind")?;
        Ok(Shape {
            id: row.try_get("id")?,
            kind: if kind == Kind::Sketch.as_str() { Kind::Sketch } else { Kind::Mesh },
            name: row.try_get("name")?,
            body: serde_json::from_str(row.try_get("body")?).map_err(sqlx::Error::decode)?,
            created_ms: row.try_get("created_ms")?,
        })
    }
}

impl Store {
    /// Keeps a mesh; the shape and whether its content is new. What is there already stays as it is.
    ///
    /// # Errors
    /// What the disk or the database said.
    pub async fn insert_mesh(
        &self,
        mesh: FileMesh,
        name: Option<&str>,
        body: Value,
    ) -> Result<(Shape, bool), StoreError> {
        let content = move || (Kind::Mesh.id(mesh.content_hash()), encode_mesh(&mesh));
        self.insert(Kind::Mesh, content, name, body).await
    }

    /// Keeps a sketch; the shape and whether its content is new. What is there already stays as it is.
    ///
    /// # Errors
    /// What the disk or the database said.
    pub async fn insert_sketch(
        &self,
        sketch: Sketch,
        name: Option<&str>,
        body: Value,
    ) -> Result<(Shape, bool), StoreError> {
        let note = (Y_AXIS, y_axis_name(sketch.y_axis()));
        let content = move || (Kind::Sketch.id(sketch.content_hash()), encode(sketch.mesh(), Some(note)));
        self.insert(Kind::Sketch, content, name, body).await
    }

    /// Keeps a shape whose id and bytes `content` takes its time to tell.
    async fn insert(
        &self,
        kind: Kind,
        content: impl FnOnce() -> (String, Result<Vec<u8>, SafeTensorError>) + Send + 'static,
        name: Option<&str>,
        body: Value,
    ) -> Result<(Shape, bool), StoreError> {
        let (id, bytes) = blocking(move || Ok(content())).await?;
        let bytes = bytes.map_err(|error| StoreError::damaged(&id, error))?;
        self.blobs.put(&blob(&id), bytes).await?;
        let sql = "INSERT INTO shapes (id, kind, name, body, created_ms) \
                   VALUES ($1, $2, $3, $4, (SELECT now_ms FROM clock)) ON CONFLICT (id) DO NOTHING";
        let query = sqlx::query(sql).bind(&id).bind(kind.as_str()).bind(name).bind(body.to_string());
        let new = query.execute(&self.pool).await?.rows_affected() == 1;
        let shape = self.shape(kind, &id).await?.ok_or(sqlx::Error::RowNotFound)?;
        Ok((shape, new))
    }

    /// The shape with this id, if there is one of this kind.
    ///
    /// # Errors
    /// What the database said.
    pub async fn shape(&self, kind: Kind, id: &str) -> Result<Option<Shape>, StoreError> {
        let sql = "SELECT * FROM shapes WHERE id = $1 AND kind = $2";
        Ok(sqlx::query_as(sql).bind(id).bind(kind.as_str()).fetch_optional(&self.pool).await?)
    }

    /// Shapes of one kind, newest first.
    ///
    /// # Errors
    /// [`StoreError::Cursor`], or what the database said.
    pub async fn shapes(&self, kind: Kind, page: &Page) -> Result<Vec<Shape>, StoreError> {
        let (created_ms, id) = page.bound()?;
        let sql = "SELECT * FROM shapes WHERE kind = $1 AND (created_ms, id) < ($2, $3) \
                   ORDER BY created_ms DESC, id DESC LIMIT $4";
        let query = sqlx::query_as(sql).bind(kind.as_str()).bind(created_ms).bind(id).bind(i64::from(page.limit));
        Ok(query.fetch_all(&self.pool).await?)
    }

    /// The geometry of a mesh, if there is one with this id.
    ///
    /// # Errors
    /// What the database or the disk said.
    pub async fn mesh(&self, id: &str) -> Result<Option<FileMesh>, StoreError> {
        self.geometry(Kind::Mesh, id, decode_mesh).await
    }

    /// The geometry of a sketch, if there is one with this id.
    ///
    /// # Errors
    /// What the database or the disk said.
    pub async fn sketch(&self, id: &str) -> Result<Option<Sketch>, StoreError> {
        self.geometry(Kind::Sketch, id, decode_sketch).await
    }

    async fn geometry<T: Send + 'static>(
        &self,
        kind: Kind,
        id: &str,
        decode: fn(&str, &[u8]) -> Result<T, String>,
    ) -> Result<Option<T>, StoreError> {
        if self.shape(kind, id).await?.is_none() {
            return Ok(None);
        }
        let name = blob(id);
        let Some(bytes) = self.blobs.read(&name).await? else {
            return Err(StoreError::damaged(name, "it is missing"));
        };
        let id = id.to_owned();
        blocking(move || decode(&id, &bytes).map(Some).map_err(|reason| StoreError::damaged(name, reason))).await
    }
}

fn blob(id: &str) -> String {
    format!("shapes/{id}.safetensors")
}

/// Header key of a sketch's blob, and its two values.
const Y_AXIS: &str = "y_axis";

fn y_axis_name(y_axis: YAxis) -> &'static str {
    match y_axis {
        YAxis::Up => "up",
        YAxis::Down => "down",
    }
}

fn encode_mesh(mesh: &FileMesh) -> Result<Vec<u8>, SafeTensorError> {
    let (positions, triangles, mends) = (mesh.positions(), mesh.triangles(), mesh.mends());
    let mut arrays = vec![
        Array::of_f64("positions", vec![positions.len(), 3], positions.iter().flatten().copied()),
        Array::of_u32("triangles", vec![triangles.len(), 3], triangles.iter().flatten().copied()),
    ];
    if let Some(Sound { triangles, origins, merged }) = &mends {
        arrays.push(Array::of_u32(SOUND, vec![triangles.len(), 3], triangles.iter().flatten().copied()));
        arrays.push(Array::of_u32(ORIGINS, vec![origins.len(), 1], origins.iter().copied()));
        arrays.push(Array::of_u32(MERGED, vec![merged.len(), 1], merged.iter().copied()));
    }
    tensors::encode(&arrays, None)
}

/// The arrays of a mesh that was mended, as [`Sound`] has them.
const SOUND: &str = "sound_triangles";
const ORIGINS: &str = "sound_origins";
const MERGED: &str = "merged";

/// What makes the sound mesh, where a blob has it.
fn mends(bytes: &[u8]) -> Result<Option<Sound>, SafeTensorError> {
    let file = SafeTensors::deserialize(bytes)?;
    if file.tensor(SOUND).is_err() {
        return Ok(None);
    }
    let triangles = tensors::matrix(&file, SOUND, Dtype::U32)?;
    let numbers = |name| -> Result<Vec<u32>, SafeTensorError> {
        let column = tensors::matrix(&file, name, Dtype::U32)?;
        Ok((0..column.rows).map(|i| u32::from_le_bytes(column.at(i, 0))).collect())
    };
    if triangles.columns != 3 {
        return Err(SafeTensorError::TensorInvalidInfo);
    }
    let triangle = |i| [0, 1, 2].map(|j| u32::from_le_bytes(triangles.at(i, j)));
    let triangles = (0..triangles.rows).map(triangle).collect();
    Ok(Some(Sound { triangles, origins: numbers(ORIGINS)?, merged: numbers(MERGED)? }))
}

fn encode(mesh: &TriangleMesh, note: Option<(&str, &str)>) -> Result<Vec<u8>, SafeTensorError> {
    let (positions, triangles) = (mesh.positions(), mesh.triangles());
    let arrays = [
        Array::of_f64("positions", vec![positions.len(), 3], positions.iter().flatten().copied()),
        Array::of_u32("triangles", vec![triangles.len(), 3], triangles.iter().flatten().copied()),
    ];
    tensors::encode(&arrays, note)
}

/// The mesh of this id. It was checked before it was stored, and its id tells that it is the same: to check it again
/// would take longer than all else that is read for a match.
fn decode_mesh(id: &str, bytes: &[u8]) -> Result<FileMesh, String> {
    let (positions, triangles) = arrays(bytes).map_err(|error| error.to_string())?;
    let mends = mends(bytes).map_err(|error| error.to_string())?;
    let mesh = FileMesh::recognised(positions, triangles, mends, |content| Kind::Mesh.id(content) == id);
    mesh.ok_or_else(|| "its content is not that of its id".to_owned())
}

fn decode_sketch(_id: &str, bytes: &[u8]) -> Result<Sketch, String> {
    let (_, header) = SafeTensors::read_metadata(bytes).map_err(|error| error.to_string())?;
    let y_axis = match header.metadata().as_ref().and_then(|notes| notes.get(Y_AXIS)).map(String::as_str) {
        Some("up") => YAxis::Up,
        Some("down") => YAxis::Down,
        _ => return Err("it does not say where y points".to_owned()),
    };
    let (positions, triangles) = arrays(bytes).map_err(|error| error.to_string())?;
    let mesh = TriangleMesh::new(positions, triangles).map_err(|refusal| refusal.to_string())?;
    Sketch::new(mesh, y_axis).map_err(|refusal| refusal.to_string())
}

type Arrays = (Vec<[f64; 3]>, Vec<[u32; 3]>);

fn arrays(bytes: &[u8]) -> Result<Arrays, SafeTensorError> {
    let file = SafeTensors::deserialize(bytes)?;
    let positions = tensors::matrix(&file, "positions", Dtype::F64)?;
    let triangles = tensors::matrix(&file, "triangles", Dtype::U32)?;
    if positions.columns != 3 || triangles.columns != 3 {
        return Err(SafeTensorError::TensorInvalidInfo);
    }
    let position = |i| [0, 1, 2].map(|j| f64::from_le_bytes(positions.at(i, j)));
    let triangle = |i| [0, 1, 2].map(|j| u32::from_le_bytes(triangles.at(i, j)));
    Ok(((0..positions.rows).map(position).collect(), (0..triangles.rows).map(triangle).collect()))
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;
    use crate::store::testing::{fresh, open};

    /// A unit square in two triangles, and a vertex of no triangle, moved by `x`.
    fn square(x: f64) -> FileMesh {
        let positions = [[x, 0.0, 0.0], [x + 1.0, 0.0, 0.0], [x + 1.0, 1.0, 0.0], [x, 1.0, 0.0], [9.0, 9.0, 0.1]];
        TriangleMesh::new(positions.to_vec(), vec![[0, 1, 2], [0, 2, 3]]).unwrap().into()
    }

    fn drawing(y_axis: YAxis) -> Sketch {
        let positions = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.3, 1.0, 0.0]];
        Sketch::new(TriangleMesh::new(positions, vec![[0, 1, 2]]).unwrap(), y_axis).unwrap()
    }

    #[tokio::test]
    async fn a_mesh_is_kept_whole_and_once() {
        let (directory, store) = fresh().await;
        let (shape, new) = store.insert_mesh(square(0.1), Some("one"), json!({"a": 1})).await.unwrap();
        assert!(new && shape.id.starts_with("mesh_") && shape.id.len() == 37, "{shape:?}");
        let (again, new) = store.insert_mesh(square(0.1), Some("two"), json!({"a": 2})).await.unwrap();
        assert!(!new);
        assert_eq!(again, shape);
        drop(store);
        let store = open(&directory).await;
        assert_eq!(store.shape(Kind::Mesh, &shape.id).await.unwrap().as_ref(), Some(&shape));
        assert_eq!(store.mesh(&shape.id).await.unwrap(), Some(square(0.1)));
        assert_eq!(store.sketch(&shape.id).await.unwrap(), None);
        assert_eq!(store.shape(Kind::Sketch, &shape.id).await.unwrap(), None);
    }

    #[tokio::test]
    async fn a_mesh_that_is_not_the_one_of_its_id_is_damaged() {
        let (_directory, store) = fresh().await;
        let (shape, _) = store.insert_mesh(square(0.1), None, json!({})).await.unwrap();
        store.blobs.delete(&blob(&shape.id)).await.unwrap();
        store.blobs.put(&blob(&shape.id), encode_mesh(&square(0.2)).unwrap()).await.unwrap();
        assert!(matches!(store.mesh(&shape.id).await, Err(StoreError::Damaged { .. })));
    }

    #[tokio::test]
    async fn a_sketch_keeps_its_axis() {
        let (_directory, store) = fresh().await;
        for y_axis in [YAxis::Up, YAxis::Down] {
            let (shape, new) = store.insert_sketch(drawing(y_axis), None, json!({})).await.unwrap();
            assert!(new && shape.id.starts_with("sketch_"), "{shape:?}");
            assert_eq!(store.sketch(&shape.id).await.unwrap(), Some(drawing(y_axis)));
            assert_eq!(store.mesh(&shape.id).await.unwrap(), None);
        }
    }

    #[tokio::test]
    async fn pages_go_from_the_newest_to_the_oldest() {
        let (_directory, store) = fresh().await;
        for x in 0..5 {
            store.insert_mesh(square(f64::from(x)), None, json!({})).await.unwrap();
        }
        store.insert_sketch(drawing(YAxis::Up), None, json!({})).await.unwrap();
        let whole = store.shapes(Kind::Mesh, &Page { after: None, limit: 100 }).await.unwrap();
        assert_eq!(whole.len(), 5);
        assert!(whole.is_sorted_by_key(|shape| std::cmp::Reverse((shape.created_ms, shape.id.clone()))));
        let mut paged = Vec::new();
        let mut after = None;
        loop {
            let page = store.shapes(Kind::Mesh, &Page { after, limit: 2 }).await.unwrap();
            after = page.last().map(Shape::cursor);
            paged.extend(page);
            if after.is_none() {
                break;
            }
        }
        assert_eq!(paged, whole);
    }

    #[tokio::test]
    async fn a_cursor_of_somebody_else_is_refused() {
        let (_directory, store) = fresh().await;
        for after in ["", "nonsense", "x.mesh_0"] {
            let page = Page { after: Some(after.to_owned()), limit: 1 };
            assert!(matches!(store.shapes(Kind::Mesh, &page).await, Err(StoreError::Cursor)), "{after}");
        }
    }
}
