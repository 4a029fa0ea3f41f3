use std::sync::Mutex;
use std::sync::mpsc;

use bytes::Bytes;
use serde_json::{Value, json};
use tokio::task::JoinHandle;

use super::*;
use crate::jobs::{Decomposition, Posing, Task};
use crate::mesh::TriangleMesh;
use crate::numerics::Watch;
use crate::pipeline::Settings;
use crate::posing::request::PoseRequest;
use crate::spectral::Boundary;
use crate::store::testing::{ALL, Place, fresh, make_rests_short, source};
use crate::store::{Job, NewJob, Places, ShapeKind, SpectrumKey, State, Submitted};

const MATCH: &str = Settings::NAME;
const SPECTRUM: &str = Decomposition::NAME;

/// A worker in the background, on a store of its own.
struct Running {
    _directory: Place,
    store: Store,
    shutdown: CancellationToken,
    worker: JoinHandle<()>,
}

impl Running {
    async fn with(config: Config, body: impl Fn(&Lease, &Progress) -> Outcome + Send + Sync + 'static) -> Running {
        Running::beating(None, config, body).await
    }

    async fn beating(
        beat: Option<Duration>,
        config: Config,
        body: impl Fn(&Lease, &Progress) -> Outcome + Send + Sync + 'static,
    ) -> Running {
        let (directory, store) = fresh().await;
        let shutdown = CancellationToken::new();
        let pool = pool::of(config.workers).unwrap();
        let body = Box::new(move |lease: &Lease, _: &Bench, progress: &Progress| body(lease, progress));
        let workshop = Workshop::new(store.clone(), pool, config.longest_job, body);
        let workshop = Arc::new(Workshop { beat: beat.unwrap_or(workshop.beat), ..workshop });
        let token = shutdown.clone();
        let worker = tokio::spawn(async move { work(&workshop, &config, &token).await });
        Running { _directory: directory, store, shutdown, worker }
    }

    /// Computing what jobs say.
    async fn for_real() -> Running {
        let (directory, store) = fresh().await;
        let shutdown = CancellationToken::new();
        let running = run(store.clone(), one_thread(), shutdown.clone());
        let worker = tokio::spawn(async move { running.await.unwrap() });
        Running { _directory: directory, store, shutdown, worker }
    }

    async fn submit(&self, payload: Value) -> String {
        self.submit_of(MATCH, payload).await
    }

    async fn submit_of(&self, kind: &str, payload: Value) -> String {
        let places = Places { queue: 1000, of_kind: 1000 };
        match self.store.submit(&NewJob::of(kind, &payload.to_string()), places).await.unwrap() {
            Submitted::Taken(job) => job.id,
            refused => panic!("{refused:?}"),
        }
    }

    /// The job as soon as it is in this state.
    async fn reaches(&self, id: &str, state: State) -> Job {
        let mut changes = self.store.job_changes(id);
        loop {
            changes.seen();
            let job = self.store.job(id).await.unwrap().unwrap();
            if job.state == state {
                return job;
            }
            assert!(!job.state.finished(), "{job:?}");
            changes.changed().await;
        }
    }

    async fn stop(self) -> (Place, Store) {
        self.shutdown.cancel();
        self.worker.await.unwrap();
        (self._directory, self.store)
    }
}

fn one_thread() -> Config {
    Config { workers: 1, ..Config::default() }
}

/// Answers, panics, fails or goes on until it is stopped, as the payload says.
fn as_told(lease: &Lease, progress: &Progress) -> Outcome {
    match serde_json::from_str::<Value>(&lease.payload).unwrap().as_str() {
        Some("panic") => panic!("as told"),
        Some("fail") => Err(Failure::refused("as told", &[])),
        Some("try again") => Err(Failure::internal("as told", true)),
        Some("lack") if lease.job.attempt < 4 => Err(Failure::Lacking),
        Some("go on") => loop {
            if Watch::proceed(progress, 0.5).is_err() {
                return Err(Failure::Stopped);
            }
            thread::yield_now();
        },
        _ => Ok(Bytes::from(lease.payload.to_string())),
    }
}

