//! How long a thread of a job computes without asking whether to go on: what a cancelled job keeps it for. In time on the
//! processor of that thread, so that it does not matter what else the machine does.

use std::backtrace::Backtrace;
use std::cell::Cell;
use std::collections::BTreeMap;
use std::sync::Mutex;

use rustix::time::{ClockId, clock_gettime};
use sketchmatch::mesh::TriangleMesh;
use sketchmatch::numerics::Cancelled;
use sketchmatch::pipeline::{self, Computing, Settings, Stage, Surroundings, Watcher};
use sketchmatch::sketch::Sketch;

use crate::shapes;
use crate::table::Table;

/// What a stretch may take, in milliseconds.
const MOST: f64 = 50.0;

thread_local! {
    /// Where this thread's clock stood when it asked last; a thread that asks for the first time has run since it began.
    static ASKED: Cell<f64> = const { Cell::new(0.0) };
}

/// Never says stop, and keeps the longest stretch before a question of each stage, with where it was asked.
#[derive(Default)]
struct Longest(Mutex<BTreeMap<&'static str, (f64, String)>>);

impl Watcher for Longest {
    fn proceed(&self, stage: Stage, _fraction: f64) -> Result<(), Cancelled> {
        let stretch = thread_milliseconds() - ASKED.get();
        let mut longest = self.0.lock().expect("nobody panics within");
        let kept = longest.entry(stage.name()).or_default();
        if stretch > kept.0 {
            *kept = (stretch, Backtrace::capture().to_string());
        }
        drop(longest);
        ASKED.set(thread_milliseconds());
        Ok(())
    }
}

/// Milliseconds this thread was on a processor.
fn thread_milliseconds() -> f64 {
    let time = clock_gettime(ClockId::ThreadCPUTime);
    time.tv_sec as f64 * 1e3 + time.tv_nsec as f64 * 1e-6
}

/// The longest stretch in each stage of a match with a new mesh of 100K vertices; where it ended with `RUST_BACKTRACE=1`.
pub fn rows(table: &Table) {
    let (mesh, sketch) = (shapes::body(shapes::HUGE), shapes::drawn());
    for preset in ["automatic", "thesis"] {
        for (stage, (stretch, place)) in of_match(&mesh, &sketch, preset) {
            let name = format!("longest stretch before a question, {preset} preset, 100K, {stage}");
            table.figure(&name, stretch, "ms", Some(MOST));
            if stretch > MOST {
                eprintln!("{name}:\n{place}");
            }
        }
    }
}

fn of_match(mesh: &TriangleMesh, sketch: &Sketch, preset: &str) -> BTreeMap<&'static str, (f64, String)> {
    let request = serde_json::json!({"mesh": "m", "sketch": "s", "preset": preset});
    let request = serde_json::from_value(request).expect("a request");
    let settings = Settings::resolve(&request).expect("a preset is in range");
    let (file, longest) = (mesh.clone().into(), Longest::default());
    let surroundings = Surroundings {
        spectra: &Computing,
        preparations: &Computing,
        watcher: &longest,
        clock: &|| 0.0,
        preview: None,
    };
    ASKED.set(thread_milliseconds());
    pipeline::run(sketch, &file, &settings, &surroundings).expect("the body can be matched");
    longest.0.into_inner().expect("nobody panics within")
}
