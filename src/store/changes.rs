use std::collections::HashMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use tokio::sync::watch;

use super::{State, Store};

/// Wakes those who wait for a change: of the queue, or of one job.
#[derive(Default)]
pub(super) struct Changes {
    queue: watch::Sender<()>,
    /// The last state told of each job that somebody waits for.
    jobs: Mutex<HashMap<String, watch::Sender<Option<State>>>>,
}

impl Changes {
    fn jobs(&self) -> MutexGuard<'_, HashMap<String, watch::Sender<Option<State>>>> {
        self.jobs.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Wakes those who wait for the job, which is now in `state`; nothing where it is gone.
    pub fn tell_of_job(&self, id: &str, state: Option<State>) {
        if let Some(job) = self.jobs().get(id) {
            job.send_replace(state);
        }
    }

    /// Wakes those who wait for any job.
    pub fn tell_of_all_jobs(&self) {
        for job in self.jobs().values() {
            job.send_modify(|_| {});
        }
    }

    /// Wakes all who wait for anything.
    pub fn tell_of_everything(&self) {
        self.tell_of_all_jobs();
        self.tell_of_queue();
    }

    /// Wakes those who wait for work.
    pub fn tell_of_queue(&self) {
        self.queue.send_replace(());
    }
}

/// Changes of the queue: that a job waits, or that one has ended.
pub struct QueueChanges(watch::Receiver<()>);

impl QueueChanges {
    /// Returns at the next change after the last that was waited for or [`seen`](Self::seen).
    pub async fn changed(&mut self) {
        // The sender lives as long as the store.
        let _ = self.0.changed().await;
    }

    /// Takes all changes so far for known.
    pub fn seen(&mut self) {
        self.0.mark_unchanged();
    }
}

/// Changes of one job.
pub struct JobChanges {
    changes: Arc<Changes>,
    id: String,
    receiver: watch::Receiver<Option<State>>,
}

impl JobChanges {
    /// Returns at the next change after the last that was waited for or [`seen`](Self::seen).
    pub async fn changed(&mut self) {
        // The sender lives as long as this receiver.
        let _ = self.receiver.changed().await;
    }

    /// Takes all changes so far for known.
    pub fn seen(&mut self) {
        self.receiver.mark_unchanged();
    }

    /// Returns when somebody cancels the job.
    pub async fn cancelled(&mut self) {
        let _ = self.receiver.wait_for(|state| *state == Some(State::Cancelled)).await;
    }
}

impl Drop for JobChanges {
    fn drop(&mut self) {
        let mut jobs = self.changes.jobs();
        if jobs.get(&self.id).is_some_and(|job| job.receiver_count() == 1) {
            jobs.remove(&self.id);
        }
    }
}

impl Store {
    /// The changes of the queue from now on.
    pub fn queue_changes(&self) -> QueueChanges {
        QueueChanges(self.changes.queue.subscribe())
    }

    /// The changes of one job from now on.
    pub fn job_changes(&self, id: &str) -> JobChanges {
        let receiver = self.changes.jobs().entry(id.to_owned()).or_default().subscribe();
        JobChanges { changes: self.changes.clone(), id: id.to_owned(), receiver }
    }
}

#[cfg(test)]
mod tests {
    use futures::FutureExt;

    use super::*;
    use crate::store::testing::fresh;

    #[tokio::test]
    async fn who_waits_for_a_job_is_woken_by_its_changes_only() {
        let (_directory, store) = fresh().await;
        let (mut one, mut other) = (store.job_changes("one"), store.job_changes("other"));
        store.changes.tell_of_job("one", Some(State::Running));
        assert!(one.changed().now_or_never().is_some() && other.changed().now_or_never().is_none());
        assert!(one.changed().now_or_never().is_none());
        store.changes.tell_of_all_jobs();
        assert!(one.changed().now_or_never().is_some() && other.changed().now_or_never().is_some());
        store.changes.tell_of_job("one", None);
        one.seen();
        assert!(one.changed().now_or_never().is_none());
    }

    #[tokio::test]
    async fn a_cancelling_is_told_from_other_changes() {
        let (_directory, store) = fresh().await;
        let mut job = store.job_changes("job");
        store.changes.tell_of_job("job", Some(State::Running));
        assert!(job.cancelled().now_or_never().is_none());
        store.changes.tell_of_job("job", Some(State::Cancelled));
        assert!(job.cancelled().now_or_never().is_some());
    }

    #[tokio::test]
    async fn nothing_is_kept_of_jobs_that_nobody_waits_for() {
        let (_directory, store) = fresh().await;
        let (first, second) = (store.job_changes("job"), store.job_changes("job"));
        drop(first);
        store.changes.tell_of_job("job", Some(State::Running));
        assert_eq!(store.changes.jobs().len(), 1);
        drop(second);
        store.changes.tell_of_job("job", Some(State::Running));
        assert!(store.changes.jobs().is_empty());
    }
}
