//! The `Host` header: every request of HTTP/1.1 has one, and on a loopback address it is a local one.
//!
//! A page of another site can make a browser reach a loopback address by a name of its own that leads there (DNS
//! rebinding). Such requests carry that name.

use std::net::IpAddr;
use std::sync::Arc;

use axum::extract::{Request, State};
use axum::http::uri::Authority;
use axum::http::{HeaderMap, HeaderValue, StatusCode, Version, header};
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};

use super::problem::{Fault, Problem};

/// The names a server answers to.
#[derive(Debug)]
pub struct OwnNames {
    /// Whether names that are neither local nor listed are answered to.
    any: bool,
    listed: Vec<String>,
}

impl OwnNames {
    /// Those of a server that listens on `address`: where that is a loopback address or names are listed, local names and
    /// the listed ones only.
    pub fn of(address: IpAddr, listed: &[String]) -> OwnNames {
        OwnNames { any: !address.is_loopback() && listed.is_empty(), listed: listed.to_vec() }
    }

    fn answer_to(&self, host: &str) -> bool {
        let host = host.trim_end_matches('.').to_ascii_lowercase();
        let address = host.trim_start_matches('[').trim_end_matches(']').parse::<IpAddr>();
        let local = host == "localhost" || host.ends_with(".localhost") || address.is_ok_and(|ip| ip.is_loopback());
        self.any || local || self.listed.iter().any(|listed| listed.eq_ignore_ascii_case(&host))
    }
}

/// Lets a request through that names its host, once, as one that is answered to.
pub async fn checked(State(names): State<Arc<OwnNames>>, request: Request, next: Next) -> Response {
    match fault(&names, request.version(), request.headers()) {
        None => next.run(request).await,
        Some(problem) => problem.into_response(),
    }
}

fn fault(names: &OwnNames, version: Version, headers: &HeaderMap) -> Option<Problem> {
    let named: Vec<&HeaderValue> = headers.get_all(header::HOST).iter().collect();
    let host = match named.as_slice() {
        [] if version == Version::HTTP_10 => return None,
        [host] => host.to_str().ok().filter(|host| !host.contains('@')).and_then(|host| host.parse::<Authority>().ok()),
        _ => None,
    };
    let Some(host) = host else {
        return Some(Problem::malformed(Fault::in_header("host", "a request names its host, once")));
    };
    (!names.answer_to(host.host())).then(|| {
        let detail = format!("this server does not answer to {}: --allowed-host adds names", host.host());
        Problem::of_fault(StatusCode::MISDIRECTED_REQUEST, Fault::in_header("host", detail))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const LOOPBACK: [u8; 4] = [127, 0, 0, 1];
    const ANYWHERE: [u8; 4] = [0, 0, 0, 0];

    /// The status of the problem with these headers; 200 where there is none.
    fn status(address: [u8; 4], listed: &[&str], version: Version, hosts: &[&'static str]) -> u16 {
        let listed: Vec<String> = listed.iter().map(|&host| host.to_owned()).collect();
        let mut headers = HeaderMap::new();
        hosts.iter().for_each(|host| _ = headers.append(header::HOST, HeaderValue::from_static(host)));
        let problem = fault(&OwnNames::of(address.into(), &listed), version, &headers);
        problem.map_or(200, |problem| problem.status)
    }

    #[test]
    fn a_loopback_address_answers_to_local_names() {
        for host in
            ["localhost", "LOCALHOST:8080", "a.localhost", "localhost.", "127.0.0.1:80", "127.9.9.9", "[::1]:8080"]
        {
            assert_eq!(status(LOOPBACK, &[], Version::HTTP_11, &[host]), 200, "{host}");
        }
        for host in ["rebound.example", "localhost.example:8080", "10.0.0.1", "[2001:db8::1]", "notlocalhost"] {
            assert_eq!(status(LOOPBACK, &[], Version::HTTP_11, &[host]), 421, "{host}");
            assert_eq!(status(ANYWHERE, &[], Version::HTTP_11, &[host]), 200, "{host}");
        }
    }

    #[test]
    fn listed_names_are_answered_to() {
        for (host, expected) in [("Shapes.example:443", 200), ("other.example", 421), ("localhost", 200)] {
            for address in [LOOPBACK, ANYWHERE] {
                assert_eq!(status(address, &["shapes.example"], Version::HTTP_11, &[host]), expected, "{host}");
            }
        }
    }

    #[test]
    fn there_is_one_host() {
        assert_eq!(status(ANYWHERE, &[], Version::HTTP_11, &[]), 400);
        assert_eq!(status(ANYWHERE, &[], Version::HTTP_10, &[]), 200);
        assert_eq!(status(ANYWHERE, &[], Version::HTTP_11, &["a", "a"]), 400);
        for host in ["", "a b", "a@b", "a/b"] {
            assert_eq!(status(ANYWHERE, &[], Version::HTTP_11, &[host]), 400, "{host:?}");
        }
    }
}
