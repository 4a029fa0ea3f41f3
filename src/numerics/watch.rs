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

/// The watcher of the whole as that of a part, which counts from 0 to 1 by itself.
pub struct Share<'a> {
    watch: &'a dyn Watch,
    begin: f64,
    end: f64,
}

impl<'a> Share<'a> {
    /// The part of the whole from `begin` to `end`.
    pub fn between(watch: &'a dyn Watch, begin: f64, end: f64) -> Share<'a> {
        Share { watch, begin, end }
    }

    /// One of `count` parts of the same length, from 0.
    pub fn of(watch: &'a dyn Watch, place: usize, count: usize) -> Share<'a> {
        let at = |place: usize| place as f64 / count.max(1) as f64;
        Share { watch, begin: at(place), end: at(place + 1) }
    }
}

impl Watch for Share<'_> {
    fn proceed(&self, fraction: f64) -> Result<(), Cancelled> {
        self.watch.proceed(self.begin + (self.end - self.begin) * fraction.clamp(0.0, 1.0))
    }
}

/// Steps of a loop between two questions: where a step takes some tenths of a microsecond, as that of a vertex does, a
/// millisecond or two.
pub const STRIDE: usize = 4096;

/// Asks the watcher once in every [`STRIDE`] steps of a loop.
pub struct Pace<'a> {
    watch: &'a dyn Watch,
    done: usize,
    of: usize,
}

impl<'a> Pace<'a> {
    /// Of a loop of so many steps, about.
    pub fn new(watch: &'a dyn Watch, of: usize) -> Pace<'a> {
        Pace { watch, done: 0, of }
    }

    /// A step is done.
    ///
    /// # Errors
    /// [`Cancelled`] by the watcher.
    pub fn step(&mut self) -> Result<(), Cancelled> {
        self.steps(1)
    }

    /// So many steps are done at once.
    ///
    /// # Errors
    /// [`Cancelled`] by the watcher.
    pub fn steps(&mut self, count: usize) -> Result<(), Cancelled> {
        let before = self.done / STRIDE;
        self.done += count;
        if self.done / STRIDE > before {
            self.watch.proceed(self.done as f64 / self.of.max(self.done) as f64)?;
        }
        Ok(())
    }
}

#[cfg(test)]
pub(crate) mod counting {
    use std::sync::atomic::{AtomicUsize, Ordering};

    use super::*;

    /// Counts the questions it is asked, and says stop at that of this number, from 0, where there is one.
    #[derive(Default)]
    pub struct Counting {
        asked: AtomicUsize,
        stop: Option<usize>,
    }

    impl Counting {
        /// Says stop at the question of this number, from 0.
        pub fn until(question: usize) -> Counting {
            Counting { asked: AtomicUsize::new(0), stop: Some(question) }
        }

        /// Questions so far.
        pub fn asked(&self) -> usize {
            self.asked.load(Ordering::Relaxed)
        }

        /// Checks that it was asked at least once in so many steps of [`STRIDE`].
        pub fn assert_asked_within(&self, steps: usize) {
            let asked = self.asked();
            assert!(asked >= steps / STRIDE, "asked {asked} times within {steps} steps");
        }
    }

    impl Watch for Counting {
        fn proceed(&self, fraction: f64) -> Result<(), Cancelled> {
            assert!((0.0..=1.0).contains(&fraction), "{fraction}");
            let question = self.asked.fetch_add(1, Ordering::Relaxed);
            if Some(question) == self.stop { Err(Cancelled) } else { Ok(()) }
        }
    }

    #[test]
    fn a_pace_asks_once_in_a_stride() {
        let counting = Counting::default();
        let mut pace = Pace::new(&counting, 2 * STRIDE);
        (0..3 * STRIDE).for_each(|_| pace.step().unwrap());
        assert_eq!(counting.asked(), 3);
        let mut pace = Pace::new(&const { Unwatched }, 0);
        assert_eq!((0..STRIDE).try_for_each(|_| pace.step()), Ok(()));
    }

    #[test]
    fn a_share_counts_within_the_whole() {
        struct Told(std::sync::Mutex<Vec<f64>>);
        impl Watch for Told {
            fn proceed(&self, fraction: f64) -> Result<(), Cancelled> {
                self.0.lock().unwrap().push(fraction);
                Ok(())
            }
        }
        let told = Told(std::sync::Mutex::default());
        for (share, fraction) in [(Share::of(&told, 1, 4), 0.5), (Share::between(&told, 0.2, 0.6), 2.0)] {
            share.proceed(fraction).unwrap();
        }
        assert_eq!(told.0.into_inner().unwrap(), [0.375, 0.6]);
    }
}
