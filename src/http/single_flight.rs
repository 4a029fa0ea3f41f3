//! What many ask for at one time and one finds out.

use std::future::Future;

use tokio::sync::Mutex;
use tokio::time::Instant;

/// What was found last, and when one began to look.
pub struct SingleFlight<T>(Mutex<Option<(Instant, T)>>);

impl<T> Default for SingleFlight<T> {
    fn default() -> SingleFlight<T> {
        SingleFlight(Mutex::new(None))
    }
}

impl<T: Clone> SingleFlight<T> {
    /// What `look` finds; or what another found meanwhile who began after this was asked for, so that it is as new. One looks at a
    /// time: however many ask at once, two look.
    pub async fn asked(&self, look: impl Future<Output = T>) -> T {
        let asked = Instant::now();
        let mut last = self.0.lock().await;
        if let Some((began, found)) = &*last
            && *began > asked
        {
            return found.clone();
        }
        let began = Instant::now();
        let found = look.await;
        *last = Some((began, found.clone()));
        found
    }
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicUsize, Ordering};

    use futures::future::join_all;
    use tokio::sync::Notify;

    use super::*;

    #[tokio::test]
    async fn of_many_who_ask_at_once_two_look_and_whoever_asks_later_looks_anew() {
        let (flight, looks, all_asked) = (SingleFlight::default(), AtomicUsize::new(0), Notify::new());
        let look = || async { looks.fetch_add(1, Ordering::Relaxed) + 1 };
        let first = flight.asked(async {
            all_asked.notified().await;
            look().await
        });
        let others = join_all((0..50).map(|_| flight.asked(look())));
        // Each is begun before the next, so that all have asked while the first looks.
        let (first, others, ()) = tokio::join!(first, others, async { all_asked.notify_one() });
        assert_eq!((first, others), (1, vec![2; 50]));
        assert_eq!(flight.asked(look()).await, 3);
    }
}
