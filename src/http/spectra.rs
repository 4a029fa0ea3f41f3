//! Spectra of shapes: answered from the cache, queued where they are not there.

use std::time::Duration;

use axum::Json;
use axum::http::{HeaderMap, HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Response};
use bytes::Bytes;
use serde::{Deserialize, Serialize};
use utoipa::{IntoParams, ToSchema};

use super::App;
use super::held::Held;
use super::job_document::{Progress, Status};
use super::media_types::{JSON, NPY, SAFETENSORS};
use super::memory::LARGEST_ANSWER;
use super::problem::{Fault, Problem};
use super::query::{Id, Query};
use super::representation::Wanted;
use super::resource::LOOK_AGAIN;
use super::{memory, paths, shapes};
use crate::export::{Unwritten, spectrum};
use crate::jobs::{Decomposition, Task};
use crate::mesh::figure::Figure;
use crate::mesh::file_mesh::FileMesh;
use crate::spectral::{Boundary, Spectrum};
use crate::store::{NewJob, Shape, ShapeKind, SpectrumKey};

const DEFAULT_EIGENPAIRS: usize = 20;

/// How long a failed decomposition is answered before it is tried anew.
const FAILURE_STANDS: Duration = Duration::from_secs(600);

#[derive(Clone, Copy, Debug, Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
#[into_params(parameter_in = Query)]
pub struct SpectrumQuery {
    /// Number of eigenpairs; 20 where it is not given. Shapes have fewer than vertices, and a server answers up to its
    /// `--max-eigenpairs`.
    #[param(minimum = 1, maximum = 1000000)]
    k: Option<usize>,
    /// `neumann` where it is not given.
    boundary: Option<Boundary>,
}

/// The first eigenvalues of a shape, ascending.
#[derive(Serialize, ToSchema)]
pub struct SpectrumDocument {
    /// In units of 1/length².
    eigenvalues: Vec<f64>,
    k: usize,
    boundary: Boundary,
    cached: bool,
}

/// A spectrum that is being worked on.
#[derive(Serialize, ToSchema)]
pub struct PendingSpectrum {
    status: Status,
    progress: Progress,
}

/// Answers the spectrum of a mesh's largest component.
///
/// JSON holds the eigenvalues. By `Accept`, `application/x-npy` answers the eigenfunctions, a row per vertex of the uploaded
/// file, not a number outside the largest component, and `application/vnd.safetensors` both and the vertex masses. What is
/// not known yet is queued: ask again.
#[utoipa::path(
    get, path = "/v1/meshes/{id}/spectrum", operation_id = "read_mesh_spectrum", tag = "meshes", params(("id" = String, Path), SpectrumQuery),
    responses(
        (status = 200, description = "the spectrum", content(
            (SpectrumDocument = "application/json"), ("application/x-npy"), ("application/vnd.safetensors"),
        )),
        (status = 202, description = "queued", body = PendingSpectrum, headers(("Location" = String), ("Retry-After" = u32))),
        (status = 304, description = "unchanged"),
    ),
)]
pub async fn of_mesh(
    app: App,
    Id(id): Id,
    Query(query): Query<SpectrumQuery>,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    SpectrumOfShape::new(&app, ShapeKind::Mesh, id, query)?.answer(&app, headers).await
}

/// Answers the spectrum of a sketch, as that of a mesh.
#[utoipa::path(
    get, path = "/v1/sketches/{id}/spectrum", operation_id = "read_sketch_spectrum", tag = "sketches", params(("id" = String, Path), SpectrumQuery),
    responses(
        (status = 200, description = "the spectrum", content(
            (SpectrumDocument = "application/json"), ("application/x-npy"), ("application/vnd.safetensors"),
        )),
        (status = 202, description = "queued", body = PendingSpectrum, headers(("Location" = String), ("Retry-After" = u32))),
        (status = 304, description = "unchanged"),
    ),
)]
pub async fn of_sketch(
    app: App,
    Id(id): Id,
    Query(query): Query<SpectrumQuery>,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    SpectrumOfShape::new(&app, ShapeKind::Sketch, id, query)?.answer(&app, headers).await
}

/// One spectrum of one shape.
pub(super) struct SpectrumOfShape {
    pub kind: ShapeKind,
    pub id: String,
    pub k: usize,
    pub boundary: Boundary,
}

/// A spectrum, the part of the shape that was decomposed, and the shape.
pub(super) struct Decomposed {
    pub spectrum: Spectrum,
    pub figure: Figure,
    pub mesh: FileMesh,
}

