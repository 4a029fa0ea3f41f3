//! The stages of a match: their share of the whole, their progress and their time.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::sync::atomic::{AtomicU64, Ordering};

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::{Surroundings, Watcher};
use crate::numerics::{Cancelled, Watch};

/// The name of the time of all stages together.
pub const TOTAL: &str = "total";

/// The stages of a match in their order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum Stage {
    Spectrum,
    Alignment,
    Regions,
    Descriptors,
    Map,
    Points,
}

impl Stage {
    pub const ALL: [Stage; 6] =
        [Stage::Spectrum, Stage::Alignment, Stage::Regions, Stage::Descriptors, Stage::Map, Stage::Points];

    pub fn name(self) -> &'static str {
        match self {
            Stage::Spectrum => "spectrum",
            Stage::Alignment => "alignment",
            Stage::Regions => "regions",
            Stage::Descriptors => "descriptors",
            Stage::Map => "map",
            Stage::Points => "points",
        }
    }

    /// Where the stage begins and ends within a match that finds no spectrum cached, as fractions.
    fn span(self) -> [f64; 2] {
        match self {
            Stage::Spectrum => [0.0, 0.3],
            Stage::Alignment => [0.3, 0.7],
            Stage::Regions => [0.7, 0.8],
            Stage::Descriptors => [0.8, 0.85],
            Stage::Map => [0.85, 0.9],
            Stage::Points => [0.9, 1.0],
        }
    }
}

/// Times the stages as they run and tells the watcher of them.
pub(super) struct Stages<'a> {
    surroundings: &'a Surroundings<'a>,
    begun: f64,
    milliseconds: RefCell<BTreeMap<String, f64>>,
    /// The largest fraction reported, as bits: of numbers that are not negative, the larger has the larger bits.
    reached: AtomicU64,
    /// Of an answer on the way: the stage that it is a part of.
    within: Option<Stage>,
}

impl<'a> Stages<'a> {
    pub fn begin(surroundings: &'a Surroundings<'a>) -> Stages<'a> {
        Stages {
            surroundings,
            begun: (surroundings.clock)(),
            milliseconds: RefCell::default(),
            reached: AtomicU64::new(0),
            within: None,
        }
    }

    /// The stages of an answer on the way, for which the progress of `stage` stands still.
    pub fn within(&self, stage: Stage) -> Stages<'a> {
        Stages {
            surroundings: self.surroundings,
            begun: self.begun,
            milliseconds: self.milliseconds.clone(),
            reached: AtomicU64::new(self.reached.load(Ordering::Relaxed)),
            within: Some(stage),
        }
    }

    /// Runs a stage, which reports its own progress to the watch it is handed.
    pub fn run<T, E: From<Cancelled>>(
        &self,
        stage: Stage,
        work: impl FnOnce(&dyn Watch) -> Result<T, E>,
    ) -> Result<T, E> {
        let watch = StageWatch {
            watcher: self.surroundings.watcher,
            stage: self.within.unwrap_or(stage),
            standing: self.within.is_some(),
            reached: &self.reached,
        };
        watch.proceed(0.0)?;
        let begun = (self.surroundings.clock)();
        let result = work(&watch)?;
        let taken = (self.surroundings.clock)() - begun;
        // The alignment has two parts: components are joined long before the sketch is laid on them.
        *self.milliseconds.borrow_mut().entry(stage.name().to_owned()).or_insert(0.0) += taken;
        Ok(result)
    }

    /// Milliseconds by stage, and in `total`.
    pub fn finish(self) -> BTreeMap<String, f64> {
        let mut milliseconds = self.milliseconds.into_inner();
        milliseconds.insert(TOTAL.to_owned(), (self.surroundings.clock)() - self.begun);
        milliseconds
    }
}

/// The watcher of a match as the watch of one stage.
struct StageWatch<'a> {
    watcher: &'a dyn Watcher,
    stage: Stage,
    /// Whether its progress stands still.
    standing: bool,
    reached: &'a AtomicU64,
}

impl Watch for StageWatch<'_> {
    fn proceed(&self, fraction: f64) -> Result<(), Cancelled> {
        let [begin, end] = self.stage.span();
        let fraction = if self.standing { begin } else { begin + (end - begin) * fraction.clamp(0.0, 1.0) };
        // A stage of several parts counts each from 0; what was reached stays.
        let reached = self.reached.fetch_max(fraction.to_bits(), Ordering::Relaxed);
        self.watcher.proceed(self.stage, fraction.max(f64::from_bits(reached)))
    }
}

#[cfg(test)]
mod tests {
    use std::cell::Cell;

    use super::*;
    use crate::pipeline::Computing;

    struct Patient;

    impl Watcher for Patient {
        fn proceed(&self, _stage: Stage, _fraction: f64) -> Result<(), Cancelled> {
            Ok(())
        }
    }

    #[test]
    fn a_stage_takes_as_long_as_its_parts() {
        let now = Cell::new(0.0);
        let clock = || now.get();
        let surroundings = Surroundings {
            spectra: &Computing,
            preparations: &Computing,
            watcher: &Patient,
            clock: &clock,
            preview: None,
        };
        let stages = Stages::begin(&surroundings);
        for (stage, taken) in [(Stage::Alignment, 5.0), (Stage::Spectrum, 2.0), (Stage::Alignment, 7.0)] {
            let work = |_: &dyn Watch| {
                now.set(now.get() + taken);
                Ok::<_, Cancelled>(())
            };
            stages.run(stage, work).unwrap();
        }
        let wanted = [("alignment", 12.0), ("spectrum", 2.0), (TOTAL, 14.0)];
        assert_eq!(stages.finish(), wanted.map(|(stage, taken)| (stage.to_owned(), taken)).into());
    }
}
