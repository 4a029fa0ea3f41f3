use serde_json::json;

use super::*;
use crate::store::testing::{fresh, open};

async fn submitted(store: &Store, number: i64) -> Job {
    store.submit(JobKind::Match, &number.to_string(), None).await.unwrap()
}

async fn claimed(store: &Store) -> Lease {
    store.claim().await.unwrap().expect("a job waits")
}

async fn state(store: &Store, id: &str) -> State {
    store.job(id).await.unwrap().unwrap().state
}

/// Lets every lease run out.
async fn expire(store: &Store) {
    sqlx::query("UPDATE jobs SET lease_ms = 0 WHERE state = 'running'").execute(&store.pool).await.unwrap();
}

async fn results(store: &Store) -> Vec<String> {
    store.blobs.names("results").await.unwrap()
}

#[tokio::test]
async fn jobs_are_claimed_in_order_spectra_first() {
    let (_directory, store) = fresh().await;
    let mut expected = Vec::new();
    for number in 0..5 {
        expected.push(submitted(&store, number).await.id);
    }
    expected.insert(0, store.submit(JobKind::Spectrum, "{}", None).await.unwrap().id);
    assert_eq!(store.queued().await.unwrap(), 6);
    for id in expected {
        assert_eq!(claimed(&store).await.job.id, id);
    }
    assert!(store.claim().await.unwrap().is_none());
    assert_eq!(store.queued().await.unwrap(), 0);
}

#[tokio::test]
async fn a_job_goes_from_queued_to_succeeded() {
    let (_directory, store) = fresh().await;
    let job = submitted(&store, 7).await;
    assert_eq!((job.state, job.attempt, job.revision, job.started_ms), (State::Queued, 0, 0, None));
    let lease = claimed(&store).await;
    assert_eq!((lease.job.state, lease.job.attempt, lease.job.revision), (State::Running, 1, 1));
    assert_eq!(&*lease.payload, "7");
    assert!(lease.job.started_ms >= Some(job.created_ms));
    assert_eq!(store.beat(&lease, "map", 0.25).await.unwrap(), Beat::Held);
    assert_eq!(store.beat(&lease, "map", 0.25).await.unwrap(), Beat::Held);
    let running = store.job(&job.id).await.unwrap().unwrap();
    assert_eq!((running.stage.as_deref(), running.fraction, running.revision), (Some("map"), 0.25, 2));
    assert_eq!(store.result(&job.id).await.unwrap(), None);
    assert!(store.succeed(&lease, Bytes::from_static(b"answer")).await.unwrap());
    let done = store.job(&job.id).await.unwrap().unwrap();
    assert_eq!((done.state, done.stage.as_deref()), (State::Succeeded, Some("finished")));
    assert_eq!((done.fraction, done.revision), (1.0, 3));
    assert!(done.finished_ms >= done.started_ms && done.started_ms.is_some());
    assert_eq!(store.result(&job.id).await.unwrap(), Some(Bytes::from_static(b"answer")));
}

#[tokio::test]
async fn progress_is_a_number_between_0_and_1() {
    let (_directory, store) = fresh().await;
    let job = submitted(&store, 0).await;
    let lease = claimed(&store).await;
    for (told, kept) in [(f64::NAN, 0.0), (-1.0, 0.0), (2.0, 1.0)] {
        assert_eq!(store.beat(&lease, "map", told).await.unwrap(), Beat::Held);
        assert_eq!(store.job(&job.id).await.unwrap().unwrap().fraction, kept);
    }
}

#[tokio::test]
async fn an_old_lease_is_fenced_off() {
    let (_directory, store) = fresh().await;
    let job = submitted(&store, 0).await;
    let old = claimed(&store).await;
    expire(&store).await;
    assert_eq!(store.reap().await.unwrap(), 1);
    let new = claimed(&store).await;
    assert_eq!((new.job.id.as_str(), new.job.attempt), (job.id.as_str(), 2));
    let before = store.job(&job.id).await.unwrap();
    assert_eq!(store.beat(&old, "map", 0.5).await.unwrap(), Beat::Lost);
    assert!(!store.succeed(&old, Bytes::from_static(b"old")).await.unwrap());
    assert!(!store.fail(&old, &json!({}), false).await.unwrap());
    assert!(!store.fail(&old, &json!({}), true).await.unwrap());
    assert!(!store.release(&old).await.unwrap());
    assert_eq!(store.job(&job.id).await.unwrap(), before);
    assert_eq!(results(&store).await, Vec::<String>::new());
    assert!(store.succeed(&new, Bytes::from_static(b"new")).await.unwrap());
    assert!(!store.succeed(&new, Bytes::from_static(b"twice")).await.unwrap());
    assert_eq!(store.result(&job.id).await.unwrap(), Some(Bytes::from_static(b"new")));
}

