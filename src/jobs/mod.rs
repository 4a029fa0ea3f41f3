//! What can be put into the queue: each kind of job is a type, in a file of its own.
//!
//! Who asks for a job says what it is by a [`Task`]; who carries it out finds its [`Kind`] by the name it is stored under.

mod bench;
mod caches;
pub mod decomposition;
mod failure;
mod kind;
mod matching;
pub mod memory;
mod once;
pub mod posing;
mod progress;
mod shapes;
mod waiting;

use std::time::Duration;

pub use bench::Bench;
pub use caches::Caches;
pub use decomposition::Decomposition;
pub use failure::Failure;
pub use kind::{Kind, Outcome, Task};
pub use posing::Posing;
pub use progress::Progress;

use crate::pipeline::Settings;

/// How long running jobs, and the requests that may wait for them, may go on after the order to stop: with what follows it fits the
/// 10 s that `docker stop` waits.
pub const GRACE: Duration = Duration::from_secs(6);

/// Every kind of job there is; of those whose turn it is the first comes first.
pub static KINDS: [Kind; 3] = [Kind::of::<Settings>(), Kind::of::<Posing>(), Kind::of::<Decomposition>()];

/// The kind of this name.
pub fn kind(name: &str) -> Option<&'static Kind> {
    KINDS.iter().find(|kind| kind.name == name)
}

/// Says what jobs measure of themselves.
pub fn describe() {
    matching::describe();
    once::describe();
}
