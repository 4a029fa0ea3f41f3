//! How computations wait for the store, which their threads are not to outlast a cancelling for.

use std::future::Future;
use std::io::{self, Write};
use std::pin::pin;
use std::time::Duration;

use tokio::runtime::Handle;
use tokio::time::timeout;

use crate::numerics::Cancelled;

/// How often somebody who waits asks whether to go on waiting.
pub const PATIENCE: Duration = Duration::from_millis(20);

/// What `work` comes to, waited for on a thread outside the runtime as long as `ask` says to go on.
///
/// # Errors
/// That of `ask`.
pub fn awaited<T>(
    runtime: &Handle,
    work: impl Future<Output = T>,
    ask: impl Fn() -> Result<(), Cancelled>,
) -> Result<T, Cancelled> {
    runtime.block_on(async {
        let mut work = pin!(work);
        loop {
            match timeout(PATIENCE, &mut work).await {
                Ok(done) => return Ok(done),
                Err(_) => ask()?,
            }
        }
    })
}

/// Bytes between two questions of who writes.
const STRETCH: usize = 1 << 16;

/// Bytes that are being written, as long as `ask` says to go on.
pub struct Writing<F> {
    pub bytes: Vec<u8>,
    asked_at: usize,
    ask: F,
}

impl<F: Fn() -> Result<(), Cancelled>> Writing<F> {
    pub fn new(ask: F) -> Writing<F> {
        Writing { bytes: Vec::new(), asked_at: 0, ask }
    }
}

impl<F: Fn() -> Result<(), Cancelled>> Write for Writing<F> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        if self.bytes.len() - self.asked_at >= STRETCH {
            (self.ask)().map_err(io::Error::other)?;
            self.asked_at = self.bytes.len();
        }
        self.bytes.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use std::cell::Cell;
    use std::future::{pending, ready};

    use super::*;

    #[test]
    fn who_waits_for_what_never_comes_is_let_go() {
        let runtime = tokio::runtime::Builder::new_multi_thread().worker_threads(1).enable_time().build().unwrap();
        let asked = Cell::new(0);
        let ask = || {
            asked.set(asked.get() + 1);
            if asked.get() < 3 { Ok(()) } else { Err(Cancelled) }
        };
        assert_eq!(awaited(runtime.handle(), ready(7), || Err(Cancelled)), Ok(7));
        assert_eq!(awaited(runtime.handle(), pending::<()>(), ask), Err(Cancelled));
        assert_eq!(asked.get(), 3);
    }

    #[test]
    fn who_writes_much_is_let_go() {
        let numbers = vec![0.125f64; 4 * STRETCH];
        let asked = Cell::new(0);
        let ask = || {
            asked.set(asked.get() + 1);
            if asked.get() < 3 { Ok(()) } else { Err(Cancelled) }
        };
        let mut writing = Writing::new(ask);
        assert!(serde_json::to_writer(&mut writing, &numbers).unwrap_err().is_io());
        assert!(writing.bytes.len() < 4 * STRETCH);
        let mut writing = Writing::new(|| Ok(()));
        serde_json::to_writer(&mut writing, &numbers).unwrap();
        assert_eq!(writing.bytes, serde_json::to_vec(&numbers).unwrap());
    }
}
