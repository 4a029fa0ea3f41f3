//! `sketchmatch health`: asks a running server whether it takes requests, for those who watch over it.

use std::time::Duration;

use anyhow::{Context, ensure};
use axum::body::Body;
use axum::http::{Request, StatusCode, Uri, header};
use clap::Args;
use hyper::client::conn::http1::handshake;
use hyper_util::rt::TokioIo;
use tokio::net::TcpStream;
use tokio::time::timeout;

/// How long an answer may take: below what watchers usually allow.
const PATIENCE: Duration = Duration::from_secs(4);

#[derive(Debug, Args)]
pub struct HealthOptions {
    /// Where the server is.
    #[arg(long, env = "SKETCHMATCH_URL", default_value = "http://127.0.0.1:8080")]
    url: Uri,
}

/// Succeeds where the server takes requests.
///
/// # Errors
/// A server that cannot be reached, does not answer in time, or takes none.
#[tokio::main(flavor = "current_thread")]
pub async fn run(options: &HealthOptions) -> anyhow::Result<()> {
    let url = &options.url;
    let answer = timeout(PATIENCE, readiness(url)).await;
    let status = answer.with_context(|| format!("{url} does not answer"))?.with_context(|| format!("asking {url}"))?;
    ensure!(status.is_success(), "{url} takes no requests: {status}");
    Ok(())
}

/// What the server at `url` answers when asked whether it takes requests.
async fn readiness(url: &Uri) -> anyhow::Result<StatusCode> {
    ensure!(url.scheme_str() == Some("http"), "an address that begins with http:// is wanted");
    let authority = url.authority().context("there is no server in it")?;
    let stream = TcpStream::connect((authority.host(), authority.port_u16().unwrap_or(80))).await?;
    let (mut sender, connection) = handshake(TokioIo::new(stream)).await?;
    tokio::spawn(connection);
    let request = Request::get("/readyz").header(header::HOST, authority.as_str()).body(Body::empty())?;
    Ok(sender.send_request(request).await?.status())
}
