use std::collections::BTreeSet;

use futures::FutureExt;
use serde_json::json;
use sqlx::Executor;

use super::deaths::{MAX_BLAMED, MAX_DEATHS};
use super::lease::rest;
use super::*;
use crate::store::database::Engine;
use crate::store::testing::{ALL, fresh, on_every_database, open};
use crate::store::{Heartbeat, JobChanges, Lease, MEMORY, NewJob, Places, Priority, Room, Submitted};

/// More than any test submits.
const PLACES: Places = Places { queue: 1000, of_kind: 1000 };

const MATCH: &str = "match";
const SPECTRUM: &str = "spectrum";

/// Whatever waits, matches first.
const ANY: [&str; 2] = [MATCH, SPECTRUM];

async fn taken(store: &Store, job: &NewJob<'_>) -> Job {
    match store.submit(job, PLACES).await.unwrap() {
        Submitted::Taken(job) => *job,
        refused => panic!("{refused:?}"),
    }
}

async fn submitted(store: &Store, number: i64) -> Job {
    taken(store, &NewJob::of(MATCH, &number.to_string())).await
}

async fn claim(store: &Store) -> Option<Lease> {
    store.claim(&ANY, ALL).await.unwrap()
}

async fn claimed(store: &Store) -> Lease {
    claim(store).await.expect("a job waits")
}

/// Lets every rest be over.
async fn rested(store: &Store) {
    sqlx::query("UPDATE jobs SET due_ms = 0").execute(&store.pool).await.unwrap();
}

async fn state(store: &Store, id: &str) -> State {
    store.job(id).await.unwrap().unwrap().state
}

/// Lets every lease run out.
async fn expire(store: &Store) {
    sqlx::query("UPDATE jobs SET lease_ms = 0 WHERE state = 'running'").execute(&store.pool).await.unwrap();
}

/// Has whoever works on jobs die.
async fn die(store: &Store) {
    // The clock goes on, as it does between two deaths.
    while sqlx::query_scalar::<_, i64>("SELECT count(*) FROM jobs, clock WHERE died_ms >= now_ms")
        .fetch_one(&store.pool)
        .await
        .unwrap()
        > 0
    {}
    expire(store).await;
    assert_eq!(store.reap().await.unwrap(), 1);
}

/// Has the database's clock show this many milliseconds more than it is.
async fn set_clock(store: &Store, more: i64) {
    let now = match store.engine {
        Engine::Sqlite => "unixepoch('subsec') * 1000",
        Engine::Postgres => "extract(epoch FROM clock_timestamp()) * 1000",
    };
    let replaced = match store.engine {
        Engine::Sqlite => "DROP VIEW clock; CREATE VIEW",
        Engine::Postgres => "CREATE OR REPLACE VIEW",
    };
    let sql = format!("{replaced} clock AS SELECT CAST({now} AS BIGINT) + {more} AS now_ms");
    store.pool.execute(AssertSqlSafe(sql)).await.unwrap();
}

async fn results(store: &Store) -> Vec<String> {
    store.blobs.names("results").await.unwrap()
}

#[tokio::test]
async fn jobs_that_are_submitted_together_are_all_taken_or_none() {
    on_every_database(async |_, store| {
        let listed = async || store.jobs(MATCH, &Page { after: None, limit: 99 }).await.unwrap().len();
        let named = ["0", "1", "2"].map(|name| NewJob { dedupe: Some(name), ..NewJob::of(MATCH, name) });
        let two = Places { queue: 2, of_kind: 2 };
        assert_eq!(store.submit_all(&named, two).await.unwrap(), Submitted::Full);
        let gone = NewJob { mesh: Some("mesh_none"), ..NewJob::of(MATCH, "3") };
        assert_eq!(store.submit_all(&[named[0], gone], two).await.unwrap(), Submitted::Gone);
        assert_eq!(listed().await, 0);
        // Nobody is in the way of who comes next.
        let Submitted::Taken(first) = store.submit_all(&named, PLACES).await.unwrap() else { panic!("there is place") };
        assert_eq!(
            (first.iter().map(|job| job.place).collect::<Vec<_>>(), listed().await),
            (vec![Some(1), Some(2), Some(3)], 3)
        );
        // The same again, where there is no place any more, stands for itself.
        let Submitted::Taken(again) = store.submit_all(&named, two).await.unwrap() else { panic!("they are there") };
        assert_eq!((again, listed().await), (first, 3));
    })
    .await;
}

