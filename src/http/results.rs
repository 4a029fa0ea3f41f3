//! The results of matches.

use axum::extract::State;
use axum::http::HeaderMap;
use axum::response::Response;
use bytes::Bytes;
use serde::Deserialize;

use super::npy;
use super::pictures::{self, Form, GLB};
use super::problem::Problem;
use super::query::Id;
use super::representation::{JSON, NPY, Wanted};
use super::{App, stored_result};
use crate::pipeline::outcome::MatchResult;

const CSV: &str = "text/csv";

/// Answers the result of a match.
///
/// JSON holds all of it. By `Accept`, `text/csv` answers the correspondences as a table, `application/x-npy` C, and
/// `model/gltf-binary` the mesh in the colours of the sketch.
#[utoipa::path(
    get, path = "/v1/matches/{id}/result", operation_id = "read_result", tag = "matches", params(("id" = String, Path)),
    responses(
        (status = 200, description = "the result", body = MatchResult),
        (status = 304, description = "unchanged"),
        (status = 409, description = "not finished, or finished without a result"),
    ),
)]
pub async fn read(State(app): State<App>, Id(id): Id, headers: HeaderMap) -> Result<Response, Problem> {
    let wanted = Wanted::negotiated(headers, &[JSON, CSV, NPY, GLB])?;
    let result = stored_result::of_match(&app, &id).await?;
    if wanted.media_type() == GLB {
        return pictures::drawn(&app, wanted, Form::Glb.into(), result).await;
    }
    let write = move |media_type| match media_type {
        CSV => csv(&result),
        NPY => matrix(&result),
        _ => Ok(result),
    };
    wanted.answer(&app, write).await
}

/// What a table of the correspondences needs of a result.
#[derive(Deserialize)]
struct Points {
    correspondences: Vec<Correspondence>,
}

#[derive(Deserialize)]
struct Correspondence {
    sketch_vertex: u64,
    point: [f64; 2],
    mesh_vertex: u64,
    confidence: Option<f64>,
}

/// The correspondences as a table with a header; an empty field where a confidence is not known.
fn csv(result: &[u8]) -> serde_json::Result<Bytes> {
    let Points { correspondences } = serde_json::from_slice(result)?;
    let mut table = String::from("sketch_vertex,x,y,mesh_vertex,confidence\r\n");
    for Correspondence { sketch_vertex, point: [x, y], mesh_vertex, confidence } in correspondences {
        let confidence = confidence.map(|value| value.to_string()).unwrap_or_default();
        table.push_str(&format!("{sketch_vertex},{x},{y},{mesh_vertex},{confidence}\r\n"));
    }
    Ok(table.into())
}

/// What an array of C needs of a result.
#[derive(Deserialize)]
struct Map {
    c: Matrix,
}

#[derive(Deserialize)]
struct Matrix {
    rows: usize,
    columns: usize,
    values: Vec<Vec<f64>>,
}

/// C as an array, mesh by sketch.
fn matrix(result: &[u8]) -> serde_json::Result<Bytes> {
    let Map { c: Matrix { rows, columns, values } } = serde_json::from_slice(result)?;
    Ok(npy::file(rows, columns, values.into_iter().flatten()).into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tabulates_correspondences() {
        let result = br#"{"correspondences": [{"sketch_vertex": 0, "point": [1.5, -2], "mesh_vertex": 7, "confidence": 0.5},
                                              {"sketch_vertex": 1, "point": [0, 0], "mesh_vertex": 8, "confidence": null}]}"#;
        let table = csv(result).unwrap();
        assert_eq!(table, "sketch_vertex,x,y,mesh_vertex,confidence\r\n0,1.5,-2,7,0.5\r\n1,0,0,8,\r\n");
    }

    #[test]
    fn lays_out_c_by_rows() {
        let file = matrix(br#"{"c": {"rows": 2, "columns": 1, "values": [[1], [2]]}}"#).unwrap();
        assert_eq!(file[file.len() - 16..], [1f64.to_le_bytes(), 2f64.to_le_bytes()].concat());
    }
}
