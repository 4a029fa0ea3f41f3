//! Requests under way, counted for every tenant: by streams and waits that do not end, one could hold the connections of
//! all.

use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::pin::Pin;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::task::{Context, Poll};

use axum::body::{Body, Bytes};
use axum::response::Response;
use hyper::body::{Body as HttpBody, Frame, SizeHint};

use super::problem::Problem;
use crate::access::Tenant;

/// Seconds after which to ask again whether a request of a tenant's has ended.
const UNTIL_ONE_ENDS: u32 = 5;

/// Counts the requests of every tenant that are under way, from their headers to the end of their answers.
pub struct OpenRequests {
    most: u64,
    open: Mutex<HashMap<Tenant, u64>>,
}

/// A request under way, until it is dropped.
pub struct Place {
    among: Arc<OpenRequests>,
    tenant: Tenant,
}

impl OpenRequests {
    /// Lets each tenant have `most` requests under way.
    pub fn new(most: u64) -> OpenRequests {
        OpenRequests { most, open: Mutex::default() }
    }

    /// A place for one request more; none where the tenant has as many under way as it may.
    pub fn place(self: &Arc<Self>, tenant: &Tenant) -> Option<Place> {
        let mut open = self.open();
        let requests = open.entry(tenant.clone()).or_default();
        if *requests >= self.most {
            return None;
        }
        *requests += 1;
        Some(Place { among: self.clone(), tenant: tenant.clone() })
    }

    /// 429: a tenant has this many requests under way.
    pub fn exceeded(&self) -> Problem {
        let detail =
            format!("up to {} requests of one tenant are under way at a time, streams of events among them", self.most);
        Problem::too_many(detail, UNTIL_ONE_ENDS)
    }

    fn open(&self) -> MutexGuard<'_, HashMap<Tenant, u64>> {
        self.open.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Drop for Place {
    fn drop(&mut self) {
        if let Entry::Occupied(mut requests) = self.among.open().entry(self.tenant.clone()) {
            *requests.get_mut() -= 1;
            if *requests.get() == 0 {
                requests.remove();
            }
        }
    }
}

/// The answer that keeps its place until it was read to its end, or nobody reads it any more.
pub fn keeping(response: Response, place: Place) -> Response {
    response.map(|body| Body::new(Keeping { body, _place: place }))
}

/// A body that keeps a place.
struct Keeping {
    body: Body,
    _place: Place,
}

impl HttpBody for Keeping {
    type Data = Bytes;
    type Error = axum::Error;

    fn poll_frame(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
    ) -> Poll<Option<Result<Frame<Bytes>, axum::Error>>> {
        Pin::new(&mut self.body).poll_frame(context)
    }

    fn is_end_stream(&self) -> bool {
        self.body.is_end_stream()
    }

    fn size_hint(&self) -> SizeHint {
        self.body.size_hint()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_tenant_has_places_of_its_own_and_gets_them_back() {
        let requests = Arc::new(OpenRequests::new(2));
        let [one, other]: [Tenant; 2] = ["one", "other"].map(|name| name.parse().unwrap());
        let (first, second) = (requests.place(&one), requests.place(&one));
        assert!(first.is_some() && second.is_some() && requests.place(&one).is_none());
        assert!(requests.place(&other).is_some());
        let answer = keeping(Response::new(Body::from("told")), first.unwrap());
        assert_eq!(answer.body().size_hint().exact(), Some(4));
        assert!(requests.place(&one).is_none());
        drop(answer);
        let third = requests.place(&one);
        assert!(third.is_some() && requests.place(&one).is_none());
        drop((second, third));
        // Nobody is remembered who asks for nothing.
        assert!(requests.open().is_empty());
    }
}