#[tokio::test]
async fn jobs_are_carried_out() {
    let running = Running::with(Config { workers: 3, ..Config::default() }, as_told).await;
    let mut ids = Vec::new();
    for number in 0..10 {
        ids.push(running.submit(json!(number)).await);
    }
    for (number, id) in ids.iter().enumerate() {
        running.reaches(id, State::Succeeded).await;
        assert_eq!(running.store.result(id).await.unwrap(), Some(Bytes::from(number.to_string())));
    }
    running.stop().await;
}

#[tokio::test]
async fn a_panic_fails_the_job_and_spares_the_thread() {
    let running = Running::with(one_thread(), as_told).await;
    let (bad, good) = (running.submit(json!("panic")).await, running.submit(json!(1)).await);
    let failed = running.reaches(&bad, State::Failed).await;
    assert_eq!((failed.attempt, failed.error.unwrap()["status"].clone()), (1, json!(500)));
    running.reaches(&good, State::Succeeded).await;
    running.stop().await;
}

#[tokio::test]
async fn a_preview_is_there_while_its_job_runs() {
    let (go_on, told) = mpsc::channel::<()>();
    let told = Mutex::new(told);
    let body = move |_: &Lease, progress: &Progress| {
        progress.preview(Bytes::from_static(b"at first sight"));
        told.lock().unwrap().recv().unwrap();
        Ok(Bytes::from_static(b"looked at"))
    };
    // No beat comes between.
    let running = Running::beating(Some(Duration::from_secs(3600)), one_thread(), body).await;
    let id = running.submit(json!(1)).await;
    let mut changes = running.store.job_changes(&id);
    while running.store.previewed(&id).await.unwrap().is_none() {
        changes.changed().await;
    }
    assert_eq!(running.store.previewed(&id).await.unwrap().as_deref(), Some(&b"at first sight"[..]));
    assert_eq!(running.store.job(&id).await.unwrap().unwrap().stage.as_deref(), Some("preview"));
    go_on.send(()).unwrap();
    running.reaches(&id, State::Succeeded).await;
    assert_eq!(running.store.previewed(&id).await.unwrap(), None);
    assert_eq!(running.store.result(&id).await.unwrap().as_deref(), Some(&b"looked at"[..]));
    running.stop().await;
}

#[tokio::test]
async fn a_refusal_is_final_and_a_mishap_is_tried_again() {
    let running = Running::with(one_thread(), as_told).await;
    let (refused, mishap) = (running.submit(json!("fail")).await, running.submit(json!("try again")).await);
    let lacking = running.submit(json!("lack")).await;
    let store = running.store.clone();
    let hurry = tokio::spawn(async move { make_rests_short(&store).await });
    let refused = running.reaches(&refused, State::Failed).await;
    assert_eq!(refused.attempt, 1);
    let problem = json!({
        "type": "about:blank", "title": "Unprocessable Entity", "status": 422, "detail": "as told",
    });
    assert_eq!(refused.error, Some(problem));
    assert_eq!(running.reaches(&mishap, State::Failed).await.attempt, crate::store::MAX_TRIES);
    assert_eq!(running.reaches(&lacking, State::Succeeded).await.attempt, 4);
    hurry.abort();
    running.stop().await;
}

#[tokio::test]
async fn a_job_that_takes_more_than_is_free_waits_for_those_that_run() {
    let running = Running::with(Config { workers: 2, memory: 0, ..Config::default() }, as_told).await;
    let (shape, _) = running.store.insert_mesh(octahedron().into(), source(""), None, json!({})).await.unwrap();
    let places = Places { queue: 9, of_kind: 9 };
    let mut ids = Vec::new();
    for payload in ["\"go on\"", "1"] {
        let job = NewJob { mesh: Some(&shape.id), bytes_per_vertex: 1, ..NewJob::of(MATCH, payload) };
        let Submitted::Taken(job) = running.store.submit(&job, places).await.unwrap() else { panic!("there is place") };
        ids.push(job.id);
    }
    running.reaches(&ids[0], State::Running).await;
    // The job that runs is beaten for meanwhile, and a thread is free.
    running.store.job_changes(&ids[0]).changed().await;
    assert_eq!(running.store.queued(MATCH).await.unwrap(), 1);
    running.store.cancel(&ids[0]).await.unwrap();
    running.reaches(&ids[1], State::Succeeded).await;
    running.stop().await;
}