#[tokio::test]
async fn jobs_are_claimed_in_order_by_the_kinds_asked_for() {
    on_every_database(async |_, store| {
        let mut matches = Vec::new();
        for number in 0..3 {
            matches.push(submitted(&store, number).await.id);
        }
        let spectrum = taken(&store, &NewJob::of(SPECTRUM, "{}")).await;
        assert_eq!(spectrum.place, Some(1));
        assert_eq!((store.queued(MATCH).await.unwrap(), store.queued(SPECTRUM).await.unwrap()), (3, 1));
        let next = async |kinds: &[&str]| store.claim(kinds, ALL).await.unwrap().map(|lease| lease.job.id);
        assert_eq!(next(&[MATCH]).await.as_ref(), Some(&matches[0]));
        assert_eq!(store.job(&matches[2]).await.unwrap().unwrap().place, Some(2));
        assert_eq!(next(&[SPECTRUM, MATCH]).await, Some(spectrum.id));
        assert_eq!(next(&[SPECTRUM, MATCH]).await.as_ref(), Some(&matches[1]));
        assert_eq!(next(&[SPECTRUM]).await, None);
        assert_eq!(next(&ANY).await.as_ref(), Some(&matches[2]));
        assert_eq!(store.job(&matches[2]).await.unwrap().unwrap().place, None);
        assert_eq!((next(&ANY).await, store.queued(MATCH).await.unwrap()), (None, 0));
    })
    .await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 4)]
async fn of_many_at_once_no_more_are_taken_than_there_are_places() {
    on_every_database(async |_, store| {
        let submit = |kind, places| {
            let store = store.clone();
            tokio::spawn(async move { store.submit(&NewJob::of(kind, "{}"), places).await.unwrap() })
        };
        let taken = async |kind, places| {
            let submitted: Vec<_> = (0..40).map(|_| submit(kind, places)).collect();
            let mut taken = 0;
            for submitted in submitted {
                taken += usize::from(matches!(submitted.await.unwrap(), Submitted::Taken(_)));
            }
            taken
        };
        assert_eq!(taken(SPECTRUM, Places { queue: 5, of_kind: 3 }).await, 3);
        assert_eq!(taken(MATCH, Places { queue: 5, of_kind: 5 }).await, 2);
    })
    .await;
}

#[tokio::test]
async fn a_job_goes_from_queued_to_succeeded() {
    on_every_database(async |_, store| {
        let job = submitted(&store, 7).await;
        assert_eq!((job.state, job.attempt, job.revision, job.started_ms), (State::Queued, 0, 0, None));
        assert_eq!(job.place, Some(1));
        let lease = claimed(&store).await;
        assert_eq!((lease.job.state, lease.job.attempt, lease.job.revision), (State::Running, 1, 1));
        assert_eq!(&*lease.payload, "7");
        assert!(lease.job.started_ms >= Some(job.created_ms));
        assert_eq!(store.heartbeat(&lease, "map", 0.25).await.unwrap(), Heartbeat::Held);
        assert_eq!(store.heartbeat(&lease, "map", 0.25).await.unwrap(), Heartbeat::Held);
        let running = store.job(&job.id).await.unwrap().unwrap();
        assert_eq!((running.stage.as_deref(), running.fraction, running.revision), (Some("map"), 0.25, 2));
        assert_eq!(store.result(&job.id).await.unwrap(), None);
        assert!(store.succeed(&lease, Bytes::from_static(b"answer")).await.unwrap());
        let done = store.job(&job.id).await.unwrap().unwrap();
        assert_eq!((done.state, done.stage.as_deref()), (State::Succeeded, Some("finished")));
        assert_eq!((done.fraction, done.revision), (1.0, 3));
        assert!(done.finished_ms >= done.started_ms && done.started_ms.is_some());
        assert_eq!(store.result(&job.id).await.unwrap(), Some(Bytes::from_static(b"answer")));
    })
    .await;
}

