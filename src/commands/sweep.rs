//! `sketchmatch sweep`: sets aside what nodes that died left among the blobs, without waiting for a node to do it.

use std::time::Duration;

use clap::Args;

use super::printed;
use crate::config::StoreOptions;
use sketchmatch::store::Store;

#[derive(Debug, Args)]
pub struct SweepOptions {
    #[command(flatten)]
    store: StoreOptions,
    /// Leave blobs alone that were written more lately: somebody may be about to name them. 0s where no node runs.
    #[arg(long, env = "SKETCHMATCH_OLDER_THAN", default_value = "1h", value_parser = humantime::parse_duration)]
    older_than: Duration,
}

/// Sweeps, and prints how many blobs were set aside.
///
/// # Errors
/// A store that cannot be opened or read.
#[tokio::main(flavor = "current_thread")]
pub async fn run(options: &SweepOptions) -> anyhow::Result<()> {
    let store = Store::open(&options.store.to_open()).await?;
    let swept = store.sweep(options.older_than).await?;
    store.close().await?;
    printed(&format!("{swept} blobs that nothing names were set aside"))
}
