//! A sketch that comes within the request for its match.

use bytes::Bytes;
use serde_json::Value;

use super::App;
use super::problem::Problem;
use crate::intake::sketch::{Drawing, SketchMeasures, untaken};
use crate::sketch::outline::OutlineRequest;
use crate::sketch::{Config, DEFAULT_TARGET_VERTICES, Sketch, from_outline};
use crate::store::{Source, Unkept};

/// A sketch that is read and not kept yet.
pub struct InlineSketch {
    pub sketch: Sketch,
    source: Source,
    /// What is told of it.
    body: Value,
}

impl InlineSketch {
    /// The sketch of a drawing that stands at the member `sketch` of a request.
    ///
    /// # Errors
    /// 422 with every fault of a drawing that cannot be matched.
    pub async fn of(app: &App, drawing: OutlineRequest) -> Result<InlineSketch, Problem> {
        app.off_runtime(move || InlineSketch::read(drawing)).await?
    }

    fn read(mut request: OutlineRequest) -> Result<InlineSketch, Problem> {
        request.target_vertices.get_or_insert(DEFAULT_TARGET_VERTICES);
        let bytes: Bytes = serde_json::to_vec(&request).map_err(Problem::internal)?.into();
        let (drawing, vertices) = request.into_parts();
        let imported = from_outline(&drawing, vertices, &Config::default());
        let imported = imported.map_err(|refusal| untaken(refusal).below("/sketch"))?;
        let body = serde_json::to_value(SketchMeasures::of(&imported)).map_err(Problem::internal)?;
        let media_type = Drawing::Outline.media_type().to_owned();
        let source = Source { bytes, media_type, parameters: String::new(), file_name: None };
        Ok(InlineSketch { sketch: imported.sketch, source, body })
    }

    /// The sketch with the id it would have if it had been uploaded by itself, to be kept with its match.
    ///
    /// # Errors
    /// What the store said.
    pub async fn unkept(self, app: &App) -> Result<Unkept, Problem> {
        Ok(app.store.unkept(self.sketch, self.source, self.body).await?)
    }
}
