//! Matches judged by what is known.

use std::sync::Arc;

use axum::http::{HeaderMap, StatusCode};
use axum::response::Response;
use bytes::Bytes;

use super::body::JsonBody;
use super::media_types::{CSV, JSON, PNG, SVG};
use super::pictures::{AnswerQuery, no_alternative};
use super::problem::{Fault, Problem};
use super::query::{Id, Query};
use super::representation::Wanted;
use super::{App, resource, shapes};
use crate::evaluation::{Evaluation, Known};
use crate::export::{Unwritten, evaluation};
use crate::intake::json;
use crate::picture::plot;
use crate::pipeline::Settings;
use crate::pipeline::outcome::MatchResult;
use crate::store::Shape;

/// Judges the answer of a match by what is known: true pairs of points, or labels of both shapes.
///
/// Errors of pairs are geodesic distances on the mesh in units of √area, of √(area / 2) where `side` is true. Nothing is kept: sent again, it is computed again. By `Accept`, `text/csv` answers a row per point, and of pairs `image/svg+xml` or `image/png` the curves.
#[utoipa::path(
    post, path = "/v1/matches/{id}/evaluations", operation_id = "evaluate_match", tag = "matches",
    params(("id" = String, Path), AnswerQuery),
    request_body = Known,
    responses(
        (status = 200, description = "what the answer is worth", content(
            (Evaluation = "application/json"), (String = "text/csv"), (String = "image/svg+xml"), ("image/png"),
        )),
        (status = 409, description = "not finished, or finished without a result"),
    ),
)]
pub async fn create(
    app: App,
    Id(id): Id,
    Query(query): Query<AnswerQuery>,
    headers: HeaderMap,
    body: JsonBody,
) -> Result<Response, Problem> {
    let wanted = Wanted::negotiated(headers, &[JSON, CSV, SVG, PNG])?;
    let result = resource::result::<Settings>(&app, &id).await?;
    let body = Arc::new(body);
    let (memory, read) = ((body.bytes.len() + result.len()).saturating_mul(json::MEMORY_OF_TREE), body.clone());
    let parsed = app.with_memory(memory, move || {
        let known = json::parsed::<Known>(&read.bytes)?;
        let result = serde_json::from_slice::<MatchResult>(&result).map_err(Problem::internal)?;
        Ok::<_, Problem>((known, result))
    });
    let (known, result) = parsed.await??;
    if matches!(known, Known::Labels(_)) && [SVG, PNG].contains(&wanted.media_type()) {
        let fault = Fault::in_header("accept", "labels have no curve: application/json or text/csv");
        return Err(Problem::of_fault(StatusCode::NOT_ACCEPTABLE, fault));
    }
    let Some(to) = result.answers(query.alternative) else { return Err(no_alternative(result.alternatives.len())) };
    let besides = |mesh: &Shape| known.numbers(to.len(), mesh.vertices) * size_of::<f64>();
    let mesh = shapes::mesh(&app, &result.mesh, besides).await?;
    let at: Vec<[f64; 2]> = result.correspondences.iter().map(|c| c.point).collect();
    let looked_at = app.off_runtime(move || (known.faults(&at, mesh.positions().len()), (known, mesh, at)));
    let (faults, (known, mesh, at)) = looked_at.await?;
    if !faults.is_empty() {
        let faults = faults.into_iter().map(|fault| Fault::at_pointer(fault.pointer, fault.detail));
        return Err(Problem::refused("the match cannot be judged by that", faults.collect()));
    }
    let write = move |media_type| written(&known.evaluation(&mesh, &at, &to), media_type);
    wanted.at_length().answer_once(&app, write).await
}

fn written(found: &Evaluation, media_type: &str) -> Result<Bytes, Unwritten> {
    Ok(match (media_type, found) {
        (CSV, _) => evaluation::csv(found),
        (SVG, Evaluation::Pairs(pairs)) => plot::svg(&[evaluation::plot_of(pairs)], 1).into(),
        (PNG, Evaluation::Pairs(pairs)) => plot::png(&[evaluation::plot_of(pairs)], 1)?.into(),
        _ => serde_json::to_vec(found)?.into(),
    })
}
