use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use tokio::sync::Notify;

use crate::jobs::{KINDS, Kind};

/// How the threads are shared by the kinds of jobs, so that many of one kind do not keep those of another waiting.
pub(super) struct Shares {
    threads: usize,
    in_use: Mutex<InUse>,
    /// Told when a share is given back.
    pub freed: Notify,
}

/// Threads in use for each kind, in the order of their list.
#[derive(Clone, Copy, Default)]
struct InUse {
    threads: [usize; KINDS.len()],
    /// When a thread was taken last, as the number of that taking; 0 where none was.
    last: [u64; KINDS.len()],
}

/// A thread in use for a kind of job; given back when it is dropped.
pub(super) struct Share {
    shares: Arc<Shares>,
    place: usize,
}

/// Where in their list a kind stands.
fn place(kind: &Kind) -> usize {
    KINDS.iter().position(|other| other.name == kind.name).unwrap_or(0)
}

impl Shares {
    pub fn new(threads: usize) -> Shares {
        Shares { threads, in_use: Mutex::default(), freed: Notify::new() }
    }

    fn in_use(&self) -> MutexGuard<'_, InUse> {
        self.in_use.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The names of the kinds that a free thread may take up, the one whose turn it is first: the one that has fewest
    /// threads, else the one that was taken longest ago. Those that have all the threads they may have are left out.
    pub fn turn(&self) -> Vec<&'static str> {
        let InUse { threads, last } = *self.in_use();
        let mut places: Vec<usize> =
            (0..KINDS.len()).filter(|&i| threads[i] < KINDS[i].threads(self.threads)).collect();
        places.sort_by_key(|&i| (threads[i], last[i]));
        places.into_iter().map(|i| KINDS[i].name).collect()
    }

    /// Takes a thread for a job of this kind.
    pub fn take(self: &Arc<Shares>, kind: &Kind) -> Share {
        let (place, mut in_use) = (place(kind), self.in_use());
        in_use.threads[place] += 1;
        in_use.last[place] = 1 + in_use.last.iter().max().copied().unwrap_or(0);
        drop(in_use);
        Share { shares: self.clone(), place }
    }
}

impl Drop for Share {
    fn drop(&mut self) {
        self.shares.in_use().threads[self.place] -= 1;
        self.shares.freed.notify_one();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::jobs::{Decomposition, Posing, Task};
    use crate::pipeline::Settings;

    const MATCH: &str = Settings::NAME;
    const POSE: &str = Posing::NAME;
    const SPECTRUM: &str = Decomposition::NAME;

    fn taken(shares: &Arc<Shares>, kind: &str) -> Share {
        shares.take(crate::jobs::kind(kind).unwrap())
    }

    #[test]
    fn one_thread_takes_turns() {
        let shares = Arc::new(Shares::new(1));
        assert_eq!(shares.turn(), [MATCH, POSE, SPECTRUM]);
        let turns = [
            (MATCH, [POSE, SPECTRUM, MATCH]),
            (SPECTRUM, [POSE, MATCH, SPECTRUM]),
            (SPECTRUM, [POSE, MATCH, SPECTRUM]),
            (POSE, [MATCH, SPECTRUM, POSE]),
        ];
        for (kind, then) in turns {
            drop(taken(&shares, kind));
            assert_eq!(shares.turn(), then);
        }
    }

    #[test]
    fn spectra_leave_a_thread_to_others() {
        let shares = Arc::new(Shares::new(3));
        let first = taken(&shares, SPECTRUM);
        assert_eq!(shares.turn(), [MATCH, POSE, SPECTRUM]);
        let _second = taken(&shares, SPECTRUM);
        assert_eq!(shares.turn(), [MATCH, POSE]);
        drop(first);
        assert_eq!(shares.turn(), [MATCH, POSE, SPECTRUM]);
    }

    #[test]
    fn matches_may_take_all_threads_and_then_it_is_the_turn_of_others() {
        let shares = Arc::new(Shares::new(2));
        let first = taken(&shares, MATCH);
        let _second = taken(&shares, MATCH);
        drop(first);
        assert_eq!(shares.turn(), [POSE, SPECTRUM, MATCH]);
    }
}