#[tokio::test]
async fn a_lease_that_stands_is_not_reaped() {
    let (_directory, store) = fresh().await;
    submitted(&store, 0).await;
    let lease = claimed(&store).await;
    assert_eq!(store.reap().await.unwrap(), 0);
    assert_eq!(store.beat(&lease, "map", 0.5).await.unwrap(), Beat::Held);
}

#[tokio::test]
async fn a_job_that_always_kills_its_process_fails_in_the_end() {
    let (directory, mut store) = fresh().await;
    let job = submitted(&store, 0).await;
    for attempt in 1..=MAX_TRIES {
        assert_eq!(claimed(&store).await.job.attempt, attempt);
        drop(store);
        store = open(&directory).await;
    }
    assert!(store.claim().await.unwrap().is_none());
    let failed = store.job(&job.id).await.unwrap().unwrap();
    assert_eq!(failed.state, State::Failed);
    assert!(failed.error.unwrap()["detail"].as_str().unwrap().contains(&format!("tried {MAX_TRIES} times")));
    assert!(failed.finished_ms.is_some());
}

#[tokio::test]
async fn retries_are_counted_and_releases_are_not() {
    let (_directory, store) = fresh().await;
    let job = submitted(&store, 0).await;
    for _ in 0..2 * MAX_TRIES {
        assert!(store.release(&claimed(&store).await).await.unwrap());
    }
    let error = json!({ "detail": "no luck" });
    for _ in 1..MAX_TRIES {
        assert!(store.fail(&claimed(&store).await, &error, true).await.unwrap());
        assert_eq!(state(&store, &job.id).await, State::Queued);
    }
    assert!(store.fail(&claimed(&store).await, &error, true).await.unwrap());
    let failed = store.job(&job.id).await.unwrap().unwrap();
    assert_eq!((failed.state, failed.error), (State::Failed, Some(error)));
    assert_eq!(failed.attempt, 3 * MAX_TRIES);
}

#[tokio::test]
async fn a_failure_without_retry_is_final() {
    let (_directory, store) = fresh().await;
    let job = submitted(&store, 0).await;
    assert!(store.fail(&claimed(&store).await, &json!({}), false).await.unwrap());
    assert_eq!(state(&store, &job.id).await, State::Failed);
}

#[tokio::test]
async fn cancelling_ends_a_queued_job_and_tells_the_worker_of_a_running_one() {
    let (_directory, store) = fresh().await;
    let (running, queued) = (submitted(&store, 0).await, submitted(&store, 1).await);
    let lease = claimed(&store).await;
    for id in [&running.id, &queued.id] {
        let job = store.cancel(id).await.unwrap().unwrap();
        assert!(job.state == State::Cancelled && job.finished_ms.is_some(), "{job:?}");
    }
    assert!(store.claim().await.unwrap().is_none());
    assert_eq!(store.beat(&lease, "map", 0.5).await.unwrap(), Beat::Cancelled);
    assert!(!store.succeed(&lease, Bytes::from_static(b"late")).await.unwrap());
    assert!(!store.release(&lease).await.unwrap());
    assert_eq!(state(&store, &running.id).await, State::Cancelled);
    assert_eq!(results(&store).await, Vec::<String>::new());
}

#[tokio::test]
async fn cancelling_leaves_finished_jobs_alone() {
    let (_directory, store) = fresh().await;
    let job = submitted(&store, 0).await;
    store.succeed(&claimed(&store).await, Bytes::new()).await.unwrap();
    assert_eq!(store.cancel(&job.id).await.unwrap(), store.job(&job.id).await.unwrap());
    assert_eq!(state(&store, &job.id).await, State::Succeeded);
    assert_eq!(store.cancel("nobody").await.unwrap(), None);
}

#[tokio::test]
async fn deleting_takes_the_job_and_its_result() {
    let (_directory, store) = fresh().await;
    let job = submitted(&store, 0).await;
    assert!(!store.delete(&job.id).await.unwrap());
    let lease = claimed(&store).await;
    assert!(!store.delete(&job.id).await.unwrap());
    store.succeed(&lease, Bytes::from_static(b"answer")).await.unwrap();
    assert_eq!(results(&store).await.len(), 1);
    assert!(store.delete(&job.id).await.unwrap());
    assert_eq!((store.job(&job.id).await.unwrap(), results(&store).await), (None, Vec::new()));
    assert!(!store.delete(&job.id).await.unwrap());
    assert_eq!(store.beat(&lease, "map", 1.0).await.unwrap(), Beat::Lost);
}