/// What there is of it.
pub(super) enum Found {
    Spectrum(Box<Held<Decomposed>>),
    /// The answer while it is worked on.
    Pending(Response),
}

impl SpectrumOfShape {
    fn new(app: &App, kind: ShapeKind, id: String, query: SpectrumQuery) -> Result<SpectrumOfShape, Problem> {
        SpectrumOfShape::of(app, kind, id, query.k, query.boundary)
    }

    /// So many pairs, 20 where nothing is said.
    pub fn of(
        app: &App,
        kind: ShapeKind,
        id: String,
        k: Option<usize>,
        boundary: Option<Boundary>,
    ) -> Result<SpectrumOfShape, Problem> {
        let k = k.unwrap_or(DEFAULT_EIGENPAIRS);
        if !(1..=app.config.max_eigenpairs).contains(&k) {
            return Err(none_of(app.config.max_eigenpairs));
        }
        Ok(SpectrumOfShape { kind, id, k, boundary: boundary.unwrap_or(Boundary::Neumann) })
    }

    async fn answer(self, app: &App, headers: HeaderMap) -> Result<Response, Problem> {
        let wanted = Wanted::negotiated(headers, &[JSON, NPY, SAFETENSORS])?;
        let functions = if wanted.media_type() == JSON { 0 } else { self.k };
        let found = match self.found(app, functions).await? {
            Found::Spectrum(found) => found,
            Found::Pending(pending) => return Ok(pending),
        };
        let vertices = found.figure.of_file().len();
        if wanted.media_type() != JSON && vertices.saturating_mul(self.k * size_of::<f64>()) > LARGEST_ANSWER {
            return Err(none_of(LARGEST_ANSWER / size_of::<f64>() / vertices));
        }
        let write = move |media_type| match media_type {
            NPY => Ok(spectrum::npy(&found.spectrum, self.k, &found.figure)),
            SAFETENSORS => spectrum::safetensors(&found.spectrum, self.k, &found.figure),
            _ => Ok::<_, Unwritten>(self.document(&found.spectrum)?),
        };
        wanted.answer(app, write).await
    }

    /// The spectrum, of k pairs or more, where it is known, with room to answer so many numbers at every vertex of the file;
    /// else it is queued.
    ///
    /// # Errors
    /// 422 where there are not so many pairs, or they are too large; as [`SpectrumOfShape::pending`].
    pub async fn found(&self, app: &App, numbers: usize) -> Result<Found, Problem> {
        let (shape, shape_hash) = self.figure(app, numbers).await?;
        let matched = shape.1.vertices.len();
        if self.k >= matched {
            return Err(none_of(matched - 1));
        }
        if let Some(excess) = memory::excess(matched, self.k, app.config.max_job_memory) {
            return Err(Problem::refused("the spectrum is too large", vec![Fault::in_query("k", excess)]));
        }
        let key = SpectrumKey { shape_hash, boundary: self.boundary };
        Ok(match app.store.spectrum_of_any(&key, self.k).await? {
            Some(spectrum) => {
                Found::Spectrum(Box::new(shape.map(|(mesh, figure)| Decomposed { spectrum, figure, mesh })))
            }
            None => Found::Pending(self.pending(app).await?),
        })
    }

    /// The shape and the part of it that is decomposed, with room for the spectrum and the answer, and the hash of that part.
    async fn figure(&self, app: &App, numbers: usize) -> Result<(Held<(FileMesh, Figure)>, blake3::Hash), Problem> {
        let besides = |shape: &Shape| {
            let spectrum = memory::of_kept_spectrum(shape.matched, self.k);
            spectrum.saturating_add(memory::of_numbers(shape.vertices, numbers))
        };
        let mesh = match self.kind {
            ShapeKind::Mesh => shapes::mesh(app, &self.id, besides).await?,
            ShapeKind::Sketch => {
                let sketch = shapes::sketch(app, &self.id, besides).await?;
                sketch.map(|sketch| FileMesh::from(sketch.mesh().clone()))
            }
        };
        let looked_at = app.off_runtime(move || {
            let figure = Figure::largest(&mesh);
            let hash = figure.mesh.content_hash();
            (mesh.map(|mesh| (mesh, figure)), hash)
        });
        looked_at.await
    }