#[tokio::test]
async fn progress_is_a_number_between_0_and_1() {
    on_every_database(async |_, store| {
        let job = submitted(&store, 0).await;
        let lease = claimed(&store).await;
        for (told, kept) in [(f64::NAN, 0.0), (-1.0, 0.0), (2.0, 1.0)] {
            assert_eq!(store.heartbeat(&lease, "map", told).await.unwrap(), Heartbeat::Held);
            assert_eq!(store.job(&job.id).await.unwrap().unwrap().fraction, kept);
        }
    })
    .await;
}

#[tokio::test]
async fn an_old_lease_is_fenced_off() {
    on_every_database(async |_, store| {
        let job = submitted(&store, 0).await;
        let old = claimed(&store).await;
        expire(&store).await;
        assert_eq!(store.reap().await.unwrap(), 1);
        let new = claimed(&store).await;
        assert_eq!((new.job.id.as_str(), new.job.attempt), (job.id.as_str(), 2));
        let before = store.job(&job.id).await.unwrap();
        assert_eq!(store.heartbeat(&old, "map", 0.5).await.unwrap(), Heartbeat::Lost);
        assert!(!store.succeed(&old, Bytes::from_static(b"old")).await.unwrap());
        assert!(!store.fail(&old, &json!({})).await.unwrap());
        assert_eq!(store.retry(&old, &json!({})).await.unwrap(), None);
        assert!(!store.postpone(&old).await.unwrap());
        assert!(!store.release(&old).await.unwrap());
        assert_eq!(store.job(&job.id).await.unwrap(), before);
        assert_eq!(results(&store).await, Vec::<String>::new());
        assert!(store.succeed(&new, Bytes::from_static(b"new")).await.unwrap());
        assert!(!store.succeed(&new, Bytes::from_static(b"twice")).await.unwrap());
        assert_eq!(store.result(&job.id).await.unwrap(), Some(Bytes::from_static(b"new")));
    })
    .await;
}

#[tokio::test]
async fn a_lease_that_stands_is_not_reaped() {
    on_every_database(async |_, store| {
        submitted(&store, 0).await;
        let lease = claimed(&store).await;
        assert_eq!(store.reap().await.unwrap(), 0);
        assert_eq!(store.heartbeat(&lease, "map", 0.5).await.unwrap(), Heartbeat::Held);
    })
    .await;
}

#[tokio::test]
async fn a_job_that_always_kills_its_process_fails_in_the_end() {
    let (directory, mut store) = fresh().await;
    let job = submitted(&store, 0).await;
    // The first death is nobody's fault in particular.
    for attempt in 1..=MAX_BLAMED + 1 {
        rested(&store).await;
        assert_eq!(claimed(&store).await.job.attempt, attempt);
        drop(store);
        store = open(&directory).await;
    }
    rested(&store).await;
    assert!(claim(&store).await.is_none());
    let failed = store.job(&job.id).await.unwrap().unwrap();
    assert_eq!(failed.state, State::Failed);
    assert!(failed.error.unwrap()["detail"].as_str().unwrap().contains("the process that the job was tried in ended"));
    assert!(failed.finished_ms.is_some());
}

