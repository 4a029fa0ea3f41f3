//! What is measured, and the one table it is printed in.

use serde_json::Value;

/// Runs of which the median is told.
const RUNS: usize = 5;

/// Milliseconds of several runs, ascending.
pub struct Sample(Vec<f64>);

impl Sample {
    pub fn new(mut runs: Vec<f64>) -> Sample {
        runs.sort_by(f64::total_cmp);
        Sample(runs)
    }

    /// The same without what else was done in every run.
    pub fn less(self, others: f64) -> Sample {
        Sample(self.0.into_iter().map(|run| run - others).collect())
    }

    pub fn median(&self) -> f64 {
        self.quantile(0.5)
    }

    pub fn quantile(&self, q: f64) -> f64 {
        self.0[((self.0.len() - 1) as f64 * q).round() as usize]
    }
}

/// CPU milliseconds of this process, user and system.
pub fn cpu() -> f64 {
    let time = rustix::time::clock_gettime(rustix::time::ClockId::ProcessCPUTime);
    time.tv_sec as f64 * 1e3 + time.tv_nsec as f64 * 1e-6
}

/// CPU milliseconds of a computation, several times over. What is short is repeated within a run, the clock being no finer than
/// a microsecond.
pub fn timed<T>(mut compute: impl FnMut() -> T) -> Sample {
    let once = |compute: &mut dyn FnMut() -> T| {
        let begun = cpu();
        std::hint::black_box(compute());
        cpu() - begun
    };
    let repeats = (20.0 / once(&mut compute).max(0.1)).ceil().max(1.0) as usize;
    Sample::new((0..RUNS).map(|_| (0..repeats).map(|_| once(&mut compute)).sum::<f64>() / repeats as f64).collect())
}

/// What the issue asks of a row.
#[derive(Clone, Copy)]
pub enum Reach {
    /// At most so many of the row's unit.
    Most(f64),
    /// At least so many times as fast as the peer.
    Times(f64),
    None,
}

/// The rows, printed as they come in as Markdown.
pub struct Table {
    peer: Value,
}

impl Table {
    /// A table with the peer's figures beside ours where they were measured.
    pub fn begin(peer: Value) -> Table {
        println!("| row | ours (median) | min – max | pyFM | ratio | reach | met |");
        println!("|---|---:|---:|---:|---:|---:|:---:|");
        Table { peer }
    }

    /// A row in CPU milliseconds; `peer` is the name of the peer's figure.
    pub fn time(&self, name: &str, sample: &Sample, peer: Option<&str>, reach: Reach) {
        let ours = sample.median();
        let theirs = peer.and_then(|peer| self.peer[peer]["median"].as_f64());
        let (told, met) = match (reach, theirs) {
            (Reach::Most(most), _) => (format!("≤ {most} ms"), Some(ours <= most)),
            (Reach::Times(times), theirs) => (format!("≥ {times}×"), theirs.map(|t| t / ours >= times)),
            (Reach::None, _) => (String::new(), None),
        };
        let range = format!("{:.2} – {:.2}", sample.quantile(0.0), sample.quantile(1.0));
        let ratio = theirs.map_or_else(String::new, |t| format!("{:.1}×", t / ours));
        let theirs = theirs.map_or_else(String::new, |t| format!("{t:.2}"));
        println!("| {name} | {ours:.2} ms | {range} | {theirs} | {ratio} | {told} | {} |", mark(met));
    }

    /// A row that is no time on the processor.
    pub fn figure(&self, name: &str, figure: f64, unit: &str, most: Option<f64>) {
        let told = most.map_or_else(String::new, |most| format!("≤ {most} {unit}"));
        println!("| {name} | {figure:.2} {unit} | | | | {told} | {} |", mark(most.map(|most| figure <= most)));
    }
}

fn mark(met: Option<bool>) -> &'static str {
    met.map_or("", |met| if met { "yes" } else { "no" })
}
