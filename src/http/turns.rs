//! Turns of what is done off the threads that answer requests, and holds on the memory that it takes.

use tokio::sync::OwnedSemaphorePermit;

use super::App;
use super::body::MEMORY_GRAIN;
use super::problem::Problem;

/// In which line work waits for its turn.
#[derive(Clone, Copy)]
pub enum Line {
    /// It takes moments.
    Short,
    /// It may take tens of seconds.
    Long,
}

/// The work, with what it takes until it has ended, also where nobody waits for it any more.
pub fn keeping<T>(
    taken: impl Send + 'static,
    work: impl FnOnce() -> T + Send + 'static,
) -> impl FnOnce() -> T + Send + 'static {
    move || {
        let _taken = taken;
        work()
    }
}

/// Permits for this many bytes.
pub fn grains(bytes: usize) -> u32 {
    u32::try_from(bytes.div_ceil(MEMORY_GRAIN)).unwrap_or(u32::MAX)
}

impl App {
    /// What `work` returns, done on a thread of its own: as many at a time as there are processors, or two. Work that has
    /// begun keeps its turn to its end, also where the client hangs up meanwhile.
    pub(super) async fn off_runtime<T: Send + 'static>(
        &self,
        work: impl FnOnce() -> T + Send + 'static,
    ) -> Result<T, Problem> {
        let turn = self.turns.clone().acquire_owned().await.map_err(Problem::internal)?;
        tokio::task::spawn_blocking(keeping(turn, work)).await.map_err(Problem::internal)
    }

    /// The same for work that may take tens of seconds: of the turns it leaves one to short work, which so goes on however much
    /// there is of it.
    pub(super) async fn at_length<T: Send + 'static>(
        &self,
        work: impl FnOnce() -> T + Send + 'static,
    ) -> Result<T, Problem> {
        let long = self.long_turns.clone().acquire_owned().await.map_err(Problem::internal)?;
        self.off_runtime(keeping(long, work)).await
    }

    /// The same for work that waits in one line or the other.
    pub(super) async fn in_line<T: Send + 'static>(
        &self,
        line: Line,
        work: impl FnOnce() -> T + Send + 'static,
    ) -> Result<T, Problem> {
        match line {
            Line::Short => self.off_runtime(work).await,
            Line::Long => self.at_length(work).await,
        }
    }

    /// A hold on about this many bytes of the memory for what is read, once they are free; what takes more than there are goes
    /// alone. Who has one asks for no other: two who did would wait for each other.
    pub(super) async fn room_for(&self, bytes: usize) -> Result<OwnedSemaphorePermit, Problem> {
        let grains = grains(bytes.min(self.config.max_reading_bytes));
        self.reading.clone().acquire_many_owned(grains).await.map_err(Problem::internal)
    }

    /// What short work returns that takes about this many bytes of memory.
    pub(super) async fn with_memory<T: Send + 'static>(
        &self,
        bytes: usize,
        work: impl FnOnce() -> T + Send + 'static,
    ) -> Result<T, Problem> {
        let memory = self.room_for(bytes).await?;
        self.off_runtime(keeping(memory, work)).await
    }

    /// Bytes of memory that are set aside for what is being read now.
    pub(super) fn reading_bytes(&self) -> usize {
        let all = grains(self.config.max_reading_bytes) as usize;
        (all - self.reading.available_permits()) * MEMORY_GRAIN
    }

    /// A hold on memory for a body of `length` bytes, given back when dropped.
    ///
    /// # Errors
    /// 503 while other bodies take it up.
    pub(super) fn memory_for(&self, length: usize) -> Result<OwnedSemaphorePermit, Problem> {
        let hold = self.memory.clone().try_acquire_many_owned(grains(length));
        hold.map_err(|_| Problem::busy("too many uploads are under way", 1))
    }

    /// Makes a hold on memory one for `length` bytes.
    ///
    /// # Errors
    /// 503 while other bodies take it up.
    pub(super) fn enlarge(&self, hold: &mut OwnedSemaphorePermit, length: usize) -> Result<(), Problem> {
        let more = length.saturating_sub(hold.num_permits() * MEMORY_GRAIN);
        hold.merge(self.memory_for(more)?);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use std::pin::pin;
    use std::sync::Arc;
    use std::sync::mpsc::channel;
    use std::time::Duration;

    use axum::http::{HeaderMap, StatusCode};
    use serde_json::json;
    use tokio::time::timeout;

    use super::*;
    use crate::http::testing::app;
    use crate::http::{Config, geometry, portraits, query};
    use crate::mesh::solids::sheet;
    use crate::store::testing::{fresh, source};

    /// Within which all is done that nothing keeps waiting.
    const SOON: Duration = Duration::from_secs(20);

    #[tokio::test]
    async fn work_keeps_its_turn_and_its_memory_when_nobody_waits_any_more() {
        let (_directory, store) = fresh().await;
        let app = app(store, Config::default());
        let turns = app.turns.available_permits();
        let (began, begun) = channel();
        let (end, ended) = channel();
        let working = app.clone();
        let asking = tokio::spawn(async move {
            let work = move || {
                began.send(()).unwrap();
                ended.recv().unwrap();
            };
            working.with_memory(1 << 20, work).await
        });
        tokio::task::spawn_blocking(move || begun.recv().unwrap()).await.unwrap();
        asking.abort();
        assert!(asking.await.unwrap_err().is_cancelled());
        assert_eq!((app.turns.available_permits(), app.reading_bytes()), (turns - 1, 1 << 20));
        end.send(()).unwrap();
        let all_turns = app.turns.acquire_many(u32::try_from(turns).unwrap()).await;
        assert!(all_turns.is_ok() && app.reading.available_permits() == grains(app.config.max_reading_bytes) as usize);
    }

    #[tokio::test]
    async fn short_work_goes_on_however_much_long_work_there_is() {
        let (_directory, store) = fresh().await;
        let mesh = store.insert_mesh(sheet(6, 3).into(), source("v"), None, json!({})).await.unwrap().0.id;
        let app = app(store, Config::default());
        let id = || query::Id(mesh.clone());
        let (ends, ended) = channel::<()>();
        let ended = Arc::new(std::sync::Mutex::new(ended));
        let long: Vec<_> = (0..=app.turns.available_permits())
            .map(|_| {
                let (app, ended) = (app.clone(), ended.clone());
                // It lasts until nobody can say any more that it is over.
                tokio::spawn(async move { app.at_length(move || ended.lock().unwrap().recv().is_err()).await })
            })
            .collect();
        while app.long_turns.available_permits() > 0 {
            tokio::task::yield_now().await;
        }
        let picture = portraits::of_mesh(app.clone(), id(), query::Query(Default::default()), HeaderMap::new());
        let mut picture = pin!(picture);
        assert!(timeout(Duration::from_millis(200), &mut picture).await.is_err());
        let triangles = timeout(SOON, geometry::of_mesh(app.clone(), id(), HeaderMap::new())).await.unwrap();
        assert_eq!(triangles.ok().unwrap().status(), StatusCode::OK);
        drop(ends);
        assert_eq!(timeout(SOON, picture).await.unwrap().ok().unwrap().status(), StatusCode::OK);
        for work in long {
            assert!(work.await.unwrap().ok().unwrap());
        }
    }
}
