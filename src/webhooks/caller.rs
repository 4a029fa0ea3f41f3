use std::error::Error;
use std::net::{IpAddr, SocketAddr};
use std::sync::Arc;
use std::time::{Duration, SystemTime};

use reqwest::dns::{Addrs, Name, Resolve, Resolving};
use reqwest::header::CONTENT_TYPE;
use reqwest::{Client, StatusCode, redirect};
use tokio::net::lookup_host;

use super::address::is_public;
use super::{Hosts, Message};
use crate::tls;

/// How long a connection may take to be made, and the whole call with the head of its answer.
const CONNECTING: Duration = Duration::from_secs(5);
const LONGEST: Duration = Duration::from_secs(10);

/// Calls receivers: allowed hosts at public addresses only, none that an answer leads to, and without reading what they say
/// beyond its head.
pub struct Caller {
    client: Client,
    hosts: Hosts,
}

/// Why a receiver was not told.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Refused {
    pub reason: String,
    /// Whether it need not be tried again.
    pub for_good: bool,
}

impl Caller {
    /// A caller of these hosts.
    ///
    /// # Errors
    /// Where the system's certificates cannot be used.
    pub fn new(hosts: Hosts) -> Result<Caller, reqwest::Error> {
        Caller::within(hosts, is_public)
    }

    /// A caller that goes to addresses within `reach` alone: what a name stands for is looked at when it is called, and the
    /// connection goes to what was looked at.
    fn within(hosts: Hosts, reach: fn(IpAddr) -> bool) -> Result<Caller, reqwest::Error> {
        tls::provide();
        let client = Client::builder()
            .redirect(redirect::Policy::none())
            .no_proxy()
            .referer(false)
            .user_agent(concat!("sketchmatch/", env!("CARGO_PKG_VERSION")))
            .connect_timeout(CONNECTING)
            .timeout(LONGEST)
            .pool_max_idle_per_host(0)
            .dns_resolver(Arc::new(Resolver { reach }))
            .build()?;
        Ok(Caller { client, hosts })
    }

    /// A caller of receivers that tests have on this machine, also without TLS.
    #[cfg(test)]
    pub fn of_this_machine(hosts: Vec<super::Host>) -> Caller {
        Caller::within(Hosts::from(hosts).without_tls(), |address| address.is_loopback()).unwrap()
    }

    /// Sends a message to a receiver; ok once that has taken it.
    ///
    /// # Errors
    /// Why it was not taken, in words that do not have the address.
    pub async fn call(&self, address: &str, message: &Message, secret: &[u8; 32]) -> Result<(), Refused> {
        let again = |reason: String| Refused { reason, for_good: false };
        // What was allowed when the job was asked for may not be any more.
        let url = self.hosts.address(address).map_err(|reason| Refused { reason, for_good: true })?;
        let mut request = self.client.post(url).header(CONTENT_TYPE, "application/json").body(message.body.clone());
        for (name, value) in message.headers(secret, SystemTime::now()) {
            request = request.header(name, value);
        }
        let answer = request.send().await.map_err(|error| again(causes(&error.without_url())))?;
        let status = answer.status();
        if status.is_success() {
            return Ok(());
        }
        Err(Refused { reason: format!("it answered {status}"), for_good: status == StatusCode::GONE })
    }
}

/// An error with what it comes from.
fn causes(error: &dyn Error) -> String {
    let mut text = error.to_string();
    let mut cause = error.source();
    while let Some(error) = cause {
        text = format!("{text}: {error}");
        cause = error.source();
    }
    text
}

/// The addresses of a name that are within reach.
struct Resolver {
    reach: fn(IpAddr) -> bool,
}

impl Resolve for Resolver {
    fn resolve(&self, name: Name) -> Resolving {
        let reach = self.reach;
        Box::pin(async move {
            let found: Vec<SocketAddr> = lookup_host((name.as_str(), 0)).await?.filter(|at| reach(at.ip())).collect();
            if found.is_empty() {
                return Err("none of the host's addresses is one that may be called".into());
            }
            Ok(Box::new(found.into_iter()) as Addrs)
        })
    }
}

