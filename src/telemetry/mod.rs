//! Logs and measures of the process.
//!
//! The log goes to standard error by a thread of its own. Where nobody takes it (a reader that stalls or has gone, a full
//! device) lines are dropped and counted, and the work goes on.

#[cfg(feature = "otel")]
mod spans;

use std::env;
use std::io::{self, IsTerminal, Write, stderr};
use std::panic;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use anyhow::Context;
use metrics_exporter_prometheus::{Matcher, PrometheusBuilder, PrometheusHandle};
use tokio::time::sleep;
use tracing_appender::non_blocking::{ErrorCounter, NonBlockingBuilder, WorkerGuard};
use tracing_subscriber::filter::Targets;
use tracing_subscriber::layer::SubscriberExt;
use tracing_subscriber::util::SubscriberInitExt;
use tracing_subscriber::{Layer, fmt, registry};

/// Bounds of the histograms in seconds: from a look-up to a long match.
const SECONDS: [f64; 14] = [0.001, 0.003, 0.01, 0.03, 0.1, 0.3, 1.0, 3.0, 10.0, 30.0, 100.0, 300.0, 1000.0, 3000.0];

/// Lines of the log that wait to be written: some megabytes at most, more than a pipe holds.
const WAITING_LINES: usize = 4096;

/// How often lines that were lost are reported.
const REPORT: Duration = Duration::from_secs(5);

/// How a log line is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum LogFormat {
    Text,
    Json,
}

/// The log of the process. Dropped, it writes what waits, for a second at most.
pub struct Log {
    losses: Losses,
    #[cfg(feature = "otel")]
    _spans: Option<spans::Exporter>,
    _writer: WorkerGuard,
}

impl Log {
    pub fn losses(&self) -> Losses {
        self.losses.clone()
    }
}

/// How many lines of the log were lost.
#[derive(Clone)]
pub struct Losses {
    /// Because too many waited.
    dropped: ErrorCounter,
    /// Because standard error did not take them.
    unwritten: Arc<AtomicU64>,
}

impl Losses {
    fn total(&self) -> u64 {
        self.dropped.dropped_lines() as u64 + self.unwritten.load(Ordering::Relaxed)
    }
}

/// Sends the log to standard error: what `filter` lets through, such as `info` or `sketchmatch=debug,warn`. It is coloured
/// on a terminal, unless the variable `NO_COLOR` is set.
///
/// # Errors
/// A filter that cannot be read.
pub fn log(filter: &str, format: LogFormat) -> anyhow::Result<Log> {
    let filter: Targets = filter.parse().context("the log filter cannot be read")?;
    let unwritten = Arc::new(AtomicU64::new(0));
    let builder = NonBlockingBuilder::default().buffered_lines_limit(WAITING_LINES).thread_name("log");
    let (writer, guard) = builder.finish(Tolerant { unwritten: unwritten.clone() });
    let losses = Losses { dropped: writer.error_counter(), unwritten };
    let lines = fmt::layer().with_writer(writer).with_ansi(stderr().is_terminal() && env::var_os("NO_COLOR").is_none());
    let lines = match format {
        LogFormat::Text => lines.boxed(),
        LogFormat::Json => lines.json().flatten_event(true).boxed(),
    };
    let subscriber = registry().with(lines.with_filter(filter));
    #[cfg(feature = "otel")]
    let (subscriber, _spans) = {
        let (layer, exporter) = spans::layer()?.unzip();
        (subscriber.with(layer), exporter)
    };
    subscriber.try_init().context("the log cannot be opened")?;
    Ok(Log {
        losses,
        #[cfg(feature = "otel")]
        _spans,
        _writer: guard,
    })
}

/// Standard error, which never fails: lines that it does not take are counted.
struct Tolerant {
    unwritten: Arc<AtomicU64>,
}

impl Write for Tolerant {
    fn write(&mut self, line: &[u8]) -> io::Result<usize> {
        if stderr().write_all(line).is_err() {
            self.unwritten.fetch_add(1, Ordering::Relaxed);
        }
        Ok(line.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

const LOST: &str = "sketchmatch_log_lines_lost_total";

/// Counts the lines that are lost, and says so in the log as soon as that is possible again.
pub async fn report_losses(losses: Losses) {
    metrics::describe_counter!(LOST, "Lines of the log that standard error did not take in time.");
    let counter = metrics::counter!(LOST);
    let mut reported = 0;
    loop {
        let total = losses.total();
        counter.absolute(total);
        if total > reported {
            tracing::warn!(lines = total - reported, "lines of the log were lost");
            reported = total;
        }
        sleep(REPORT).await;
    }
}

/// Sends the words of a panic to the log: written straight to standard error, they could hold up what goes on.
pub fn log_panics() {
    panic::set_hook(Box::new(|panic| {
        tracing::error!(%panic, "a thread panicked");
    }));
}

/// How often measures are put together.
const UPKEEP: Duration = Duration::from_secs(5);

/// Puts the single values of histograms together again and again: until then each is kept, also where nobody reads the measures.
pub async fn keep_small(measures: PrometheusHandle) {
    loop {
        sleep(UPKEEP).await;
        measures.run_upkeep();
    }
}

/// Collects every measure of the process from now on; the handle writes them down.
///
/// # Errors
/// When there is a collector already.
pub fn measures() -> anyhow::Result<PrometheusHandle> {
    let builder = PrometheusBuilder::new().set_buckets_for_metric(Matcher::Suffix("_seconds".to_owned()), &SECONDS)?;
    Ok(builder.install_recorder()?)
}