#[tokio::test]
async fn a_job_whose_process_died_runs_alone_from_then_on() {
    on_every_database(async |_, store| {
        let (bad, neighbour, other) =
            (submitted(&store, 0).await, submitted(&store, 1).await, submitted(&store, 2).await);
        assert!(!claimed(&store).await.suspect && !claimed(&store).await.suspect);
        expire(&store).await;
        assert_eq!(store.reap().await.unwrap(), 2);
        let beside_others = Room { alone: false, ..ALL };
        assert!(store.claim(&ANY, beside_others).await.unwrap().is_none(), "nor is a suspect overtaken");
        for blamed in 1..=MAX_BLAMED {
            rested(&store).await;
            let lease = claimed(&store).await;
            assert!(lease.suspect && lease.job.id == bad.id, "{lease:?}");
            die(&store).await;
            assert_eq!(state(&store, &bad.id).await == State::Failed, blamed == MAX_BLAMED);
        }
        // What ran beside it was not harmed again.
        let lease = claimed(&store).await;
        assert!(lease.suspect && lease.job.id == neighbour.id && lease.job.attempt == 2, "{lease:?}");
        store.succeed(&lease, Bytes::new()).await.unwrap();
        let lease = store.claim(&ANY, beside_others).await.unwrap().unwrap();
        assert!(!lease.suspect && lease.job.id == other.id);
    })
    .await;
}

#[tokio::test]
async fn no_job_is_to_blame_where_those_of_others_die_too() {
    on_every_database(async |_, store| {
        let (one, other) = (submitted(&store, 0).await, submitted(&store, 1).await);
        // Whichever runs is killed, one after the other.
        for step in 0..2 * MAX_DEATHS {
            let victim = if step % 2 == 0 { &one.id } else { &other.id };
            let turn = "UPDATE jobs SET due_ms = (SELECT now_ms FROM clock) + CASE WHEN id = $1 THEN 0 ELSE 30000 END";
            sqlx::query(turn).bind(victim).execute(&store.pool).await.unwrap();
            assert_eq!(&claimed(&store).await.job.id, victim);
            die(&store).await;
            assert_eq!(state(&store, victim).await == State::Failed, step / 2 + 1 == MAX_DEATHS, "but not for ever");
        }
    })
    .await;
}

#[tokio::test]
async fn deaths_use_up_no_tries_and_jobs_rest_after_them() {
    on_every_database(async |_, store| {
        submitted(&store, 0).await;
        for seconds in [0, 1, 2] {
            rested(&store).await;
            claimed(&store).await;
            die(&store).await;
            let (rest, tries): (i64, i64) =
                sqlx::query_as("SELECT due_ms - died_ms, tries FROM jobs").fetch_one(&store.pool).await.unwrap();
            assert_eq!((rest, tries), (1000 * seconds, 0));
        }
    })
    .await;
}

#[tokio::test]
async fn those_that_somebody_waits_for_come_before_batch_jobs_for_an_hour() {
    on_every_database(async |_, store| {
        let batch = NewJob { priority: Priority::Batch, ..NewJob::of(MATCH, "1") };
        let (early, late) = (taken(&store, &batch).await, taken(&store, &batch).await);
        let awaited = submitted(&store, 2).await;
        assert_eq!(
            (awaited.place, awaited.priority, early.priority),
            (Some(1), Priority::Interactive, Priority::Batch)
        );
        assert_eq!(store.job(&late.id).await.unwrap().unwrap().place, Some(3));
        assert_eq!(claimed(&store).await.job.id, awaited.id);
        let younger = submitted(&store, 3).await;
        let sql = "UPDATE jobs SET created_ms = created_ms - 3600000 WHERE id = $1";
        sqlx::query(sql).bind(&early.id).execute(&store.pool).await.unwrap();
        assert_eq!(claimed(&store).await.job.id, early.id, "after an hour the turn is that of age");
        assert_eq!(claimed(&store).await.job.id, younger.id);
        assert_eq!(claimed(&store).await.job.id, late.id);
    })
    .await;
}