#[cfg(test)]
mod tests {
    use axum::Router;
    use axum::http::HeaderMap;
    use axum::response::Redirect;
    use axum::routing::post;
    use bytes::Bytes;
    use tokio::net::TcpListener;
    use tokio::sync::mpsc::{UnboundedReceiver, unbounded_channel};

    use super::*;

    const SECRET: [u8; 32] = [7; 32];

    fn message() -> Message {
        Message { id: "job-1".to_owned(), body: Bytes::from_static(b"{}") }
    }

    /// A receiver on this machine: its port, and what it is sent at `/`; `/away` leads there, `/no` and `/gone` refuse.
    async fn receiver() -> (u16, UnboundedReceiver<(HeaderMap, Bytes)>) {
        let (sender, received) = unbounded_channel();
        let take = move |headers: HeaderMap, body: Bytes| {
            let sender = sender.clone();
            async move { sender.send((headers, body)).unwrap() }
        };
        let routes = Router::new()
            .route("/", post(take))
            .route("/away", post(|| async { Redirect::temporary("/") }))
            .route("/no", post(|| async { StatusCode::INTERNAL_SERVER_ERROR }))
            .route("/gone", post(|| async { StatusCode::GONE }));
        let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
        let port = listener.local_addr().unwrap().port();
        tokio::spawn(async move { axum::serve(listener, routes).await.unwrap() });
        (port, received)
    }

    #[tokio::test]
    async fn a_receiver_is_told_once_and_answers_are_looked_at() {
        let (port, mut received) = receiver().await;
        let caller = Caller::of_this_machine(vec![format!("localhost:{port}").parse().unwrap()]);
        let call = async |path: &str| caller.call(&format!("http://localhost:{port}{path}"), &message(), &SECRET).await;
        call("/").await.unwrap();
        let (headers, body) = received.recv().await.unwrap();
        assert_eq!(
            (&headers["webhook-id"], &headers["content-type"], &body[..]),
            (&"job-1".parse().unwrap(), &"application/json".parse().unwrap(), &b"{}"[..])
        );
        for (path, reason, for_good) in [("/no", "500", false), ("/away", "307", false), ("/gone", "410", true)] {
            let refused = call(path).await.unwrap_err();
            assert!(refused.reason.contains(reason) && refused.for_good == for_good, "{refused:?}");
        }
        assert!(received.try_recv().is_err(), "no answer leads anywhere");
        let other = caller.call("http://localhost:1/", &message(), &SECRET).await.unwrap_err();
        assert!(other.for_good, "{other:?}");
    }

    #[tokio::test]
    async fn names_that_stand_for_this_machine_are_not_called() {
        let (port, mut received) = receiver().await;
        let hosts: Hosts = vec![format!("localhost:{port}").parse().unwrap()].into();
        // As in production, but for TLS.
        let caller = Caller::within(hosts.without_tls(), is_public).unwrap();
        let refused = caller.call(&format!("http://localhost:{port}/"), &message(), &SECRET).await.unwrap_err();
        assert!(refused.reason.contains("may be called") && !refused.reason.contains(&port.to_string()), "{refused:?}");
        assert!(!refused.for_good && received.try_recv().is_err());
    }

    #[tokio::test]
    async fn a_receiver_that_is_silent_is_left() {
        let silent = TcpListener::bind("127.0.0.1:0").await.unwrap();
        let port = silent.local_addr().unwrap().port();
        let mut caller = Caller::of_this_machine(vec![format!("localhost:{port}").parse().unwrap()]);
        let quick = Client::builder().dns_resolver(Arc::new(Resolver { reach: |_| true })).no_proxy();
        caller.client = quick.timeout(Duration::from_millis(50)).build().unwrap();
        let refused = caller.call(&format!("http://localhost:{port}/"), &message(), &SECRET).await.unwrap_err();
        assert!(refused.reason.contains("timed out"), "{refused:?}");
    }
}