    fn document(&self, spectrum: &Spectrum) -> serde_json::Result<Bytes> {
        let eigenvalues = spectrum.eigenvalues.iter().copied().take(self.k).collect();
        let document = SpectrumDocument { eigenvalues, k: self.k, boundary: self.boundary, cached: true };
        serde_json::to_vec(&document).map(Bytes::from)
    }

    /// 202 while the spectrum is worked on.
    ///
    /// # Errors
    /// The problem of a decomposition that failed lately; 503 where the queue is full.
    async fn pending(&self, app: &App) -> Result<Response, Problem> {
        let SpectrumOfShape { kind, id, k, boundary } = self;
        let task = Decomposition { shape: id.clone(), kind: *kind, k: *k, boundary: *boundary };
        let payload = serde_json::to_string(&task).map_err(Problem::internal)?;
        if let Some(failure) = app.store.late_failure(&payload, FAILURE_STANDS).await? {
            return Err(Problem::of_job(failure.error.as_ref()));
        }
        let job = NewJob { dedupe: Some(&payload), ..task.job(&payload) };
        let job = app.queued(&job, None).await?;
        let boundary = match boundary {
            Boundary::Neumann => "neumann",
            Boundary::Dirichlet => "dirichlet",
        };
        let location = format!("{}/spectrum?k={k}&boundary={boundary}", paths::of_shape(*kind, id));
        let location = HeaderValue::try_from(location).map_err(Problem::internal)?;
        let document = PendingSpectrum {
            status: job.state.into(),
            progress: Progress { stage: job.stage, fraction: job.fraction },
        };
        let headers = [(header::LOCATION, location), (header::RETRY_AFTER, HeaderValue::from(LOOK_AGAIN))];
        Ok((StatusCode::ACCEPTED, headers, Json(document)).into_response())
    }
}

/// 422: there are so many eigenpairs, and not those asked for.
fn none_of(most: usize) -> Problem {
    Problem::refused("there is no such spectrum", vec![Fault::in_query("k", format!("k is from 1 to {most} here"))])
}

#[cfg(test)]
mod tests {
    use std::fs;
    use std::path::Path;
    use std::pin::pin;

    use serde_json::json;
    use tokio::time::timeout;

    use super::*;
    use crate::http::Config;
    use crate::http::testing::app;
    use crate::mesh::solids::sheet;
    use crate::numerics::{Unwatched, instruction_set};
    use crate::spectral::spectrum;
    use crate::store::testing::{Place, fresh, source};

    /// What answers, and a mesh whose spectrum is known.
    async fn known() -> (Place, App, String) {
        let (place, store) = fresh().await;
        let flat = Figure::largest(&sheet(6, 3).into()).mesh;
        let key = SpectrumKey { shape_hash: flat.content_hash(), boundary: Boundary::Neumann };
        let kept = spectrum(&flat, DEFAULT_EIGENPAIRS, Boundary::Neumann, &Unwatched).unwrap();
        store.put_spectrum(&key, kept, None).await.unwrap();
        let mesh = store.insert_mesh(flat.into(), source("v"), None, json!({})).await.unwrap().0.id;
        (place, app(store, Config::default()), mesh)
    }

    async fn answered(app: &App, mesh: &str) -> StatusCode {
        let query = Query(SpectrumQuery { k: None, boundary: None });
        of_mesh(app.clone(), Id(mesh.to_owned()), query, HeaderMap::new()).await.into_response().status()
    }

    #[tokio::test]
    async fn what_is_read_waits_for_room_and_gives_it_back() {
        let (_place, app, mesh) = known().await;
        let others = app.room_for(usize::MAX).await.ok().unwrap();
        let mut answer = pin!(answered(&app, &mesh));
        assert!(timeout(Duration::from_millis(200), &mut answer).await.is_err());
        drop(others);
        let status = timeout(Duration::from_secs(20), answer).await.unwrap();
        assert_eq!((status, app.reading_bytes()), (StatusCode::OK, 0));
    }

    #[tokio::test]
    async fn what_a_node_of_another_instruction_set_has_kept_is_answered() {
        let (place, app, mesh) = known().await;
        let within = |folder: &Path| fs::read_dir(folder).unwrap().next().unwrap().unwrap().path();
        let own = within(&within(&place.path().join("data/blobs/spectra")));
        let other = own.with_file_name(own.file_name().unwrap().to_str().unwrap().replace(instruction_set(), "other"));
        fs::rename(own, other).unwrap();
        assert_eq!(answered(&app, &mesh).await, StatusCode::OK);
    }
}