#[tokio::test]
async fn cancelling_stops_the_computation_and_frees_its_thread() {
    let running = Running::with(one_thread(), as_told).await;
    let (endless, next) = (running.submit(json!("go on")).await, running.submit(json!(1)).await);
    running.reaches(&endless, State::Running).await;
    assert_eq!(running.store.queued(MATCH).await.unwrap(), 1, "only as many jobs are claimed as there are threads");
    running.store.cancel(&endless).await.unwrap();
    running.reaches(&next, State::Succeeded).await;
    let (_directory, store) = running.stop().await;
    assert_eq!(store.job(&endless).await.unwrap().unwrap().state, State::Cancelled);
}

#[tokio::test]
async fn who_is_cancelled_is_told_without_a_beat() {
    let running = Running::beating(Some(Duration::from_secs(3600)), one_thread(), as_told).await;
    let endless = running.submit(json!("go on")).await;
    running.reaches(&endless, State::Running).await;
    let next = running.submit(json!(1)).await;
    running.store.cancel(&endless).await.unwrap();
    running.reaches(&next, State::Succeeded).await;
    running.stop().await;
}

#[tokio::test]
async fn a_job_that_takes_too_long_fails_and_gives_its_thread_free() {
    let config = Config { longest_job: Duration::from_millis(100), ..one_thread() };
    let running = Running::with(config, as_told).await;
    let (endless, next) = (running.submit(json!("go on")).await, running.submit(json!(1)).await);
    let failed = running.reaches(&endless, State::Failed).await;
    let error = failed.error.unwrap();
    assert_eq!((&error["status"], failed.attempt), (&json!(422), 1));
    assert!(error["detail"].as_str().unwrap().contains("longer than the 0.1 s"), "{error}");
    running.reaches(&next, State::Succeeded).await;
    running.stop().await;
}

#[tokio::test]
async fn an_outcome_is_told_when_the_store_has_what_it_takes_again() {
    let running = Running::with(one_thread(), as_told).await;
    let blobs = running._directory.path().join("data/blobs");
    let elsewhere = running._directory.path().join("elsewhere");
    std::fs::rename(&blobs, &elsewhere).unwrap();
    let id = running.submit(json!(7)).await;
    let mut changes = running.store.job_changes(&id);
    while running.store.job(&id).await.unwrap().unwrap().stage.is_none() {
        changes.changed().await;
    }
    std::fs::rename(&elsewhere, &blobs).unwrap();
    assert_eq!(running.reaches(&id, State::Succeeded).await.attempt, 1, "it is not computed anew");
    running.stop().await;
}

#[tokio::test]
async fn many_spectra_do_not_keep_a_match_waiting() {
    let running = Running::with(Config { workers: 2, ..Config::default() }, as_told).await;
    let mut spectra = Vec::new();
    for _ in 0..4 {
        spectra.push(running.submit_of(SPECTRUM, json!("go on")).await);
    }
    running.reaches(&spectra[0], State::Running).await;
    let id = running.submit(json!(1)).await;
    running.reaches(&id, State::Succeeded).await;
    assert_eq!(running.store.queued(SPECTRUM).await.unwrap(), 3);
    for id in spectra {
        running.store.cancel(&id).await.unwrap();
    }
    running.stop().await;
}

#[tokio::test]
async fn progress_is_reported_while_it_computes() {
    let running = Running::with(one_thread(), as_told).await;
    let id = running.submit(json!("go on")).await;
    let mut changes = running.store.job_changes(&id);
    let job = loop {
        let job = running.store.job(&id).await.unwrap().unwrap();
        if job.stage.is_some() {
            break job;
        }
        changes.changed().await;
    };
    assert_eq!((job.stage.as_deref(), job.fraction), (Some("spectrum"), 0.5));
    running.store.cancel(&id).await.unwrap();
    running.stop().await;
}

