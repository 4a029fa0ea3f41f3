//! Routines of libraries that cannot be asked to stop.

use std::sync::mpsc::{RecvTimeoutError, channel};
use std::thread;
use std::time::Duration;

/// How often it is asked meanwhile.
const PATIENCE: Duration = Duration::from_millis(10);

/// What `work` returns, which a thread of its own does while the calling one does nothing but `ask` whether to go on. Where
/// that says stop nobody waits any longer: the work ends by itself, and what it returns is dropped.
///
/// # Errors
/// That of `ask`.
///
/// # Panics
/// Where `work` does.
pub fn apart<T: Send + 'static, E>(
    work: impl FnOnce() -> T + Send + 'static,
    ask: impl Fn() -> Result<(), E>,
) -> Result<T, E> {
    let (sender, receiver) = channel();
    let thread = thread::spawn(move || {
        // Nobody receives it where the watcher said stop.
        let _ = sender.send(work());
    });
    loop {
        match receiver.recv_timeout(PATIENCE) {
            Ok(done) => return Ok(done),
            Err(RecvTimeoutError::Timeout) => ask()?,
            Err(RecvTimeoutError::Disconnected) => match thread.join() {
                Err(panic) => std::panic::resume_unwind(panic),
                Ok(()) => unreachable!("work that ends without a panic is received"),
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use std::cell::Cell;
    use std::convert::Infallible;

    use super::*;
    use crate::numerics::Cancelled;

    #[test]
    fn what_is_done_apart_comes_back() {
        assert_eq!(apart(|| 6 * 7, || Ok::<_, Infallible>(())), Ok(42));
    }

    #[test]
    fn nobody_waits_for_what_is_cancelled() {
        let (release, held) = channel::<()>();
        let asked = Cell::new(0);
        let ask = || {
            asked.set(asked.get() + 1);
            if asked.get() < 3 { Ok(()) } else { Err(Cancelled) }
        };
        // It would wait for ever.
        assert_eq!(apart(move || held.recv(), ask), Err(Cancelled));
        drop(release);
    }

    #[test]
    #[should_panic(expected = "at work")]
    fn a_panic_comes_through() {
        let Ok(()) = apart(|| panic!("at work"), || Ok::<_, Infallible>(()));
    }
}
