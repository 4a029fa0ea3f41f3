//! The example creatures, from the list to a match.

use serde_json::json;

use crate::server::{Server, header, id, json_of, problem_of};

#[tokio::test(flavor = "multi_thread")]
async fn an_example_can_be_uploaded_as_it_comes() {
    let server = Server::working().await;
    let examples = server.read("/v1/examples").await;
    assert_eq!(examples.as_array().unwrap().len(), 2);
    let links = &examples[0]["links"];
    let mesh = server.get(links["mesh"].as_str().unwrap()).send().await.unwrap();
    assert_eq!(header(&mesh, "content-type"), "model/obj");
    let mesh = server.post("/v1/meshes").header("content-type", "model/obj").body(mesh.bytes().await.unwrap());
    let mesh = json_of(mesh.send().await.unwrap(), 201).await;
    let mut sketches = Vec::new();
    for form in ["application/json", "image/svg+xml", "image/png"] {
        let sketch = server.get(links["sketch"].as_str().unwrap()).header("accept", form).send().await.unwrap();
        assert_eq!(header(&sketch, "content-type"), form);
        let sketch = server.post("/v1/sketches").header("content-type", form).body(sketch.bytes().await.unwrap());
        let sketch = json_of(sketch.send().await.unwrap(), 201).await;
        assert!(sketch["vertices"].as_u64().unwrap() > 700, "{form}: {sketch}");
        sketches.push(id(&sketch));
    }
    let request = server.post("/v1/matches").json(&json!({"mesh": id(&mesh), "sketch": sketches[0]}));
    let done = json_of(request.header("prefer", "wait=60").send().await.unwrap(), 200).await;
    assert_eq!(server.read(done["links"]["result"].as_str().unwrap()).await["rating"], "high");
    problem_of(server.get("/v1/examples/unicorn/mesh").send().await.unwrap(), 404).await;
}
