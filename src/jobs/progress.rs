use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};

use bytes::Bytes;
use tokio::sync::Notify;

use crate::numerics::{Cancelled, Watch};
use crate::pipeline::{Stage, Watcher};

/// What a computation and the task that reports on it tell each other: how far it is, and whether it is to stop.
#[derive(Default)]
pub struct Progress {
    stopped: AtomicBool,
    at: Mutex<(&'static str, f64)>,
    preview: Mutex<Option<Bytes>>,
    previewed: Notify,
}

impl Progress {
    /// The stage under way, and the fraction of the whole job that is done.
    pub fn at(&self) -> (&'static str, f64) {
        *self.at.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Shows what the outcome looks like at first sight, in JSON.
    pub fn preview(&self, preview: Bytes) {
        *self.preview.lock().unwrap_or_else(PoisonError::into_inner) = Some(preview);
        self.previewed.notify_one();
    }

    /// What is shown next.
    pub async fn previewed(&self) -> Bytes {
        loop {
            self.previewed.notified().await;
            if let Some(preview) = self.preview.lock().unwrap_or_else(PoisonError::into_inner).take() {
                return preview;
            }
        }
    }

    /// Has the computation end at its next question.
    pub fn stop(&self) {
        self.stopped.store(true, Ordering::Relaxed);
    }

    /// Whether to go on, wherever the computation is.
    ///
    /// # Errors
    /// [`Cancelled`] where it is to stop.
    pub fn going(&self) -> Result<(), Cancelled> {
        if self.stopped.load(Ordering::Relaxed) { Err(Cancelled) } else { Ok(()) }
    }

    /// The progress of a job that is one stage of this name.
    pub fn stage(&self, name: &'static str) -> OneStage<'_> {
        OneStage { progress: self, name }
    }

    fn reach(&self, stage: &'static str, fraction: f64) -> Result<(), Cancelled> {
        *self.at.lock().unwrap_or_else(PoisonError::into_inner) = (stage, fraction);
        self.going()
    }
}

/// A match goes through stages.
impl Watcher for Progress {
    fn proceed(&self, stage: Stage, fraction: f64) -> Result<(), Cancelled> {
        self.reach(stage.name(), fraction)
    }
}

/// A spectrum is one stage.
impl Watch for Progress {
    fn proceed(&self, fraction: f64) -> Result<(), Cancelled> {
        self.reach(Stage::Spectrum.name(), fraction)
    }
}

/// A job that is one stage.
pub struct OneStage<'a> {
    progress: &'a Progress,
    name: &'static str,
}

impl Watch for OneStage<'_> {
    fn proceed(&self, fraction: f64) -> Result<(), Cancelled> {
        self.progress.reach(self.name, fraction)
    }
}
