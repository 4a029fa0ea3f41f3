//! Tells receivers of the ends of jobs, from the database, so that none is forgotten by a process that dies.

use std::sync::Arc;
use std::time::{Duration, UNIX_EPOCH};

use metrics::{counter, describe_counter};
use serde_json::json;
use tokio::sync::Semaphore;
use tokio::time::sleep;
use tokio_util::sync::CancellationToken;
use tokio_util::task::TaskTracker;

use crate::store::{MAX_CALLS, Store, StoreError, Webhook};
use crate::webhooks::{Caller, Message};

/// How often calls that have rested are looked for.
const POLL: Duration = Duration::from_secs(5);

/// Calls at one time: one that is slow to listen keeps others waiting for seconds at most.
const CALLS: usize = 16;

const TOLD: &str = "sketchmatch_webhooks_total";

/// Says what is measured here and sets it to nothing.
pub(super) fn describe() {
    describe_counter!(TOLD, "Calls that tell of the end of a job, by outcome.");
    for outcome in ["delivered", "refused", "given_up"] {
        counter!(TOLD, "outcome" => outcome).absolute(0);
    }
}

/// Makes the calls that are due, until `shutdown`: what is under way then is broken off and made again later.
pub(super) async fn call_until(shutdown: &CancellationToken, store: &Store, caller: Caller) {
    let (caller, calls, slots) = (Arc::new(caller), TaskTracker::new(), Arc::new(Semaphore::new(CALLS)));
    let mut changes = store.queue_changes();
    while let Some(Ok(slot)) = shutdown.run_until_cancelled(slots.clone().acquire_owned()).await {
        changes.seen();
        let due = match shutdown.run_until_cancelled(store.due_webhook()).await {
            Some(Ok(due)) => due,
            Some(Err(error)) => {
                tracing::error!(%error, "calls that are due cannot be looked for");
                None
            }
            None => break,
        };
        let Some(webhook) = due else {
            let change = async {
                tokio::select! { () = changes.changed() => {}, () = sleep(POLL) => {} }
            };
            shutdown.run_until_cancelled(change).await;
            continue;
        };
        let (shutdown, store, caller) = (shutdown.clone(), store.clone(), caller.clone());
        calls.spawn(async move {
            if let Some(Err(error)) = shutdown.run_until_cancelled(call(&store, &caller, &webhook)).await {
                tracing::error!(%error, job = webhook.job.id, "a call cannot be told of, and may be made again");
            }
            drop(slot);
        });
    }
    calls.close();
    calls.wait().await;
}

/// Makes a call and forgets it where it need not be made again.
async fn call(store: &Store, caller: &Caller, webhook: &Webhook) -> Result<(), StoreError> {
    let (job, tries) = (&webhook.job.id, webhook.tries);
    let secret = store.webhook_secret(&webhook.job.tenant).await?;
    let outcome = match caller.call(&webhook.url, &message(webhook), &secret).await {
        Ok(()) => "delivered",
        Err(refused) if refused.for_good || tries >= MAX_CALLS => {
            tracing::warn!(job, tries, reason = refused.reason, "the receiver of a job's end is given up");
            "given_up"
        }
        Err(refused) => {
            tracing::info!(job, tries, reason = refused.reason, "the receiver of a job's end is called again later");
            "refused"
        }
    };
    counter!(TOLD, "outcome" => outcome).increment(1);
    if outcome != "refused" { store.forget_webhook(webhook).await } else { Ok(()) }
}