#[tokio::test]
async fn tenants_take_turns_whoever_asks_for_more() {
    on_every_database(async |_, store| {
        let (acme, umbrella) = (store.of(&"acme".parse().unwrap()), store.of(&"umbrella".parse().unwrap()));
        for number in 0..6 {
            submitted(&acme, number).await;
        }
        let (first, second) = (submitted(&umbrella, 6).await, submitted(&umbrella, 7).await);
        let whose = async || claimed(&store).await.job.tenant.to_string();
        // By what runs.
        assert_eq!([whose().await, whose().await, whose().await], ["acme", "umbrella", "acme"]);
        assert_eq!(state(&umbrella, &first.id).await, State::Running);
        // By who was served last, where nothing runs.
        let done = "UPDATE jobs SET state = 'succeeded', started_ms = started_ms - CASE WHEN tenant = 'acme' THEN 1 ELSE 2 END \
                    WHERE state = 'running'";
        sqlx::query(done).execute(&store.pool).await.unwrap();
        assert_eq!(claimed(&store).await.job.id, second.id);
        assert_eq!([whose().await, whose().await], ["acme", "acme"]);
    })
    .await;
}

#[tokio::test]
async fn a_clock_that_jumps_costs_a_try_and_loses_nothing() {
    on_every_database(async |place, store| {
        let job = submitted(&store, 0).await;
        let lease = claimed(&store).await;
        // A day on: the lease is over, and who had it changes nothing any more.
        set_clock(&store, 86_400_000).await;
        assert_eq!(store.reap().await.unwrap(), 1);
        assert!(!store.succeed(&lease, Bytes::from_static(b"late")).await.unwrap());
        let lease = claimed(&store).await;
        assert_eq!(store.heartbeat(&lease, "map", 0.5).await.unwrap(), Heartbeat::Held);
        assert_eq!(store.reap().await.unwrap(), 0);
        // Back again: of who beats nothing is taken for long, and who died is not waited for until tomorrow.
        set_clock(&store, 0).await;
        assert_eq!(store.heartbeat(&lease, "map", 0.5).await.unwrap(), Heartbeat::Held);
        assert_eq!(store.reap().await.unwrap(), 0);
        set_clock(&store, -86_400_000).await;
        assert_eq!(store.reap().await.unwrap(), 1);
        // Nor is a rest as long as the clock is wrong.
        set_clock(&store, -2 * 86_400_000).await;
        let lease = claimed(&store).await;
        assert!(store.succeed(&lease, Bytes::from_static(b"answer")).await.unwrap());
        assert_eq!(store.result(&job.id).await.unwrap(), Some(Bytes::from_static(b"answer")));
        let claim = store.take("spectrum").await.unwrap();
        set_clock(&store, -3 * 86_400_000).await;
        let other = if store.is_shared() { place.open().await } else { store.clone() };
        assert!(claim.is_some() && other.take("spectrum").await.unwrap().is_some());
    })
    .await;
}

#[tokio::test]
async fn jobs_are_let_in_by_what_they_take_and_do_not_overtake_each_other() {
    on_every_database(async |_, store| {
        // The second was written by a node of the version before, which told nothing of what is matched.
        sqlx::query(
            "INSERT INTO shapes (id, kind, body, created_ms, vertices, matched) \
             VALUES ('m', 'mesh', '{}', 0, 70, 50), ('s', 'sketch', '{}', 0, 60, 0)",
        )
        .execute(&store.pool)
        .await
        .unwrap();
        let large = NewJob { mesh: Some("m"), bytes_per_vertex: 10, ..NewJob::of(MATCH, "large") };
        let (large, small) = (taken(&store, &large).await, submitted(&store, 1).await);
        let with = |memory, alone| Room { memory, alone };
        assert!(store.claim(&ANY, with(499, false)).await.unwrap().is_none());
        let lease = store.claim(&ANY, with(500, false)).await.unwrap().unwrap();
        assert_eq!((lease.job.id, lease.memory), (large.id, 500));
        assert_eq!(store.claim(&ANY, with(0, false)).await.unwrap().unwrap().job.id, small.id);
        assert!(store.claim(&ANY, with(0, false)).await.unwrap().is_none());
        taken(&store, &NewJob { mesh: Some("m"), bytes_per_vertex: 10, ..NewJob::of(MATCH, "large") }).await;
        assert!(store.claim(&ANY, with(0, true)).await.unwrap().is_some(), "alone it runs whatever it takes");
        let larger =
            NewJob { sketch: Some("s"), bytes_per_vertex: 10, bytes_besides: 7, ..NewJob::of(MATCH, "larger") };
        taken(&store, &larger).await;
        assert!(store.claim(&ANY, with(606, false)).await.unwrap().is_none());
        assert_eq!(store.claim(&ANY, with(607, false)).await.unwrap().unwrap().memory, 607);
    })
    .await;
}

