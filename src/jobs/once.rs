//! What all jobs of all nodes need is computed by one of them, and read by the others where it is kept.

use std::time::Duration;

use metrics::{counter, describe_counter};
use tokio::runtime::Handle;
use tokio::time::sleep;

use super::waiting::awaited;
use crate::numerics::{Cancelled, Watch};
use crate::store::{Store, StoreError};

/// How often somebody who waits for another looks again.
const AGAIN: Duration = Duration::from_millis(100);

const ASKED: &str = "sketchmatch_cache_total";

/// What is kept so that it is computed once.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Cache {
    Spectra,
    Preparations,
    Weights,
}

impl Cache {
    const fn name(self) -> &'static str {
        match self {
            Cache::Spectra => "spectra",
            Cache::Preparations => "preparations",
            Cache::Weights => "weights",
        }
    }

    /// Counts a question to the cache by what came of it.
    fn count(self, outcome: &'static str) {
        counter!(ASKED, "cache" => self.name(), "outcome" => outcome).increment(1);
    }
}

/// Says what is measured here and sets it to nothing, so that what has not happened yet is 0 and not unknown.
pub(super) fn describe() {
    describe_counter!(
        ASKED,
        "Questions of jobs to what is cached: found (hit), computed by another meanwhile (waited), or computed (miss)."
    );
    for cache in [Cache::Spectra, Cache::Preparations, Cache::Weights] {
        for outcome in ["hit", "waited", "miss"] {
            counter!(ASKED, "cache" => cache.name(), "outcome" => outcome).absolute(0);
        }
    }
}

/// What is cached, or what `compute` makes, which then is to keep it: by one at a time of all who need what goes by `name`, on
/// whichever node they are. Called from threads outside the runtime. A claim that fails costs time, not the answer.
///
/// # Errors
/// [`Cancelled`] by the watcher while another computes it; what `cached` and `compute` say.
pub(super) fn once<T, E: From<Cancelled>>(
    (store, runtime): (&Store, &Handle),
    (cache, name): (Cache, &str),
    watch: &dyn Watch,
    cached: impl Fn() -> Result<Option<T>, Cancelled>,
    compute: impl FnOnce() -> Result<T, E>,
) -> Result<T, E> {
    if let Some(found) = cached()? {
        cache.count("hit");
        return Ok(found);
    }
    let ask = || watch.proceed(0.0);
    let _claim = loop {
        let (taker, taken) = (store.clone(), name.to_owned());
        // A claim that nobody waits for any more is given up again.
        let taking = runtime.spawn(async move { taker.take(&taken).await });
        match awaited(runtime, taking, ask)?.map_err(|error| StoreError::damaged("a claim", error)).flatten() {
            Ok(Some(claim)) => break Some(claim),
            Ok(None) => awaited(runtime, async { sleep(AGAIN).await }, ask)?,
            Err(error) => {
                tracing::warn!(%error, name, "it cannot be claimed, and may be computed by others too");
                break None;
            }
        }
    };
    // Whoever had the claim before has kept it meanwhile.
    if let Some(found) = cached()? {
        cache.count("waited");
        return Ok(found);
    }
    cache.count("miss");
    compute()
}

#[cfg(test)]
mod tests {
    use std::sync::Mutex;
    use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
    use std::thread;

    use super::*;
    use crate::numerics::Unwatched;
    use crate::store::testing::on_every_database;

    #[tokio::test(flavor = "multi_thread")]
    async fn what_eight_need_on_two_nodes_is_computed_once() {
        on_every_database(async |place, store| {
            let other = if store.is_shared() { place.open().await } else { store.clone() };
            let (kept, computed, runtime) = (Mutex::new(None), AtomicUsize::new(0), Handle::current());
            let compute = || {
                thread::sleep(Duration::from_millis(50));
                *kept.lock().unwrap() = Some(computed.fetch_add(1, Ordering::SeqCst));
                Ok::<_, Cancelled>(0)
            };
            let cached = || Ok(*kept.lock().unwrap());
            let answers: Vec<_> = thread::scope(|scope| {
                let needed = [&store, &other].into_iter().cycle().take(8);
                let threads: Vec<_> = needed
                    .map(|store| {
                        scope.spawn(|| {
                            once((store, &runtime), (Cache::Spectra, "spectrum"), &Unwatched, cached, compute)
                        })
                    })
                    .collect();
                threads.into_iter().map(|thread| thread.join().unwrap().unwrap()).collect()
            });
            assert_eq!((answers, computed.into_inner()), (vec![0; 8], 1));
        })
        .await;
    }

    #[tokio::test(flavor = "multi_thread")]
    async fn waiting_ends_when_it_is_cancelled_and_without_a_database_nobody_waits() {
        struct Stopped(AtomicBool);
        impl Watch for Stopped {
            fn proceed(&self, _fraction: f64) -> Result<(), Cancelled> {
                if self.0.swap(true, Ordering::SeqCst) { Err(Cancelled) } else { Ok(()) }
            }
        }
        on_every_database(async |_, store| {
            let (_claim, runtime) = (store.take("spectrum").await.unwrap().unwrap(), Handle::current());
            let needed = |watch: &(dyn Watch + Sync)| {
                let ask = || {
                    once((&store, &runtime), (Cache::Spectra, "spectrum"), watch, || Ok(None), || Ok::<_, Cancelled>(1))
                };
                thread::scope(|scope| scope.spawn(ask).join().unwrap())
            };
            assert!(needed(&Stopped(AtomicBool::new(false))).is_err());
            store.close().await.unwrap();
            assert_eq!(needed(&Unwatched).ok(), Some(1));
        })
        .await;
    }
}
