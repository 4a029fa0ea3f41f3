//! The results of matches.

use axum::http::HeaderMap;
use axum::response::Response;
use serde::Deserialize;
use utoipa::IntoParams;

use super::media_types::{CSV, GLB, JSON, NPY};
use super::problem::Problem;
use super::query::{Id, Query};
use super::representation::Wanted;
use super::{App, pictures, resource};
use crate::export::picture::Form;
use crate::export::{correspondences, functional_map};
use crate::pipeline::Settings;
use crate::pipeline::outcome::MatchResult;

/// What is asked of a result.
#[derive(Debug, Default, Deserialize, IntoParams)]
#[into_params(parameter_in = Query)]
#[serde(default, deny_unknown_fields)]
pub struct ResultQuery {
    /// Of a match that runs: the answer at first sight, once there is one (the stage `preview` tells). Of a match that
    /// succeeded its result.
    preview: bool,
}

/// Answers the result of a match.
///
/// JSON holds all of it. By `Accept`, `text/csv` answers the correspondences as a table, `application/x-npy` C, and
/// `model/gltf-binary` the mesh in the colours of the sketch. With `preview=true` the answer at first sight will do: it is
/// there well before the result, on the best view of the mesh as it is, has `preview: true` and no alternatives, and is not
/// to be kept.
#[utoipa::path(
    get, path = "/v1/matches/{id}/result", operation_id = "read_result", tag = "matches", params(("id" = String, Path), ResultQuery),
    responses(
        (status = 200, description = "the result; the points, C, or the coloured mesh", content(
            (MatchResult = "application/json"), (String = "text/csv"), ("application/x-npy"), ("model/gltf-binary"),
        )),
        (status = 304, description = "unchanged"),
        (status = 409, description = "not finished, or finished without a result"),
    ),
)]
pub async fn read(
    app: App,
    Id(id): Id,
    Query(query): Query<ResultQuery>,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    let wanted = Wanted::negotiated(headers, &[JSON, CSV, NPY, GLB])?;
    let preview = if query.preview { resource::preview::<Settings>(&app, &id).await? } else { None };
    let (wanted, result) = match preview {
        Some(preview) => (wanted.passing(), preview),
        None => (wanted, resource::result::<Settings>(&app, &id).await?),
    };
    if wanted.media_type() == GLB {
        return pictures::drawn(&app, wanted, Form::Glb.into(), result).await;
    }
    let write = move |media_type| match media_type {
        CSV => correspondences::csv(&result),
        NPY => functional_map::npy(&result),
        _ => Ok(result),
    };
    wanted.answer(&app, write).await
}

#[cfg(test)]
mod tests {
    use axum::body::to_bytes;
    use axum::http::{StatusCode, header};
    use axum::response::IntoResponse;
    use bytes::Bytes;

    use super::*;
    use crate::http::Config;
    use crate::http::testing::app;
    use crate::jobs::Task;
    use crate::store::testing::{ALL, fresh};
    use crate::store::{NewJob, Places};

    #[tokio::test]
    async fn a_preview_is_answered_until_the_result_is_there() {
        let (_directory, store) = fresh().await;
        store.submit(&NewJob::of(Settings::NAME, "{}"), Places { queue: 1, of_kind: 1 }).await.unwrap();
        let lease = store.claim(&[Settings::NAME], ALL).await.unwrap().unwrap();
        let app = app(store.clone(), Config::default());
        let asked = async |preview: bool| {
            let query = Query(ResultQuery { preview });
            read(app.clone(), Id(lease.job.id.clone()), query, HeaderMap::new()).await.into_response()
        };
        assert_eq!(asked(true).await.status(), StatusCode::CONFLICT);
        store.preview(&lease, br#"{"preview": true}"#, 0.5).await.unwrap();
        assert_eq!(asked(false).await.status(), StatusCode::CONFLICT);
        let preview = asked(true).await;
        assert_eq!(
            (preview.status(), &preview.headers()[header::CACHE_CONTROL]),
            (StatusCode::OK, &"no-store".parse().unwrap())
        );
        assert_eq!(to_bytes(preview.into_body(), 99).await.unwrap(), &br#"{"preview": true}"#[..]);
        store.succeed(&lease, Bytes::from_static(b"{}")).await.unwrap();
        for preview in [false, true] {
            assert_eq!(to_bytes(asked(preview).await.into_body(), 99).await.unwrap(), &b"{}"[..]);
        }
    }
}