/// What a receiver is told: that there is something to look at, and nothing that is not in its hands already.
fn message(webhook: &Webhook) -> Message {
    let job = &webhook.job;
    let (kind, status) = (job.kind.as_str(), job.state.as_str());
    let ended = Duration::from_millis(job.finished_ms.and_then(|ms| u64::try_from(ms).ok()).unwrap_or(0));
    let body = json!({
        "type": format!("{kind}.{status}"),
        "timestamp": humantime::format_rfc3339_millis(UNIX_EPOCH + ended).to_string(),
        "data": { "id": job.id, "kind": kind, "status": status, "name": job.name },
    });
    Message { id: job.id.clone(), body: body.to_string().into() }
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicBool, Ordering};

    use axum::Router;
    use axum::body::Bytes;
    use axum::http::{HeaderMap, StatusCode};
    use axum::routing::post;
    use serde_json::Value;
    use tokio::net::TcpListener;
    use tokio::sync::mpsc::unbounded_channel;

    use super::*;
    use crate::store::testing::{make_webhooks_due, on_every_database};
    use crate::store::{NewJob, Places, Submitted};

    #[tokio::test]
    async fn a_receiver_hears_of_the_end_of_a_job_by_whichever_process_lives() {
        on_every_database(async |place, store| {
            let (sender, mut received) = unbounded_channel();
            let deaf = Arc::new(AtomicBool::new(true));
            let hears = deaf.clone();
            let take = move |headers: HeaderMap, body: Bytes| {
                sender.send((headers, body)).unwrap();
                let status =
                    if hears.load(Ordering::SeqCst) { StatusCode::SERVICE_UNAVAILABLE } else { StatusCode::OK };
                async move { status }
            };
            let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
            let port = listener.local_addr().unwrap().port();
            let routes = Router::new().route("/", post(take));
            tokio::spawn(async move { axum::serve(listener, routes).await.unwrap() });
            let acme = store.of(&"acme".parse().unwrap());
            let url = format!("http://localhost:{port}/");
            let job = NewJob { webhook: Some(&url), name: Some("mine"), ..NewJob::of("match", "{}") };
            let Submitted::Taken(job) = acme.submit(&job, Places { queue: 9, of_kind: 9 }).await.unwrap() else {
                panic!("there is place")
            };
            let secret = store.webhook_secret(acme.tenant()).await.unwrap();
            acme.cancel(&job.id).await.unwrap();

            let calling = |store: Store| {
                let (shutdown, stopped) = (CancellationToken::new(), CancellationToken::new());
                let (stop, done) = (shutdown.clone(), stopped.clone());
                tokio::spawn(async move {
                    let caller = Caller::of_this_machine(vec![format!("localhost:{port}").parse().unwrap()]);
                    call_until(&stop, &store, caller).await;
                    drop(store);
                    done.cancel();
                });
                (shutdown, stopped)
            };
            let (shutdown, stopped) = calling(store.clone());
            let (first, _) = received.recv().await.unwrap();
            shutdown.cancel();
            stopped.cancelled().await;
            drop((acme, store));
            // Another process goes on, once the rest is over.
            let store = place.open().await;
            deaf.store(false, Ordering::SeqCst);
            make_webhooks_due(&store).await;
            let (shutdown, stopped) = calling(store.clone());
            let (headers, body) = received.recv().await.unwrap();
            assert_eq!(
                (&headers["webhook-id"], &first["webhook-id"]),
                (&first["webhook-id"], &job.id.parse().unwrap())
            );
            let told: Value = serde_json::from_slice(&body).unwrap();
            assert_eq!(told["type"], "match.cancelled");
            assert_eq!(told["data"], json!({"id": job.id, "kind": "match", "status": "cancelled", "name": "mine"}));
            // It is signed by the secret of its tenant.
            let message = Message { id: job.id.clone(), body };
            let seconds = headers["webhook-timestamp"].to_str().unwrap().parse().unwrap();
            let signed = message.signature(&secret, seconds);
            assert_eq!(headers["webhook-signature"], signed.as_str());
            while store.webhooks_waiting().await.unwrap() > 0 {
                tokio::task::yield_now().await;
            }
            shutdown.cancel();
            stopped.cancelled().await;
            assert!(received.try_recv().is_err(), "what was heard is not told again");
        })
        .await;
    }
}