#[tokio::test]
async fn an_unfinished_job_answers_for_its_equals() {
    let (_directory, store) = fresh().await;
    let submit = || store.submit(JobKind::Spectrum, "null", Some("key"));
    let first = submit().await.unwrap();
    assert_eq!(submit().await.unwrap(), first);
    let lease = claimed(&store).await;
    assert_eq!(submit().await.unwrap().id, first.id);
    store.succeed(&lease, Bytes::new()).await.unwrap();
    let second = submit().await.unwrap();
    assert_ne!(second.id, first.id);
    store.cancel(&second.id).await.unwrap();
    assert_ne!(submit().await.unwrap().id, second.id);
    let other = store.submit(JobKind::Spectrum, "null", Some("other")).await.unwrap();
    assert_eq!(other.state, State::Queued);
    assert_eq!(store.queued().await.unwrap(), 2);
}

#[tokio::test]
async fn a_key_makes_one_job_a_day_whatever_becomes_of_it() {
    let (_directory, store) = fresh().await;
    let submit = |key: &'static str| store.submit_once(JobKind::Match, "null", key);
    let first = submit("key").await.unwrap();
    assert_eq!(submit("key").await.unwrap(), first);
    let lease = claimed(&store).await;
    store.succeed(&lease, Bytes::new()).await.unwrap();
    let again = submit("key").await.unwrap();
    assert_eq!((&again.id, again.state), (&first.id, State::Succeeded));
    assert_ne!(submit("other").await.unwrap().id, first.id);
    sqlx::query("UPDATE jobs SET created_ms = 0").execute(&store.pool).await.unwrap();
    assert_ne!(submit("key").await.unwrap().id, first.id);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 4)]
async fn many_at_once_claim_every_job_once() {
    const JOBS: usize = 60;
    let (_directory, store) = fresh().await;
    for number in 0..JOBS {
        submitted(&store, number as i64).await;
    }
    let claimers: Vec<_> = (0..12)
        .map(|_| {
            let store = store.clone();
            tokio::spawn(async move {
                let mut ids = Vec::new();
                while let Some(lease) = store.claim().await.unwrap() {
                    assert!(store.succeed(&lease, Bytes::new()).await.unwrap());
                    ids.push(lease.job.id);
                }
                ids
            })
        })
        .collect();
    let mut ids = Vec::new();
    for claimer in claimers {
        ids.extend(claimer.await.unwrap());
    }
    assert_eq!(ids.len(), JOBS);
    assert_eq!(ids.into_iter().collect::<BTreeSet<_>>().len(), JOBS);
}

#[tokio::test]
async fn lists_are_by_kind_from_the_newest() {
    let (_directory, store) = fresh().await;
    let mut ids = Vec::new();
    for number in 0..5 {
        ids.insert(0, submitted(&store, number).await.id);
    }
    store.submit(JobKind::Spectrum, "null", None).await.unwrap();
    let listed = |after: Option<String>, limit| {
        let store = store.clone();
        async move { store.jobs(JobKind::Match, &Page { after, limit }).await.unwrap() }
    };
    let first = listed(None, 3).await;
    let rest = listed(first.last().map(Job::cursor), 3).await;
    let both: Vec<_> = first.into_iter().chain(rest).map(|job| job.id).collect();
    assert_eq!(both, ids);
}

#[tokio::test]
async fn reopening_frees_what_was_running_and_keeps_the_rest() {
    let (directory, store) = fresh().await;
    let (done, running, queued) = (submitted(&store, 0).await, submitted(&store, 1).await, submitted(&store, 2).await);
    store.succeed(&claimed(&store).await, Bytes::from_static(b"answer")).await.unwrap();
    let lease = claimed(&store).await;
    // The process died between the blob and the row.
    store.blobs.put(&format!("results/{}/{}", running.id, lease.job.attempt), Bytes::new()).await.unwrap();
    drop(store);
    let store = open(&directory).await;
    assert_eq!(store.result(&done.id).await.unwrap(), Some(Bytes::from_static(b"answer")));
    assert_eq!(results(&store).await, [format!("results/{}/1", done.id)]);
    assert_eq!(state(&store, &running.id).await, State::Queued);
    assert_eq!(claimed(&store).await.job.id, running.id);
    assert_eq!(claimed(&store).await.job.id, queued.id);
}

#[tokio::test]
async fn those_who_wait_are_woken_by_every_change() {
    let (_directory, store) = fresh().await;
    let mut changes = store.changes();
    let job = submitted(&store, 0).await;
    assert!(changes.has_changed().unwrap());
    changes.mark_unchanged();
    let lease = claimed(&store).await;
    assert!(changes.has_changed().unwrap());
    changes.mark_unchanged();
    store.beat(&lease, "map", 0.5).await.unwrap();
    assert!(changes.has_changed().unwrap());
    changes.mark_unchanged();
    store.cancel(&job.id).await.unwrap();
    assert!(changes.has_changed().unwrap());
    changes.mark_unchanged();
    assert!(store.claim().await.unwrap().is_none());
    assert!(!changes.has_changed().unwrap());
}
