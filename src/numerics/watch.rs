/// Whoever waits for a computation: asked at every iteration whether to go on.
pub trait Watch: Sync {
    /// `fraction` of the present computation is done, in `[0, 1]`.
    ///
    /// # Errors
    /// [`Cancelled`] when nobody waits any more; the computation then returns it upwards at once.
    fn proceed(&self, fraction: f64) -> Result<(), Cancelled>;
}

/// The watcher said stop.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("cancelled")]
pub struct Cancelled;

/// Never cancels: for tests, the command line and computations too short to ask.
pub struct Unwatched;

impl Watch for Unwatched {
    fn proceed(&self, _fraction: f64) -> Result<(), Cancelled> {
        Ok(())
    }
}
