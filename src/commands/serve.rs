//! `sketchmatch serve`: the service, with its workers in the process.

use std::error::Error;

use anyhow::Context;
use futures::future::{Either, ready};
use tokio::net::TcpListener;
use tokio::task::JoinHandle;
use tokio_util::sync::CancellationToken;

use super::signals::stop_on_signal;
use crate::config::{Listen, ServeOptions};
use crate::telemetry::{self, Log};
use sketchmatch::http::{self, App};
use sketchmatch::intake::svg_reader;
use sketchmatch::store::Store;
use sketchmatch::worker;

/// Serves until SIGTERM or SIGINT, then lets requests and jobs come to an end.
///
/// # Errors
/// What kept the server from starting, or broke it off.
pub async fn run(options: &ServeOptions, log: &Log) -> anyhow::Result<()> {
    telemetry::log_panics();
    let shutdown = CancellationToken::new();
    stop_on_signal(shutdown.clone())?;
    tracing::info!(
        version = env!("CARGO_PKG_VERSION"),
        store = ?options.store.config(),
        http = ?options.http(),
        worker = ?options.worker.config(),
        "starting"
    );
    let measures = telemetry::measures()?;
    tokio::spawn(telemetry::keep_small(measures.clone()));
    tokio::spawn(telemetry::report_losses(log.losses()));
    let store = options.worker.cached(Store::open(&options.store.to_open()).await?);
    let admission = options.admission(&store).await?;
    let listener = listener(&options.listen).await?;
    tracing::info!(address = %listener.local_addr()?, "listening");
    let working = tokio::spawn(worker::run(store.clone(), options.worker.config(), shutdown.clone()));
    let tenant_limits = options.tenants.limits(&admission);
    let svg_reader = Some(svg_reader::this_program()?);
    let config = http::Config { admission, tenant_limits, svg_reader, ..options.http() };
    let app = App::new(store.clone(), config, measures, shutdown);
    let measuring = match &options.metrics_listen {
        Some(address) => {
            let listener = self::listener(address).await?;
            tracing::info!(measures = %listener.local_addr()?, "listening");
            Either::Left(http::serve_measures(listener, app.clone()))
        }
        None => Either::Right(ready(Ok(()))),
    };
    let serving = http::serve(listener, app);
    let served = async { tokio::try_join!(serving, measuring).context("serving") };
    tokio::try_join!(served, ended(working))?;
    store.close().await.context("closing the database")?;
    tracing::info!("stopped");
    Ok(())
}

pub(super) async fn listener(address: &Listen) -> anyhow::Result<TcpListener> {
    TcpListener::bind(address.addresses()).await.with_context(|| format!("listening on {address}"))
}

/// How the workers ended, a panic among the errors.
async fn ended<E: Error + Send + Sync + 'static>(working: JoinHandle<Result<(), E>>) -> anyhow::Result<()> {
    working.await.context("the workers broke off")?.context("starting the workers")
}

#[cfg(test)]
mod tests {
    use std::future::pending;
    use std::io;

    use super::*;

    #[tokio::test]
    async fn workers_that_break_off_end_the_server() {
        let panicking: JoinHandle<io::Result<()>> = tokio::spawn(async { panic!("as told") });
        let failing = tokio::spawn(async { Err(io::Error::other("no threads")) });
        for (working, reason) in [(panicking, "broke off"), (failing, "starting")] {
            let serving = pending::<anyhow::Result<()>>();
            let error = tokio::try_join!(serving, ended(working)).unwrap_err();
            assert!(error.to_string().contains(reason), "{error:#}");
        }
    }
}
