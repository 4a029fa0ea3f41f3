//! `sketchmatch work`: a node that computes what servers with the same store are asked for, and answers those who watch it.

use anyhow::Context;
use clap::Args;
use futures::future::{Either, ready};
use tokio_util::sync::CancellationToken;

use super::serve::listener;
use super::signals::stop_on_signal;
use crate::config::{Listen, StoreOptions, WorkerOptions};
use crate::telemetry::{self, Log};
use sketchmatch::http::{self, App};
use sketchmatch::store::Store;
use sketchmatch::worker;

#[derive(Debug, Args)]
pub struct WorkOptions {
    #[command(flatten)]
    store: StoreOptions,
    #[command(flatten)]
    worker: WorkerOptions,
    /// Address or name, and port, to answer /healthz, /readyz and /metrics on, to whoever reaches it [default: nobody is
    /// answered].
    #[arg(long, env = "SKETCHMATCH_METRICS_LISTEN", value_parser = Listen::resolve)]
    metrics_listen: Option<Listen>,
}

/// Works until SIGTERM or SIGINT, then lets running jobs come to an end or gives them back.
///
/// # Errors
/// What kept the node from starting, or broke it off.
pub async fn run(options: &WorkOptions, log: &Log) -> anyhow::Result<()> {
    telemetry::log_panics();
    let shutdown = CancellationToken::new();
    stop_on_signal(shutdown.clone())?;
    let (store, config) = (options.store.to_open(), options.worker.config());
    tracing::info!(version = env!("CARGO_PKG_VERSION"), ?store, worker = ?config, "starting");
    let measures = telemetry::measures()?;
    tokio::spawn(telemetry::keep_small(measures.clone()));
    tokio::spawn(telemetry::report_losses(log.losses()));
    let store = options.worker.cached(Store::open(&store).await?);
    let watched = match &options.metrics_listen {
        Some(address) => {
            let listener = listener(address).await?;
            tracing::info!(measures = %listener.local_addr()?, "listening");
            let app = App::new(store.clone(), http::Config::default(), measures, shutdown.clone());
            Either::Left(http::serve_measures(listener, app))
        }
        None => Either::Right(ready(Ok(()))),
    };
    tracing::info!("working");
    let working = async { worker::run(store.clone(), config, shutdown).await.context("starting the workers") };
    tokio::try_join!(working, async { watched.await.context("answering those who watch") })?;
    store.close().await.context("closing the database")?;
    tracing::info!("stopped");
    Ok(())
}