#[tokio::test]
async fn retries_are_counted_and_what_is_given_back_is_not() {
    on_every_database(async |_, store| {
        let job = submitted(&store, 0).await;
        for _ in 0..MAX_TRIES {
            assert!(store.release(&claimed(&store).await).await.unwrap());
            assert!(store.postpone(&claimed(&store).await).await.unwrap());
            rested(&store).await;
        }
        let error = json!({ "detail": "no luck" });
        for _ in 1..MAX_TRIES {
            assert_eq!(store.retry(&claimed(&store).await, &error).await.unwrap(), Some(State::Queued));
            rested(&store).await;
        }
        assert_eq!(store.retry(&claimed(&store).await, &error).await.unwrap(), Some(State::Failed));
        let failed = store.job(&job.id).await.unwrap().unwrap();
        assert_eq!((failed.state, failed.error), (State::Failed, Some(error)));
        assert_eq!(failed.attempt, 3 * MAX_TRIES);
    })
    .await;
}

#[tokio::test]
async fn a_job_rests_longer_after_every_try() {
    on_every_database(async |_, store| {
        submitted(&store, 0).await;
        for seconds in [1, 2, 4] {
            store.retry(&claimed(&store).await, &json!({})).await.unwrap();
            assert!(claim(&store).await.is_none());
            let rest = "SELECT due_ms - now_ms FROM jobs, clock";
            let rest: i64 = sqlx::query_scalar(rest).fetch_one(&store.pool).await.unwrap();
            assert!((1..=1000 * seconds).contains(&rest) && rest > 1000 * seconds - 900, "{rest}");
            rested(&store).await;
        }
        assert_eq!([1, 2, 6, 7, 100].map(|tries| rest(tries).as_secs()), [1, 2, 32, 60, 60]);
    })
    .await;
}

#[tokio::test]
async fn a_failure_is_final() {
    on_every_database(async |_, store| {
        let job = submitted(&store, 0).await;
        assert!(store.fail(&claimed(&store).await, &json!({})).await.unwrap());
        assert_eq!(state(&store, &job.id).await, State::Failed);
    })
    .await;
}

#[tokio::test]
async fn a_failure_is_found_by_name_while_it_is_late() {
    on_every_database(async |_, store| {
        let (named, lately) = (NewJob { dedupe: Some("name"), ..NewJob::of(SPECTRUM, "{}") }, LEASE);
        assert_eq!(store.late_failure("name", lately).await.unwrap(), None);
        let job = taken(&store, &named).await;
        assert_eq!(store.late_failure("name", lately).await.unwrap(), None);
        store.fail(&claimed(&store).await, &json!({ "detail": "thin" })).await.unwrap();
        // However many jobs come after it.
        for number in 0..120 {
            submitted(&store, number).await;
        }
        assert_eq!(store.late_failure("name", lately).await.unwrap().unwrap().id, job.id);
        assert_eq!(store.late_failure("name", Duration::ZERO).await.unwrap(), None);
        taken(&store, &named).await;
        assert_eq!(store.late_failure("name", lately).await.unwrap(), None);
    })
    .await;
}

