use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use tokio::sync::Notify;

use crate::store::JobKind;

/// How the threads are shared by the kinds of jobs, so that many of one kind do not keep those of another waiting.
pub(super) struct Shares {
    threads: usize,
    taken: Mutex<Taken>,
    /// Told when a share is given back.
    pub freed: Notify,
}

#[derive(Default)]
struct Taken {
    matches: usize,
    spectra: usize,
    last: Option<JobKind>,
}

/// A thread in use for a kind of job; given back when it is dropped.
pub(super) struct Share {
    shares: Arc<Shares>,
    kind: JobKind,
}

impl Taken {
    fn of(&mut self, kind: JobKind) -> &mut usize {
        match kind {
            JobKind::Match => &mut self.matches,
            JobKind::Spectrum => &mut self.spectra,
        }
    }
}

impl Shares {
    pub fn new(threads: usize) -> Shares {
        Shares { threads, taken: Mutex::default(), freed: Notify::new() }
    }

    fn taken(&self) -> MutexGuard<'_, Taken> {
        self.taken.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The kinds that a free thread may take up, the one whose turn it is first: the one that has fewer threads, else
    /// the one that was not taken last. Of several threads spectra leave one alone: they may take long, and a match that
    /// comes need not wait for one to end.
    pub fn turn(&self) -> Vec<JobKind> {
        let Taken { matches, spectra, last } = *self.taken();
        let spectrum_first = spectra < matches || (spectra == matches && last == Some(JobKind::Match));
        let order =
            if spectrum_first { [JobKind::Spectrum, JobKind::Match] } else { [JobKind::Match, JobKind::Spectrum] };
        let most_spectra = (self.threads - 1).max(1);
        order.into_iter().filter(|kind| *kind == JobKind::Match || spectra < most_spectra).collect()
    }

    /// Takes a thread for a job of this kind.
    pub fn take(self: &Arc<Shares>, kind: JobKind) -> Share {
        let mut taken = self.taken();
        *taken.of(kind) += 1;
        taken.last = Some(kind);
        drop(taken);
        Share { shares: self.clone(), kind }
    }
}

impl Drop for Share {
    fn drop(&mut self) {
        *self.shares.taken().of(self.kind) -= 1;
        self.shares.freed.notify_one();
    }
}

#[cfg(test)]
mod tests {
    use super::JobKind::{Match, Spectrum};
    use super::*;

    #[test]
    fn one_thread_takes_turns() {
        let shares = Arc::new(Shares::new(1));
        assert_eq!(shares.turn(), [Match, Spectrum]);
        for (taken, then) in [(Match, [Spectrum, Match]), (Spectrum, [Match, Spectrum]), (Spectrum, [Match, Spectrum])]
        {
            drop(shares.take(taken));
            assert_eq!(shares.turn(), then);
        }
    }

    #[test]
    fn spectra_leave_a_thread_to_matches() {
        let shares = Arc::new(Shares::new(3));
        let first = shares.take(Spectrum);
        assert_eq!(shares.turn(), [Match, Spectrum]);
        let _second = shares.take(Spectrum);
        assert_eq!(shares.turn(), [Match]);
        drop(first);
        assert_eq!(shares.turn(), [Match, Spectrum]);
    }

    #[test]
    fn matches_may_take_all_threads_and_then_it_is_the_turn_of_spectra() {
        let shares = Arc::new(Shares::new(2));
        let first = shares.take(Match);
        let _second = shares.take(Match);
        drop(first);
        assert_eq!(shares.turn(), [Spectrum, Match]);
    }
}
