//! Matches an example creature with a generated client: walk SERVER MESH SKETCH

use std::env;
use std::fs;

use anyhow::{Context, ensure};
use futures_util::StreamExt;
use sketchmatch_client::*;

#[tokio::main]
async fn main() -> anyhow::Result<()> {
    let arguments: Vec<String> = env::args().skip(1).collect();
    let [server, mesh_file, sketch_file] = arguments.as_slice() else { anyhow::bail!("walk SERVER MESH SKETCH") };
    let client = SketchmatchClient::with_base_url(server)?;

    let query = UploadMeshRequestQuery { name: Some("a cat".to_owned()), ..Default::default() };
    let request = UploadMeshRequest { query, header: Default::default(), body: fs::read(mesh_file)? };
    let mesh = match client.upload_mesh(request).await? {
        ApiResponse::Ok(mesh) | ApiResponse::Created(mesh) => mesh.body,
        other => anyhow::bail!("{other:?}"),
    };
    ensure!(mesh.closed && mesh.components == 1 && mesh.vertices > 4000, "{mesh:?}");

    let body: OutlineRequest = serde_json::from_slice(&fs::read(sketch_file)?)?;
    let request = UploadSketchRequest { query: Default::default(), header: Default::default(), body };
    let sketch = match client.upload_sketch(request).await? {
        ApiResponse::Ok(sketch) | ApiResponse::Created(sketch) => sketch.body,
        other => anyhow::bail!("{other:?}"),
    };
    ensure!(sketch.vertices > 700 && sketch.warnings.is_empty(), "{sketch:?}");

    let body = MatchRequest { mesh: mesh.id.clone(), sketch: MatchRequestSketch::String(sketch.id.clone()), ..Default::default() };
    let request = CreateMatchRequest { query: Default::default(), header: Default::default(), body };
    let asked = match client.create_match(request).await? {
        ApiResponse::Accepted(asked) => asked.body,
        other => anyhow::bail!("{other:?}"),
    };
    let id = asked.id;

    let path = FollowMatchRequestPath { id: id.clone() };
    let ApiResponse::Ok(mut events) =
        client.follow_match(FollowMatchRequest { path, header: Default::default() }).await?
    else {
        anyhow::bail!("no events")
    };
    let mut last = None;
    while let Some(event) = events.next().await {
        last = Some(event?.into_data());
    }
    let last = last.context("no event")?;
    ensure!(last.status == Status::Succeeded && last.progress.fraction == 1.0, "{last:?}");

    let path = ReadResultRequestPath { id: id.clone() };
    let ApiResponse::Ok(answer) = client.read_result(ReadResultRequest { path, query: Default::default() }).await? else {
        anyhow::bail!("no result")
    };
    ensure!(answer.correspondences.len() as i64 == sketch.vertices as i64);
    ensure!((answer.c.rows, answer.c.columns) == (20, 20) && answer.rating == Some(Rating::High), "{:?}", answer.rating);
    ensure!((&answer.mesh, &answer.sketch, &answer.r#match) == (&mesh.id, &sketch.id, &Some(id.clone())));

    let query = DrawMatchRequestQuery { width: Some(400), ..Default::default() };
    let request = DrawMatchRequest { path: DrawMatchRequestPath { id }, query };
    let ApiResponse::Ok(picture) = client.draw_match(request).await? else { anyhow::bail!("no picture") };
    ensure!(&picture[1..4] == b"PNG" && picture[16..20] == 400u32.to_be_bytes());

    let path = ReadMatchRequestPath { id: "none".to_owned() };
    let missing = client.read_match(ReadMatchRequest { path }).await?;
    ensure!(format!("{missing:?}").contains("404"), "{missing:?}");
    println!("matched {} points, {:?}", answer.correspondences.len(), answer.rating);
    Ok(())
}