#[tokio::test]
async fn cancelling_ends_a_queued_job_and_tells_the_worker_of_a_running_one() {
    on_every_database(async |_, store| {
        let (running, queued) = (submitted(&store, 0).await, submitted(&store, 1).await);
        let lease = claimed(&store).await;
        for id in [&running.id, &queued.id] {
            let job = store.cancel(id).await.unwrap().unwrap();
            assert!(job.state == State::Cancelled && job.finished_ms.is_some(), "{job:?}");
        }
        assert!(claim(&store).await.is_none());
        assert_eq!(store.heartbeat(&lease, "map", 0.5).await.unwrap(), Heartbeat::Cancelled);
        assert!(!store.succeed(&lease, Bytes::from_static(b"late")).await.unwrap());
        assert!(!store.release(&lease).await.unwrap());
        assert_eq!(state(&store, &running.id).await, State::Cancelled);
        assert_eq!(results(&store).await, Vec::<String>::new());
    })
    .await;
}

#[tokio::test]
async fn cancelling_leaves_finished_jobs_alone() {
    on_every_database(async |_, store| {
        let job = submitted(&store, 0).await;
        store.succeed(&claimed(&store).await, Bytes::new()).await.unwrap();
        assert_eq!(store.cancel(&job.id).await.unwrap(), store.job(&job.id).await.unwrap());
        assert_eq!(state(&store, &job.id).await, State::Succeeded);
        assert_eq!(store.cancel("nobody").await.unwrap(), None);
    })
    .await;
}

#[tokio::test]
async fn deleting_takes_the_job_and_its_result() {
    on_every_database(async |_, store| {
        let job = submitted(&store, 0).await;
        assert!(!store.delete(&job.id).await.unwrap());
        let lease = claimed(&store).await;
        assert!(!store.delete(&job.id).await.unwrap());
        store.succeed(&lease, Bytes::from_static(b"answer")).await.unwrap();
        assert_eq!(results(&store).await.len(), 1);
        assert!(store.delete(&job.id).await.unwrap());
        assert_eq!((store.job(&job.id).await.unwrap(), results(&store).await), (None, Vec::new()));
        assert!(!store.delete(&job.id).await.unwrap());
        assert_eq!(store.heartbeat(&lease, "map", 1.0).await.unwrap(), Heartbeat::Lost);
    })
    .await;
}

#[tokio::test]
async fn an_unfinished_job_answers_for_its_equals() {
    on_every_database(async |_, store| {
        let named = |name| NewJob { dedupe: Some(name), ..NewJob::of(SPECTRUM, "null") };
        let submit = async || taken(&store, &named("key")).await;
        let first = submit().await;
        assert_eq!(submit().await, first);
        let lease = claimed(&store).await;
        assert_eq!(submit().await.id, first.id);
        store.succeed(&lease, Bytes::new()).await.unwrap();
        let second = submit().await;
        assert_ne!(second.id, first.id);
        let full = store.submit(&named("key"), Places { queue: 0, of_kind: 0 }).await.unwrap();
        assert_eq!(full, Submitted::Taken(Box::new(second.clone())), "one that is there takes no place");
        store.cancel(&second.id).await.unwrap();
        assert_ne!(submit().await.id, second.id);
        let other = taken(&store, &named("other")).await;
        assert_eq!(other.state, State::Queued);
        assert_eq!(store.queued(SPECTRUM).await.unwrap(), 2);
    })
    .await;
}