#[tokio::test]
async fn a_stop_lets_running_jobs_finish() {
    let (sender, receiver) = mpsc::channel::<()>();
    let receiver = Mutex::new(receiver);
    let running = Running::with(one_thread(), move |_, _| {
        receiver.lock().unwrap().recv().unwrap();
        Ok(Bytes::from_static(b"in time"))
    })
    .await;
    let (first, second) = (running.submit(json!(1)).await, running.submit(json!(2)).await);
    running.reaches(&first, State::Running).await;
    running.shutdown.cancel();
    sender.send(()).unwrap();
    let (_directory, store) = running.stop().await;
    assert_eq!(store.result(&first).await.unwrap(), Some(Bytes::from_static(b"in time")));
    assert_eq!(store.job(&second).await.unwrap().unwrap().state, State::Queued);
}

#[tokio::test]
async fn after_the_grace_running_jobs_are_given_back() {
    let running = Running::with(Config { grace: Duration::ZERO, ..one_thread() }, as_told).await;
    let id = running.submit(json!("go on")).await;
    running.reaches(&id, State::Running).await;
    let (_directory, store) = running.stop().await;
    let job = store.job(&id).await.unwrap().unwrap();
    assert_eq!((job.state, job.started_ms, job.stage), (State::Queued, None, None));
    assert_eq!(store.claim(&[MATCH], ALL).await.unwrap().unwrap().job.attempt, 2);
}

fn octahedron() -> TriangleMesh {
    let positions = [[1., 0., 0.], [-1., 0., 0.], [0., 1., 0.], [0., -1., 0.], [0., 0., 1.], [0., 0., -1.]].to_vec();
    let (top, bottom) = ([[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4]], [[2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]]);
    TriangleMesh::new(positions, [top, bottom].concat()).unwrap()
}

#[tokio::test]
async fn a_spectrum_is_computed_and_kept() {
    let running = Running::for_real().await;
    let (shape, _) = running.store.insert_mesh(octahedron().into(), source(""), None, json!({})).await.unwrap();
    let task = Decomposition { shape: shape.id, kind: ShapeKind::Mesh, k: 4, boundary: Boundary::Neumann };
    let job = running.submit_of(SPECTRUM, json!(task)).await;
    running.reaches(&job, State::Succeeded).await;
    let result = running.store.result(&job).await.unwrap().unwrap();
    let result: Value = serde_json::from_slice(&result).unwrap();
    let key = SpectrumKey { shape_hash: octahedron().content_hash(), boundary: Boundary::Neumann };
    let kept = running.store.spectrum(&key, 4).await.unwrap().unwrap();
    assert_eq!(result["eigenvalues"], json!(kept.eigenvalues[..4]));
    // Three coordinate functions share one eigenvalue by symmetry.
    assert!(kept.eigenvalues[0] == 0.0 && (kept.eigenvalues[3] / kept.eigenvalues[1] - 1.0).abs() < 1e-9);
    running.stop().await;
}

#[tokio::test]
async fn a_spectrum_that_cannot_be_is_refused_with_the_reason() {
    let running = Running::for_real().await;
    let (shape, _) = running.store.insert_mesh(octahedron().into(), source(""), None, json!({})).await.unwrap();
    let too_long = Decomposition { shape: shape.id, kind: ShapeKind::Mesh, k: 7, boundary: Boundary::Neumann };
    let nobody = Decomposition { shape: "mesh_nobody".to_owned(), ..too_long.clone() };
    for (task, reason) in [(too_long, "7 eigenfunctions"), (nobody, "no mesh mesh_nobody")] {
        let job = running.submit_of(SPECTRUM, json!(task)).await;
        let error = running.reaches(&job, State::Failed).await.error.unwrap();
        assert_eq!(error["status"], 422);
        assert!(error["detail"].as_str().unwrap().contains(reason), "{error}");
    }
    running.stop().await;
}

#[tokio::test]
async fn a_pose_of_a_match_that_is_gone_is_refused_with_the_reason() {
    let running = Running::for_real().await;
    let (shape, _) = running.store.insert_mesh(octahedron().into(), source(""), None, json!({})).await.unwrap();
    let request = PoseRequest { matching: "gone".to_owned(), ..PoseRequest::default() };
    let task = Posing { request, mesh: shape.id, sketch: "sketch_nobody".to_owned() };
    let job = running.submit_of(Posing::NAME, json!(task)).await;
    let error = running.reaches(&job, State::Failed).await.error.unwrap();
    assert_eq!((&error["status"], &error["detail"]), (&json!(422), &json!("there is no sketch sketch_nobody")));
    running.stop().await;
}
