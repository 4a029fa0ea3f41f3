use std::collections::HashSet;
use std::hash::Hash;
use std::sync::{Condvar, Mutex, PoisonError};

use super::waiting::PATIENCE;
use crate::numerics::{Cancelled, Watch};

/// Computations under way, by key: whoever comes second waits for the first instead of doing the same.
pub struct SingleFlight<K> {
    under_way: Mutex<HashSet<K>>,
    landed: Condvar,
}

/// The right to be the only one to compute something; it ends when it is dropped.
pub struct Flight<'a, K: Hash + Eq> {
    flights: &'a SingleFlight<K>,
    key: K,
}

impl<K: Hash + Eq + Clone> SingleFlight<K> {
    pub fn new() -> SingleFlight<K> {
        SingleFlight { under_way: Mutex::new(HashSet::new()), landed: Condvar::new() }
    }

    /// Waits until nobody else is computing `key`. The holder must not wait for other work of its own pool, or it
    /// could be made to wait for itself.
    ///
    /// # Errors
    /// [`Cancelled`] by the watcher while waiting.
    pub fn board(&self, key: K, watch: &dyn Watch) -> Result<Flight<'_, K>, Cancelled> {
        let mut under_way = self.under_way.lock().unwrap_or_else(PoisonError::into_inner);
        while !under_way.insert(key.clone()) {
            watch.proceed(0.0)?;
            let woken = self.landed.wait_timeout(under_way, PATIENCE);
            under_way = woken.unwrap_or_else(PoisonError::into_inner).0;
        }
        drop(under_way);
        Ok(Flight { flights: self, key })
    }
}

impl<K: Hash + Eq> Drop for Flight<'_, K> {
    fn drop(&mut self) {
        self.flights.under_way.lock().unwrap_or_else(PoisonError::into_inner).remove(&self.key);
        self.flights.landed.notify_all();
    }
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
    use std::thread;

    use super::*;
    use crate::numerics::Unwatched;

    #[test]
    fn one_key_is_computed_by_one_at_a_time() {
        let (flights, aloft, most) = (SingleFlight::new(), AtomicUsize::new(0), AtomicUsize::new(0));
        thread::scope(|scope| {
            for _ in 0..8 {
                scope.spawn(|| {
                    let _flight = flights.board("key", &Unwatched);
                    most.fetch_max(aloft.fetch_add(1, Ordering::SeqCst) + 1, Ordering::SeqCst);
                    thread::yield_now();
                    aloft.fetch_sub(1, Ordering::SeqCst);
                });
            }
        });
        assert_eq!(most.into_inner(), 1);
    }

    #[test]
    fn different_keys_do_not_wait() {
        let flights = SingleFlight::new();
        let first = flights.board(1, &Unwatched);
        assert!(first.is_ok() && flights.board(2, &Unwatched).is_ok());
    }

    #[test]
    fn waiting_ends_when_it_is_cancelled() {
        struct Stopped(AtomicBool);
        impl Watch for Stopped {
            fn proceed(&self, _fraction: f64) -> Result<(), Cancelled> {
                if self.0.swap(true, Ordering::SeqCst) { Err(Cancelled) } else { Ok(()) }
            }
        }
        let flights = SingleFlight::new();
        let _first = flights.board(1, &Unwatched);
        assert!(flights.board(1, &Stopped(AtomicBool::new(false))).is_err());
    }
}