#[tokio::test]
async fn a_key_makes_one_job_a_day_whatever_becomes_of_it() {
    on_every_database(async |_, store| {
        let submit = async |key| {
            let once = NewJob { dedupe: Some(key), taken_for: MEMORY, ..NewJob::of(MATCH, "null") };
            taken(&store, &once).await
        };
        let first = submit("key").await;
        assert_eq!(submit("key").await, first);
        let lease = claimed(&store).await;
        store.succeed(&lease, Bytes::new()).await.unwrap();
        let again = submit("key").await;
        assert_eq!((&again.id, again.state), (&first.id, State::Succeeded));
        assert_ne!(submit("other").await.id, first.id);
        sqlx::query("UPDATE jobs SET created_ms = 0").execute(&store.pool).await.unwrap();
        assert_ne!(submit("key").await.id, first.id);
    })
    .await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 4)]
async fn many_at_once_claim_every_job_once() {
    const JOBS: usize = 60;
    on_every_database(async |_, store| {
        for number in 0..JOBS {
            submitted(&store, number as i64).await;
        }
        let claimers: Vec<_> = (0..12)
            .map(|_| {
                let store = store.clone();
                tokio::spawn(async move {
                    let mut ids = Vec::new();
                    while let Some(lease) = claim(&store).await {
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
    })
    .await;
}

#[tokio::test]
async fn lists_are_by_kind_from_the_newest() {
    on_every_database(async |_, store| {
        let mut ids = Vec::new();
        for number in 0..5 {
            ids.insert(0, submitted(&store, number).await.id);
        }
        taken(&store, &NewJob::of(SPECTRUM, "null")).await;
        let listed = |after: Option<String>, limit| {
            let store = store.clone();
            async move { store.jobs(MATCH, &Page { after, limit }).await.unwrap() }
        };
        let first = listed(None, 3).await;
        let rest = listed(first.last().map(Job::cursor), 3).await;
        let both: Vec<_> = first.into_iter().chain(rest).map(|job| job.id).collect();
        assert_eq!(both, ids);
    })
    .await;
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
    let aside = store.blobs.names("aside").await.unwrap();
    assert_eq!(aside, [format!("aside/results/{}/1", running.id)], "what nothing names is kept for people to look at");
    assert_eq!(state(&store, &running.id).await, State::Queued);
    assert_eq!(claimed(&store).await.job.id, running.id);
    assert_eq!(claimed(&store).await.job.id, queued.id);
}

#[tokio::test]
async fn those_who_wait_for_a_job_are_woken_by_its_changes_alone() {
    on_every_database(async |_, store| {
        let (one, other) = (submitted(&store, 0).await, submitted(&store, 1).await);
        let (mut of_one, mut of_other) = (store.job_changes(&one.id), store.job_changes(&other.id));
        let told = |of_one: &mut JobChanges| of_one.changed().now_or_never().is_some();
        let lease = claimed(&store).await;
        assert!(told(&mut of_one));
        store.heartbeat(&lease, "map", 0.5).await.unwrap();
        assert!(told(&mut of_one));
        assert_eq!(store.retry(&lease, &json!({})).await.unwrap(), Some(State::Queued));
        assert!(told(&mut of_one));
        store.cancel(&one.id).await.unwrap();
        assert!(told(&mut of_one));
        store.delete(&one.id).await.unwrap();
        assert!(told(&mut of_one) && !told(&mut of_one));
        assert!(!told(&mut of_other));
        let lease = claimed(&store).await;
        expire(&store).await;
        store.reap().await.unwrap();
        of_other.seen();
        assert_eq!(lease.job.id, other.id);
    })
    .await;
}

#[tokio::test]
async fn those_who_wait_for_work_are_woken_when_there_may_be_some() {
    on_every_database(async |_, store| {
        let mut changes = store.queue_changes();
        let mut told = || changes.changed().now_or_never().is_some();
        submitted(&store, 0).await;
        assert!(told());
        let lease = claimed(&store).await;
        store.heartbeat(&lease, "map", 0.5).await.unwrap();
        assert!(!told(), "what is being done is no work for others");
        store.release(&lease).await.unwrap();
        assert!(told() && !told());
    })
    .await;
}
