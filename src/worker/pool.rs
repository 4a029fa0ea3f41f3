use rayon::{ThreadPool, ThreadPoolBuildError, ThreadPoolBuilder};

/// What the threads yield to those that answer requests, which wake up for moments only: a third of the share of a thread
/// that yields nothing, so that other programs on the machine do not starve them.
#[cfg(target_os = "linux")]
const NICENESS: i32 = 5;

/// As many threads as may compute at once, of low priority.
pub(super) fn of(workers: usize) -> Result<ThreadPool, ThreadPoolBuildError> {
    ThreadPoolBuilder::new()
        .num_threads(workers)
        .thread_name(|index| format!("compute-{index}"))
        .start_handler(|_| step_back())
        .build()
}

/// Lowers the priority of the calling thread; on Linux a thread has one of its own, elsewhere it keeps the process's.
fn step_back() {
    #[cfg(target_os = "linux")]
    if let Err(error) = rustix::process::setpriority_process(Some(rustix::thread::gettid()), NICENESS) {
        tracing::warn!(%error, "computing threads keep their priority");
    }
}
