//! Routines of libraries that cannot be asked to stop.

use std::sync::mpsc::{RecvTimeoutError, channel};
use std::thread;
use std::time::Duration;

use super::{Cancelled, Watch};

/// How often the watcher is asked meanwhile.
const PATIENCE: Duration = Duration::from_millis(10);

/// What `work` returns, which a thread of its own does while the calling one asks the watcher and does nothing else. Where
/// that says stop nobody waits any longer: the work ends by itself, and what it returns is dropped.
///
/// # Errors
/// [`Cancelled`] by the watcher.
///
/// # Panics
/// Where `work` does.
pub fn apart<T: Send + 'static>(work: impl FnOnce() -> T + Send + 'static, watch: &dyn Watch) -> Result<T, Cancelled> {
    let (sender, receiver) = channel();
    let thread = thread::spawn(move || {
        // Nobody receives it where the watcher said stop.
        let _ = sender.send(work());
    });
    loop {
        match receiver.recv_timeout(PATIENCE) {
            Ok(done) => return Ok(done),
            Err(RecvTimeoutError::Timeout) => watch.proceed(0.0)?,
            Err(RecvTimeoutError::Disconnected) => match thread.join() {
                Err(panic) => std::panic::resume_unwind(panic),
                Ok(()) => unreachable!("work that ends without a panic is received"),
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::watch::counting::Counting;
    use super::*;
    use crate::numerics::Unwatched;

    #[test]
    fn what_is_done_apart_comes_back() {
        assert_eq!(apart(|| 6 * 7, &Unwatched), Ok(42));
    }

    #[test]
    fn nobody_waits_for_what_is_cancelled() {
        let (release, held) = channel::<()>();
        // It would wait for ever.
        assert_eq!(apart(move || held.recv(), &Counting::until(2)), Err(Cancelled));
        drop(release);
    }

    #[test]
    #[should_panic(expected = "at work")]
    fn a_panic_comes_through() {
        let _ = apart(|| panic!("at work"), &Unwatched);
    }
}
