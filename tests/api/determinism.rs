//! The same question gets the same answer to the byte: whatever the number of workers, the state of the caches, and
//! however often the server was started in between.

use std::path::Path;

use bytes::Bytes;
use reqwest::Client;
use serde_json::{Value, json};
use sketchmatch::example::{self, SIZES};

use crate::client::client;
use crate::program::{Program, end};
use crate::server::{id, json_of};

const PRESETS: [&str; 2] = ["automatic", "thesis"];

/// What is read of a match beside its result: the path below it, and the form.
const VIEWS: [(&str, &str); 7] = [
    ("result", "text/csv"),
    ("result", "application/x-npy"),
    ("picture", "image/png"),
    ("picture", "image/svg+xml"),
    ("matrix", "image/png"),
    ("matrix", "image/svg+xml"),
    ("mesh.glb", "model/gltf-binary"),
];

/// The forms of a spectrum.
const SPECTRA: [&str; 3] = ["application/json", "application/x-npy", "application/vnd.safetensors"];

/// A server to be asked.
struct Asked {
    program: Program,
    client: Client,
}

impl Asked {
    fn start(data: &Path, workers: usize) -> Asked {
        Asked { program: Program::start(data, workers), client: client() }
    }

    async fn read(&self, path: &str, accept: &str) -> (u16, Bytes) {
        let answer = self.client.get(self.program.url(path)).header("accept", accept).send().await.unwrap();
        (answer.status().as_u16(), answer.bytes().await.unwrap())
    }

    /// The ids of the smallest example, uploaded: of the mesh and of the sketch.
    async fn shapes(&self) -> [String; 2] {
        let files = example::files(*SIZES.start()).unwrap();
        let mut ids = Vec::new();
        for (name, path) in [("quadruped/mesh.obj", "/v1/meshes"), ("quadruped/sketch.svg", "/v1/sketches")] {
            let (_, file) = files.iter().find(|(file, _)| file == name).unwrap();
            let upload = self.client.post(self.program.url(path)).body(file.clone()).send().await.unwrap();
            ids.push(id(&upload.json().await.unwrap()));
        }
        ids.try_into().unwrap()
    }

    /// The paths of a match by each preset, all queued before the first is looked at.
    async fn matches(&self) -> Vec<String> {
        let [mesh, sketch] = self.shapes().await;
        let mut paths = Vec::new();
        for preset in PRESETS {
            let request = json!({"mesh": mesh, "sketch": sketch, "preset": preset});
            let answer = self.client.post(self.program.url("/v1/matches")).json(&request).send().await.unwrap();
            paths.push(json_of(answer, 202).await["links"]["self"].as_str().unwrap().to_owned());
        }
        paths
    }

    /// All that can be read of finished matches, but for their ids and times.
    async fn answers(&self, paths: &[String]) -> Vec<(String, Bytes)> {
        let mut answers = Vec::new();
        for (preset, path) in PRESETS.iter().zip(paths) {
            let document = end(&self.program, &self.client, path).await;
            assert_eq!(document["status"], "succeeded", "{document}");
            let (_, result) = self.read(&format!("{path}/result"), "application/json").await;
            let result: Value = serde_json::from_slice(&result).unwrap();
            for (name, value) in result.as_object().unwrap().iter().filter(|(name, _)| !is_of_the_run(name)) {
                answers.push((format!("{preset}: {name}"), value.to_string().into()));
            }
            for (view, form) in VIEWS {
                let (status, body) = self.read(&format!("{path}/{view}"), form).await;
                assert_eq!(status, 200, "{view} as {form}");
                answers.push((format!("{preset}: {view} as {form}"), body));
            }
        }
        let [mesh, sketch] = self.shapes().await;
        for shape in [format!("meshes/{mesh}"), format!("sketches/{sketch}")] {
            for form in SPECTRA {
                let (status, body) = self.read(&format!("/v1/{shape}/spectrum?k=20"), form).await;
                assert_eq!(status, 200, "{shape} as {form}");
                answers.push((format!("the spectrum of {shape} as {form}"), body));
            }
        }
        answers
    }

    /// Fills the cache with a longer spectrum than a match needs.
    async fn know_more(&self) {
        let path = format!("/v1/meshes/{}/spectrum?k=60", self.shapes().await[0]);
        while self.read(&path, "application/json").await.0 == 202 {
            tokio::task::yield_now().await;
        }
    }
}

/// The members of a result that are of this run of the match and not of its answer.
fn is_of_the_run(name: &str) -> bool {
    ["match", "timings_ms"].contains(&name)
}

fn assert_same(found: &[(String, Bytes)], expected: &[(String, Bytes)], when: &str) {
    let names = |answers: &[(String, Bytes)]| answers.iter().map(|(name, _)| name.clone()).collect::<Vec<_>>();
    assert_eq!(names(found), names(expected), "{when}");
    let other = found.iter().zip(expected).filter(|(found, expected)| found != expected);
    assert_eq!(names(&other.map(|(found, _)| found.clone()).collect::<Vec<_>>()), [""; 0], "{when}");
}

#[tokio::test(flavor = "multi_thread")]
async fn an_answer_depends_on_the_question_alone() {
    let (data, fresh) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let server = Asked::start(data.path(), 1);
    let paths = server.matches().await;
    let expected = server.answers(&paths).await;
    let repeated = server.answers(&server.matches().await).await;
    assert_same(&repeated, &expected, "asked again, all spectra known");
    drop(server);

    let restarted = Asked::start(data.path(), 1);
    assert_same(&restarted.answers(&paths).await, &expected, "read after a restart");
    assert_same(&restarted.answers(&restarted.matches().await).await, &expected, "asked after a restart");

    let other = Asked::start(fresh.path(), 2);
    other.know_more().await;
    assert_same(&other.answers(&other.matches().await).await, &expected, "two workers and a longer spectrum known");
}
