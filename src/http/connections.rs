//! Connections: as many at a time as there is room for, none of which can be held by doing nothing.

use std::future::poll_fn;
use std::io;
use std::pin::pin;
use std::sync::Arc;
use std::time::Duration;

use axum::Router;
use hyper::server::conn::http1;
use hyper::service::service_fn;
use hyper_util::rt::{TokioIo, TokioTimer};
use rustix::process::{Resource, getrlimit};
use tokio::io::{AsyncRead, AsyncReadExt, AsyncWrite, AsyncWriteExt};
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::{OwnedSemaphorePermit, Semaphore, watch};
use tokio::time::{sleep, timeout};
use tokio_io_timeout::TimeoutStream;
use tokio_util::sync::CancellationToken;
use tokio_util::task::TaskTracker;

use super::unread;
use crate::jobs::GRACE;

/// Open files that connections leave to the database, the blobs, the workers and the log.
const KEPT_DESCRIPTORS: usize = 128;

/// How long to wait after a connection could not be taken, for want of descriptors or memory.
const BREATHER: Duration = Duration::from_millis(100);

/// How long a client that still sends is listened to after the last answer, so that it comes to read it; and how long
/// one that is silent.
const LINGERING: Duration = Duration::from_secs(30);
const LINGERING_IN_SILENCE: Duration = Duration::from_secs(2);

/// How connections are kept.
#[derive(Clone, Copy, Debug)]
pub struct ConnectionLimits {
    /// Connections at one time; fewer where the process may not have so many files open.
    pub connections: usize,
    /// How long a client may take over the headers of a request, the first and every further one, and how long it may
    /// leave an answer unread.
    pub idle: Duration,
}

/// Answers on `listener` with `service` until `shutdown`, then lets open requests finish within a grace period.
///
/// Where all connections are taken, those without a request are closed once another client comes; who comes after it waits
/// in the system's queue.
pub async fn serve(listener: TcpListener, service: Router, limits: ConnectionLimits, shutdown: CancellationToken) {
    let slots = Arc::new(Semaphore::new(limits.connections.min(most_connections())));
    let (open, crowded, over) = (TaskTracker::new(), watch::Sender::new(()), CancellationToken::new());
    while let Some(accepted) = shutdown.run_until_cancelled(listener.accept()).await {
        let stream = match accepted {
            Ok((stream, _)) => stream,
            Err(error) => {
                tracing::warn!(%error, "a connection could not be taken");
                sleep(BREATHER).await;
                continue;
            }
        };
        let Some(Ok(slot)) = shutdown.run_until_cancelled(free(&slots, &crowded)).await else { break };
        let (service, shutdown, mut crowded) = (service.clone(), shutdown.clone(), crowded.subscribe());
        let told_to_leave = async move {
            tokio::select! {
                () = shutdown.cancelled() => {}
                _ = crowded.changed() => {}
            }
        };
        let over = over.clone();
        open.spawn(async move {
            over.run_until_cancelled(connection(stream, service, limits.idle, told_to_leave)).await;
            drop(slot);
        });
    }
    drop(listener);
    open.close();
    if timeout(GRACE, open.wait()).await.is_err() {
        over.cancel();
        open.wait().await;
    }
}

/// The connections for which there are descriptors; at least one.
fn most_connections() -> usize {
    let descriptors = getrlimit(Resource::Nofile).current.and_then(|limit| usize::try_from(limit).ok());
    let connections = descriptors.map_or(usize::MAX, |descriptors| descriptors.saturating_sub(KEPT_DESCRIPTORS));
    connections.clamp(1, Semaphore::MAX_PERMITS)
}

/// The right to one connection more. Where there is none, connections without a request are told to leave.
async fn free(
    slots: &Arc<Semaphore>,
    crowded: &watch::Sender<()>,
) -> Result<OwnedSemaphorePermit, tokio::sync::AcquireError> {
    if let Ok(slot) = slots.clone().try_acquire_owned() {
        return Ok(slot);
    }
    crowded.send_replace(());
    slots.clone().acquire_owned().await
}

/// Answers the requests of one connection, to its end or, once `told_to_leave`, to the end of the request under way.
async fn connection(stream: TcpStream, service: Router, idle: Duration, told_to_leave: impl Future<Output = ()>) {
    let mut stream = TimeoutStream::new(stream);
    stream.set_write_timeout(Some(idle));
    let answer = service_fn(move |request| Box::pin(unread::answer(service.clone(), request)));
    let mut connection = http1::Builder::new()
        .timer(TokioTimer::new())
        .header_read_timeout(idle)
        // Who has sent all there is to send may close that half and still wait for the answer.
        .half_close(true)
        .serve_connection(TokioIo::new(Box::pin(stream)), answer);
    let told_to_leave = pin!(told_to_leave);
    let ended = tokio::select! {
        ended = poll_fn(|context| connection.poll_without_shutdown(context)) => ended,
        () = told_to_leave => {
            std::pin::Pin::new(&mut connection).graceful_shutdown();
            poll_fn(|context| connection.poll_without_shutdown(context)).await
        }
    };
    if let Err(error) = ended {
        tracing::debug!(%error, "a connection broke off");
    }
    // Fails where the client has left before, which is as well.
    let _ = linger(connection.into_parts().io.into_inner()).await;
}

/// Ends a connection: says that nothing more comes, and takes for a while what the client still sends. A connection with
/// unread bytes would be reset, and the client lose an answer it has not read yet, such as that its body is too large.
async fn linger(mut stream: impl AsyncRead + AsyncWrite + Unpin) -> io::Result<()> {
    stream.shutdown().await?;
    let mut unread = [0; 8192];
    let silent = async {
        while let Ok(received) = timeout(LINGERING_IN_SILENCE, stream.read(&mut unread)).await {
            if received? == 0 {
                break;
            }
        }
        Ok(())
    };
    timeout(LINGERING, silent).await.unwrap_or(Ok(()))
}
