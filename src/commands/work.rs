//! `sketchmatch work`: a node that computes what servers with the same store are asked for, and answers nobody.

use anyhow::Context;
use clap::Args;
use rustix::fs::Mode;
use rustix::process::umask;
use tokio_util::sync::CancellationToken;

use super::signals::stop_on_signal;
use crate::config::{StoreOptions, WorkerOptions};
use crate::telemetry;
use sketchmatch::store::Store;
use sketchmatch::worker;

#[derive(Debug, Args)]
pub struct WorkOptions {
    #[command(flatten)]
    store: StoreOptions,
    #[command(flatten)]
    worker: WorkerOptions,
}

/// Works until SIGTERM or SIGINT, then lets running jobs come to an end or gives them back.
///
/// # Errors
/// What kept the node from starting, or broke it off.
#[tokio::main]
pub async fn run(options: &WorkOptions) -> anyhow::Result<()> {
    telemetry::log_panics();
    let shutdown = CancellationToken::new();
    stop_on_signal(shutdown.clone())?;
    let (store, config) = (options.store.config(), options.worker.config());
    tracing::info!(version = env!("CARGO_PKG_VERSION"), ?store, worker = ?config, "starting");
    // What is kept in files is nobody's but the service's.
    umask(Mode::RWXG | Mode::RWXO);
    let store = options.worker.cached(Store::open(&store).await?);
    tracing::info!("working");
    worker::run(store.clone(), config, shutdown).await.context("starting the workers")?;
    store.close().await.context("closing the database")?;
    tracing::info!("stopped");
    Ok(())
}
