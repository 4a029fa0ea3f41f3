//! How long database and blobs take to answer.

use std::future::Future;
use std::time::Instant;

use metrics::{describe_histogram, histogram};
use tracing::Instrument;

const SECONDS: &str = "sketchmatch_store_seconds";

/// What is measured, by the names it is measured under.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Operation {
    /// A job is put into the queue.
    Submit,
    /// A worker looks for a job.
    Claim,
    /// A worker reports progress.
    Beat,
    /// A job changes its state.
    Change,
    ReadBlob,
    WriteBlob,
}

impl Operation {
    const ALL: [Operation; 6] = [
        Operation::Submit,
        Operation::Claim,
        Operation::Beat,
        Operation::Change,
        Operation::ReadBlob,
        Operation::WriteBlob,
    ];

    const fn name(self) -> &'static str {
        match self {
            Operation::Submit => "submit",
            Operation::Claim => "claim",
            Operation::Beat => "beat",
            Operation::Change => "change",
            Operation::ReadBlob => "read_blob",
            Operation::WriteBlob => "write_blob",
        }
    }
}

/// Says what is measured here and sets it to nothing, so that what has not happened yet is 0 and not unknown.
pub fn describe() {
    describe_histogram!(SECONDS, "Seconds that the database or the place of the blobs took, by operation.");
    for operation in Operation::ALL {
        let _ = histogram!(SECONDS, "operation" => operation.name());
    }
}

/// What `work` comes to; how long it took is measured, and part of the trace.
pub(super) async fn timed<T>(operation: Operation, work: impl Future<Output = T>) -> T {
    let begun = Instant::now();
    let done = work.instrument(tracing::debug_span!("store", operation = operation.name())).await;
    histogram!(SECONDS, "operation" => operation.name()).record(begun.elapsed().as_secs_f64());
    done
}
