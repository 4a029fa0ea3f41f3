//! What other nodes change, as their database tells it.

use std::sync::Arc;
use std::time::Duration;

use tokio::time::sleep;

use super::changes::Changes;
use super::database::Listener;
use super::{DatabaseUrl, State, StoreError};

/// Rest before the database is asked again to tell of changes.
const REST: Duration = Duration::from_secs(1);

/// Passes on the changes that other nodes make, for ever. While the database does not tell of them they are found out by those
/// who look again from time to time.
pub(super) async fn follow(mut listener: Listener, url: DatabaseUrl, node: String, changes: Arc<Changes>) {
    loop {
        if let Err(error) = pass_on(&mut listener, &changes).await {
            tracing::warn!(%error, "the database does not tell of changes");
        }
        listener = loop {
            sleep(REST).await;
            if let Ok(again) = Listener::at(&url, &node).await {
                break again;
            }
        };
        changes.tell_of_everything();
    }
}

/// Passes changes on until the connection is lost.
async fn pass_on(listener: &mut Listener, changes: &Changes) -> Result<(), StoreError> {
    loop {
        match listener.next().await? {
            Some(told) => {
                let state = State::named(&told.state);
                changes.tell_of_job(&told.job, state);
                if state != Some(State::Running) {
                    changes.tell_of_queue();
                }
            }
            None => changes.tell_of_everything(),
        }
    }
}

#[cfg(test)]
mod tests {
    use bytes::Bytes;

    use crate::store::testing::{ALL, fresh_shared};
    use crate::store::{NewJob, Places};

    #[tokio::test]
    async fn what_one_node_changes_wakes_those_who_wait_at_another() {
        let Some((place, one)) = fresh_shared().await else { return };
        let other = place.open().await;
        let (mut own, mut queue) = (one.queue_changes(), other.queue_changes());
        let places = Places { queue: 9, of_kind: 9 };
        for number in ["1", "2"] {
            one.submit(&NewJob::of("match", number), places).await.unwrap();
            queue.changed().await;
        }
        own.seen();
        let lease = other.claim(&["match"], ALL).await.unwrap().unwrap();
        let mut job = one.job_changes(&lease.job.id);
        other.heartbeat(&lease, "map", 0.5).await.unwrap();
        job.changed().await;
        // Who works on it is told at once that it is cancelled.
        let mut told = other.job_changes(&lease.job.id);
        one.cancel(&lease.job.id).await.unwrap();
        told.cancelled().await;
        let lease = other.claim(&["match"], ALL).await.unwrap().unwrap();
        other.succeed(&lease, Bytes::new()).await.unwrap();
        own.changed().await;
    }

    #[tokio::test]
    async fn a_lost_connection_is_made_again_and_all_look_again() {
        let Some((place, one)) = fresh_shared().await else { return };
        let other = place.open().await;
        let mut queue = other.queue_changes();
        let cut = "SELECT count(*) FROM (SELECT pg_terminate_backend(pid) FROM pg_stat_activity \
                   WHERE query LIKE 'LISTEN %' || current_schema() || '%') AS cut";
        assert_eq!(sqlx::query_scalar::<_, i64>(cut).fetch_one(&one.pool).await.unwrap(), 2);
        queue.changed().await;
        queue.seen();
        one.submit(&NewJob::of("match", "1"), Places { queue: 9, of_kind: 9 }).await.unwrap();
        queue.changed().await;
    }
}
